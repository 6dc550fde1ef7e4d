"""Mixed precision: Pardiso's factors in single precision, solutions refined with the matrix in double."""

from __future__ import annotations

import numpy as np
from scipy.sparse import bsr_array

from bsm_mesh.arrays import FloatArray
from bsm_mesh.errors import SingularMatrixError
from bsm_mesh.solve.algebra.block_matrix import BlockPattern
from bsm_mesh.solve.algebra.pardiso import Pardiso

ACCURACY = 1e-4  # of a solution's right side, rows over the root of their diagonal: what Newton's method needs
# Part that one more solution with the same factors may leave, or it is the last: rounding is near, or other factors are
# cheaper. A refinement in a wall of 400 000 leaves a fiftieth.
WORTH_REPEATING = 0.5


class MixedPrecisionPardiso:
    """Pardiso for corrections that need only be good: single precision, and double where that does not do.

    Parameters
    ----------
    pattern : BlockPattern
        The whole matrix.
    threads : int
        As `Pardiso` takes them.
    single : bool
        False: double precision from the start.

    Attributes
    ----------
    single : bool
        Whether factors are of single precision still.
    """

    name = "pardiso"

    def __init__(self, pattern: BlockPattern, threads: int = 0, *, single: bool = True) -> None:
        self._pattern, self._threads = pattern, threads
        self._solver, self.single = Pardiso(pattern, threads, single=single), single
        self._data = self._root = np.zeros(0)

    def factorize(self, data: FloatArray) -> None:
        """Factorize the values (n_places, axes, axes)."""
        self._data = data
        self._root = np.sqrt(np.abs(np.einsum("kii->ki", data[self._pattern.diagonal])))
        try:
            self._solver.factorize(data)
        except SingularMatrixError:
            if not self.single:
                raise
            self._go_double()

    def solve(self, right_side: FloatArray) -> FloatArray:
        """Return the solution (n, axes) to `ACCURACY`; not a number where the matrix turns out to be singular."""
        if not self.single:
            return self._solver.solve(right_side)
        matrix = bsr_array((self._data, self._pattern.column, self._pattern.row_start))
        wanted = ACCURACY * self._size(right_side)
        x, left, size = np.zeros_like(right_side), right_side, np.inf
        while True:
            x = x + self._solved(left)
            left = right_side - (matrix @ x.ravel()).reshape(x.shape)
            before, size = size, self._size(left)
            if size <= wanted:
                return x
            if not size < WORTH_REPEATING * before:
                break
        try:
            self._go_double()
        except SingularMatrixError:  # which single precision did not notice
            return np.full_like(right_side, np.nan)
        return self._solver.solve(right_side)

    def _solved(self, right_side: FloatArray) -> FloatArray:
        """Return the solution by the single factors; forces are scaled into the middle of what single numbers hold."""
        size = float(np.abs(right_side).max())
        return self._solver.solve(right_side / size) * size if size > 0 else np.zeros_like(right_side)

    def _size(self, forces: FloatArray) -> float:
        return float((np.abs(forces) / np.where(self._root > 0, self._root, 1.0)).max())

    def _go_double(self) -> None:
        self._solver.close()
        self._solver, self.single = Pardiso(self._pattern, self._threads), False
        self._solver.factorize(self._data)

    def close(self) -> None:
        """Release the factors."""
        self._solver.close()
