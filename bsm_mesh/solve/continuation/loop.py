"""Continuation to equilibrium or collapse: steps from one accepted state to the next.

Each step ends in a solution of ``loads + bolts + contacts - lam * M (q - q_n) = 0`` for the position q, with total
contact laws, exact rotations and `System.mass` as M, anchored at the accepted position, lam hardly more than
nothing; or, where none is near, in where explicit motion with the blocks' real masses leads.

The step, numbered as in the loop:

1. the contact set near the accepted position, with its history, and the equations of the step;
2. the methods of the phase's plan (`plan.PLANS`), tried in order;
3. one acceptance: within the range of the contact search, and no unstable equilibrium;
4. accepted: history and bolts are committed;
5. verdict.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from time import perf_counter

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.model.model import Model
from bsm_mesh.model.options import Options
from bsm_mesh.movements import distances
from bsm_mesh.results.records import Status, StepRecord
from bsm_mesh.solve.bolts.memory import BoltMemory
from bsm_mesh.solve.continuation.acceptance import Acceptance
from bsm_mesh.solve.continuation.mechanics import mechanics_of
from bsm_mesh.solve.continuation.plan import USUAL, Route
from bsm_mesh.solve.continuation.state import CycleMemory, LoopState
from bsm_mesh.solve.continuation.verdict import Collapse, CollapseCriterion
from bsm_mesh.solve.motion.motion import Motion, Start
from bsm_mesh.solve.motion.shaking_memory import ShakingMemory
from bsm_mesh.solve.step.attempt import Attempt, Iterate
from bsm_mesh.solve.step.equations import StepEquations
from bsm_mesh.solve.step.factorization import Factors
from bsm_mesh.solve.step.system import Contacts, Evaluation, History


@dataclass(frozen=True, slots=True, kw_only=True)
class LoopSettings:
    """Parts of a step's equations other than forces.

    Attributes
    ----------
    min_lam : float
        Regularisation of a step that leads to rest, over the inverse of the step length: hardly more than nothing.
    """

    min_lam: float = 1e-7


SETTINGS = LoopSettings()


class Continuation:
    """The continuation of one model.

    Parameters
    ----------
    model : Model
        The model.
    options : Options
        Tolerance, limits, linear solver.
    observer : callable
        Gets every accepted step's record, and a function that returns the state then.
    start : Start, optional
        Initial state; by default the given geometry, with contacts without forces.
    resumed : LoopState, optional
        Where the same run was after one of its steps, to continue from there.
    accepted : callable
        Called between two steps, where `state` may be taken.
    route : Route
        Its plans.

    Attributes
    ----------
    state : LoopState
        State after the last accepted step; none before the first.
    shaken : ShakingMemory or None
        How far the stage was shaken.
    """

    shaken: ShakingMemory | None = None

    def __init__(
        self,
        model: Model,
        options: Options,
        observer: Callable[[StepRecord, Callable[[], Motion]], None],
        start: Start | None = None,
        resumed: LoopState | None = None,
        accepted: Callable[[], None] = lambda: None,
        route: Route = USUAL,
    ) -> None:
        self.options, self.observer, self._between_steps = options, observer, accepted
        mechanics = mechanics_of(model)
        given = (None, None) if start is None else (start.bolts, start.position)
        self.system = mechanics.system(model, *given)
        self.factors = Factors(self.system, options)
        self.begin = start or Start(
            position=self.system.start, history=mechanics.no_history(), intact=True, bolts=self.system.bolts
        )
        self.start_residual = 0.0
        self.origin = self.begin.position if self.begin.origin is None else self.begin.origin
        self.collapse = CollapseCriterion(self.system, self.origin, options.displacement_limit, options.falls)
        self.min_lam = SETTINGS.min_lam / self.system.d
        self._route, self._acceptance = route, Acceptance(self.system, options, intact=self.begin.intact)
        self.steps: list[StepRecord] = []
        begin = self.begin
        first = self._state_after(0, begin.position, begin.history, velocity=begin.velocity)
        self.state = first if resumed is None else self._recall(resumed)

    @property
    def tolerance(self) -> float:
        """Maximum norm of the residual at rest, over the mean weight."""
        return self._acceptance.tolerance

    def run(self) -> Motion:
        """Return the final state: equilibrium, collapse, or not converged."""
        acceptance = self._acceptance
        while True:
            state, tried, began = self.state, [], (perf_counter(), self.factors.count)
            equations, iterate = self._begun(state)  # (1)
            phase, goal = acceptance.phase(equations, iterate, state.number), acceptance.goal(iterate)
            for method in self._route.plan(phase):  # (2)
                if not method.applies(equations, iterate, goal):
                    continue
                tried.append(method.name)
                found, moving = method.solve(equations, iterate, goal), state.velocity is not None
                attempt = acceptance.accepted(found, phase, moving=moving, quiet=state.quiet)  # (3)
                if attempt is not None:
                    break
            else:
                reason = f"no method found the end of a step; tried: {', '.join(tried)}"
                return self._end(Status.NOT_CONVERGED, reason, equations.contacts, state.position)
            after = self._after(state, attempt, tuple(tried), began)
            if isinstance(after, Motion):
                return after
            self.state = after
            self._between_steps()

    def _begun(self, state: LoopState) -> tuple[StepEquations, Iterate]:
        """Return the equations of a step from a state, and where it begins."""
        system, position = self.system, state.position
        contacts = system.gather(state.history, position, first=state.number == 0 and self.begin.intact)
        if state.number == 0:
            self._set_residual_scale(contacts, position)
        equations = StepEquations(system, self.factors, contacts, position, self.min_lam)
        residual = system.static_residual(contacts, position)
        moving_steps = self._acceptance.pace.moving_steps
        return equations, Iterate(residual=residual, velocity=state.velocity, moving_steps=moving_steps)

    def _after(
        self, state: LoopState, attempt: Attempt, tried: tuple[str, ...], began: tuple[float, int]
    ) -> LoopState | Motion:
        """Return the state after a step that ends with an attempt, or the final one.

        `began`: time and factorizations at its start.
        """
        system, number = self.system, state.number
        contacts, position, velocity = attempt.contacts, attempt.position, attempt.velocity
        at, system.bolts = attempt.at, attempt.equations.system.bolts
        history, changed = system.commit(contacts, at, position)  # (4)
        system.bolts = system.bolts.commit(system.bolts.evaluate(position))
        residual = system.static_residual(contacts, position)
        self._record(number, residual, position, contacts, at, began, tried)
        at_rest = system.wearing_residual(contacts, at, residual) < self.options.tolerance
        at_rest = at_rest and changed == 0 and velocity is None
        quiet = bool(at_rest and system.prescription_complete(position))
        if quiet and state.quiet:  # (5)
            return self._end(Status.STABLE, "static equilibrium", contacts, position)
        contacted = at.closed if attempt.contacted is None else attempt.contacted
        if collapse := self.collapse.check(contacts, contacted, position, velocity):
            return self._collapsed(collapse, contacts, position, velocity)
        if number + 1 == self.options.max_steps:
            return self._end(Status.NOT_CONVERGED, self._exhausted("steps", residual, position), contacts, position)
        if velocity is not None:  # what has been thrown off falls from rest: statics knows no flight
            # Where nothing weighs or is loaded, masses are those of the cycles: what no force moves does not drift on.
            drifts = self.system.mean_weight == 0 and residual < self.options.tolerance
            velocity = np.where(self.collapse.thrown[:, None] | drifts, 0.0, velocity)
        return self._state_after(number + 1, position, history, velocity=velocity, quiet=quiet)

    def _state_after(
        self,
        steps: int,
        position: FloatArray,
        history: History,
        *,
        velocity: FloatArray | None = None,
        quiet: bool = False,
        cycle: CycleMemory | None = None,
    ) -> LoopState:
        """Return the state after so many steps."""
        return LoopState(
            number=steps,
            position=position,
            history=history,
            velocity=velocity,
            quiet=quiet,
            bolts=BoltMemory.of(self.system.bolts),
            pace=self._acceptance.pace,
            collapse=self.collapse.memory,
            residual_scale=self.system.residual_scale,
            start_residual=self.start_residual,
            double_precision=self.factors.double_precision,
            cycle=CycleMemory.none() if cycle is None else cycle,
            steps=tuple(self.steps),
            shaken=self.shaken,
        )

    def _recall(self, state: LoopState) -> LoopState:
        """Go back to a state of the same run, and return it."""
        self.system.bolts = state.bolts.recalled(self.system.bolts)
        self.system.residual_scale, self.start_residual = state.residual_scale, state.start_residual
        self.collapse.recall(state.collapse)
        self.factors.recall(state.double_precision)
        self._acceptance.pace, self.steps, self.shaken = state.pace, list(state.steps), state.shaken
        return state

    def _exhausted(self, steps: str, residual: float, position: FloatArray) -> str:
        """Return why the run ended without a verdict, and possible cures."""
        moved = float(distances(position).max())
        return (
            f"the limit of {self.options.max_steps} {steps} was reached with residual {residual:.1e}, a block having "
            f"moved {moved:.3g} m; if that is failure set displacement_limit in [solver] below it, else raise max_steps"
        )

    def _set_residual_scale(self, contacts: Contacts, position: FloatArray) -> None:
        self.system.set_residual_scale(contacts, position)
        self.start_residual = self.system.static_residual(contacts, position)

    def _record(
        self,
        number: int,
        residual: float,
        position: FloatArray,
        contacts: Contacts,
        at: Evaluation,
        began: tuple[float, int],
        tried: tuple[str, ...],
        time: float | None = None,
    ) -> None:
        time_then, before = began
        record = StepRecord(
            stage=0,
            step=number,
            residual=residual,
            max_displacement=float((distances(position - self.origin) * ~self.collapse.small).max()),
            newton_iterations=self.factors.count - before,
            factorizations=self.factors.count - before,
            open_contacts=int((contacts.within_tolerance & ~at.closed).sum()),
            slipping_contacts=int(at.at_strength.sum()),
            seconds=perf_counter() - time_then,
            method=tried[-1],
            tried=tried[:-1],
            time=time,
        )
        self.steps.append(record)
        self.observer(record, lambda: self._motion(Status.NOT_CONVERGED, "on its way", contacts, position))

    def _collapsed(
        self, collapse: Collapse, contacts: Contacts, position: FloatArray, velocity: FloatArray | None = None
    ) -> Motion:
        status = Status.UNSTABLE if collapse.down.size else Status.NOT_CONVERGED
        end = self._end(status, collapse.reason, contacts, position)
        return replace(
            end, unstable_blocks=collapse.unstable, down=collapse.down, small=collapse.small, velocity=velocity
        )

    def _end(self, status: Status, reason: str, contacts: Contacts, position: FloatArray) -> Motion:
        self.factors.close()
        return self._motion(status, reason, contacts, position)

    def _motion(self, status: Status, reason: str, contacts: Contacts, position: FloatArray) -> Motion:
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
