"""Passages of bolts through polyhedra: straight lines through convex cells, piece after piece."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.model.bolt_layout import SHORT, Passages
from bsm_mesh.model.bolts import Bolt
from bsm_mesh.model.polygons import owner_of_corner
from bsm_mesh.three_d.blocks.cell_sides import sides_of_cells
from bsm_mesh.three_d.blocks.polygons import spread
from bsm_mesh.three_d.blocks.polyhedra import Polyhedra

LEVEL = 1e-9  # sine: a bolt nearer to a face's plane than this runs along it


def pass_polyhedra(
    bolts: Sequence[Bolt], blocks: Polyhedra, present: BoolArray
) -> tuple[Passages, list[tuple[int, str, float]]]:
    """Return the pieces of bolts in blocks that are present (n_bolts, n_blocks).

    Bolt, face and length [m] are returned too where a bolt lies in a face between two blocks, or in an outer face.
    """
    sides = _Sides(blocks)
    pieces: list[tuple[int, int, float, float]] = []
    along: list[tuple[int, str, float]] = []
    for b, bolt in enumerate(bolts):
        cell, first, last, flat = sides.crossed(np.array(bolt.start), np.array(bolt.end))
        there = present[b, blocks.cell_block[cell]]
        cell, first, last, flat = cell[there], first[there], last[there], flat[there]
        lies = np.flatnonzero(flat >= 0)
        if lies.size:
            k = lies[np.argmin(first[lies])]
            along.append((b, f"a face of block {blocks.cell_block[cell[k]]}", float(last[k] - first[k])))
            cell, first, last = _once(cell, first, last, SHORT * bolt.length)
        pieces += _joined(b, blocks.cell_block[cell], first, last, SHORT * bolt.length)
    columns = list(zip(*pieces, strict=True)) or [(), (), (), ()]
    return Passages(
        bolt=np.array(columns[0], np.int32),
        block=np.array(columns[1], np.int32),
        first=np.array(columns[2], np.float64),
        last=np.array(columns[3], np.float64),
    ), along


class _Sides:
    """The faces of every cell as half spaces, cell after cell."""

    def __init__(self, blocks: Polyhedra) -> None:
        self._of, corners = sides_of_cells(blocks), blocks.vertices[blocks.face_vertices]
        owner = owner_of_corner(blocks.face_offsets)
        self._low, self._high = np.full((2, len(blocks.cell_block), 3), [[[np.inf]], [[-np.inf]]])
        for cells in blocks.face_cells[owner].T:
            np.minimum.at(self._low, cells[cells >= 0], corners[cells >= 0])
            np.maximum.at(self._high, cells[cells >= 0], corners[cells >= 0])
        blocks_of = np.where(blocks.face_cells >= 0, blocks.cell_block[blocks.face_cells], -1)
        self._inner = (blocks_of[:, 0] == blocks_of[:, 1])[self._of.face]

    def crossed(self, start: FloatArray, end: FloatArray) -> tuple[IntArray, FloatArray, FloatArray, IntArray]:
        """Return cells (k,) on the way, distances [m] at which it enters and leaves, a side in which it lies or -1."""
        length = float(np.linalg.norm(end - start))
        unit, slack = (end - start) / length, SHORT * length
        low, high = np.minimum(start, end) - slack, np.maximum(start, end) + slack
        cell = np.flatnonzero(((self._low <= high) & (self._high >= low)).all(axis=1))
        sizes = np.diff(self._of.start)[cell]
        side = spread(self._of.start[cell], sizes)
        of = np.repeat(np.arange(len(cell)), sizes)
        speed = self._of.normal[side] @ unit
        height = np.einsum(
            "ij,ij->i", self._of.point[side] - start, self._of.normal[side]
        )  # of the plane over the start
        level = np.abs(speed) < LEVEL
        with np.errstate(divide="ignore", invalid="ignore"):
            reach = height / speed
        enters, leaves = np.zeros(len(cell)), np.full(len(cell), length)
        np.maximum.at(enters, of[speed <= -LEVEL], reach[speed <= -LEVEL])
        np.minimum.at(leaves, of[speed >= LEVEL], reach[speed >= LEVEL])
        outside = level & (height < -slack)
        leaves[of[outside]] = -np.inf
        flat = np.full(len(cell), -1)
        lies = level & (np.abs(height) <= slack) & ~self._inner[side]
        flat[of[lies]] = side[lies]
        kept = np.flatnonzero(leaves - enters > slack)
        kept = kept[np.lexsort((cell[kept], enters[kept]))]
        return cell[kept].astype(np.int32), enters[kept], leaves[kept], flat[kept]


def _once(cell: IntArray, first: FloatArray, last: FloatArray, slack: float) -> tuple[IntArray, FloatArray, FloatArray]:
    """Return the pieces without those that begin within one before: cells on both sides of a face hold the same."""
    kept, reached = [], -np.inf
    for k in range(len(cell)):
        if last[k] > reached + slack:
            kept.append(k)
            reached = last[k]
    return cell[kept], first[kept], last[kept]


def _joined(
    bolt: int, block: IntArray, first: FloatArray, last: FloatArray, slack: float
) -> list[tuple[int, int, float, float]]:
    """Return bolt, block, beginning and end [m] of every piece, those in cells of one block joined."""
    found: list[tuple[int, int, float, float]] = []
    for own, begins, ends in zip(block.tolist(), first.tolist(), last.tolist(), strict=True):
        if found and found[-1][1] == own and begins - found[-1][3] <= slack:
            found[-1] = (bolt, own, found[-1][2], max(found[-1][3], ends))
        else:
            found.append((bolt, own, begins, ends))
    return found
