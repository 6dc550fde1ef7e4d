"""Node sets and surfaces of finite-element meshes as line elements along the sides that they hold."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.model.edges import LongArray
from bsm_mesh.model.polygons import next_corner


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Sides:
    """The sides of surface elements, each once.

    Attributes
    ----------
    ends : (n_sides, 2) int64
        Nodes at their ends, the lower first; sorted.
    at_rim : (n_sides,) bool
        Whether one element only has the side.
    """

    ends: LongArray
    at_rim: BoolArray

    @classmethod
    def of(cls, corners: LongArray, offsets: IntArray) -> Sides:
        """Return the sides of outlines; parameters as in `MeshCells`."""
        ends, uses = np.unique(
            np.sort(np.stack([corners, corners[next_corner(offsets)]], axis=1), axis=1), axis=0, return_counts=True
        )
        return cls(ends=ends.reshape(-1, 2), at_rim=uses == 1)

    def longer_than_zero(self, points: FloatArray) -> Sides:
        """Return the sides without those of no length, as interface elements of no thickness have them."""
        long = np.any(points[self.ends[:, 0]] != points[self.ends[:, 1]], axis=1)
        return Sides(ends=self.ends[long], at_rim=self.at_rim[long])

    def between(self, nodes: LongArray) -> LongArray:
        """Return the sides between two of the nodes: those at the rim if there are any, else those inside."""
        both: BoolArray = np.isin(self.ends[:, 0], nodes) & np.isin(self.ends[:, 1], nodes)
        return self._chosen(both)

    def among(self, ends: LongArray) -> LongArray:
        """Return those of some sides that are at the rim if there are any, else all that are sides, (k, 2)."""
        wanted = np.sort(ends.reshape(-1, 2), axis=1)
        return self._chosen(_rows_in(self.ends, wanted))

    def _chosen(self, inside: BoolArray) -> LongArray:
        outside = inside & self.at_rim
        return self.ends[outside if outside.any() else inside]


def _rows_in(rows: LongArray, wanted: LongArray) -> BoolArray:
    base = int(max(rows.max(initial=0), wanted.max(initial=0))) + 1
    found: BoolArray = np.isin(rows @ np.array([base, 1]), wanted @ np.array([base, 1]))
    return found


def set_pieces(
    points: FloatArray,
    corners: LongArray,
    offsets: IntArray,
    node_sets: Mapping[str, LongArray],
    sides: Mapping[str, LongArray],
) -> dict[str, LongArray]:
    """Return the ends of the line elements that represent node sets and surfaces; none for those without a side.

    Parameters
    ----------
    points, corners, offsets : array
        As in `MeshCells`.
    node_sets : mapping of str to (k,) int64
        Nodes of each set.
    sides : mapping of str to (k, 2) int64
        Ends of the sides of each surface.
    """
    if not node_sets and not sides:
        return {}
    every = Sides.of(corners, offsets).longer_than_zero(points)
    found = {name: every.between(nodes) for name, nodes in node_sets.items()}
    for name, ends in sides.items():
        found[name] = np.concatenate([found.get(name, np.empty((0, 2), np.int64)), every.among(ends)])
    return {name: ends for name, ends in found.items() if len(ends)}
