"""`ranks`, for scripts that solve with MPI (docs/performance.md); the solver itself is `algebra.pardiso_mpi`."""

from bsm_mesh.solve.algebra.pardiso_mpi import ranks

__all__ = ["ranks"]
