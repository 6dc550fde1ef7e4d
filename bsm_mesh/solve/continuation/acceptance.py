"""Phase of a step of the continuation, its tolerance, and whether an attempt may end it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from bsm_mesh.model.options import Options
from bsm_mesh.solve.continuation.pace import Pace
from bsm_mesh.solve.continuation.plan import Phase
from bsm_mesh.solve.continuation.stability import falling_mode
from bsm_mesh.solve.motion.following import accelerates, is_fast
from bsm_mesh.solve.step.attempt import Attempt, Goal, Iterate
from bsm_mesh.solve.step.equations import StepEquations
from bsm_mesh.solve.step.system import System


@dataclass(frozen=True, slots=True, kw_only=True)
class AcceptanceSettings:
    """How exactly a step is solved.

    Attributes
    ----------
    min_inner : float
        Smallest tolerance of a step over that of rest: below 1, so that rest in a step is rest in the next step too,
        and no smaller, for in large models rounding is near.
    reduction : float
        Part of a step's residual to which it is solved.
    push : float
        Movement out of an unstable equilibrium, over the step length.
    """

    min_inner: float = 0.5
    reduction: float = 1e-2
    push: float = 0.01


SETTINGS = AcceptanceSettings()


class Acceptance:
    """Phase, goal and end of the steps of a run.

    Parameters
    ----------
    system : System
        The blocks.
    options : Options
        Tolerance.
    intact : bool
        Whether all contacts are intact where the run begins.

    Attributes
    ----------
    pace : Pace
        When an equilibrium is looked for.
    """

    def __init__(self, system: System, options: Options, *, intact: bool) -> None:
        self._system, self._options, self._intact = system, options, intact
        self.pace = Pace()

    @property
    def tolerance(self) -> float:
        """Maximum norm of the residual at rest, over the mean weight."""
        return self._options.tolerance * self._system.residual_scale

    def phase(self, equations: StepEquations, iterate: Iterate, number: int) -> Phase:
        """Return the phase of a step, by its number and where it begins."""
        if number == 0 and iterate.velocity is None:
            return Phase.START if self._intact else Phase.AFTER_CHANGE
        if iterate.velocity is not None and (
            self.pace.wait > 0 or is_fast(equations, iterate) or accelerates(equations, iterate)
        ):
            return Phase.MOVING
        return Phase.NEAR_REST

    def goal(self, iterate: Iterate) -> Goal:
        """Return the goal of a step.

        At rest a part of the residual at its start is enough: steps to come take up the others. Velocities end in an
        equilibrium only, or what slides slowly would stop at every step.
        """
        rest, residual = SETTINGS.min_inner * self.tolerance, 0.0 if iterate.velocity is not None else iterate.residual
        wanted = SETTINGS.reduction * min(residual, 1.0) * self._system.residual_scale
        return Goal(max_residual=max(rest, wanted), rest=rest)

    def accepted(self, attempt: Attempt, phase: Phase, *, moving: bool, quiet: bool) -> Attempt | None:
        """Return an attempt if the step may end with it, and count the step; else None.

        Where it leads to an unstable equilibrium blocks at rest are moved on a little, as they would fall from there,
        and followed. Moving blocks never end there: an equilibrium that nothing holds them in is not on their way.
        `moving`, `quiet`: they had velocities when the step began, or were at rest.
        """
        if not attempt.may_end:
            return None
        if attempt.velocity is None:
            if not attempt.equations.within_search_range(attempt.position):
                return None
            mode = None if quiet else falling_mode(attempt.equations, attempt.position, attempt.at, self.tolerance)
            if mode is not None:
                if moving:
                    return None
                self.pace = self.pace.followed()
                pushed = self._system.moved_by(attempt.position, SETTINGS.push * self._system.d * mode)
                attempt = replace(attempt, position=pushed, velocity=np.zeros_like(pushed))
        self.pace = self.pace.counted(moves=attempt.velocity is not None, near_rest=phase is Phase.NEAR_REST)
        return attempt
