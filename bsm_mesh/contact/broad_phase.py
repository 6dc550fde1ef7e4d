"""Broad phase of the contact search: pairs of blocks with overlapping boxes, in linear time, by a uniform grid.

The cells follow the median box. A block is entered in the cells that its box covers; one that
covers many (a base under a wall, a long outline round everything) only in the cells along its edges, because
contacts lie there. A cell crowded with small blocks is swept along x. No table of all cells is kept: the entries
are sorted by column, then by row, so neither a long diagonal chain nor a block that flew off costs memory.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from bsm_mesh.arrays import BoolArray, IntArray
from bsm_mesh.compiled import njit
from bsm_mesh.contact.outlines import RecordArray

CELL = 1.25  # cell over the median of the boxes' longer sides: most boxes then lie in one to four cells
MANY_CELLS = 9  # a box that covers more is entered along its edges
CROWD = 24  # entries in a cell from which sorting and sweeping pays


class _Grid(NamedTuple):
    """Cells: an origin in the middle of the blocks, columns and rows counted from -reach to reach; far ones merge."""

    x: float
    y: float
    cell: float
    reach: int


def near_pairs(vertices: RecordArray, blocks: RecordArray) -> IntArray:
    """Return the pairs of blocks that may touch, (k, 2) int32: lower number first, sorted, each once.

    All pairs whose boxes overlap are returned, except those of two fixed blocks, and those of a large block with one
    that is near none of its edges.
    """
    if len(blocks) < 2:
        return np.empty((0, 2), dtype=np.int32)
    side = np.maximum(blocks["x1"] - blocks["x0"], blocks["y1"] - blocks["y0"])
    grid = _Grid(
        x=float(np.median(blocks["x0"])),
        y=float(np.median(blocks["y0"])),
        cell=CELL * float(np.median(side)),
        reach=2 * len(blocks) + 64,
    )
    owner, column, row, large = _enter_blocks(vertices, blocks, grid)
    order = _sort_by(column, np.arange(len(owner), dtype=np.int32), 2 * grid.reach + 1)
    order = _sort_by(row, order, 2 * grid.reach + 1)
    found = _pairs_in_cells(owner[order], column[order], row[order], large, blocks, grid)
    return _sorted_once(found, len(blocks))


@njit(inline="always")
def _cell_of(x: float, origin: float, grid: _Grid) -> int:  # pragma: no cover - compiled
    """Return the column (or row) of a coordinate, from 0; what lies beyond the reach is put in the last one."""
    k = np.floor((x - origin) / grid.cell)
    return int(min(max(k, -grid.reach), grid.reach)) + grid.reach


@njit(allocates=True)
def _enter_blocks(
    vertices: RecordArray, blocks: RecordArray, grid: _Grid
) -> tuple[IntArray, IntArray, IntArray, BoolArray]:  # pragma: no cover - compiled
    """Return the entries (block, column, row) in the grid, and which blocks are entered along their edges."""
    n = blocks.size
    entries = np.empty((4 * n + 64, 3), np.int32)
    count = np.int64(0)  # the kernels below would be compiled for a constant too
    large = np.zeros(n, np.bool_)
    for b in range(n):
        x0, y0, x1, y1 = blocks[b].x0, blocks[b].y0, blocks[b].x1, blocks[b].y1
        columns = _cell_of(x1, grid.x, grid) - _cell_of(x0, grid.x, grid) + 1
        rows = _cell_of(y1, grid.y, grid) - _cell_of(y0, grid.y, grid) + 1
        large[b] = columns * rows > MANY_CELLS
        if large[b]:
            first, last = blocks[b].first, blocks[b].last
            margin = vertices[first:last].x.min() - x0
            for i in range(first, last):
                k = i + 1 if i + 1 < last else first
                start, end = (vertices[i].x, vertices[i].y), (vertices[k].x, vertices[k].y)
                entries, count = _enter_edge(entries, count, b, start, end, margin, grid)
        else:
            entries, count = _enter_box(entries, count, b, x0, y0, x1, y1, grid)
    return entries[:count, 0].copy(), entries[:count, 1].copy(), entries[:count, 2].copy(), large


@njit(allocates=True)
def _enter_edge(
    entries: IntArray,
    count: int,
    block: int,
    start: tuple[float, float],
    end: tuple[float, float],
    margin: float,
    grid: _Grid,
) -> tuple[IntArray, int]:  # pragma: no cover - compiled
    """Enter the cells along an edge, piece by piece, each as long as a cell."""
    dx, dy = end[0] - start[0], end[1] - start[1]
    pieces = int(np.ceil(max(abs(dx), abs(dy)) / grid.cell)) + 1
    for p in range(pieces):
        xa, ya = start[0] + dx * p / pieces, start[1] + dy * p / pieces
        xb, yb = start[0] + dx * (p + 1) / pieces, start[1] + dy * (p + 1) / pieces
        low_x, low_y = min(xa, xb) - margin, min(ya, yb) - margin
        entries, count = _enter_box(
            entries, count, block, low_x, low_y, max(xa, xb) + margin, max(ya, yb) + margin, grid
        )
    return entries, count


@njit(allocates=True)
def _enter_box(
    entries: IntArray, count: int, block: int, x0: float, y0: float, x1: float, y1: float, grid: _Grid
) -> tuple[IntArray, int]:  # pragma: no cover - compiled
    """Enter all cells of a box."""
    for column in range(_cell_of(x0, grid.x, grid), _cell_of(x1, grid.x, grid) + 1):
        for row in range(_cell_of(y0, grid.y, grid), _cell_of(y1, grid.y, grid) + 1):
            if count == entries.shape[0]:
                entries = _longer(entries)
            entries[count, 0], entries[count, 1], entries[count, 2] = block, column, row
            count += 1
    return entries, count


@njit(allocates=True)
def _sort_by(key: IntArray, order: IntArray, n_keys: int) -> IntArray:  # pragma: no cover - compiled
    """Return `order` sorted by key (0 <= key < n_keys), equal keys left in their order (counting sort)."""
    start = np.zeros(n_keys + 1, np.int32)
    for k in key:
        start[k + 1] += 1
    for k in range(n_keys):
        start[k + 1] += start[k]
    out = np.empty_like(order)
    for i in order:
        out[start[key[i]]] = i
        start[key[i]] += 1
    return out


@njit(allocates=True)
def _pairs_in_cells(
    owner: IntArray,
    column: IntArray,
    row: IntArray,
    large: BoolArray,
    blocks: RecordArray,
    grid: _Grid,
) -> IntArray:  # pragma: no cover - compiled
    """Return the pairs (k, 2) found cell by cell; pairs with a large block may come several times."""
    pairs = np.empty((4 * blocks.size + 64, 2), np.int32)
    count = 0
    first = 0
    while first < owner.size:
        last = first + 1
        while last < owner.size and column[last] == column[first] and row[last] == row[first]:
            last += 1
        members = owner[first:last]
        swept = last - first > CROWD
        if swept:
            members = members[np.argsort(blocks["x0"][members])]
        for p in range(members.size):
            i = members[p]
            for q in range(p + 1, members.size):
                j = members[q]
                if blocks[j].x0 > blocks[i].x1:
                    if swept:
                        break
                    continue
                if blocks[i].x0 > blocks[j].x1 or blocks[i].y0 > blocks[j].y1 or blocks[j].y0 > blocks[i].y1:
                    continue
                if i == j or (blocks[i].fixed and blocks[j].fixed):
                    continue
                if not (large[i] or large[j]):  # two boxes: counted in the cell of their overlap's lower left corner
                    if _cell_of(max(blocks[i].x0, blocks[j].x0), grid.x, grid) != column[first]:
                        continue
                    if _cell_of(max(blocks[i].y0, blocks[j].y0), grid.y, grid) != row[first]:
                        continue
                if count == pairs.shape[0]:
                    pairs = _longer(pairs)
                pairs[count, 0], pairs[count, 1] = min(i, j), max(i, j)
                count += 1
        first = last
    return pairs[:count]


@njit(allocates=True)
def _longer(rows: IntArray) -> IntArray:  # pragma: no cover - compiled
    """Return twice as many rows that begin with these. For slices Numba compiles a message about shapes, in 2 s."""
    longer = np.empty((2 * rows.shape[0], rows.shape[1]), np.int32)
    for i in range(rows.shape[0]):
        for k in range(rows.shape[1]):
            longer[i, k] = rows[i, k]
    return longer


def _sorted_once(pairs: IntArray, n_blocks: int) -> IntArray:
    """Return the pairs sorted by lower, then higher block, each once."""
    lower, higher = pairs.T.copy()
    order = _sort_by(higher, np.arange(len(pairs), dtype=np.int32), n_blocks)
    order = _sort_by(lower, order, n_blocks)
    lower, higher = lower[order], higher[order]
    first = np.ones(len(pairs), dtype=bool)
    first[1:] = (lower[1:] != lower[:-1]) | (higher[1:] != higher[:-1])
    return np.stack([lower[first], higher[first]], axis=1)
