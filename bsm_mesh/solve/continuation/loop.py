"""Equilibrium by pseudo-time continuation: implicit static steps with a mass-like regularisation that fades.

Each step solves ``loads + bolts + contacts - lam * M (q - q_n) = 0`` for the position q, with total contact laws,
exact rotations, and ``M = diag(W, W, W I/A)`` anchored at the accepted position. Where little moves, lam falls
by four a step and the end is static equilibrium; where blocks run away it stays, and they are followed.

The step, numbered as in the loop:

1. contacts near the accepted position, with their history;
2. the step's equations, at the start with the least lam first: by Newton's method, and where too many contacts
   change for it, along a path of smoothed laws, or by dynamic relaxation where that is slow; near rest by few cycles of
   it as well; while blocks move, by the interior point method, in the end by cycles that follow the blocks, or with
   the shear strengths held;
3. a step that is not solved or moves too far is taken again with a greater lam;
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
from bsm_mesh.solve.contacts.forces import Evaluation, MovingContacts
from bsm_mesh.solve.contacts.history import History, commit
from bsm_mesh.solve.continuation.first_step import CONFIRMED, first_step, relaxed_step
from bsm_mesh.solve.continuation.stability import fall_rate
from bsm_mesh.solve.continuation.strategies import MOST_FAILURES, MovingSteps
from bsm_mesh.solve.continuation.verdict import Falling
from bsm_mesh.solve.motion.motion import Motion, Start
from bsm_mesh.solve.motion.sliding import can_slide
from bsm_mesh.solve.options import Options
from bsm_mesh.solve.step.attempt import Found
from bsm_mesh.solve.step.block_system import MovingModel
from bsm_mesh.solve.step.equations import Step
from bsm_mesh.solve.step.factorization import Factors

FIRST_LAM = 1e-3  # over d
HELD_LAM = 0.1  # over d: least for a step with shear strengths held
LEAST_INNER = 0.5  # of the tolerance: more is asked of no step, for in great models rounding is near
LEAST_LAM, MOST_LAM = 1e-7, 1e9  # over d


@dataclass(frozen=True, eq=False, slots=True)
class _Taken:
    """A step as it was taken, and whether a smaller lam had been tried before."""

    found: Found
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
        Gets every accepted step's record, and a function that returns where the blocks are then.
    start : Start, optional
        Where it starts; by default from the blocks as they are given, with contacts that bear nothing.
    """

    def __init__(
        self,
        model: Model,
        options: Options,
        observer: Callable[[StepRecord, Callable[[], Motion]], None],
        start: Start | None = None,
    ) -> None:
        self.options, self.observer = options, observer
        self.moving = MovingModel(model) if start is None else MovingModel(model, start.bolts, start.position)
        self.factors = Factors(self.moving, options)
        self.begin = start or Start(
            position=self.moving.start, history=History.none(), intact=True, bolts=self.moving.bolts
        )
        self.start_residual = 0.0
        limit = options.displacement_limit or float(np.ptp(model.blocks.vertices, axis=0).max())
        self.falling = Falling(self.moving, self.begin.position, limit)
        self.least_lam = LEAST_LAM / self.moving.d
        self.movement = MovingSteps(excavated=not self.begin.intact)
        self.steps: list[StepRecord] = []

    @property
    def tolerance(self) -> float:
        """Greatest force out of balance that counts as rest, over the mean weight."""
        return self.options.tolerance * self.moving.stressed

    def run(self) -> Motion:
        """Return where the blocks come to rest, or how they come down."""
        moving, d = self.moving, self.moving.d
        position, history = self.begin.position, self.begin.history
        lam, quiet, rejected_before, velocity = FIRST_LAM / d, 0, False, None
        for number in range(self.options.max_steps):
            began, count = time.perf_counter(), self.factors.count
            gather = partial(moving.gather, history, position, first=number == 0 and self.begin.intact)  # (1)
            taken = self._first(gather, position) if number == 0 else None
            taken = taken or self._take(gather(), position, lam, velocity, from_rest=number == 0, quiet=quiet > 0)
            if taken is None:
                return self._end(Status.NOT_CONVERGED, "a step cannot be solved at any length", gather(), position)
            found, contacts, lam, rejected = taken.found, taken.step.contacts, taken.step.lam, taken.rejected
            greatest = float(np.abs((found.position - position) / moving.scale).max())
            position, at, velocity = found.position, found.at, found.velocity
            history, changed = commit(contacts, at, position, moving.outlines.size)  # (4)
            moving.bolts = moving.bolts.commit(moving.bolts.evaluate(position))
            residual = moving.static_residual(contacts, position)
            self._record(number, residual, position, contacts, at, began, count)
            at_rest = residual < self.options.tolerance and changed == 0 and moving.reached(position)
            quiet = quiet + 1 if at_rest else 0
            if quiet >= 2:  # (5)
                return self._end(Status.STABLE, "static equilibrium", contacts, position)
            bore = at.bearing if found.bore is None else found.bore
            reason, blocks = self.falling.look(contacts, bore, position)
            if reason:
                return self._end(Status.UNSTABLE, reason, contacts, position, blocks)
            slower = 1 / 1.5 if rejected or rejected_before else 1 / 4
            rejected_before = rejected
            lam = float(np.clip(lam * np.clip(greatest / d, slower, 4.0), self.least_lam, 1e3 / d))
        return self._end(Status.NOT_CONVERGED, self._out_of("steps", residual, position), contacts, position)

    def _out_of(self, steps: str, residual: float, position: FloatArray) -> str:
        """Return why the run gave up, and what may help."""
        moved = float(np.hypot(*position[:, :2].T).max())
        return (
            f"the limit of {self.options.max_steps} {steps} was reached with residual {residual:.1e}, a block having "
            f"moved {moved:.3g} m; if that is failure set displacement_limit below it, else raise max_steps"
        )

    def _first(self, gather: Callable[[], MovingContacts], position: FloatArray) -> _Taken | None:
        """Return the first step with the least lam, or None where it is not solved; (2).

        Where a path is slow, or nothing else leads to rest, blocks come to it by damped motion.

        Its contacts are updated on the way. So nobody else keeps those that it began with: of a million blocks they
        would take 1 GB, and are gathered again in a second.
        """
        excavated = not self.begin.intact
        step, found = first_step(self._start(gather, position), self.tolerance, excavated=excavated)
        if not found.converged and not excavated:
            del step, found
            relaxed = relaxed_step(self._start(gather, position), self.tolerance)
            if relaxed is None:
                return None
            step, found = relaxed
        return _Taken(found, step) if self._holds(found, step) else None

    def _start(self, gather: Callable[[], MovingContacts], position: FloatArray) -> Step:
        contacts = gather()
        self._starts_from(contacts, position)
        return Step(self.moving, self.factors, contacts, position, self.least_lam)

    def _starts_from(self, contacts: MovingContacts, position: FloatArray) -> None:
        self.moving.starts_from(contacts, position)
        self.start_residual = self.moving.static_residual(contacts, position)

    def _take(
        self,
        contacts: MovingContacts,
        anchor: FloatArray,
        lam: float,
        velocity: FloatArray | None,
        *,
        from_rest: bool,
        quiet: bool,
    ) -> _Taken | None:
        """Return the step as it was taken, with a greater lam where it needs one; (2) and (3)."""
        residual = self.moving.static_residual(contacts, anchor)
        inner = self._inner(residual)
        falls = self.least_lam > LEAST_LAM / self.moving.d  # which the first step found out where it led to
        failures = int(from_rest and falls)
        moves = velocity is not None or not self.begin.intact
        moving_lam = self._moving_lam(residual) if moves else 0.0
        lam = wanted = max(lam, self.least_lam, 0.0 if from_rest else moving_lam)
        while lam <= MOST_LAM / self.moving.d:
            step = Step(self.moving, self.factors, contacts, anchor, lam)
            step.velocity = velocity
            found = self.movement.solve(step, inner, from_rest=from_rest, failures=failures)
            least = self.least_lam
            if self._holds(found, step, quiet=quiet):
                return _Taken(found, step, rejected=failures > 0)
            failures += 1
            if self.least_lam > least:
                lam = wanted = max(lam, self.least_lam)
                continue
            farther = lam * max(2.0, step.movement(found.position - anchor) / self.moving.d)
            if from_rest and can_slide(step):
                moving_lam = self._moving_lam(residual)
            lam = farther if found.converged else max(4 * lam, FIRST_LAM / self.moving.d, moving_lam)
            if failures == MOST_FAILURES and not from_rest:
                lam = max(wanted, HELD_LAM / self.moving.d)
        return None

    def _moving_lam(self, residual: float) -> float:
        """Return the lam with which a free block that lacks a residual moves by a step length."""
        return min(residual * self.moving.stressed, 1.0) / self.moving.d

    def _inner(self, residual: float) -> float:
        """Return the tolerance of a step that begins with a residual, over the mean weight."""
        tolerance = self.options.tolerance
        inner = max(LEAST_INNER * tolerance, 1e-2 * min(residual, 1.0))
        if residual < CONFIRMED * tolerance:  # at rest already, which this step confirms
            inner = max(inner, residual / CONFIRMED)
        return inner * self.moving.stressed

    def _holds(self, found: Found, step: Step, *, quiet: bool = False) -> bool:
        """Return whether a step may end where it led; the least lam rises where blocks would fall from there."""
        if not (found.converged and step.takes(found.position)):
            return False
        fall = 0.0 if quiet else fall_rate(step, found.position, found.at, self.tolerance)
        if fall == 0 or step.lam >= 2 * fall:
            return True
        self.least_lam = max(self.least_lam, 2 * fall)
        return False

    def _record(
        self,
        number: int,
        residual: float,
        position: FloatArray,
        contacts: MovingContacts,
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
            open_contacts=int((contacts.touching & ~at.bearing).sum()),
            slipping_contacts=int(at.at_strength.sum()),
            seconds=time.perf_counter() - began,
        )
        self.steps.append(record)
        self.observer(record, lambda: self._motion(Status.NOT_CONVERGED, "on its way", contacts, position))

    def _end(
        self,
        status: Status,
        reason: str,
        contacts: MovingContacts,
        position: FloatArray,
        unstable: IntArray | None = None,
    ) -> Motion:
        self.factors.close()
        return self._motion(status, reason, contacts, position, unstable)

    def _motion(
        self,
        status: Status,
        reason: str,
        contacts: MovingContacts,
        position: FloatArray,
        unstable: IntArray | None = None,
    ) -> Motion:
        at = self.moving.evaluate(contacts, position)
        return Motion(
            status=status,
            reason=reason,
            position=position,
            contacts=contacts,
            at=at,
            bolts=self.moving.bolts,
            bolts_at=self.moving.bolts.evaluate(position),
            constraints=self.moving.constraints_at(position),
            loads=self.moving.loads_at(position),
            unstable_blocks=np.zeros(0, dtype=np.int32) if unstable is None else unstable,
            start_residual=self.start_residual,
            residual=self.moving.static_residual(contacts, position),
            reference=self.moving.stressed * self.moving.weight(at),
            steps=tuple(self.steps),
            linear_solver=self.factors.name,
        )
