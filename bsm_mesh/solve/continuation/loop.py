"""Continuation to equilibrium or collapse: steps from one accepted state to the next.

Each step ends in a solution of ``loads + bolts + contacts - lam * M (q - q_n) = 0`` for the position q, with total
contact laws, exact rotations and ``M = diag(W, W, W I/A)`` anchored at the accepted position, lam hardly more than
nothing; or, where none is near, in where explicit motion with the blocks' real masses leads.

The step, numbered as in the loop:

1. the contact set near the accepted position, with its history, and the equations of the step;
2. the methods of the phase's plan (`plan.PLANS`), tried in order;
3. one acceptance: within the range of the contact search, and no unstable equilibrium;
4. accepted: history and bolts are committed;
5. verdict.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.model.model import Model
from bsm_mesh.results.records import Status, StepRecord
from bsm_mesh.solve.contacts.forces import ContactSet, Evaluation
from bsm_mesh.solve.contacts.history import History, commit
from bsm_mesh.solve.continuation.plan import USUAL, Phase, Route
from bsm_mesh.solve.continuation.stability import falling_mode
from bsm_mesh.solve.continuation.verdict import Collapse, CollapseCriterion
from bsm_mesh.solve.methods.nearby_equilibrium import SETTINGS as NEARBY
from bsm_mesh.solve.motion.following import is_fast
from bsm_mesh.solve.motion.motion import Motion, Start
from bsm_mesh.solve.options import Options
from bsm_mesh.solve.step.attempt import Attempt, Goal, Iterate, Method
from bsm_mesh.solve.step.block_system import BlockSystem
from bsm_mesh.solve.step.equations import StepEquations, moved_by
from bsm_mesh.solve.step.factorization import Factors


@dataclass(frozen=True, slots=True, kw_only=True)
class LoopSettings:
    """How exactly a step is solved, and when an equilibrium is looked for.

    Attributes
    ----------
    min_inner : float
        Smallest tolerance of a step over that of rest: in large models rounding is near.
    reduction : float
        Part of a step's residual to which it is solved.
    min_lam : float
        Regularisation of a step that leads to rest, over the inverse of the step length: hardly more than nothing.
    max_pause : int
        Moving steps after which an equilibrium nearby is looked for again, at most.
    quiet_steps : int
        Steps in equilibrium that confirm it.
    push : float
        Movement out of an unstable equilibrium, over the step length.
    """

    min_inner: float = 0.5
    reduction: float = 1e-2
    min_lam: float = 1e-7
    max_pause: int = 8
    quiet_steps: int = 2
    push: float = 0.01


SETTINGS = LoopSettings()


@dataclass(slots=True)
class _Pace:
    """For how many steps blocks are followed before an equilibrium is looked for, twice as many after each failure."""

    wait: int = 0
    pause: int = 1
    moving_steps: int = 0

    def follow(self) -> None:
        """Follow blocks for as long as there is: they leave an unstable equilibrium, which is near."""
        self.wait = self.pause = SETTINGS.max_pause

    def count(self, attempt: Attempt, *, near_rest: bool) -> None:
        """Count a step: begin anew at rest; `near_rest`: there was no equilibrium nearby, so wait longer."""
        if attempt.velocity is None:
            self.wait, self.pause, self.moving_steps = 0, 1, 0
            return
        if near_rest:
            self.wait, self.pause = self.pause, min(2 * self.pause, SETTINGS.max_pause)
        self.wait, self.moving_steps = max(0, self.wait - 1), self.moving_steps + 1


class Continuation:
    """The continuation of one model.

    Parameters
    ----------
    model : Model
        What is given.
    options : Options
        Tolerance, limits, linear solver.
    observer : callable
        Gets every accepted step's record, and a function that returns the state then.
    start : Start, optional
        Initial state; by default the given geometry, with contacts without forces.
    route : Route
        Its plans.
    """

    def __init__(
        self,
        model: Model,
        options: Options,
        observer: Callable[[StepRecord, Callable[[], Motion]], None],
        start: Start | None = None,
        route: Route = USUAL,
    ) -> None:
        self.options, self.observer, self.route = options, observer, route
        self.system = BlockSystem(model) if start is None else BlockSystem(model, start.bolts, start.position)
        self.factors = Factors(self.system, options)
        self.begin = start or Start(
            position=self.system.start, history=History.none(), intact=True, bolts=self.system.bolts
        )
        self.start_residual = 0.0
        self.origin = self.begin.position if self.begin.origin is None else self.begin.origin
        self.collapse = CollapseCriterion(self.system, self.origin, options.displacement_limit, options.falls)
        self.min_lam = SETTINGS.min_lam / self.system.d
        self._pace = _Pace()
        self.steps: list[StepRecord] = []

    @property
    def tolerance(self) -> float:
        """Maximum norm of the residual at rest, over the mean weight."""
        return self.options.tolerance * self.system.residual_scale

    def run(self) -> Motion:
        """Return the final state: equilibrium, collapse, or not converged."""
        system = self.system
        position, history, velocity, quiet = self.begin.position, self.begin.history, self.begin.velocity, 0
        for number in range(self.options.max_steps):
            began, count = time.perf_counter(), self.factors.count
            contacts = system.gather(history, position, first=number == 0 and self.begin.intact)  # (1)
            if number == 0:
                self._set_residual_scale(contacts, position)
            equations = StepEquations(system, self.factors, contacts, position, self.min_lam)
            residual = system.static_residual(contacts, position)
            iterate = Iterate(residual=residual, velocity=velocity, moving_steps=self._pace.moving_steps)
            tried, attempt = self._solve_step(equations, iterate, number, quiet=quiet > 0)  # (2), (3)
            if attempt is None:
                reason = f"no method found the end of a step: {', '.join(tried)} were tried"
                return self._end(Status.NOT_CONVERGED, reason, contacts, position)
            contacts, position, velocity = attempt.contacts, attempt.position, attempt.velocity
            at, system.bolts = attempt.at, attempt.equations.system.bolts
            history, changed = commit(contacts, at, position, system.outlines.size)  # (4)
            system.bolts = system.bolts.commit(system.bolts.evaluate(position))
            residual = system.static_residual(contacts, position)
            self._record(number, residual, position, contacts, at, began, count, tried)
            at_rest = residual < self.options.tolerance and changed == 0 and velocity is None
            quiet = quiet + 1 if at_rest and system.prescription_complete(position) else 0
            if quiet >= SETTINGS.quiet_steps:  # (5)
                return self._end(Status.STABLE, "static equilibrium", contacts, position)
            contacted = at.closed if attempt.contacted is None else attempt.contacted
            if collapse := self.collapse.check(contacts, contacted, position, velocity):
                return self._collapsed(collapse, contacts, position, velocity)
            if velocity is not None:  # what has been thrown off falls from rest: statics knows no flight
                velocity = np.where(self.collapse.thrown[:, None], 0.0, velocity)
        return self._end(Status.NOT_CONVERGED, self._exhausted("steps", residual, position), contacts, position)

    def _exhausted(self, steps: str, residual: float, position: FloatArray) -> str:
        """Return why the run ended without a verdict, and what may help."""
        moved = float(np.hypot(*position[:, :2].T).max())
        return (
            f"the limit of {self.options.max_steps} {steps} was reached with residual {residual:.1e}, a block having "
            f"moved {moved:.3g} m; if that is failure set displacement_limit below it, else raise max_steps"
        )

    def _set_residual_scale(self, contacts: ContactSet, position: FloatArray) -> None:
        self.system.set_residual_scale(contacts, position)
        self.start_residual = self.system.static_residual(contacts, position)

    def _solve_step(
        self, equations: StepEquations, iterate: Iterate, number: int, *, quiet: bool
    ) -> tuple[tuple[str, ...], Attempt | None]:
        """Return the names of the methods tried, and the last one's attempt: the first that is acceptable, or None."""
        tried: tuple[str, ...] = ()
        phase = self._phase(equations, iterate, number)
        goal = Goal(max_residual=self._step_tolerance(iterate.residual), rest=self.tolerance)
        for method in self.route.plan(phase):
            if not method.applies(equations, iterate, goal):
                continue
            tried = (*tried, method.name)
            attempt = self._accepted(method, equations, iterate, goal, quiet=quiet)
            if attempt is not None:
                self._pace.count(attempt, near_rest=phase is Phase.NEAR_REST)
                return tried, attempt
        return tried, None

    def _phase(self, equations: StepEquations, iterate: Iterate, number: int) -> Phase:
        if number == 0 and iterate.velocity is None:
            return Phase.START if self.begin.intact else Phase.AFTER_CHANGE
        if iterate.velocity is not None and (self._pace.wait > 0 or is_fast(equations, iterate)):
            return Phase.MOVING
        return Phase.NEAR_REST

    def _accepted(
        self, method: Method, equations: StepEquations, iterate: Iterate, goal: Goal, *, quiet: bool
    ) -> Attempt | None:
        """Return a method's attempt if the step may end with it.

        Where it leads to an unstable equilibrium blocks are moved on a little, as they would fall from there, and
        followed.
        """
        attempt = method.solve(equations, iterate, goal)
        if not attempt.may_end:
            return None
        if attempt.velocity is not None:
            return attempt
        if not attempt.equations.within_search_range(attempt.position):
            return None
        mode = None if quiet else falling_mode(attempt.equations, attempt.position, attempt.at, self.tolerance)
        if mode is None:
            return attempt
        self._pace.follow()
        pushed = moved_by(attempt.position, SETTINGS.push * self.system.d * mode)
        return replace(attempt, position=pushed, velocity=np.zeros_like(pushed))

    def _step_tolerance(self, residual: float) -> float:
        """Return the tolerance of a step that starts with a residual, over the mean weight."""
        tolerance = self.options.tolerance
        inner = max(SETTINGS.min_inner * tolerance, SETTINGS.reduction * min(residual, 1.0))
        if residual < NEARBY.confirmed * tolerance:  # at rest already, confirmed by this step
            inner = max(inner, residual / NEARBY.confirmed)
        return inner * self.system.residual_scale

    def _record(
        self,
        number: int,
        residual: float,
        position: FloatArray,
        contacts: ContactSet,
        at: Evaluation,
        began: float,
        before: int,
        tried: tuple[str, ...],
    ) -> None:
        record = StepRecord(
            stage=0,
            step=number,
            residual=residual,
            max_displacement=float(np.hypot(*(position - self.origin)[:, :2].T).max()),
            newton_iterations=self.factors.count - before,
            factorizations=self.factors.count - before,
            open_contacts=int((contacts.within_tolerance & ~at.closed).sum()),
            slipping_contacts=int(at.at_strength.sum()),
            seconds=time.perf_counter() - began,
            method=tried[-1],
            tried=tried[:-1],
        )
        self.steps.append(record)
        self.observer(record, lambda: self._motion(Status.NOT_CONVERGED, "on its way", contacts, position))

    def _collapsed(
        self, collapse: Collapse, contacts: ContactSet, position: FloatArray, velocity: FloatArray | None = None
    ) -> Motion:
        status = Status.UNSTABLE if collapse.down.size else Status.NOT_CONVERGED
        end = self._end(status, collapse.reason, contacts, position)
        return replace(
            end, unstable_blocks=collapse.unstable, down=collapse.down, small=collapse.small, velocity=velocity
        )

    def _end(self, status: Status, reason: str, contacts: ContactSet, position: FloatArray) -> Motion:
        self.factors.close()
        return self._motion(status, reason, contacts, position)

    def _motion(self, status: Status, reason: str, contacts: ContactSet, position: FloatArray) -> Motion:
        at = self.system.evaluate(contacts, position)
        return Motion(
            status=status,
            reason=reason,
            position=position,
            contacts=contacts,
            at=at,
            bolts=self.system.bolts,
            bolts_at=self.system.bolts.evaluate(position),
            constraints=self.system.constraints_at(position),
            loads=self.system.loads_at(position),
            unstable_blocks=np.zeros(0, dtype=np.int32),
            down=np.zeros(0, dtype=np.int32),
            small=np.zeros(0, dtype=bool),
            velocity=None,
            start_residual=self.start_residual,
            residual=self.system.static_residual(contacts, position),
            reference=self.system.residual_scale * self.system.weight(at),
            steps=tuple(self.steps),
            linear_solver=self.factors.name,
        )
