"""How a model is solved."""

from __future__ import annotations

from dataclasses import dataclass
from numbers import Integral
from typing import Literal, get_args

from bsm_mesh.errors import nearest, raise_faults
from bsm_mesh.model.values import Rules

Scheme = Literal["linear", "continuation"]
LinearSolverName = Literal["auto", "pardiso", "superlu"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Options:
    """How a model is solved.

    Attributes
    ----------
    scheme : {"linear"}
        ``"linear"``: one step, small displacements, every contact carries tension and any shear (Wang ch. 3).
    tolerance : float
        Greatest force out of balance of a block that counts as equilibrium, over the reference weight.
    linear_solver : {"auto", "pardiso", "superlu"}
        ``"auto"``: Pardiso where the `mkl` package is installed, else SuperLU; the results say which.
    threads : int
        Threads of the linear solver; 0: as many as there are cores.
    """

    scheme: Scheme = "linear"
    tolerance: float = 1e-6
    max_steps: int = 500
    displacement_limit: float | None = None
    linear_solver: LinearSolverName = "auto"
    threads: int = 0

    def __post_init__(self) -> None:
        rules = Rules("solver")
        rules.number("tolerance", self.tolerance, "", above=0, below=1)
        rules.number("threads", self.threads, "", least=0)
        if not isinstance(self.threads, Integral):
            rules.faults.append(f"solver: threads = {self.threads!r} must be a whole number")
        for name, known in (("scheme", get_args(Scheme)), ("linear_solver", get_args(LinearSolverName))):
            value = getattr(self, name)
            if value not in known:
                rules.faults.append(f"solver: {name} = {value!r} is unknown{nearest(str(value), known)}")
        raise_faults(rules.faults)
