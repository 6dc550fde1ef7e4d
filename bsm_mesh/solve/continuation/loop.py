"""Pseudo-time continuation to equilibrium: implicit static steps with a mass-like regularisation that fades.

Each step solves ``loads + bolts + contacts - lam * M (q - q_n) = 0`` for the position q, with total contact laws,
exact rotations, and ``M = diag(W, W, W I/A)`` anchored at the accepted position. Where movements are
small, lam falls by four a step and the end is static equilibrium; in a collapse it stays, and blocks are followed.

The step, numbered as in the loop:

1. the contact set near the accepted position, with its history;
2. the equations of the step, at the start with the smallest lam first: by Newton's method; where too many contacts
   change for it, along the smoothing path, or by dynamic relaxation where that is slow; near rest by damped motion as
   well; while blocks move, by the interior point method, by explicit motion, or with frozen friction;
3. a step that is not solved, or moves out of the search range, is repeated with a greater lam;
4. accepted: history and bolts are committed; lam is adapted to the movement;
5. verdict.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.model.model import Model
from bsm_mesh.results.records import Status, StepRecord
from bsm_mesh.solve.contacts.forces import ContactSet, Evaluation
from bsm_mesh.solve.contacts.history import History, commit
from bsm_mesh.solve.continuation.first_step import CONFIRMED, first_step, relaxed_step
from bsm_mesh.solve.continuation.stability import instability_rate
from bsm_mesh.solve.continuation.strategies import MAX_FAILURES, MovingSteps
from bsm_mesh.solve.continuation.verdict import CollapseCriterion
from bsm_mesh.solve.motion.motion import Motion, Start
from bsm_mesh.solve.motion.sliding import can_follow_dynamically
from bsm_mesh.solve.options import Options
from bsm_mesh.solve.step.attempt import Attempt
from bsm_mesh.solve.step.block_system import BlockSystem
from bsm_mesh.solve.step.equations import Step
from bsm_mesh.solve.step.factorization import Factors

FIRST_LAM = 1e-3  # over d
FROZEN_LAM = 0.1  # over d: smallest for a step with frozen friction
MIN_INNER = 0.5  # smallest tolerance of a step over that of rest: in large models rounding is near
MIN_LAM, MAX_LAM = 1e-7, 1e9  # over d


@dataclass(frozen=True, eq=False, slots=True)
class _Taken:
    """An accepted step, and whether a smaller lam was rejected before."""

    found: Attempt
    step: Step
    rejected: bool = False


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
    """

    def __init__(
        self,
        model: Model,
        options: Options,
        observer: Callable[[StepRecord, Callable[[], Motion]], None],
        start: Start | None = None,
    ) -> None:
        self.options, self.observer = options, observer
        self.system = BlockSystem(model) if start is None else BlockSystem(model, start.bolts, start.position)
        self.factors = Factors(self.system, options)
        self.begin = start or Start(
            position=self.system.start, history=History.none(), intact=True, bolts=self.system.bolts
        )
        self.start_residual = 0.0
        limit = options.displacement_limit or float(np.ptp(model.blocks.vertices, axis=0).max())
        self.collapse = CollapseCriterion(self.system, self.begin.position, limit)
        self.min_lam = MIN_LAM / self.system.d
        self.movement = MovingSteps(excavated=not self.begin.intact)
        self.steps: list[StepRecord] = []

    @property
    def tolerance(self) -> float:
        """Maximum norm of the residual at rest, over the mean weight."""
        return self.options.tolerance * self.system.residual_scale

    def run(self) -> Motion:
        """Return the final state: equilibrium, collapse, or not converged."""
        system, d = self.system, self.system.d
        position, history = self.begin.position, self.begin.history
        lam, quiet, rejected_before, velocity = FIRST_LAM / d, 0, False, None
        for number in range(self.options.max_steps):
            began, count = time.perf_counter(), self.factors.count
            gather = partial(system.gather, history, position, first=number == 0 and self.begin.intact)  # (1)
            taken = self._first(gather, position) if number == 0 else None
            taken = taken or self._solve_step(gather(), position, lam, velocity, from_rest=number == 0, quiet=quiet > 0)
            if taken is None:
                return self._end(Status.NOT_CONVERGED, "a step cannot be solved at any length", gather(), position)
            found, contacts, lam, rejected = taken.found, taken.step.contacts, taken.step.lam, taken.rejected
            largest = float(np.abs((found.position - position) / system.scale).max())
            position, at, velocity = found.position, found.at, found.velocity
            history, changed = commit(contacts, at, position, system.outlines.size)  # (4)
            system.bolts = system.bolts.commit(system.bolts.evaluate(position))
            residual = system.static_residual(contacts, position)
            self._record(number, residual, position, contacts, at, began, count)
            at_rest = residual < self.options.tolerance and changed == 0 and system.prescription_complete(position)
            quiet = quiet + 1 if at_rest else 0
            if quiet >= 2:  # (5)
                return self._end(Status.STABLE, "static equilibrium", contacts, position)
            contacted = at.closed if found.contacted_during_step is None else found.contacted_during_step
            reason, blocks = self.collapse.check(contacts, contacted, position)
            if reason:
                status = Status.UNSTABLE if blocks.size else Status.NOT_CONVERGED
                return self._end(status, reason, contacts, position, blocks)
            slower = 1 / 1.5 if rejected or rejected_before else 1 / 4
            rejected_before = rejected
            lam = float(np.clip(lam * np.clip(largest / d, slower, 4.0), self.min_lam, 1e3 / d))
        return self._end(Status.NOT_CONVERGED, self._exhausted("steps", residual, position), contacts, position)

    def _exhausted(self, steps: str, residual: float, position: FloatArray) -> str:
        """Return why the run ended without a verdict, and what may help."""
        moved = float(np.hypot(*position[:, :2].T).max())
        return (
            f"the limit of {self.options.max_steps} {steps} was reached with residual {residual:.1e}, a block having "
            f"moved {moved:.3g} m; if that is failure set displacement_limit below it, else raise max_steps"
        )

    def _first(self, gather: Callable[[], ContactSet], position: FloatArray) -> _Taken | None:
        """Return the first step with the smallest lam, or None where it is not solved; (2).

        Where the smoothing path is slow or fails, blocks come to rest by damped motion.

        Its contacts are updated on the way, and the initial ones are not kept: of a million blocks they would take
        1 GB, and are gathered again in a second.
        """
        excavated = not self.begin.intact
        step, found = first_step(self._start(gather, position), self.tolerance, excavated=excavated)
        if not found.converged and not excavated:
            del step, found
            relaxed = relaxed_step(self._start(gather, position), self.tolerance)
            if relaxed is None:
                return None
            step, found = relaxed
        return _Taken(found, step) if self._is_acceptable(found, step) else None

    def _start(self, gather: Callable[[], ContactSet], position: FloatArray) -> Step:
        contacts = gather()
        self._set_residual_scale(contacts, position)
        return Step(self.system, self.factors, contacts, position, self.min_lam)

    def _set_residual_scale(self, contacts: ContactSet, position: FloatArray) -> None:
        self.system.set_residual_scale(contacts, position)
        self.start_residual = self.system.static_residual(contacts, position)

    def _solve_step(
        self,
        contacts: ContactSet,
        anchor: FloatArray,
        lam: float,
        velocity: FloatArray | None,
        *,
        from_rest: bool,
        quiet: bool,
    ) -> _Taken | None:
        """Return the solved step, with a greater lam where it needs one; (2) and (3)."""
        residual = self.system.static_residual(contacts, anchor)
        inner = self._step_tolerance(residual)
        unstable = self.min_lam > MIN_LAM / self.system.d  # raised by the first step
        failures = int(from_rest and unstable)
        moves = velocity is not None or not self.begin.intact
        moving_lam = self._moving_lam(residual) if moves else 0.0
        lam = wanted = max(lam, self.min_lam, 0.0 if from_rest else moving_lam)
        while lam <= MAX_LAM / self.system.d:
            step = Step(self.system, self.factors, contacts, anchor, lam)
            step.velocity = velocity
            found = self.movement.solve(step, inner, from_rest=from_rest, failures=failures)
            least = self.min_lam
            if self._is_acceptable(found, step, quiet=quiet):
                return _Taken(found, step, rejected=failures > 0)
            failures += 1
            if self.min_lam > least:
                lam = wanted = max(lam, self.min_lam)
                continue
            farther = lam * max(2.0, step.movement(found.position - anchor) / self.system.d)
            if from_rest and can_follow_dynamically(step):
                moving_lam = self._moving_lam(residual)
            lam = farther if found.converged else max(4 * lam, FIRST_LAM / self.system.d, moving_lam)
            if failures == MAX_FAILURES and not from_rest:
                lam = max(wanted, FROZEN_LAM / self.system.d)
        return None

    def _moving_lam(self, residual: float) -> float:
        """Return the lam with which a free block moves by a step length under a residual."""
        return min(residual * self.system.residual_scale, 1.0) / self.system.d

    def _step_tolerance(self, residual: float) -> float:
        """Return the tolerance of a step that starts with a residual, over the mean weight."""
        tolerance = self.options.tolerance
        inner = max(MIN_INNER * tolerance, 1e-2 * min(residual, 1.0))
        if residual < CONFIRMED * tolerance:  # at rest already, confirmed by this step
            inner = max(inner, residual / CONFIRMED)
        return inner * self.system.residual_scale

    def _is_acceptable(self, found: Attempt, step: Step, *, quiet: bool = False) -> bool:
        """Return whether a step may end with an attempt; `min_lam` rises where that is an unstable equilibrium."""
        if not (found.converged and step.within_search_range(found.position)):
            return False
        rate = 0.0 if quiet else instability_rate(step, found.position, found.at, self.tolerance)
        if rate == 0 or step.lam >= 2 * rate:
            return True
        self.min_lam = max(self.min_lam, 2 * rate)
        return False

    def _record(
        self,
        number: int,
        residual: float,
        position: FloatArray,
        contacts: ContactSet,
        at: Evaluation,
        began: float,
        before: int,
    ) -> None:
        record = StepRecord(
            stage=0,
            step=number,
            residual=residual,
            max_displacement=float(np.hypot(*(position - self.begin.position)[:, :2].T).max()),
            newton_iterations=self.factors.count - before,
            factorizations=self.factors.count - before,
            open_contacts=int((contacts.within_tolerance & ~at.closed).sum()),
            slipping_contacts=int(at.at_strength.sum()),
            seconds=time.perf_counter() - began,
        )
        self.steps.append(record)
        self.observer(record, lambda: self._motion(Status.NOT_CONVERGED, "on its way", contacts, position))

    def _end(
        self,
        status: Status,
        reason: str,
        contacts: ContactSet,
        position: FloatArray,
        unstable: IntArray | None = None,
    ) -> Motion:
        self.factors.close()
        return self._motion(status, reason, contacts, position, unstable)

    def _motion(
        self,
        status: Status,
        reason: str,
        contacts: ContactSet,
        position: FloatArray,
        unstable: IntArray | None = None,
    ) -> Motion:
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
            unstable_blocks=np.zeros(0, dtype=np.int32) if unstable is None else unstable,
            start_residual=self.start_residual,
            residual=self.system.static_residual(contacts, position),
            reference=self.system.residual_scale * self.system.weight(at),
            steps=tuple(self.steps),
            linear_solver=self.factors.name,
        )
