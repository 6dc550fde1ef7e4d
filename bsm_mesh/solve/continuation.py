"""Equilibrium by pseudo-time continuation: implicit static steps with a mass-like regularisation that fades.

Each step solves ``loads + contact forces - lam * M (q - q_n) = 0`` for the position q, with total contact laws,
exact rotations, and ``M = diag(W, W, W I/A)`` anchored at the accepted position. Where little moves, lam falls
by four a step and the end is static equilibrium; where blocks run away it stays, and they are followed.

The step, numbered as in the loop:

1. contacts near the accepted position, with their history;
2. Newton: force out of balance, tangent, correction, capped at twice the step length d;
3. the correction is halved until the 2-norm falls (the greatest residual as merit needs many times the iterations);
4. a step that does not converge or moves too far is taken again with a greater lam;
5. accepted: history is committed; lam is adapted to the movement;
6. verdict.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.contact.properties import JointCatalogue
from bsm_mesh.contact.search import Outlines, corner_positions
from bsm_mesh.errors import SingularMatrixError
from bsm_mesh.model.loads import point_forces_of
from bsm_mesh.model.model import Model
from bsm_mesh.model.supports import bars_of
from bsm_mesh.model.water_pressure import WaterLoad
from bsm_mesh.results.records import Status, StepRecord
from bsm_mesh.solve.constraints import Constraints, constrain_bars
from bsm_mesh.solve.linear_solvers import LinearSolver, make_linear_solver
from bsm_mesh.solve.moving import (
    Evaluation,
    History,
    MovingContacts,
    commit,
    elastic_tangent,
    evaluate,
    first_tangent,
    gather_contacts,
    tangent_stiffness,
    turned,
)
from bsm_mesh.solve.options import Options
from bsm_mesh.solve.pattern import BlockPattern, constrain, whole_pattern
from bsm_mesh.solve.system import external_loads, reference_weight

STEP = 0.05  # of the block size: step length d
FIRST_LAM = 1e-3  # over d
LEAST_LAM, MOST_LAM = 1e-7, 1e9  # over d
MOST_ITERATIONS = 12
MOST_DIRECT = 40  # iterations of the first try, at the least lam: most models at rest need no more
MOST_HALVINGS = 6
SOFTNESS = 0.1  # in the direct try, at a residual of the reference weight; falls with it
DRIVEN = 0.5  # of the step length: how far supports move blocks in a step
REACHED = 1e-6  # of the step length: what a prescribed displacement may lack at the end
FREE_MOVE = 0.1  # of its size: a block that has moved this far without contact comes down
SHIFT, BALANCED, BALANCE_ITERATIONS = 4.0, 1e-3, 12  # over the block size
RECENT_STEPS, MOVES = 5, 0.25  # unstable: moved more than a quarter of the greatest over the last five steps


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Start:
    """Where the continuation starts: positions (n, 3), what contacts remember, whether untouched ones are intact."""

    position: FloatArray
    history: History
    intact: bool


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Motion:
    """Where the continuation ended."""

    status: Status
    reason: str
    position: FloatArray
    contacts: MovingContacts
    at: Evaluation
    constraints: Constraints
    loads: FloatArray
    unstable_blocks: IntArray
    start_residual: float
    residual: float
    reference: float
    steps: tuple[StepRecord, ...]
    linear_solver: str


@dataclass(eq=False, slots=True)
class _Work:
    """Counts and the linear solver of one pattern."""

    solver: LinearSolver | None = None
    pattern: BlockPattern | None = None
    name: str = ""
    factorizations: int = 0
    iterations: int = 0
    steps: list[StepRecord] = field(default_factory=list)


def moved_by(position: FloatArray, step: FloatArray) -> FloatArray:
    """Return positions after finite turns about the instant centres of a step (n, 3): the exponential map of SE(2).

    A block that turns about a stiff corner so keeps the corner in place; added up plainly, translation and rotation
    would move it by the square of the angle, and the line search would cut every step to that.
    """
    u, v, turn = step.T
    sinc = np.sinc(turn / np.pi)
    versed = np.sin(turn / 2) * np.sinc(turn / (2 * np.pi))  # (1 - cos) / turn
    moved: FloatArray = position + np.column_stack([sinc * u - versed * v, versed * u + sinc * v, turn])
    return moved


class Continuation:
    """The continuation of one model.

    Parameters
    ----------
    model : Model
        What is given.
    options : Options
        Tolerance, limits, linear solver.
    observer : callable
        Gets every accepted step's record.
    start : Start, optional
        Where it starts; by default from the blocks as they are given, with contacts that bear nothing.
    """

    def __init__(
        self, model: Model, options: Options, observer: Callable[[StepRecord], None], start: Start | None = None
    ) -> None:
        self.model, self.options, self.observer = model, options, observer
        moments = model.blocks.moments
        self.start = np.column_stack([moments.centroid, np.zeros(model.blocks.count)])
        self.begin = start or Start(position=self.start, history=History.none(), intact=True)
        self.start_residual = 0.0
        self.bars = bars_of(model.supports, model.blocks)
        self.bar_arm = self.bars.point - moments.centroid[self.bars.block]
        at_start = self.constraints_at(self.start, conflicts=True)
        held = np.zeros(model.blocks.count, dtype=bool)
        held[at_start.block[at_start.held == 3]] = True
        self.driven = held.copy()  # blocks that only their supports move
        prescribed = np.unique(self.bars.block[self.bars.value != 0])
        held[prescribed] = False
        self.held = held
        self.outlines = Outlines.of(model.blocks, held)
        self.catalogue = JointCatalogue(model)
        self.applied = point_forces_of(model.acting_loads, model.blocks)
        self.water = WaterLoad(model)
        self.applied_arm = self.applied.point - moments.centroid[self.applied.block]
        self.loads = external_loads(model)
        self.dead = self._dead_forces()
        self.reference = reference_weight(model, self.loads)
        weight = np.maximum(model.weights, 1e-3 * self.reference)
        self.mass = np.column_stack([weight, weight, weight * moments.polar / moments.area])
        self.scale = np.column_stack([np.ones((model.blocks.count, 2)), 1 / moments.gyration])
        self.d = STEP * self.outlines.size
        self.limit = options.displacement_limit or float(np.ptp(model.blocks.vertices, axis=0).max())
        self.work = _Work()
        self.least_lam = LEAST_LAM / self.d
        self.parted = self.begin.position.copy()  # where each block last had a contact or a support

    def _dead_forces(self) -> FloatArray:
        """Return weights and the forces of loads, which keep their direction, (n, 2)."""
        total = self.model.gravity_forces
        np.add.at(total, self.applied.block, self.applied.force)
        return total

    def run(self) -> Motion:
        """Return where the blocks come to rest, or how they come down."""
        position, history = self.begin.position, self.begin.history
        lam, quiet, rejected_before = FIRST_LAM / self.d, 0, False
        recent: list[FloatArray] = [position]
        for number in range(self.options.max_steps):
            began = time.perf_counter()
            counts = self.work.factorizations, self.work.iterations
            contacts = self._gather(history, position, first=number == 0 and self.begin.intact)  # (1)
            residual = self._static_residual(contacts, position)
            if number == 0:
                self.start_residual = residual
            inner = max(0.1 * self.options.tolerance, 1e-2 * min(residual, 1.0))
            rejected = False
            tries = [(LEAST_LAM / self.d, MOST_DIRECT)] if number == 0 else []
            while True:  # (2)-(4)
                step_lam, most = tries.pop() if tries else (lam, MOST_ITERATIONS)
                direct = most == MOST_DIRECT
                moved, at, converged = self._newton(
                    contacts,
                    position,
                    step_lam,
                    0.5 * self.options.tolerance if direct else inner,
                    most,
                    first=number == 0,
                )
                greatest = float(np.abs((moved - position) / self.scale).max())
                if converged and greatest <= 2 * self.d:
                    fall = 0.0 if quiet else self._balanced(contacts, moved, at)
                    if fall == 0 or step_lam >= 2 * fall:
                        lam = step_lam
                        break
                    self.least_lam = max(self.least_lam, 2 * fall)
                    lam, rejected = max(lam, self.least_lam), True
                    continue
                if direct:
                    continue
                rejected = True
                lam = max(4 * lam, FIRST_LAM / self.d) if not converged else lam * max(2.0, greatest / self.d)
                if lam > MOST_LAM / self.d:
                    return self._end(Status.NOT_CONVERGED, "a step cannot be solved at any length", contacts, position)
            position = moved
            history, changed = commit(contacts, at, position, self.outlines.size)  # (5)
            residual = self._static_residual(contacts, position)
            self._record(number, residual, position, contacts, at, began, counts)
            recent = [*recent[-RECENT_STEPS:], position]
            at_rest = residual < self.options.tolerance and changed == 0 and self._reached(position)
            quiet = quiet + 1 if at_rest else 0
            if quiet >= 2:  # (6)
                return self._end(Status.STABLE, "static equilibrium", contacts, position)
            reason, blocks = self._falling(contacts, at, position, recent)
            if reason:
                return self._end(Status.UNSTABLE, reason, contacts, position, blocks)
            slower = 1 / 1.5 if rejected or rejected_before else 1 / 4
            rejected_before = rejected
            lam = float(np.clip(lam * np.clip(greatest / self.d, slower, 4.0), self.least_lam, 1e3 / self.d))
        reason = f"the limit of {self.options.max_steps} steps was reached with residual {residual:.1e}"
        return self._end(Status.NOT_CONVERGED, reason, contacts, position)

    def loads_at(self, position: FloatArray) -> FloatArray:
        """Return weights, loads and water, (n, 3).

        Loads keep their direction and move with their point on the block; the water's pressure is that of where the
        block is.
        """
        if not len(self.applied.block) and not self.water.acts:
            return self.loads
        loads = self.water_at(position)
        loads[:, :2] += self.dead
        arm = turned(self.applied_arm, position[self.applied.block, 2])
        force = self.applied.force
        np.add.at(loads[:, 2], self.applied.block, arm[:, 0] * force[:, 1] - arm[:, 1] * force[:, 0])
        return loads

    def water_at(self, position: FloatArray) -> FloatArray:
        """Return the water's force and moment on every block where it stands, (n, 3)."""
        return self.water.on_blocks(corner_positions(self.outlines, position), position[:, :2])

    def point_forces_at(self, position: FloatArray) -> tuple[IntArray, FloatArray, FloatArray]:
        """Return block, point and force of every load as the blocks stand."""
        arm = turned(self.applied_arm, position[self.applied.block, 2])
        return self.applied.block, position[self.applied.block, :2] + arm, self.applied.force

    def bar_arms(self, position: FloatArray) -> FloatArray:
        """Return the arms from centroids to held points as the blocks stand, (n_bars, 2) [m]."""
        return turned(self.bar_arm, position[self.bars.block, 2])

    def constraints_at(self, position: FloatArray, *, conflicts: bool = False) -> Constraints:
        """Return the supports' constraints on small movements from a position."""
        arm = self.bar_arms(position)
        moved = position[self.bars.block] - self.start[self.bars.block]
        reached = ((moved[:, :2] + arm - self.bar_arm) * self.bars.direction).sum(axis=1)
        reached = np.where(self.bars.holds_rotation, moved[:, 2], reached)
        return constrain_bars(self.model, self.bars, arm, self.bars.value - reached, conflicts=conflicts)

    def _given(self, supports: Constraints) -> FloatArray:
        """Return the part of the prescribed displacements that is applied in one step.

        It is less than blocks fall in a step, so that those on a support that sinks keep up with it.
        """
        size = float(np.abs(supports.given / self.scale).max())
        return supports.given * min(1.0, DRIVEN * self.d / size) if size > 0 else supports.given

    def _reached(self, position: FloatArray) -> bool:
        """Return whether the prescribed displacements are applied in full."""
        return float(np.abs(self.constraints_at(position).given / self.scale).max()) <= REACHED * self.d

    def _gather(self, history: History, position: FloatArray, *, first: bool) -> MovingContacts:
        return gather_contacts(self.model, self.outlines, self.catalogue, history, position, 1.5 * self.d, first=first)

    def _evaluate(self, contacts: MovingContacts, position: FloatArray) -> Evaluation:
        return evaluate(contacts, self.catalogue.laws, position)

    def _free(self, forces: FloatArray, supports: Constraints) -> FloatArray:
        """Return forces as accelerations see them: held axes out, moments over the radius of gyration."""
        free = supports.free_part(forces)
        plain = np.ones(len(forces), dtype=bool)
        plain[supports.block] = False
        free[plain] *= self.scale[plain]
        return free

    def _static_residual(self, contacts: MovingContacts, position: FloatArray) -> float:
        at = self._evaluate(contacts, position)
        supports = self.constraints_at(position)
        return float(np.abs(self._free(self.loads_at(position) + at.forces, supports)).max()) / self._weight(at)

    def _weight(self, at: Evaluation) -> float:
        if self.reference > 0:
            return self.reference
        forces = at.pressure[at.bearing]
        return float(forces.mean()) if forces.size and forces.mean() > 0 else 1.0

    def _newton(
        self, contacts: MovingContacts, anchor: FloatArray, lam: float, inner: float, most: int, *, first: bool
    ) -> tuple[FloatArray, Evaluation, bool]:
        """Return position, evaluation, and whether the step's equations hold to `inner`."""
        pattern = self._pattern(contacts)
        supports = self.constraints_at(anchor)
        given = self._given(supports)
        position = anchor + given
        at = self._evaluate(contacts, position)
        for iteration in range(most + 1):
            forces = self.loads_at(position) + at.forces - lam * self.mass * (position - anchor)
            free = self._free(forces, supports)
            weight = self._weight(at)
            greatest, norm = float(np.abs(free).max()) / weight, float(np.linalg.norm(free)) / weight
            if greatest < inner and (iteration or not given.any()):
                return position, at, True
            if iteration == most:
                break
            if first and iteration == 0:
                data = first_tangent(contacts, at, pattern.place, len(pattern.column))
            else:
                softness = SOFTNESS * min(greatest, 1.0) if most == MOST_DIRECT else 0.0
                data = tangent_stiffness(contacts, at, pattern.place, len(pattern.column), softness)
            step = self._correct(pattern, data, supports, lam, forces)
            if step is None:
                break
            size = float(np.abs(step / self.scale).max())
            part = min(1.0, 2 * self.d / size) if size > 0 else 1.0
            position, at = self._halve(contacts, anchor, position, step, part, lam, supports, norm)
        return position, at, False

    def _correct(
        self, pattern: BlockPattern, data: FloatArray, supports: Constraints, lam: float, forces: FloatArray
    ) -> FloatArray | None:
        """Return the Newton correction, or None where the matrix is singular."""
        data[pattern.diagonal, [[0], [1], [2]], [[0], [1], [2]]] += lam * self.mass.T
        constrain(
            pattern.row_start, pattern.column, pattern.diagonal, data, supports.number, supports.basis, supports.held
        )
        assert self.work.solver is not None
        self.work.iterations += 1
        self.work.factorizations += 1
        try:
            self.work.solver.factorize(data)
            step = supports.expand(self.work.solver.solve(supports.free_part(forces)))
        except SingularMatrixError:
            return None
        return step if np.isfinite(step).all() else None

    def _halve(
        self,
        contacts: MovingContacts,
        anchor: FloatArray,
        position: FloatArray,
        step: FloatArray,
        part: float,
        lam: float,
        supports: Constraints,
        norm: float,
    ) -> tuple[FloatArray, Evaluation]:
        """Return the best of the corrections halved until the 2-norm falls (3)."""
        best: tuple[float, FloatArray, Evaluation] | None = None
        for _ in range(MOST_HALVINGS + 1):
            trial = moved_by(position, part * step)
            at = self._evaluate(contacts, trial)
            free = self._free(self.loads_at(trial) + at.forces - lam * self.mass * (trial - anchor), supports)
            found = float(np.linalg.norm(free)) / self._weight(at)
            if best is None or found < best[0]:
                best = found, trial, at
            if found < (1 - 1e-3 * part) * norm:
                break
            part /= 2
        assert best is not None
        return best[1], best[2]

    def _balanced(self, contacts: MovingContacts, position: FloatArray, at: Evaluation) -> float:
        """Return how fast blocks fall out of an equilibrium, as a lam; 0 where it is none, or a stable one.

        A block balanced on a corner is in equilibrium too, and Newton finds it as readily as any other. The lowest
        eigenvalue of the tangent over the mass, from power iteration on the shifted inverse, tells: a Rayleigh
        quotient is never below it, so that nothing stable is taken for unstable.
        """
        supports = self.constraints_at(position)
        free = self._free(self.loads_at(position) + at.forces, supports)
        if self.reference == 0 or float(np.abs(free).max()) >= self.options.tolerance * self._weight(at):
            return 0.0
        pattern = self._pattern(contacts)
        data = elastic_tangent(contacts, at, pattern.place, len(pattern.column), self.outlines.size)
        shift = SHIFT / self.outlines.size
        vector = np.random.default_rng(0).normal(size=position.shape) * self.scale
        lowest = 0.0
        for k in range(BALANCE_ITERATIONS):
            pushed = self.mass * vector
            if k == 0:
                found = self._correct(pattern, data, supports, shift, pushed)
                if found is None:
                    return 0.0
            else:
                assert self.work.solver is not None
                found = supports.expand(self.work.solver.solve(supports.free_part(pushed)))
            square = float((found * self.mass * found).sum())
            if not (np.isfinite(square) and square > 0):
                return 0.0
            lowest = min(lowest, float((found * pushed).sum()) / square - shift) if k else 0.0
            vector = found / np.sqrt(square)
        return -lowest if lowest < -BALANCED / self.outlines.size else 0.0

    def _pattern(self, contacts: MovingContacts) -> BlockPattern:
        """Return the pattern of the candidates; its analysis is kept while it stays the same."""
        c, old = contacts.candidates, self.work.pattern
        pattern = whole_pattern(self.model.blocks.count, c.block_a, c.block_b)
        same = (
            old is not None
            and len(old.column) == len(pattern.column)
            and np.array_equal(old.row_start, pattern.row_start)
            and np.array_equal(old.column, pattern.column)
        )
        if not same:
            if self.work.solver is not None:
                self.work.solver.close()
            self.work.solver = make_linear_solver(
                self.options.linear_solver, pattern, self.model.blocks.moments.centroid, self.options.threads
            )
            self.work.name, self.work.pattern = self.work.solver.name, pattern
        return pattern

    def _falling(
        self, contacts: MovingContacts, at: Evaluation, position: FloatArray, recent: list[FloatArray]
    ) -> tuple[str, IntArray]:
        """Return why and which blocks come down; an empty reason if none does."""
        c = contacts.candidates
        supported = np.zeros(len(position), dtype=bool)
        supported[c.block_a[at.bearing]] = supported[c.block_b[at.bearing]] = True
        supported[self.bars.block] = True
        self.parted[supported] = position[supported]
        moved = np.hypot(*(position - self.begin.position)[:, :2].T)
        fallen = np.hypot(*(position - self.parted)[:, :2].T)
        size = np.sqrt(self.model.blocks.moments.area)
        loaded = np.abs(self.loads).max(axis=1) > 0
        free = ~supported & loaded & (fallen > FREE_MOVE * size)
        if free.any():
            reason = "a block has lost all contact and moves freely"
        elif moved.max() > self.limit:
            reason = f"a block has moved more than {self.limit:.3g} m"
        else:
            return "", np.zeros(0, dtype=np.int32)
        lately = np.abs((recent[-1] - recent[0]) / self.scale).max(axis=1) * ~self.driven
        return reason, np.flatnonzero(free | (lately > MOVES * lately.max())).astype(np.int32)

    def _record(
        self,
        number: int,
        residual: float,
        position: FloatArray,
        contacts: MovingContacts,
        at: Evaluation,
        began: float,
        before: tuple[int, int],
    ) -> None:
        record = StepRecord(
            stage=0,
            step=number,
            residual=residual,
            max_displacement=float(np.hypot(*(position - self.begin.position)[:, :2].T).max()),
            newton_iterations=self.work.iterations - before[1],
            factorizations=self.work.factorizations - before[0],
            open_contacts=int((contacts.touching & ~at.bearing).sum()),
            slipping_contacts=int((at.bearing & ~at.sticking).sum()),
            seconds=time.perf_counter() - began,
        )
        self.work.steps.append(record)
        self.observer(record)

    def _end(
        self,
        status: Status,
        reason: str,
        contacts: MovingContacts,
        position: FloatArray,
        unstable: IntArray | None = None,
    ) -> Motion:
        at = self._evaluate(contacts, position)
        if self.work.solver is not None:
            self.work.solver.close()
        return Motion(
            status=status,
            reason=reason,
            position=position,
            contacts=contacts,
            at=at,
            constraints=self.constraints_at(position),
            loads=self.loads_at(position),
            unstable_blocks=np.zeros(0, dtype=np.int32) if unstable is None else unstable,
            start_residual=self.start_residual,
            residual=self._static_residual(contacts, position),
            reference=self._weight(at),
            steps=tuple(self.work.steps),
            linear_solver=self.work.name,
        )
