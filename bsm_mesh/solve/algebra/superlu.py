"""SciPy's SuperLU on small blocks: the linear solver that is there everywhere."""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.compiled import njit
from bsm_mesh.errors import SingularMatrixError
from bsm_mesh.solve.algebra.block_matrix import BlockPattern
from bsm_mesh.solve.algebra.ordering import elimination_order


class SuperLU:
    """SciPy's SuperLU in symmetric mode, the blocks ordered by nested dissection.

    SuperLU's own orderings of 1e5 blocks take from ten seconds to minutes; one on the blocks, by their position,
    takes a fraction of a second and leaves the blocks whole for SuperLU's supernodes.

    Parameters
    ----------
    pattern : BlockPattern
        The matrix.
    position : (n, 2 or 3) float64 [m]
        Centroids of the blocks.
    definite : bool
        Whether to look at the pivots, of which it makes a copy: else a matrix that is not positive definite passes.
    """

    name = "superlu"

    def __init__(self, pattern: BlockPattern, position: FloatArray, *, definite: bool = False) -> None:
        self._pattern, self._definite = pattern, definite
        self._order = elimination_order(pattern, position)
        position = np.empty(pattern.rows, dtype=np.int32)
        position[self._order] = np.arange(pattern.rows, dtype=np.int32)
        self._columns = _full_columns(pattern.row_start, pattern.column, position, pattern.symmetric)
        self._factors = None

    def factorize(self, data: FloatArray) -> None:
        """Factorize without pivoting: the matrix is positive definite."""
        from scipy.sparse import csc_array
        from scipy.sparse.linalg import splu

        start, row, source = self._columns
        values, indices, pointers = _scalar_columns(start, row, source, data)
        n = data.shape[1] * self._pattern.rows
        try:
            factors = splu(
                csc_array((values, indices, pointers), shape=(n, n)),
                permc_spec="NATURAL",
                diag_pivot_thresh=0.0,
                options={"SymmetricMode": True},
            )
        except RuntimeError as error:
            raise SingularMatrixError(str(error)) from error
        if self._definite and not (factors.U.diagonal() > 0).all():
            raise SingularMatrixError("SuperLU found a pivot that is not positive")
        self._factors = factors

    def solve(self, right_side: FloatArray) -> FloatArray:
        """Return the solution (n, axes)."""
        assert self._factors is not None
        x = np.empty_like(right_side)
        x[self._order] = self._factors.solve(right_side[self._order].reshape(-1)).reshape(x.shape)
        return x

    def close(self) -> None:
        """Drop the factors."""
        self._factors = None


@njit(allocates=True)
def _full_columns(
    row_start: IntArray, column: IntArray, position: IntArray, symmetric: bool
) -> tuple[IntArray, IntArray, IntArray]:  # pragma: no cover - compiled
    """Return the reordered full block matrix by columns: starts, rows, and source place (-place - 1: transposed)."""
    n = row_start.size - 1
    start = np.zeros(n + 1, np.int32)
    for i in range(n):
        for p in range(row_start[i], row_start[i + 1]):
            start[position[column[p]] + 1] += 1
            if symmetric and column[p] != i:
                start[position[i] + 1] += 1
    for i in range(n):
        start[i + 1] += start[i]
    fill = start[:-1].copy()
    row = np.empty(start[n], np.int32)
    source = np.empty(start[n], np.int32)
    for i in range(n):
        for p in range(row_start[i], row_start[i + 1]):
            j = column[p]
            at = fill[position[j]]
            row[at] = position[i]
            source[at] = p
            fill[position[j]] += 1
            if symmetric and j != i:
                at = fill[position[i]]
                row[at] = position[j]
                source[at] = -p - 1
                fill[position[i]] += 1
    for j in range(n):  # rows rise within a column
        for a in range(start[j] + 1, start[j + 1]):
            r, s, b = row[a], source[a], a
            while b > start[j] and row[b - 1] > r:
                row[b] = row[b - 1]
                source[b] = source[b - 1]
                b -= 1
            row[b] = r
            source[b] = s
    return start, row, source


@njit(allocates=True)
def _scalar_columns(
    start: IntArray, row: IntArray, source: IntArray, data: FloatArray
) -> tuple[FloatArray, IntArray, IntArray]:  # pragma: no cover - compiled
    """Return values, row indices and column starts of the scalar matrix."""
    n = start.size - 1
    axes = data.shape[1]
    values = np.empty(axes * axes * row.size)
    indices = np.empty(axes * axes * row.size, np.int32)
    pointers = np.empty(axes * n + 1, np.int32)
    at = 0
    for j in range(n):
        for s in range(axes):
            pointers[axes * j + s] = at
            for p in range(start[j], start[j + 1]):
                for r in range(axes):
                    indices[at] = axes * row[p] + r
                    values[at] = data[source[p], r, s] if source[p] >= 0 else data[-source[p] - 1, s, r]
                    at += 1
    pointers[axes * n] = at
    return values, indices, pointers
