"""Task and result of a method: a trial solution that owns its contacts, so nothing is rolled back."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import Protocol

from bsm_mesh.arrays import BoolArray, FloatArray
from bsm_mesh.solve.step.equations import StepEquations
from bsm_mesh.solve.step.system import Contacts, Evaluation

# Rms residual over the mean weight with which a step may end ACCEPTABLE though few blocks exceed the goal: later steps
# take it up.
MAX_RMS = 0.03
# Residual over the mean weight below which few contacts change: they are searched for there, and Newton's tangent is
# exact; more digits would be lost before.
FEW_CHANGE = 1e-3


class Outcome(StrEnum):
    """How a method ended."""

    SOLVED = "solved"  # the residual is below the goal
    ACCEPTABLE = "acceptable"  # few blocks exceed it, or blocks move on: the step may end here
    STALLED = "stalled"
    SINGULAR = "singular"


@dataclass(frozen=True, slots=True, kw_only=True)
class Goal:
    """Goal of a step.

    Attributes
    ----------
    max_residual : float
        Maximum norm of the residual, over the mean weight.
    rest : float
        The same, of a model at rest: the smallest that a step asks for, so that the next has only to confirm it.
    """

    max_residual: float
    rest: float


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Iterate:
    """Where a step begins, without its equations.

    Attributes
    ----------
    residual : float
        Maximum norm of the static residual, over the reference weight.
    velocity : (n, axes) float64 or None [sqrt(m), rad / sqrt(m)]
        Of blocks that are followed: its square is twice the height of a free fall to it. None: at rest.
    moving_steps : int
        Steps of explicit motion since blocks were last in equilibrium.
    """

    residual: float
    velocity: FloatArray | None = None
    moving_steps: int = 0


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Attempt:
    """A trial solution of a step.

    Attributes
    ----------
    equations : StepEquations
        With the contacts as the method left them.
    position : (n, axes) float64 [m, rad]
        Where it ended.
    outcome : Outcome
        How.
    velocity : (n, axes) float64 or None
        As in `Iterate`, after explicit motion.
    contacted : (m,) bool or None
        Which contacts were closed at any time of the step; None: those closed at its end.
    """

    equations: StepEquations
    position: FloatArray
    outcome: Outcome
    velocity: FloatArray | None = None
    contacted: BoolArray | None = None

    @property
    def may_end(self) -> bool:
        """Whether the step may end with it."""
        return self.outcome in (Outcome.SOLVED, Outcome.ACCEPTABLE)

    @property
    def contacts(self) -> Contacts:
        """The contacts at its end."""
        return self.equations.contacts

    @property
    def at(self) -> Evaluation:
        """The contact forces at its end."""
        return self.equations.evaluate(self.position)


class Method(Protocol):
    """A way to end a step."""

    name: str

    def applies(self, equations: StepEquations, at: Iterate, goal: Goal) -> bool:
        """Return whether it is worth trying: the only place where such a condition may stand."""

    def solve(self, equations: StepEquations, at: Iterate, goal: Goal) -> Attempt:
        """Return a trial solution."""
