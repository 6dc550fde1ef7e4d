"""The faces of a graph, enclosed by its edges, each with its rock."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from bsm_mesh.geometries.cutting.graph import Graph
from bsm_mesh.geometries.cutting.pieces import BoolArray, IntArray
from bsm_mesh.geometries.errors import GeometryError
from bsm_mesh.geometries.joint_sets import FloatArray
from bsm_mesh.geometries.rock_mass import Excavation, Opening, Region, RockMass

THINNEST = 0.05  # tolerances: width of a face below which its points stay on the grid
MOST_ROUNDS = 20  # of putting points back on the grid where their faces would turn over


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Faces:
    """Faces of rock, each an outer ring and the rings of its holes.

    Attributes
    ----------
    corners : (n_corners,) int64
        Points of the rings, ring after ring; outer rings counter-clockwise, holes clockwise.
    rings : (n_rings + 1,) int64
        Ring r owns ``corners[rings[r]:rings[r + 1]]``.
    faces : (n_faces + 1,) int64
        Face f owns the rings ``faces[f]`` to ``faces[f + 1] - 1``, the outer one first.
    """

    corners: IntArray
    rings: IntArray
    faces: IntArray

    @property
    def count(self) -> int:
        """Number of faces."""
        return len(self.faces) - 1

    @property
    def following(self) -> IntArray:
        """Next corner of the same ring, for every corner."""
        following = np.arange(1, len(self.corners) + 1)
        following[self.rings[1:] - 1] = self.rings[:-1]
        return following

    @property
    def owner(self) -> IntArray:
        """Face of every corner."""
        of_ring = np.repeat(np.arange(self.count), np.diff(self.faces))
        return np.repeat(of_ring, np.diff(self.rings))

    def polygons(self, points: FloatArray) -> Any:
        """Return the faces as shapely polygons."""
        import shapely

        flat = points[self.corners]
        closed = np.insert(np.arange(len(flat)), self.rings[1:], self.rings[:-1])
        ring = np.repeat(np.arange(len(self.rings) - 1), np.diff(self.rings) + 1)
        rings = shapely.linearrings(flat[closed], indices=ring)
        return shapely.polygons(rings, indices=np.repeat(np.arange(self.count), np.diff(self.faces)))

    def areas(self, points: FloatArray) -> FloatArray:
        """Return the area of every face [m2]."""
        here = points[self.corners]
        origin = here[np.repeat(self.rings[:-1], np.diff(self.rings))]
        a, b = here - origin, here[self.following] - origin
        parts = np.add.reduceat((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]) / 2, self.rings[:-1])
        area: FloatArray = np.add.reduceat(parts, self.faces[:-1])
        return area

    def perimeters(self, points: FloatArray) -> FloatArray:
        """Return the length of the rings of every face [m]."""
        here = points[self.corners]
        length = np.hypot(*(here[self.following] - here).T)
        perimeter: FloatArray = np.bincount(self.owner, length, minlength=self.count).astype(np.float64)
        return perimeter

    def edge_faces(self, graph: Graph) -> tuple[IntArray, IntArray]:
        """Return edge and face for every side of a face, in the order of the corners."""
        a, b = self.corners, self.corners[self.following]
        count = len(graph.points)
        keys = np.minimum(a, b) * count + np.maximum(a, b)
        of_graph = graph.edges[:, 0] * count + graph.edges[:, 1]
        order = np.argsort(of_graph)
        return order[np.searchsorted(of_graph, keys, sorter=order)], self.owner


def enclose_faces(graph: Graph, mass: RockMass) -> tuple[Faces, IntArray]:
    """Return the faces in the rock, and the last region that each lies in.

    Raises
    ------
    GeometryError
        If nothing encloses rock.
    """
    import shapely

    lines = shapely.linestrings(graph.points[graph.edges])
    found = shapely.orient_polygons(shapely.get_parts(shapely.polygonize(lines)))
    region = regions_at(shapely.get_coordinates(shapely.point_on_surface(found)), mass.regions)
    found, region = found[region >= 0], region[region >= 0]
    if len(found) == 0:
        raise GeometryError("the joints and outlines enclose no rock; see whether the tolerance fits the model")
    ring, of_face = shapely.get_rings(found, return_index=True)
    coordinates, of_ring = shapely.get_coordinates(ring, return_index=True)
    closing = np.append(of_ring[1:] != of_ring[:-1], True)
    sizes = np.bincount(of_ring[~closing])
    corners = find_points(coordinates[~closing], graph.points)
    starts = [np.concatenate([[0], np.cumsum(n)]) for n in (sizes, np.bincount(of_face))]
    return Faces(corners=corners, rings=starts[0], faces=starts[1]), region


def regions_at(points: FloatArray, regions: Sequence[Region | Opening | Excavation]) -> IntArray:
    """Return the index of the last region of rock around each point; -1 in an opening and outside."""
    index = np.full(len(points), -1)
    for number, region in enumerate(regions):
        if not isinstance(region, Excavation):
            inside = _inside(points, region)
            if isinstance(region, Region) and region.clipped:
                inside &= index >= 0
            index[inside] = number if isinstance(region, Region) else -1
    return index


def excavations_at(points: FloatArray, regions: Sequence[Region | Opening | Excavation]) -> dict[str, BoolArray]:
    """Return which points lie in each named excavation."""
    found: dict[str, BoolArray] = {}
    for region in regions:
        if isinstance(region, Excavation):
            found[region.name] = found.get(region.name, np.zeros(len(points), dtype=np.bool_)) | _inside(points, region)
    return found


def keep_valid(graph: Graph, faces: Faces, placed: FloatArray, rounded: FloatArray, tolerance: float) -> FloatArray:
    """Return the points `placed`, but `rounded` where a face would turn over, cross itself or lose all width.

    Raises
    ------
    GeometryError
        If a face stays no simple polygon: outlines of regions are nearer to each other than the tolerance.
    """
    import shapely

    wide = faces.areas(rounded)
    long = np.hypot(*(rounded[graph.edges[:, 1]] - rounded[graph.edges[:, 0]]).T)
    points = placed.copy()
    for _ in range(MOST_ROUNDS):
        area = faces.areas(points)
        length = np.hypot(*(points[graph.edges[:, 1]] - points[graph.edges[:, 0]]).T)
        bad = ~shapely.is_valid(faces.polygons(points)) | (area <= 0)
        thin = (area < THINNEST * tolerance * faces.perimeters(points)) & (wide > area)
        short = (length < THINNEST * tolerance) & (long > length)
        nodes = np.union1d(faces.corners[(bad | thin)[faces.owner]], graph.edges[short])
        nodes = nodes[np.any(points[nodes] != rounded[nodes], axis=1)]
        if nodes.size:
            points[nodes] = rounded[nodes]
        elif bad.any():  # outlines are within the tolerance of each other: they too go to the grid
            nodes = np.unique(faces.corners[bad[faces.owner]])
            points[nodes] = rounded[nodes] = graph.points[nodes]
        else:
            return points
    where = points[faces.corners[np.flatnonzero(bad[faces.owner])[0]]] if bad.any() else points[nodes[0]]
    raise GeometryError(
        f"a block near ({where[0]:.6g}, {where[1]:.6g}) is no simple polygon; outlines lie nearer to each other than "
        "the tolerance: give a smaller tolerance, or move one of them"
    )


def _inside(points: FloatArray, region: Region | Opening | Excavation) -> BoolArray:
    import shapely

    polygon = shapely.Polygon(np.asarray(region.outline, dtype=np.float64))
    shapely.prepare(polygon)
    inside: BoolArray = shapely.contains_xy(polygon, points[:, 0], points[:, 1])
    return inside


def find_points(coordinates: FloatArray, points: FloatArray) -> IntArray:
    """Return the number of the point at each of the coordinates; `points` are sorted by y, then x."""
    structured = [
        np.ascontiguousarray(xy[:, ::-1] + 0.0).view([("y", "f8"), ("x", "f8")])[:, 0] for xy in (points, coordinates)
    ]
    unique, inverse = np.unique(structured[1], return_inverse=True)
    number: IntArray = np.searchsorted(structured[0], unique)[inverse.reshape(-1)]
    return number
