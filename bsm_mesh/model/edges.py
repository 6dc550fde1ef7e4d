"""Edges of blocks found by the two points that they join."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from bsm_mesh.arrays import BoolArray, IntArray
from bsm_mesh.model.polygons import next_corner

LongArray = npt.NDArray[np.int64]


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class EdgeTable:
    """All edges, sorted by the numbers of their two points.

    Attributes
    ----------
    keys : (n_edges,) int64
        Sorted; lower point number times `base` plus the higher.
    order : (n_edges,) int64
        Edge number of each key.
    rising : (n_edges,) bool
        Whether each edge (by its own number) runs from its lower to its higher point number.
    base : int
        Above all point numbers.
    """

    keys: LongArray
    order: LongArray
    rising: BoolArray
    base: int

    @classmethod
    def of(cls, nodes: IntArray, offsets: IntArray) -> EdgeTable:
        """Return the table of blocks whose corners lie at the points `nodes`.

        Parameters
        ----------
        nodes : (n_vertices,) int32
            Number of the point of every corner, block after block.
        offsets : (n_blocks + 1,) int32
            Block b owns ``nodes[offsets[b]:offsets[b + 1]]``.
        """
        following = nodes[next_corner(offsets)]
        base = int(nodes.max()) + 1
        keys = _keys(nodes, following, base)
        order = np.argsort(keys, kind="stable")
        return cls(keys=keys[order], order=order, rising=nodes < following, base=base)

    def joining(self, first: npt.NDArray[np.integer], last: npt.NDArray[np.integer]) -> tuple[LongArray, LongArray]:
        """Return all edges between pairs of points, either way round.

        Parameters
        ----------
        first, last : (n,) int
            Point numbers; a negative one joins nothing.

        Returns
        -------
        query, edge : (k,) int64
            Edge ``edge[i]`` joins the points of pair ``query[i]``.
        """
        keys = _keys(first, last, self.base)
        valid = (np.minimum(first, last) >= 0) & (np.maximum(first, last) < self.base)
        low = np.searchsorted(self.keys, keys, side="left")
        count = np.where(valid, np.searchsorted(self.keys, keys, side="right") - low, 0)
        query = np.repeat(np.arange(len(keys)), count)
        within = np.arange(len(query)) - np.repeat(np.cumsum(count) - count, count)
        return query, self.order[low[query] + within]

    def pairs(self) -> tuple[LongArray, LongArray]:
        """Return the edges that join the same two points in opposite directions, and no third one does.

        Returns
        -------
        one, other : (k,) int64
            Edge numbers, the lower first.
        """
        starts, uses = self._runs()
        twice = starts[uses == 2]
        one, other = self.order[twice], self.order[twice + 1]
        opposite = self.rising[one] != self.rising[other]
        return one[opposite], other[opposite]

    def contested(self) -> LongArray:
        """Return pairs of edges that claim the same side of the same two points, or are more than two, (k, 2)."""
        starts, uses = self._runs()
        twice = starts[uses == 2]
        one, other = self.order[twice], self.order[twice + 1]
        same = self.rising[one] == self.rising[other]
        three = self.order[starts[uses > 2][:, None] + np.arange(3)]  # two of them run the same way
        rising = self.rising[three]
        last = np.where(rising[:, 0] == rising[:, 1], 1, 2)
        first = np.where(rising[:, 0] == rising[np.arange(len(three)), last], 0, 1)
        rows = np.arange(len(three))
        crowded = np.stack([three[rows, first], three[rows, last]], axis=1)
        return np.concatenate([np.stack([one[same], other[same]], axis=1), crowded])

    def unpaired(self) -> BoolArray:
        """Return which edges are in none of the `pairs`, (n_edges,).

        These are the outline of the body, both sides of a gap, and edges with a corner of a neighbour between their
        ends. Edges that several blocks claim are unpaired too.
        """
        unpaired: BoolArray = np.ones(len(self.keys), dtype=np.bool_)
        for edges in self.pairs():
            unpaired[edges] = False
        return unpaired

    def _runs(self) -> tuple[LongArray, LongArray]:
        """Return where each key starts, and how many edges carry it."""
        starts = np.flatnonzero(np.concatenate([[True], self.keys[1:] != self.keys[:-1]]))
        return starts, np.diff(np.append(starts, len(self.keys)))


def pairs_of(one: IntArray, other: IntArray) -> IntArray:
    """Return a number of every pair of blocks, whichever is first, (k,) int64."""
    number: IntArray = (np.minimum(one, other).astype(np.int64) << 32) | np.maximum(one, other)
    return number


def _keys(first: npt.NDArray[np.integer], last: npt.NDArray[np.integer], base: int) -> LongArray:
    keys: LongArray = np.minimum(first, last).astype(np.int64) * base + np.maximum(first, last)
    return keys
