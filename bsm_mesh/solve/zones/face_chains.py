"""Chains of sides of zones along the faces of blocks: points of joints slide along them.

A chain continues over the sides of one block, and over those of a neighbour whose face begins where that of the first
ends. It turns by less than 90 degrees there; of several neighbours the one that turns least is next.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.contact.rules import RULES
from bsm_mesh.solve.zones.interfaces import Interfaces
from bsm_mesh.solve.zones.mesh import ContinuumMesh

Lip = Callable[[IntArray, IntArray], FloatArray]


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class FaceChains:
    """Pieces of the blocks' edges (`ContinuumMesh`), (p,) each.

    Attributes
    ----------
    node : (p, 2 or 3) int32
        Start and end in the direction of the outline, and with second-order zones the middle.
    before, after : (p,) int32
        The pieces before and after it along the chain; -1: none.
    bend : (p,) float64
        Sine of the turn from it to the piece after it; positive: away from what lies on the face.
    block : (p,) int32
        Whose they are.
    plane : (p,) int32
        Number of the plane face of every piece.
    """

    node: IntArray
    before: IntArray
    after: IntArray
    bend: FloatArray
    block: IntArray
    plane: IntArray

    @classmethod
    def of(cls, whole: ContinuumMesh, opened: ContinuumMesh, order: int) -> FaceChains:
        """Return the chains of a mesh that is opened along its joints; `whole` is the same before."""
        facet = opened.piece_facet
        node = opened.piece_ends
        if order == 2:
            node = np.column_stack([node, opened.mesh.p.shape[1] + facet])
        outside = np.flatnonzero(opened.mesh.f2t[1, facet] < 0)
        after, bend = _following(whole, outside)
        before = np.full(len(facet), -1, dtype=np.int32)
        there = np.flatnonzero(after >= 0)
        before[after[there]] = there
        block = opened.block[opened.mesh.f2t[0, facet]]
        plane = _plane(after, bend)
        return cls(node=node.astype(np.int32), before=before, after=after, bend=bend, block=block, plane=plane)

    def shapes(self, share: FloatArray) -> FloatArray:
        """Return the shape functions of a side's nodes at parts of it from its start, (q, 2 or 3)."""
        if self.node.shape[1] == 2:
            return np.stack([1 - share, share], axis=1)
        return np.stack([(1 - share) * (1 - 2 * share), share * (2 * share - 1), 4 * share * (1 - share)], axis=1)

    def facing(
        self,
        point: FloatArray,
        own: IntArray,
        piece: IntArray,
        place: FloatArray,
        present: BoolArray,
        tail: IntArray,
        lip: Lip,
    ) -> tuple[IntArray, FloatArray]:
        """Return the pieces that points (q, 2) [m] face along the chains, and at which part of them, (q,) each.

        Parameters
        ----------
        point : (q, 2) float64 [m]
            Where points are.
        own : (q,) int32
            Their blocks, to whose faces they do not pass.
        piece : (q,) int32
            From which pieces they start.
        place : (k, 2) float64 [m]
            Where nodes are.
        present : (n,) bool
            Which blocks are there.
        tail : (q,) int
            Which way the face of a point lies that ends with it: 1 behind it along the chain, -1 before it; 0: both.
        lip : callable
            Returns how deep such an end has to lie on the face of a block to carry, of blocks (k,) for points (k,) [m].
        """
        share = self._projected(point, piece, place)
        for way, sign in ((self.after, 1.0), (self.before, -1.0)):
            for _ in range(len(self.block)):
                further = way[piece]
                on = np.flatnonzero(self._may_pass(own, piece, further, present))
                here, next_ = self.block[piece[on]], self.block[further[on]]
                late = sign * tail[on]
                later = np.where(here == next_, 0, late) * lip(on, np.where(late > 0, next_, here))
                there = self._projected(point[on], further[on], place)
                left = (0.5 - sign * (share[on] - 0.5)) * self._side(piece[on], place)
                passed = (0.5 + sign * (there - 0.5)) * self._side(further[on], place)
                goes = np.where(later > 0, passed > later, left < -later)
                step = self._gap(point[on], piece[on], place) - self._gap(point[on], further[on], place)
                goes &= (here == next_) | (step <= lip(on, next_))
                if not goes.any():
                    break
                piece = piece.copy()
                piece[on[goes]], share[on[goes]] = further[on[goes]], there[goes]
        return piece, share

    def _may_pass(self, own: IntArray, piece: IntArray, further: IntArray, present: BoolArray) -> BoolArray:
        """Return which points (q,) may pass to a piece: to a block from another, both there, and not to their own."""
        here, next_ = self.block[piece], self.block[further]
        found: BoolArray = (further >= 0) & (next_ != own) & present[here] & present[next_]
        return found

    def free_ends(self, interfaces: Interfaces) -> tuple[BoolArray, BoolArray]:
        """Return at which starts and ends of pieces a face continues without an interface, (p,) each.

        A face that turns away from the other side does not continue.
        """
        alone = np.ones(len(self.block), dtype=bool)
        alone[interfaces.pieces] = False
        at_end = (self.after >= 0) & alone[self.after] & (self.bend <= RULES.flat)
        at_start = (self.before >= 0) & alone[self.before] & (self.bend[self.before] <= RULES.flat)
        return at_start, at_end

    def with_ends_covered(self, interfaces: Interfaces) -> Interfaces:
        """Return the interfaces; the second side is the one whose faces do not continue beyond them, if any."""
        face = self.plane[interfaces.pieces]
        free = np.logical_or(*self.free_ends(interfaces))[interfaces.pieces].astype(int)
        _, pair = np.unique(np.sort(face, axis=1), axis=0, return_inverse=True)
        pair = pair.reshape(-1)
        low = face[:, 0] <= face[:, 1]
        sided = np.where(low[:, None], free, free[:, ::-1])
        fewer = np.bincount(pair, sided[:, 0] - sided[:, 1])[pair]  # negative: the lower face is covered whole
        swapped = np.where(low, fewer < 0, fewer > 0)

        def turned(sides: IntArray) -> IntArray:
            found: IntArray = np.where(swapped[:, None], sides[:, ::-1], sides)
            return found

        return replace(
            interfaces,
            pieces=turned(interfaces.pieces),
            vertex=turned(interfaces.vertex),
            facet=turned(interfaces.facet),
        )

    def _side(self, piece: IntArray, place: FloatArray) -> FloatArray:
        """Return the lengths of pieces (q,), where nodes are at `place` (k, 2), (q,) [m]."""
        start, end = np.moveaxis(place[self.node[piece, :2]], 1, 0)
        length: FloatArray = np.hypot(*(end - start).T)
        return length

    def _gap(self, point: FloatArray, piece: IntArray, place: FloatArray) -> FloatArray:
        """Return how far points are in front of the chords of their pieces, (q,) [m]; negative: behind."""
        start, end = np.moveaxis(place[self.node[piece, :2]], 1, 0)
        (x, y), (ex, ey) = (point - start).T, (end - start).T
        gap: FloatArray = (ey * x - ex * y) / np.hypot(ex, ey)
        return gap

    def _projected(self, point: FloatArray, piece: IntArray, place: FloatArray) -> FloatArray:
        """Return at which part of its piece every point is, along the chord; outside 0 to 1 beyond the ends.

        Along the chord a side of second order is at ``(4 m - 1) s + (2 - 4 m) s^2`` for a part s, its middle at m.
        """
        corner = place[self.node[piece]]
        chord = corner[:, 1] - corner[:, 0]
        square = (chord**2).sum(axis=1)
        share: FloatArray = ((point - corner[:, 0]) * chord).sum(axis=1) / square
        if corner.shape[1] == 3:
            middle = ((corner[:, 2] - corner[:, 0]) * chord).sum(axis=1) / square
            first, second = 4 * middle - 1, 2 - 4 * middle
            share = 2 * share / (first + np.sqrt(np.maximum(first**2 + 4 * second * share, 0.0)))
        return share


