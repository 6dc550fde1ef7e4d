"""Equilibrium by pseudo-time continuation: implicit static steps with a mass-like regularisation that fades.

Each step solves ``loads + bolts + contacts - lam * M (q - q_n) = 0`` for the position q, with total contact laws,
exact rotations, and ``M = diag(W, W, W I/A)`` anchored at the accepted position. Where little moves, lam falls
by four a step and the end is static equilibrium; where blocks run away it stays, and they are followed.

The step, numbered as in the loop:

1. contacts near the accepted position, with their history;
2. the step's equations, at the start with the least lam first: by Newton's method, and where too many contacts
   change for it, along a path of smoothed laws; while blocks move, by the interior point method, in the end with the
   shear strengths held;
3. a step that is not solved or moves too far is taken again with a greater lam;
4. accepted: history and bolts are committed; lam is adapted to the movement;
5. verdict.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.model.model import Model
from bsm_mesh.results.records import Status, StepRecord
from bsm_mesh.solve.balance import fall_rate
from bsm_mesh.solve.bolt_evaluation import BoltEvaluation
from bsm_mesh.solve.bolts import InstalledBolts
from bsm_mesh.solve.constraints import Constraints
from bsm_mesh.solve.factors import Factors
from bsm_mesh.solve.falling import Falling
from bsm_mesh.solve.first_step import CONFIRMED, first_step
from bsm_mesh.solve.history import History, commit
from bsm_mesh.solve.moving import Evaluation, MovingContacts
from bsm_mesh.solve.moving_model import MovingModel
from bsm_mesh.solve.newton import Found
from bsm_mesh.solve.options import Options
from bsm_mesh.solve.step import Step
from bsm_mesh.solve.strategies import MOST_FAILURES, MovingSteps

FIRST_LAM = 1e-3  # over d
HELD_LAM = 0.1  # over d: least for a step with shear strengths held
LEAST_INNER = 0.5  # of the tolerance: more is asked of no step, for in great models rounding is near
LEAST_LAM, MOST_LAM = 1e-7, 1e9  # over d


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Start:
    """Where the continuation starts: positions (n, 3), what contacts and bolts remember, whether all are intact."""

    position: FloatArray
    history: History
    intact: bool
    bolts: InstalledBolts


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Motion:
    """Where the continuation ended."""

    status: Status
    reason: str
    position: FloatArray
    contacts: MovingContacts
    at: Evaluation
    bolts: InstalledBolts
    bolts_at: BoltEvaluation
    constraints: Constraints
    loads: FloatArray
    unstable_blocks: IntArray
    start_residual: float
    residual: float
    reference: float
    steps: tuple[StepRecord, ...]
    linear_solver: str


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
        self.movement = MovingSteps()
        self.steps: list[StepRecord] = []

    def run(self) -> Motion:
        """Return where the blocks come to rest, or how they come down."""
        moving, d = self.moving, self.moving.d
        position, history = self.begin.position, self.begin.history
        lam, quiet, rejected_before = FIRST_LAM / d, 0, False
        for number in range(self.options.max_steps):
            began, count = time.perf_counter(), self.factors.count
            contacts = moving.gather(history, position, first=number == 0 and self.begin.intact)  # (1)
            residual = moving.static_residual(contacts, position)
            if number == 0:
                self.start_residual = residual
            inner = max(LEAST_INNER * self.options.tolerance, 1e-2 * min(residual, 1.0))
            if residual < CONFIRMED * self.options.tolerance:  # at rest already, which this step confirms
                inner = max(inner, residual / CONFIRMED)
            taken = self._take(contacts, position, lam, inner, direct=number == 0, quiet=quiet > 0)
            if taken is None:
                return self._end(Status.NOT_CONVERGED, "a step cannot be solved at any length", contacts, position)
            found, contacts, lam, rejected = taken.found, taken.step.contacts, taken.step.lam, taken.rejected
            greatest = float(np.abs((found.position - position) / moving.scale).max())
            position, at = found.position, found.at
            history, changed = commit(contacts, at, position, moving.outlines.size)  # (4)
            moving.bolts = moving.bolts.commit(moving.bolts.evaluate(position))
            residual = moving.static_residual(contacts, position)
            self._record(number, residual, position, contacts, at, began, count)
            at_rest = residual < self.options.tolerance and changed == 0 and moving.reached(position)
            quiet = quiet + 1 if at_rest else 0
            if quiet >= 2:  # (5)
                return self._end(Status.STABLE, "static equilibrium", contacts, position)
            reason, blocks = self.falling.look(contacts, at, position)
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

    def _take(
        self, contacts: MovingContacts, anchor: FloatArray, lam: float, inner: float, *, direct: bool, quiet: bool
    ) -> _Taken | None:
        """Return the step as it was taken, with a greater lam where it needs one; (2) and (3)."""
        wanted, failures, from_rest = lam, 0, direct
        while lam <= MOST_LAM / self.moving.d:
            step = Step(self.moving, self.factors, contacts, anchor, self.least_lam if direct else lam)
            taken = self._first(step) if direct else self._move(step, inner, failures, from_rest=from_rest)
            found, greatest = taken.found, step.movement(taken.found.position - anchor)
            if found.converged and taken.step.takes(found.position):
                fall = 0.0 if quiet else fall_rate(taken.step, found.position, found.at, self.options.tolerance)
                if fall == 0 or step.lam >= 2 * fall:
                    return replace(taken, rejected=failures > 0)
                self.least_lam = max(self.least_lam, 2 * fall)
                lam = wanted = max(lam, self.least_lam)
                failures += 1
            elif not direct:
                failures += 1
                farther = lam * max(2.0, greatest / self.moving.d)
                lam = farther if found.converged else max(4 * lam, FIRST_LAM / self.moving.d)
                if failures == MOST_FAILURES and not from_rest:
                    lam = max(wanted, HELD_LAM / self.moving.d)
            direct = False
        return None

    def _move(self, step: Step, inner: float, failures: int, *, from_rest: bool) -> _Taken:
        return _Taken(self.movement.solve(step, inner, from_rest=from_rest, failures=failures), step)

    def _first(self, step: Step) -> _Taken:
        step, found = first_step(step, self.options.tolerance, excavated=not self.begin.intact)
        return _Taken(found, step)

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
            reference=self.moving.weight(at),
            steps=tuple(self.steps),
            linear_solver=self.factors.name,
        )
