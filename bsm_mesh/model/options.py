"""How a model is solved."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, Literal, get_args

from bsm_mesh.errors import raise_faults
from bsm_mesh.model.falls import Falls
from bsm_mesh.model.quantities import DISPLACEMENT_LIMIT, PART, STEPS, THREADS, TOLERANCE
from bsm_mesh.model.values import Rules

Scheme = Literal["linear", "continuation", "wang"]
LinearSolverName = Literal["auto", "pardiso", "superlu", "cluster"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Options:
    """How a model is solved.

    Attributes
    ----------
    scheme : {"linear", "continuation", "wang"}
        ``"linear"``: one step, small displacements, every contact carries tension and any shear (Wang ch. 3).
        ``"continuation"``: joints slip and open, blocks move far, the verdict is found (Wang ch. 4 in purpose).
        ``"wang"``: the iteration of Wang Fig. 4.9, corrected, to compare with the thesis only: slow where blocks slide.
    tolerance : float
        Largest residual force of a block in equilibrium, over the reference weight. That is the greatest of the blocks'
        mean weight, the mean load of a loaded block and the contacts' mean force at the start. 1e-12 to 1e-4.
    max_steps : int
        Steps of the continuation, cycles of ``"wang"``, after which it gives up: `not_converged`.
    displacement_limit : float or None [m]
        A block with a larger displacement is unstable; None: the size of the model.
    sliding_stiffness : float
        ``"wang"``: least part of their shear stiffness that sliding contacts keep in the stiffness matrix; it halves
        from cycle to cycle down to that. 1 keeps all of it; the less, the further a cycle moves sliding blocks.
    linear_solver : {"auto", "pardiso", "superlu", "cluster"}
        ``"auto"``: Pardiso where the `mkl` package is installed, else SuperLU; the results say which. ``"cluster"``:
        Pardiso on MPI ranks (`bsm_mesh.solve.cluster`).
    threads : int
        Threads of the linear solver, of every MPI rank, and of explicit cycles; 0: as many as there are cores.
    falls : Falls
        The treatment of unstable blocks.

    Examples
    --------
    >>> import bsm_mesh as bsm
    >>> bsm.Options(scheme="linear").scheme
    'linear'
    >>> bsm.Options(displacement_limit=1.0, falls=bsm.Falls(on_fall="remove")).falls.on_fall
    'remove'
    """

    scheme: Scheme = "continuation"
    tolerance: Annotated[float, TOLERANCE] = 1e-6
    max_steps: Annotated[int, STEPS] = 500
    displacement_limit: Annotated[float, DISPLACEMENT_LIMIT] | None = None
    sliding_stiffness: Annotated[float, PART] = 1e-6
    linear_solver: LinearSolverName = "auto"
    threads: Annotated[int, THREADS] = 0
    falls: Falls = field(default_factory=Falls)

    def __post_init__(self) -> None:
        rules = Rules("solver")
        rules.numbers(self)
        rules.choice("scheme", self.scheme, get_args(Scheme))
        rules.choice("linear_solver", self.linear_solver, get_args(LinearSolverName))
        rules.a_thing("falls", self.falls, Falls)
        raise_faults(rules.faults)
