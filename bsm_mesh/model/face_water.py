"""Water pressure on parts of edges, as flow in the joints gives it: the other way in which water presses on blocks."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray, Portable, show_only

ON_LINE = 1e-6  # of a part's length: what is further from a line does not lie on it
NEAR = 0.5  # of a part's length: what is further from it is on no part


@dataclass(frozen=True, eq=False, repr=False, slots=True, kw_only=True)
class FaceWater(Portable):
    """Wet parts of edges, along each of which the pressure is linear; all else is dry.

    Attributes
    ----------
    edge : (p,) int32
        The edge that each is a part of.
    ends : (p, 2) float64
        Where it begins and ends, as parts of the edge's length.
    pressure : (p, 2) float64 [Pa]
        At its two ends.
    """

    edge: IntArray
    ends: FloatArray
    pressure: FloatArray

    def __post_init__(self) -> None:
        show_only(self)

    @classmethod
    def none(cls) -> FaceWater:
        """Return no water."""
        return cls(edge=np.zeros(0, np.int32), ends=np.zeros((0, 2)), pressure=np.zeros((0, 2)))

    def scaled(self, share: float) -> FaceWater:
        """Return a share of the pressures."""
        return replace(self, pressure=share * self.pressure)

    def chosen(self, parts: BoolArray) -> FaceWater:
        """Return the water on some of the parts (p,)."""
        return FaceWater(edge=self.edge[parts], ends=self.ends[parts], pressure=self.pressure[parts])

    def of_corners(self, corner: IntArray) -> FaceWater:
        """Return the water on the edges of a submodel, whose corners have the numbers `corner` (k,), rising, here."""
        place = np.minimum(np.searchsorted(corner, self.edge), max(len(corner) - 1, 0))
        there = corner[place] == self.edge if len(corner) else np.zeros(len(self.edge), dtype=bool)
        return FaceWater(edge=place[there].astype(np.int32), ends=self.ends[there], pressure=self.pressure[there])

    def points(self, vertices: FloatArray, following: IntArray) -> tuple[FloatArray, FloatArray]:
        """Return both ends of the parts, (p, 2) [m] each, the corners being at `vertices`."""
        start, end = vertices[self.edge], vertices[following[self.edge]]
        along = end - start
        first, last = (start + self.ends[:, k, None] * along for k in range(2))
        return first, last

    def forces(self, length: FloatArray) -> FloatArray:
        """Return the two forces at the ends of every part of a length (p,), with its resultant and moment (Eq. 6.2)."""
        q1, q2 = self.pressure.T
        forces: FloatArray = np.stack([2 * q1 + q2, q1 + 2 * q2], axis=1) * length[:, None] / 6
        return forces

    def on_lines(self, parts: tuple[FloatArray, FloatArray], start: FloatArray, end: FloatArray) -> FloatArray:
        """Return the forces at both ends of lines, (k, 2) [N/m], from the parts that lie on them in their direction.

        Parameters
        ----------
        parts : ((p, 2), (p, 2)) float64 [m]
            Both ends of the parts, as `points` returns them.
        start, end : (k, 2) float64 [m]
            The lines: faces or edges of the blocks as they were given.
        """
        import shapely

        forces = np.zeros((len(start), 2))
        if not len(self.edge) or not len(start):
            return forces
        first, last = parts
        length = np.hypot(*(last - first).T)
        tree = shapely.STRtree(shapely.linestrings(np.stack([start, end], axis=1)))
        middle = shapely.points((first + last) / 2)
        part, line = tree.query(middle, predicate="dwithin", distance=ON_LINE * length)
        along = (end - start)[line]
        part_along = (last - first)[part]
        full = np.hypot(*along.T)
        cosine = (along * part_along).sum(axis=1) / (full * length[part])
        same_way = cosine > 1 - ON_LINE
        part, line, along, full = part[same_way], line[same_way], along[same_way], full[same_way]
        of_part = self.forces(length)[part]
        for k, at in enumerate((first[part], last[part])):
            t = ((at - start[line]) * along).sum(axis=1) / full**2
            np.add.at(forces, line, np.stack([(1 - t) * of_part[:, k], t * of_part[:, k]], axis=1))
        return forces

    def at(self, parts: tuple[FloatArray, FloatArray], points: FloatArray) -> FloatArray:
        """Return the pressure at points (k, 2) [m] from the nearest parts, (k,) [Pa]; 0 where none is near."""
        import shapely

        pressure = np.zeros(len(points))
        if not len(self.edge) or not len(points):
            return pressure
        first, last = parts
        tree = shapely.STRtree(shapely.linestrings(np.stack([first, last], axis=1)))
        nearest = tree.nearest(shapely.points(points))
        along = (last - first)[nearest]
        square = (along**2).sum(axis=1)
        offset = points - first[nearest]
        t = np.clip((offset * along).sum(axis=1) / square, 0.0, 1.0)
        near = np.hypot(*(offset - t[:, None] * along).T) <= NEAR * np.sqrt(square)
        q1, q2 = self.pressure[nearest].T
        pressure[near] = ((1 - t) * q1 + t * q2)[near]
        return pressure
