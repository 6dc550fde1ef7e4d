"""Equilibrium by pseudo-time continuation: implicit static steps with a mass-like regularisation that fades.

Each step solves ``loads + bolts + contacts - lam * M (q - q_n) = 0`` for the position q, with total contact laws,
exact rotations, and ``M = diag(W, W, W I/A)`` anchored at the accepted position. Where little moves, lam falls
by four a step and the end is static equilibrium; where blocks run away it stays, and they are followed.

The step, numbered as in the loop:

1. contacts near the accepted position, with their history;
2. the step's equations, at the start with the least lam first: by Newton's method, and where too many contacts
   change for it, by the interior point method and Newton's from there;
3. a step that is not solved or moves too far is taken again with a greater lam;
4. accepted: history and bolts are committed; lam is adapted to the movement;
5. verdict.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.model.model import Model
from bsm_mesh.results.records import Status, StepRecord
from bsm_mesh.solve.balance import fall_rate
from bsm_mesh.solve.bolts import BoltEvaluation, InstalledBolts
from bsm_mesh.solve.constraints import Constraints
from bsm_mesh.solve.interior_point import interior_point
from bsm_mesh.solve.moving import Evaluation, History, MovingContacts, commit
from bsm_mesh.solve.moving_model import MovingModel
from bsm_mesh.solve.newton import LONGEST, MOST_ITERATIONS, Found, elastic_position, newton
from bsm_mesh.solve.options import Options
from bsm_mesh.solve.step import Factors, Step

FIRST_LAM = 1e-3  # over d
LEAST_LAM, MOST_LAM = 1e-7, 1e9  # over d
QUICK = 0.1  # Newton's method at the start goes on while it shrinks the 2-norm to this with every factorization
MOST_MOVING = 6  # iterations of Newton's method in a moving step
NEAR_REST = 1e-4  # tolerance of a step below which few contacts still change: Newton's method is given time
BARRIERS = (1.0, 10.0)  # what the interior point method begins with at the start, one after the other
HAND_OVER = 1e-2  # residual by the exact laws at which the interior point method hands over to Newton's
FREE_MOVE = 0.1  # of its size: a block that has moved this far without contact comes down
RECENT_STEPS, MOVES = 5, 0.25  # unstable: moved more than a quarter of the greatest over the last five steps


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
        self.limit = options.displacement_limit or float(np.ptp(model.blocks.vertices, axis=0).max())
        self.least_lam = LEAST_LAM / self.moving.d
        self.parted = self.begin.position.copy()  # where each block last had a contact or a support
        self.steps: list[StepRecord] = []

    def run(self) -> Motion:
        """Return where the blocks come to rest, or how they come down."""
        moving, d = self.moving, self.moving.d
        position, history = self.begin.position, self.begin.history
        lam, quiet, rejected_before = FIRST_LAM / d, 0, False
        recent: list[FloatArray] = [position]
        for number in range(self.options.max_steps):
            began, count = time.perf_counter(), self.factors.count
            contacts = moving.gather(history, position, first=number == 0 and self.begin.intact)  # (1)
            residual = moving.static_residual(contacts, position)
            if number == 0:
                self.start_residual = residual
            inner = max(0.1 * self.options.tolerance, 1e-2 * min(residual, 1.0))
            found, lam, rejected = self._take(contacts, position, lam, inner, direct=number == 0, quiet=quiet > 0)
            if found is None:
                return self._end(Status.NOT_CONVERGED, "a step cannot be solved at any length", contacts, position)
            greatest = float(np.abs((found.position - position) / moving.scale).max())
            position, at = found.position, found.at
            history, changed = commit(contacts, at, position, moving.outlines.size)  # (4)
            moving.bolts = moving.bolts.commit(moving.bolts.evaluate(position))
            residual = moving.static_residual(contacts, position)
            self._record(number, residual, position, contacts, at, began, count)
            recent = [*recent[-RECENT_STEPS:], position]
            at_rest = residual < self.options.tolerance and changed == 0 and moving.reached(position)
            quiet = quiet + 1 if at_rest else 0
            if quiet >= 2:  # (5)
                return self._end(Status.STABLE, "static equilibrium", contacts, position)
            reason, blocks = self._falling(contacts, at, position, recent)
            if reason:
                return self._end(Status.UNSTABLE, reason, contacts, position, blocks)
            slower = 1 / 1.5 if rejected or rejected_before else 1 / 4
            rejected_before = rejected
            lam = float(np.clip(lam * np.clip(greatest / d, slower, 4.0), self.least_lam, 1e3 / d))
        return self._end(Status.NOT_CONVERGED, self._out_of("steps", residual, position), contacts, position)

    def _out_of(self, steps: str, residual: float, position: FloatArray) -> str:
        """Return why the run gave up, and what may help."""
        moved = float(np.hypot(*(position - self.moving.start)[:, :2].T).max())
        return (
            f"the limit of {self.options.max_steps} {steps} was reached with residual {residual:.1e}, a block having "
            f"moved {moved:.3g} m; if that is failure set displacement_limit below it, else raise max_steps"
        )

    def _take(
        self, contacts: MovingContacts, anchor: FloatArray, lam: float, inner: float, *, direct: bool, quiet: bool
    ) -> tuple[Found | None, float, bool]:
        """Return the step's end, the lam it was solved with, and whether a greater one was needed; (2) and (3)."""
        rejected, from_rest = False, direct
        while lam <= MOST_LAM / self.moving.d:
            step_lam = self.least_lam if direct else lam
            step = Step(self.moving, self.factors, contacts, anchor, step_lam)
            found = self._at_once(step) if direct else self._moving(step, inner, from_rest=from_rest)
            greatest = step.movement(found.position - anchor)
            if found.converged and greatest <= LONGEST * self.moving.d:
                fall = 0.0 if quiet else fall_rate(step, found.position, found.at, self.options.tolerance)
                if fall == 0 or step_lam >= 2 * fall:
                    return found, step_lam, rejected
                self.least_lam = max(self.least_lam, 2 * fall)
                lam, rejected = max(lam, self.least_lam), True
            elif not direct:
                rejected = True
                farther = lam * max(2.0, greatest / self.moving.d)
                lam = farther if found.converged else max(4 * lam, FIRST_LAM / self.moving.d)
            direct = False
        return None, lam, True

    def _at_once(self, step: Step) -> Found:
        """Return the equilibrium next to the start, where there is one: most models at rest need no more."""
        tolerance = 0.5 * self.options.tolerance
        rest = newton(step, step.start, tolerance, most=0)
        if rest.converged:  # the in-situ state: what is in equilibrium must not move by rounding either
            return rest
        elastic = elastic_position(step)
        if step.norm_at(elastic) <= QUICK * step.norm_at(step.start):
            found = newton(step, elastic, tolerance, contraction=QUICK)
            if found.converged:
                return found
        return self._from_inside(step, elastic, tolerance, MOST_ITERATIONS, BARRIERS)

    def _moving(self, step: Step, inner: float, *, from_rest: bool) -> Found:
        """Return the end of a step in which blocks move."""
        most = MOST_ITERATIONS if inner < NEAR_REST else MOST_MOVING
        found = newton(step, step.start, inner, from_rest=from_rest, most=most)
        return found if found.converged else self._from_inside(step, step.start, inner, MOST_MOVING)

    def _from_inside(
        self, step: Step, elastic: FloatArray, tolerance: float, most: int, barriers: tuple[float, ...] = (1.0,)
    ) -> Found:
        """Return what Newton's method finds from where the interior point method ends."""
        for barrier in barriers:
            near = interior_point(step, elastic, HAND_OVER, barrier=barrier)
            if near is not None:
                return newton(step, near, tolerance, most=most)
        return Found(step.start, step.evaluate(step.start), converged=False)

    def _falling(
        self, contacts: MovingContacts, at: Evaluation, position: FloatArray, recent: list[FloatArray]
    ) -> tuple[str, IntArray]:
        """Return why and which blocks come down; an empty reason if none does."""
        moving, supported = self.moving, self._supported(contacts, at, position)
        self.parted[supported] = position[supported]
        moved = np.hypot(*(position - self.begin.position)[:, :2].T)
        fallen = np.hypot(*(position - self.parted)[:, :2].T)
        size = np.sqrt(moving.model.blocks.moments.area)
        loaded = np.abs(moving.loads).max(axis=1) > 0
        free = ~supported & loaded & (fallen > FREE_MOVE * size)
        if free.any():
            reason = "a block has lost all contact and moves freely"
        elif moved.max() > self.limit:
            reason = f"a block has moved more than {self.limit:.3g} m"
        else:
            return "", np.zeros(0, dtype=np.int32)
        lately = np.abs((recent[-1] - recent[0]) / moving.scale).max(axis=1) * ~moving.driven
        return reason, np.flatnonzero(free | (lately > MOVES * lately.max())).astype(np.int32)

    def _supported(self, contacts: MovingContacts, at: Evaluation, position: FloatArray) -> BoolArray:
        """Return which blocks a chain of bearing contacts and bolts joins to a support, (n,); others fall."""
        c, n, bolts = contacts.candidates, self.moving.model.blocks.count, self.moving.bolts
        near, far = bolts.holding_pairs(bolts.evaluate(position))
        ends = (np.concatenate([c.block_a[at.bearing], near]), np.concatenate([c.block_b[at.bearing], far]))
        _, part = connected_components(coo_array((np.ones(len(ends[0])), ends), shape=(n, n)), directed=False)
        held: BoolArray = np.isin(part, part[self.moving.bars.block])
        return held

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
            slipping_contacts=int((at.bearing & ~at.sticking).sum()),
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