def _plane(after: IntArray, bend: FloatArray) -> IntArray:
    """Return the number of the plane face of every piece, (p,)."""
    there = np.flatnonzero((after >= 0) & (np.abs(bend) <= RULES.flat))
    graph = coo_matrix((np.ones(len(there), np.int8), (there, after[there])), shape=(len(after), len(after)))
    number: IntArray = connected_components(graph, directed=False)[1]
    return number


def _following(mesh: ContinuumMesh, pieces: IntArray) -> tuple[IntArray, FloatArray]:
    """Return for every piece the one of `pieces` that starts at its end and turns least, and the sine of its turn.

    Both (p,); -1 and 0 where none turns by less than 90 degrees.
    """
    ends, place = mesh.piece_ends, mesh.mesh.p.T
    along = place[ends[:, 1]] - place[ends[:, 0]]
    along = along / np.hypot(*along.T)[:, None]
    order = pieces[np.argsort(ends[pieces, 0], kind="stable")]
    start = ends[order, 0]
    first, last = (np.searchsorted(start, ends[pieces, 1], side=side) for side in ("left", "right"))
    count = last - first
    one = np.repeat(pieces, count)
    within = np.arange(len(one)) - np.repeat(np.cumsum(count) - count, count)
    other = order[np.repeat(first, count) + within]
    turn = along[one, 0] * along[other, 1] - along[one, 1] * along[other, 0]
    on = (along[one] * along[other]).sum(axis=1)
    least = np.argsort(on, kind="stable")  # the one that turns least is written last
    least = least[on[least] > 0]
    after, bend = np.full(len(ends), -1, dtype=np.int32), np.zeros(len(ends))
    after[one[least]], bend[one[least]] = other[least], turn[least]
    return after, bend
