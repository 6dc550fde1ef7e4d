"""The block pattern of the stiffness matrix, made once, and the compiled pass that fills it.

The linear matrix is symmetric and positive semi-definite (Wang's Eq. 3.41 times -1) and is kept as its upper triangle
of blocks in compressed rows, 3 x 3 in the plane and 6 x 6 in space; the tangent of sliding contacts is not symmetric
and is kept whole. An open contact keeps its place, so that the analysis of a pattern lasts.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.compiled import njit


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class BlockPattern:
    """A matrix of small blocks in compressed rows: the upper triangle of a symmetric one, or all of it.

    Attributes
    ----------
    row_start : (n + 1,) int32
        Row i owns the places ``row_start[i]:row_start[i + 1]``.
    column : (n_places,) int32
        Column of every place, rising within a row.
    diagonal : (n,) int32
        Place of each row's diagonal block.
    place : (m,) or (m, 4) int32
        Place of each contact's pair of blocks; of its blocks aa, ab, ba, bb where the pattern is whole.
    symmetric : bool
        Whether only the upper triangle is kept.
    """

    row_start: IntArray
    column: IntArray
    diagonal: IntArray
    place: IntArray
    symmetric: bool

    @property
    def rows(self) -> int:
        """Number of block rows."""
        return len(self.row_start) - 1


def block_pattern(n_blocks: int, block_a: IntArray, block_b: IntArray) -> BlockPattern:
    """Return the pattern of the pairs (block_a[c], block_b[c]) and the diagonal."""
    row_start, column, place = _pattern(n_blocks, block_a, block_b)
    return BlockPattern(row_start=row_start, column=column, diagonal=row_start[:-1].copy(), place=place, symmetric=True)


def whole_pattern(n_blocks: int, block_a: IntArray, block_b: IntArray) -> BlockPattern:
    """Return the pattern of both triangles, from the pairs (block_a[c], block_b[c]) and the diagonal."""
    upper = block_pattern(n_blocks, block_a, block_b)
    row_start, column, upper_at, lower_at = _mirror(upper.row_start, upper.column)
    diagonal = upper_at[upper.diagonal]
    low_first = (block_a < block_b)[:, None]
    across = np.column_stack([upper_at[upper.place], lower_at[upper.place]])  # (low, high) and (high, low)
    across = np.where(low_first, across, across[:, ::-1])
    place = np.column_stack([diagonal[block_a], across, diagonal[block_b]]).astype(np.int32, copy=False)
    return BlockPattern(row_start=row_start, column=column, diagonal=diagonal, place=place, symmetric=False)


def upper_triangle(whole: BlockPattern) -> tuple[BlockPattern, BoolArray]:
    """Return the pattern of the upper triangle of a whole one, and which of its places (n_places,) that has."""
    row = np.repeat(np.arange(whole.rows, dtype=np.int32), np.diff(whole.row_start))
    chosen = whole.column >= row
    row_start = np.zeros(whole.rows + 1, np.int32)
    row_start[1:] = np.cumsum(np.bincount(row[chosen], minlength=whole.rows))
    number = np.cumsum(chosen, dtype=np.int32) - 1
    upper = BlockPattern(
        row_start=row_start,
        column=whole.column[chosen],
        diagonal=row_start[:-1].copy(),
        place=number[np.where(chosen[whole.place[:, 1]], whole.place[:, 1], whole.place[:, 2])],
        symmetric=True,
    )
    return upper, chosen


@njit(allocates=True)
def _mirror(
    row_start: IntArray, column: IntArray
) -> tuple[IntArray, IntArray, IntArray, IntArray]:  # pragma: no cover - compiled
    """Return row starts and columns of the whole matrix, and where each upper place and its mirror image went."""
    n = row_start.size - 1
    start = np.zeros(n + 1, np.int32)
    for i in range(n):
        for p in range(row_start[i], row_start[i + 1]):
            start[i + 1] += 1
            if column[p] != i:
                start[column[p] + 1] += 1
    for i in range(n):
        start[i + 1] += start[i]
    fill = start[:-1].copy()
    whole = np.empty(start[n], np.int32)
    upper_at, lower_at = np.empty(column.size, np.int32), np.empty(column.size, np.int32)
    for i in range(n):  # rows rise, so the mirrored columns of a row rise too, before its own
        for p in range(row_start[i], row_start[i + 1]):
            j = column[p]
            if j != i:
                whole[fill[j]] = i
                lower_at[p] = fill[j]
                fill[j] += 1
            else:
                lower_at[p] = -1
    for i in range(n):
        for p in range(row_start[i], row_start[i + 1]):
            whole[fill[i]] = column[p]
            upper_at[p] = fill[i]
            if column[p] == i:
                lower_at[p] = fill[i]
            fill[i] += 1
    return start, whole, upper_at, lower_at


@njit(allocates=True)
def _pattern(
    n: int, block_a: IntArray, block_b: IntArray
) -> tuple[IntArray, IntArray, IntArray]:  # pragma: no cover - compiled
    """Return row starts, columns and places: a counting sort by row, an insertion sort within each row."""
    m = block_a.size
    start = np.zeros(n + 1, np.int64)
    for c in range(m):
        start[min(block_a[c], block_b[c]) + 1] += 1
    for i in range(n):
        start[i + 1] += start[i]
    fill = start[:-1].copy()
    contact = np.empty(m, np.int32)  # contacts in the order of their row
    for c in range(m):
        i = min(block_a[c], block_b[c])
        contact[fill[i]] = c
        fill[i] += 1
    row_start = np.empty(n + 1, np.int32)
    column = np.empty(m + n, np.int32)
    place = np.empty(m, np.int32)
    used = 0
    for i in range(n):
        row_start[i] = used
        column[used] = i
        used += 1
        first = used
        for k in range(start[i], start[i + 1]):
            c = contact[k]
            j = max(block_a[c], block_b[c])
            at = used
            while at > first and column[at - 1] >= j:
                at -= 1
            if at == used or column[at] != j:
                for shift in range(used, at, -1):
                    column[shift] = column[shift - 1]
                column[at] = j
                used += 1
        for k in range(start[i], start[i + 1]):
            c = contact[k]
            j = max(block_a[c], block_b[c])
            at = first
            while column[at] != j:
                at += 1
            place[c] = at
    row_start[n] = used
    return row_start, column[:used].copy(), place


@njit(allocates=True)
def fill_stiffness(
    row_start: IntArray,
    block_a: IntArray,
    block_b: IntArray,
    place: IntArray,
    n_places: int,
    point: FloatArray,
    normal: FloatArray,
    stiffness_n: FloatArray,
    stiffness_s: FloatArray,
    centroid: FloatArray,
) -> FloatArray:  # pragma: no cover - compiled
    """Return the 3 x 3 blocks of K, (n_places, 3, 3): B^T T^T k T D of every contact (Wang Eq. 3.19)."""
    data = np.zeros((n_places, 3, 3))
    g = np.empty(3)  # rows of T B for the block with the lower and the higher number
    h = np.empty(3)
    for c in range(block_a.size):
        low, high = min(block_a[c], block_b[c]), max(block_a[c], block_b[c])
        for spring in range(2):
            if spring == 0:
                k, dx, dy = stiffness_n[c], normal[c, 0], normal[c, 1]
            else:
                k, dx, dy = stiffness_s[c], -normal[c, 1], normal[c, 0]
            if k == 0.0:
                continue
            g[0] = dx
            g[1] = dy
            g[2] = (point[c, 0] - centroid[low, 0]) * dy - (point[c, 1] - centroid[low, 1]) * dx
            h[0] = dx
            h[1] = dy
            h[2] = (point[c, 0] - centroid[high, 0]) * dy - (point[c, 1] - centroid[high, 1]) * dx
            at_low, at_high, across = row_start[low], row_start[high], place[c]
            for r in range(3):
                for s in range(3):
                    data[at_low, r, s] += k * g[r] * g[s]
                    data[at_high, r, s] += k * h[r] * h[s]
                    data[across, r, s] -= k * g[r] * h[s]
    return data


@njit(allocates=True)
def constrain(
    row_start: IntArray,
    column: IntArray,
    diagonal: IntArray,
    data: FloatArray,
    number: IntArray,
    basis: FloatArray,
    constrained: IntArray,
) -> None:  # pragma: no cover - compiled
    """Rotate the rows and columns of supported blocks into their own axes and strike out constrained ones, in place.

    Parameters
    ----------
    row_start, column, diagonal, data
        The pattern and its blocks.
    number : (n,) int32
        Row of each block in `basis` and `constrained`; -1 for a block without support.
    basis : (k, axes, axes) float64
        Columns: the block's own axes, constrained ones first.
    constrained : (k,) int32
        Number of constrained axes.
    """
    for i in range(row_start.size - 1):
        for p in range(row_start[i], row_start[i + 1]):
            j = column[p]
            if number[i] >= 0:
                _multiply(data[p], basis[number[i]], True)
                data[p, : constrained[number[i]], :] = 0.0
            if number[j] >= 0:
                _multiply(data[p], basis[number[j]], False)
                data[p, :, : constrained[number[j]]] = 0.0
        if number[i] >= 0:
            for r in range(constrained[number[i]]):
                data[diagonal[i], r, r] = 1.0


@njit(allocates=True)
def _multiply(block: FloatArray, basis: FloatArray, from_left: bool) -> None:  # pragma: no cover - compiled
    """Replace a block by basis^T block, or by block basis."""
    old, axes = block.copy(), block.shape[0]
    for r in range(axes):
        for s in range(axes):
            block[r, s] = 0.0
            for t in range(axes):
                block[r, s] += basis[t, r] * old[t, s] if from_left else old[r, t] * basis[t, s]
