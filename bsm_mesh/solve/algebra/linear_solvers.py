"""Linear solvers by name, behind one small protocol: analyse a pattern once, factorize values, solve."""

from __future__ import annotations

from typing import Protocol

from bsm_mesh.arrays import FloatArray
from bsm_mesh.errors import ModelError, nearest
from bsm_mesh.solve.algebra import pardiso
from bsm_mesh.solve.algebra.block_matrix import BlockPattern
from bsm_mesh.solve.algebra.mixed_precision import MixedPrecisionPardiso
from bsm_mesh.solve.algebra.ordering import elimination_order
from bsm_mesh.solve.algebra.superlu import SuperLU


class LinearSolver(Protocol):
    """A direct solver for a symmetric matrix of small blocks whose pattern stays."""

    name: str

    def factorize(self, data: FloatArray) -> None:
        """Factorize the values (n_places, axes, axes) of the upper triangle.

        Raises
        ------
        SingularMatrixError
            If the matrix is not positive definite.
        """

    def solve(self, right_side: FloatArray) -> FloatArray:
        """Return x (n, axes) of K x = right_side (n, axes) with the last factors."""

    def close(self) -> None:
        """Give the memory of the factors back."""


def make_linear_solver(
    name: str,
    pattern: BlockPattern,
    position: FloatArray,
    threads: int = 0,
    *,
    once: bool = False,
    corrections: bool = False,
    definite: bool = False,
    single: bool = True,
) -> LinearSolver:
    """Return the named solver with the pattern analysed when first factorized.

    Parameters
    ----------
    name : {"auto", "pardiso", "superlu", "cluster"}
        ``"auto"`` is Pardiso where the `mkl` package is installed, else SuperLU. ``"cluster"`` is Pardiso on MPI
        ranks. The results record which.
    pattern : BlockPattern
        Upper triangle of the matrix.
    position : (n, 2 or 3) float64 [m]
        Centroids of the blocks, for an elimination order.
    threads : int
        Threads that Pardiso may use; 0: as many as there are cores.
    once : bool
        Whether the pattern will be factorized once only: then Pardiso takes a quick order instead of a good one.
    corrections : bool
        Whether solutions need four digits only: then Pardiso factorizes large systems in single precision.
    definite : bool
        Whether `factorize` must find out that a matrix is not positive definite.
    single : bool
        False: double precision also where single would do for corrections.

    Raises
    ------
    ModelError
        For an unknown name, or Pardiso where it is not installed.
    """
    if name == "auto":
        name = "pardiso" if pardiso.is_available() else "superlu"
    if name == "pardiso" and corrections and pattern.rows >= pardiso.LARGE:
        return MixedPrecisionPardiso(pattern, threads, single=single)
    if name == "pardiso":
        return pardiso.Pardiso(pattern, threads, elimination_order(pattern, position) if once else None)
    if name == "cluster":
        from bsm_mesh.solve.algebra.pardiso_mpi import ClusterPardiso  # MPI: only where it is asked for

        return ClusterPardiso(pattern, threads)
    if name == "superlu":
        return SuperLU(pattern, position, definite=definite)
    raise ModelError(f"linear_solver: '{name}' is unknown{nearest(name, ('auto', 'pardiso', 'superlu', 'cluster'))}")
