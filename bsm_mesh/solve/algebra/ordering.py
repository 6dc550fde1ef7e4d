"""An order of the blocks in which factorizing makes little fill: nested dissection by their positions."""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.compiled import njit
from bsm_mesh.solve.algebra.block_matrix import BlockPattern


def elimination_order(pattern: BlockPattern, position: FloatArray) -> IntArray:
    """Return the blocks in the order in which they are eliminated."""
    from scipy.sparse import csr_array

    n = pattern.rows
    upper = csr_array((np.ones(len(pattern.column), np.int8), pattern.column, pattern.row_start), shape=(n, n))
    graph = csr_array(upper + upper.T) if pattern.symmetric else upper
    order: IntArray = nested_dissection(graph.indptr, graph.indices, position)
    return order


@njit(allocates=True)
def nested_dissection(
    start: IntArray, neighbour: IntArray, position: FloatArray
) -> IntArray:  # pragma: no cover - compiled
    """Return the blocks in elimination order (George 1973): both halves first, the cut between them last.

    Parts are cut at the median of the coordinate along which they are longer; the cut is the blocks of the
    lower half with a neighbour in the upper one.

    Parameters
    ----------
    start : (n + 1,) int32
        Block i has the neighbours ``neighbour[start[i]:start[i + 1]]``.
    neighbour : (k,) int32
        Neighbours of every block, both ways.
    position : (n, 2 or 3) float64 [m]
        Centroids.
    """
    n = start.size - 1
    order = np.arange(n).astype(np.int32)
    upper = np.zeros(n, np.int32)  # number of the last cut of which a block was in the upper half
    cut = 0
    parts = [(0, n)]
    while len(parts) > 0:
        first, last = parts.pop()
        if last - first < 2:
            continue
        members = order[first:last].copy()
        cut += 1
        _mark_upper_half(members, position, upper, cut)
        lower_end, separator_start = first, last
        upper_part = np.empty(members.size, np.int32)
        n_upper = 0
        for i in members:
            if upper[i] == cut:
                upper_part[n_upper] = i
                n_upper += 1
                continue
            touches = False
            for p in range(start[i], start[i + 1]):
                if upper[neighbour[p]] == cut:
                    touches = True
                    break
            if touches:
                separator_start -= 1
                order[separator_start] = i
            else:
                order[lower_end] = i
                lower_end += 1
        for k in range(n_upper):
            order[lower_end + k] = upper_part[k]
        if n_upper == 0 or lower_end == first:  # all at one coordinate: leave it
            continue
        parts.append((first, lower_end))
        parts.append((lower_end, separator_start))
    return order


@njit(allocates=True)
def _mark_upper_half(
    members: IntArray, position: FloatArray, upper: IntArray, cut: int
) -> None:  # pragma: no cover - compiled
    """Set `upper` (n,) of the members beyond the median of the coordinate along which they are longer to `cut`."""
    axis, longest, highest = 0, -np.inf, np.inf
    for other in range(position.shape[1]):
        low, high = np.inf, -np.inf
        for i in members:
            low, high = min(low, position[i, other]), max(high, position[i, other])
        if high - low > longest:
            axis, longest, highest = other, high - low, high
    along = np.empty(members.size)
    for k in range(members.size):
        along[k] = position[members[k], axis]
    middle = np.median(along)
    for k in range(members.size):
        if along[k] > middle or along[k] == middle == highest:
            upper[members[k]] = cut
