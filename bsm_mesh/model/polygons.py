"""Geometry of many polygons stored flat: areas, centroids, moments, and which of them are faulty."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Moments:
    """Areas and moments of polygons, per metre of thickness.

    Attributes
    ----------
    area : (n,) float64 [m2]
        Positive for counter-clockwise corners.
    centroid : (n, 2) float64 [m]
        Centre of area.
    polar : (n,) float64 [m4]
        Polar second moment of area about the centroid.
    """

    area: FloatArray
    centroid: FloatArray
    polar: FloatArray

    @property
    def bulk(self) -> FloatArray:
        """Area of every polygon [m2]; of polyhedra the volume: the factor of a unit weight."""
        return self.area

    @property
    def size(self) -> FloatArray:
        """Side of the square of the same area [m]; of polyhedra that of the cube."""
        return np.sqrt(self.area)

    def mean_size(self, chosen: BoolArray) -> float:
        """Size of a polygon of the mean area of those chosen (n,) [m]."""
        return float(np.sqrt(self.area[chosen].mean()))

    @property
    def median_size(self) -> float:
        """Size of the polygon of median area [m]."""
        return float(np.sqrt(np.median(self.area)))

    @property
    def gyration(self) -> FloatArray:
        """Polar radius of gyration [m]: turns a moment into a force of the block's own size."""
        radius: FloatArray = np.sqrt(self.polar / self.area)
        return radius


def next_corner(offsets: IntArray) -> IntArray:
    """Return for every corner the number of the next corner of the same polygon, (n_vertices,)."""
    following = np.arange(1, int(offsets[-1]) + 1, dtype=np.int32)
    following[offsets[1:] - 1] = offsets[:-1]
    return following


def owner_of_corner(offsets: IntArray) -> IntArray:
    """Return the polygon that owns each corner (and so each edge), (n_vertices,)."""
    return np.repeat(np.arange(len(offsets) - 1, dtype=np.int32), np.diff(offsets))


def polygon_moments(vertices: FloatArray, offsets: IntArray) -> Moments:
    """Return area, centroid and polar second moment of every polygon.

    Coordinates are taken from each polygon's first corner, so that a model far from the origin
    loses no digits.

    Parameters
    ----------
    vertices : (n_vertices, 2) float64 [m]
        Corners, counter-clockwise, polygon after polygon.
    offsets : (n + 1,) int32
        Polygon b owns ``vertices[offsets[b]:offsets[b + 1]]``.
    """
    starts = offsets[:-1]
    sizes = np.diff(offsets)
    anchor = vertices[starts]
    x, y = (vertices - np.repeat(anchor, sizes, axis=0)).T
    following = next_corner(offsets)
    x2, y2 = x[following], y[following]
    cross = x * y2 - x2 * y
    area = np.add.reduceat(cross, starts) / 2
    second = np.add.reduceat((x * x + x * x2 + x2 * x2 + y * y + y * y2 + y2 * y2) * cross, starts) / 12
    with np.errstate(all="ignore"):  # a polygon of no area is the caller's to report
        cx = np.add.reduceat((x + x2) * cross, starts) / (6 * area)
        cy = np.add.reduceat((y + y2) * cross, starts) / (6 * area)
        polar = second - area * (cx**2 + cy**2)
    return Moments(area=area, centroid=anchor + np.stack([cx, cy], axis=1), polar=polar)


def edge_vectors(vertices: FloatArray, offsets: IntArray) -> FloatArray:
    """Return the vector from every corner to the next, (n_vertices, 2) [m]."""
    vectors: FloatArray = vertices[next_corner(offsets)] - vertices
    return vectors


def corner_turns(vertices: FloatArray, offsets: IntArray) -> FloatArray:
    """Return the angle by which the outline turns at the end of every edge, (n_vertices,) [rad], left positive."""
    out = edge_vectors(vertices, offsets)
    after = out[next_corner(offsets)]
    turns: FloatArray = np.arctan2(
        out[:, 0] * after[:, 1] - out[:, 1] * after[:, 0], out[:, 0] * after[:, 0] + out[:, 1] * after[:, 1]
    )
    return turns


def convex_polygons(vertices: FloatArray, offsets: IntArray) -> BoolArray:
    """Return which polygons are convex and simple: no right turn, and one turn of 360 degrees in all."""
    turns = corner_turns(vertices, offsets)
    starts = offsets[:-1]
    convex: BoolArray = (np.minimum.reduceat(turns, starts) > -1e-9) & (
        np.abs(np.add.reduceat(turns, starts) - 2 * np.pi) < 1e-6
    )
    return convex


def self_crossing(vertices: FloatArray, offsets: IntArray) -> IntArray:
    """Return the numbers of the polygons whose outline crosses or touches itself.

    Triangles and convex polygons are settled at once; only the others are looked at one by one (by GEOS).
    """
    many = np.diff(offsets) > 3
    suspects = np.flatnonzero(many & ~convex_polygons(vertices, offsets)) if many.any() else np.flatnonzero(many)
    if suspects.size == 0:
        return suspects.astype(np.int32)
    import shapely

    sizes = np.diff(offsets)[suspects]
    within = np.arange(sizes.sum()) - np.repeat(np.cumsum(sizes) - sizes, sizes)
    corners = vertices[np.repeat(offsets[suspects], sizes) + within]
    rings = shapely.linearrings(corners, indices=np.repeat(np.arange(len(suspects)), sizes))
    valid: BoolArray = shapely.is_valid(shapely.polygons(rings))
    crossing: IntArray = suspects[~valid].astype(np.int32)
    return crossing
