"""Patterns of joints that are no parallel lines: masonry, and Voronoi cells."""

from __future__ import annotations

import math
import zlib
from dataclasses import dataclass

import numpy as np

from bsm_mesh.geometries.errors import GeometryError
from bsm_mesh.geometries.joint_sets import FloatArray, JointSet, Points, clip_traces

MOST_CELLS = 1_000_000


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Heads:
    """The upright joints of masonry in running bond; the level ones are a `JointSet`. `bricks` gives both.

    Attributes
    ----------
    name : str
        Name of the joint.
    length : float
        Of a brick [m].
    height : float
        Of a brick [m].
    start : (float, float)
        Lower left corner of a brick [m].
    shift : float
        By how much of its length a course is shifted against the one below.
    within : (k, 2) array_like, optional
        Polygon that the pattern keeps to [m].
    """

    name: str
    length: float
    height: float
    start: tuple[float, float] = (0.0, 0.0)
    shift: float = 0.5
    within: Points | None = None

    @property
    def extends(self) -> bool:
        """Whether dead ends continue to the next joint."""
        return False

    def traces(self, low: FloatArray, high: FloatArray, seed: int) -> FloatArray:
        """Return the traces in the box from `low` to `high`, (n, 2, 2) [m]."""
        first = np.floor((low - self.start) / (self.length, self.height)).astype(int) - 1
        last = np.ceil((high - self.start) / (self.length, self.height)).astype(int) + 1
        column, course = np.meshgrid(np.arange(first[0], last[0] + 1), np.arange(first[1], last[1] + 1))
        x = self.start[0] + (column + np.mod(course * self.shift, 1.0)) * self.length
        y = self.start[1] + course * self.height
        ends = [np.stack([x.ravel(), (y + up).ravel()], axis=1) for up in (0.0, self.height)]
        traces = np.stack(ends, axis=1)
        return traces if self.within is None else clip_traces(traces, self.within)


def bricks(
    length: float,
    height: float,
    *,
    bed: str = "bed",
    head: str = "head",
    start: tuple[float, float] = (0.0, 0.0),
    shift: float = 0.5,
    within: Points | None = None,
) -> tuple[JointSet, Heads]:
    """Return the level and the upright joints of masonry in running bond.

    Parameters
    ----------
    length : float
        Of a brick [m].
    height : float
        Of a brick [m].
    bed, head : str
        Names of the level and of the upright joints.
    start : (float, float)
        Lower left corner of a brick [m].
    shift : float
        By how much of its length a course is shifted against the one below; 0 gives continuous upright joints.
    within : (k, 2) array_like, optional
        Polygon that the pattern keeps to [m].

    Examples
    --------
    >>> from bsm_mesh import geometries as g
    >>> beds, heads = g.bricks(0.5, 0.25)
    >>> beds.name, heads.length
    ('bed', 0.5)
    """
    if not (math.isfinite(length) and length > 0 and math.isfinite(height) and height > 0):
        raise GeometryError(f"bricks: length = {length} and height = {height} must be above 0 m")
    beds = JointSet(name=bed, dip=0.0, spacing=height, start=start, within=within)
    return beds, Heads(name=head, length=length, height=height, start=start, shift=shift, within=within)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Voronoi:
    """Voronoi cells around points at random: blocky rock without a direction.

    Attributes
    ----------
    name : str
        Name of the joint.
    size : float
        Size of the cells: the square root of their mean area [m].
    rounds : int
        How often each point is moved to the centroid of its cell (Lloyd 1982): 0 gives ragged cells, 20 nearly
        regular ones, a centroidal Voronoi pattern.
    within : (k, 2) array_like, optional
        Polygon that the pattern keeps to [m].

    Examples
    --------
    >>> from bsm_mesh import geometries as g
    >>> g.Voronoi(name="V", size=1.0, rounds=20).size
    1.0
    """

    name: str
    size: float
    rounds: int = 0
    within: Points | None = None

    @property
    def extends(self) -> bool:
        """Whether dead ends continue to the next joint."""
        return False

    def traces(self, low: FloatArray, high: FloatArray, seed: int) -> FloatArray:
        """Return the sides of the cells in the box from `low` to `high`, (n, 2, 2) [m].

        Raises
        ------
        GeometryError
            If there would be more than a million cells.
        """
        import shapely

        if not (math.isfinite(self.size) and self.size > 0):
            raise GeometryError(f"Voronoi '{self.name}': size = {self.size} must be above 0 m")
        low, high = low - 2 * self.size, high + 2 * self.size  # cells at the edge of the points are no cells
        count = int(np.prod((high - low) / self.size))
        if count > MOST_CELLS:
            raise GeometryError(f"Voronoi '{self.name}': size = {self.size} m gives {count} cells; give a greater one")
        generator = np.random.default_rng([seed, zlib.crc32(self.name.encode())])
        points = low + generator.uniform(size=(max(count, 4), 2)) * (high - low)
        frame = shapely.box(*low, *high)
        for _ in range(self.rounds):
            cells = shapely.get_parts(shapely.voronoi_polygons(shapely.MultiPoint(points), extend_to=frame))
            points = shapely.get_coordinates(shapely.centroid(shapely.intersection(cells, frame)))
        sides = shapely.get_parts(
            shapely.voronoi_polygons(shapely.MultiPoint(points), extend_to=frame, only_edges=True)
        )
        coordinates, line = shapely.get_coordinates(sides, return_index=True)
        follows = line[1:] == line[:-1]
        traces = np.stack([coordinates[:-1][follows], coordinates[1:][follows]], axis=1)
        return traces if self.within is None else clip_traces(traces, self.within)
