"""One step of the continuation: its phase, the methods of the phase's plan, one acceptance."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from bsm_mesh.solve.continuation.pace import Pace
from bsm_mesh.solve.continuation.plan import USUAL, Phase, Route
from bsm_mesh.solve.continuation.stability import falling_mode
from bsm_mesh.solve.motion.following import is_fast
from bsm_mesh.solve.options import Options
from bsm_mesh.solve.step.attempt import Attempt, Goal, Iterate
from bsm_mesh.solve.step.block_system import BlockSystem
from bsm_mesh.solve.step.equations import StepEquations, moved_by


@dataclass(frozen=True, slots=True, kw_only=True)
class AcceptanceSettings:
    """How exactly a step is solved.

    Attributes
    ----------
    min_inner : float
        Smallest tolerance of a step over that of rest: below 1, so that what is at rest is so in the next step too,
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


class StepSolver:
    """Solves the steps of a run.

    Parameters
    ----------
    system : BlockSystem
        The blocks.
    options : Options
        Tolerance.
    route : Route
        Its plans.
    intact : bool
        Whether all contacts are intact where the run begins.

    Attributes
    ----------
    pace : Pace
        When an equilibrium is looked for.
    """

    def __init__(self, system: BlockSystem, options: Options, route: Route = USUAL, *, intact: bool) -> None:
        self._system, self._options, self._route, self._intact = system, options, route, intact
        self.pace = Pace()

    @property
    def tolerance(self) -> float:
        """Maximum norm of the residual at rest, over the mean weight."""
        return self._options.tolerance * self._system.residual_scale

    def solve(
        self, equations: StepEquations, iterate: Iterate, number: int, *, quiet: bool
    ) -> tuple[tuple[str, ...], Attempt | None]:
        """Return the names of the methods tried, and the last one's attempt: the first that is acceptable, or None."""
        tried: tuple[str, ...] = ()
        phase = self._phase(equations, iterate, number)
        goal = Goal(max_residual=self._step_tolerance(iterate), rest=SETTINGS.min_inner * self.tolerance)
        for method in self._route.plan(phase):
            if not method.applies(equations, iterate, goal):
                continue
            tried = (*tried, method.name)
            attempt = self._accepted(method.solve(equations, iterate, goal), quiet=quiet)
            if attempt is not None:
                self.pace = self.pace.counted(moves=attempt.velocity is not None, near_rest=phase is Phase.NEAR_REST)
                return tried, attempt
        return tried, None

    def _phase(self, equations: StepEquations, iterate: Iterate, number: int) -> Phase:
        if number == 0 and iterate.velocity is None:
            return Phase.START if self._intact else Phase.AFTER_CHANGE
        if iterate.velocity is not None and (self.pace.wait > 0 or is_fast(equations, iterate)):
            return Phase.MOVING
        return Phase.NEAR_REST

    def _accepted(self, attempt: Attempt, *, quiet: bool) -> Attempt | None:
        """Return an attempt if the step may end with it.

        Where it leads to an unstable equilibrium blocks are moved on a little, as they would fall from there, and
        followed.
        """
        if not attempt.may_end:
            return None
        if attempt.velocity is not None:
            return attempt
        if not attempt.equations.within_search_range(attempt.position):
            return None
        mode = None if quiet else falling_mode(attempt.equations, attempt.position, attempt.at, self.tolerance)
        if mode is None:
            return attempt
        self.pace = self.pace.followed()
        pushed = moved_by(attempt.position, SETTINGS.push * self._system.d * mode)
        return replace(attempt, position=pushed, velocity=np.zeros_like(pushed))

    def _step_tolerance(self, iterate: Iterate) -> float:
        """Return the tolerance of a step, over the mean weight.

        At rest a part of the residual at its start is enough: steps to come take up the others. Velocities end in an
        equilibrium only, or what slides slowly would stop at every step.
        """
        tolerance, residual = self._options.tolerance, 0.0 if iterate.velocity is not None else iterate.residual
        inner = max(SETTINGS.min_inner * tolerance, SETTINGS.reduction * min(residual, 1.0))
        return inner * self._system.residual_scale
