"""`Options` for scripts that take it from here; it is of the model."""

from bsm_mesh.model.options import LinearSolverName, Options, Scheme

__all__ = ["LinearSolverName", "Options", "Scheme"]
