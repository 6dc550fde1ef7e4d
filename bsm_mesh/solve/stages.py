"""Construction stages: blocks are excavated and placed, the others keep their forces (Wang 4.5.2).

A scheme (`LinearScheme`, `ContinuationScheme`) keeps the state of contacts and blocks from stage to stage, in the
numbers of the whole model, and solves the blocks present as a submodel.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Protocol

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.errors import counted, listing
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.model.loads import PointForces, point_forces_of
from bsm_mesh.model.model import Model
from bsm_mesh.model.stages import Stage, presence
from bsm_mesh.model.submodel import SubModel, submodel_of
from bsm_mesh.model.supports import Bars, bars_of
from bsm_mesh.model.water import Water
from bsm_mesh.results.bolts import BoltForces
from bsm_mesh.results.falls import Fall
from bsm_mesh.results.records import ContactForces, StageResult, Status, StepRecord
from bsm_mesh.solve.falls import Falls, after_falls, falls_of

FAR = 0.1  # of a block's size, the root of its area
Reporter = Callable[[str], None]
Checker = Callable[[StageResult], tuple[str, ...]]  # what speaks against a stage at rest, a sentence each
Observer = Callable[[StepRecord, Callable[[], StageResult]], None]  # a step, and what returns the stage
Finished = Callable[[tuple[StageResult, ...]], None]


@dataclass(frozen=True, eq=False, slots=True)
class Outcome:
    """The result of a stage in the numbers of its submodel, and the forces in its bars.

    `down` (k,) are the blocks that come down, and `small` (k,) which of them are too small to count.
    """

    stage: StageResult
    bar_forces: FloatArray
    down: IntArray = field(default_factory=lambda: np.zeros(0, dtype=np.int32))
    small: BoolArray = field(default_factory=lambda: np.zeros(0, dtype=bool))


class Scheme(Protocol):
    """A scheme, as used by the stages."""

    linear_solver: str
    moved: FloatArray
    """Displacement of every block since it was given, or placed, (n, 3)."""

    def set_in_situ(self) -> tuple[str, ...]:
        """Set the contact forces from the in-situ field; return notes on it."""

    def stage_bars(self, bars: Bars, number: int) -> Bars:
        """Return the supports for a stage."""

    def remove_and_place_blocks(self, stays: BoolArray, comes: BoolArray) -> None:
        """Remove contacts of blocks that do not stay (n,), cut their bolts, place those that come (n,)."""

    def install(self, number: int) -> None:
        """Install the bolts of a stage at the current position, from which its movement counts."""

    def as_given(self, block: IntArray, point: FloatArray) -> FloatArray:
        """Return the positions in the given geometry of points (k, 2) of blocks (k,)."""

    def solve(self, part: SubModel, number: int, bars_before: FloatArray, observer: Observer) -> Outcome:
        """Return the submodel in equilibrium or collapse, and keep its state."""


@dataclass(eq=False, slots=True)
class StageState:
    """The state that changes from stage to stage, in the numbers of the whole."""

    present: BoolArray
    bars: Bars
    bar_forces: FloatArray
    forces: list[PointForces]
    water: Water | None
    unreleased_forces: list[tuple[PointForces, float]] = field(default_factory=list)  # on new surfaces; part released
    origin: FloatArray = field(default_factory=lambda: np.zeros((0, 3)))
    fallen: list[int] = field(default_factory=list)


def solve_stages(
    model: Model,
    scheme: Scheme,
    report: Reporter,
    observer: Observer,
    check: Checker,
    finished: Finished,
    falls: Falls,
    notes: tuple[str, ...] = (),
) -> tuple[StageResult, ...]:
    """Return the results of all stages up to the first that is not stable; ``initial``, with `notes`, is the first.

    A stage that a scheme calls stable is so only where `check` finds nothing against it. `finished` gets the stages so
    far at the end of each. `falls` says what is done with blocks that come down. `notes` belong to the first.

    Raises
    ------
    ModelError
        If the start cannot be analysed.
    """
    here = presence(model.stages, model.blocks)
    bars = bars_of(model.supports, model.blocks)
    state = StageState(
        present=here[0],
        bars=bars,
        bar_forces=np.zeros(len(bars.block)),
        forces=[point_forces_of(model.acting_loads, model.blocks)],
        water=model.water,
        origin=np.zeros((model.blocks.count, 3)),
    )
    if model.in_situ is not None and model.in_situ.method == "direct":
        from bsm_mesh.solve.contacts.in_situ import in_situ_bars

        report("in-situ stress")
        notes = (*notes, *scheme.set_in_situ())
        state.bar_forces = in_situ_bars(model, bars)
    results = [_equilibrium(model, scheme, state, "initial", 0, (1.0,), observer, check, falls, notes)]
    finished(tuple(results))
    if model.in_situ is not None:
        state.origin = scheme.moved.copy()
    for number, stage in enumerate(model.stages, start=1):
        if not results[-1].status.is_stable:
            break
        report(f"stage {stage.name}")
        now = here[number].copy()
        now[state.fallen] = False
        _begin(model, scheme, state, stage, now, results[-1].contacts)
        scheme.install(number)
        parts = stage.relaxation
        results.append(_equilibrium(model, scheme, state, stage.name, number, parts, observer, check, falls, ()))
        finished(tuple(results))
    return tuple(results)


def _begin(
    model: Model, scheme: Scheme, state: StageState, stage: Stage, now: BoolArray, contacts: ContactForces
) -> None:
    """Remove and place the blocks of a stage, and add its loads."""
    stays, leaves = state.present & now, state.present & ~now
    state.unreleased_forces.append((_forces_on_new_faces(scheme, contacts, stays, leaves), 0.0))
    scheme.remove_and_place_blocks(stays, now & ~state.present)
    if stage.pressure:
        state.forces.append(_pressure_on_new_faces(model, stays, leaves, stage.pressure))
    state.forces.append(point_forces_of(model.worked_out(stage.loads), model.blocks))
    state.water = state.water if stage.water is None else stage.water
    state.origin[~stays] = 0.0
    state.bar_forces[~stays[state.bars.block]] = 0.0
    state.present = now


def _equilibrium(
    model: Model,
    scheme: Scheme,
    state: StageState,
    name: str,
    number: int,
    factors: tuple[float, ...],
    observer: Observer,
    check: Checker,
    falls: Falls,
    notes: tuple[str, ...],
) -> StageResult:
    """Return a stage's result: equilibrium after every released part of the excavation forces."""
    before = scheme.moved.copy()
    steps: list[StepRecord] = []
    fallen: list[Fall] = []
    start_residual = None

    def placed(stage: StageResult, part: SubModel, moved: FloatArray) -> StageResult:
        displacement = (moved - state.origin) * state.present[:, None]
        return replace(
            _in_whole(stage, part),
            name=name,
            displacement=displacement,
            bolts=replace(stage.bolts, displacement=displacement_at(model.blocks, displacement, stage.bolts)),
            stage_displacement=(moved - before) * state.present[:, None],
            origin=state.origin.copy(),
            start_residual=stage.start_residual if start_residual is None else start_residual,
            steps=tuple(steps),
            notes=(*notes, *stage.notes),
        )

    todo = list(factors)
    while todo:
        factor = todo[0]
        state.unreleased_forces = [(forces, max(released, factor)) for forces, released in state.unreleased_forces]
        bars = scheme.stage_bars(state.bars, number)
        part = submodel_of(model, state.present, bars, _all_forces(state), state.water)

        def watch(record: StepRecord, stage: Callable[[], StageResult], part: SubModel = part) -> None:
            def as_it_stands() -> StageResult:
                now, moved = stage(), scheme.moved.copy()
                moved[part.block] = now.displacement
                return placed(now, part, moved)

            steps.append(replace(record, stage=number, step=len(steps)))
            observer(steps[-1], as_it_stands)

        outcome = scheme.solve(part, number, state.bar_forces[part.bar], watch)
        state.bar_forces[part.bar] = outcome.bar_forces
        start_residual = outcome.stage.start_residual if start_residual is None else start_residual
        stage = _confirmed(placed(outcome.stage, part, scheme.moved), check)
        if falls.takes_away(outcome.small):
            down = part.block[outcome.down]
            fallen.extend(falls_of(model, down, outcome.small, stage, scheme.moved))
            _take_away(scheme, state, down)
            continue
        if stage.status is not Status.STABLE:
            break
        del todo[0]
    state.unreleased_forces = [(forces, released) for forces, released in state.unreleased_forces if released < 1]
    if state.water is not None and state.water.table and not stage.water.any():
        dry = "no block lies below the water table: check its level and unit"
        stage = replace(stage, notes=(*stage.notes, dry))
    stage = replace(stage, notes=(*stage.notes, *_note_on_movement(model.blocks, stage)))
    return after_falls(stage, tuple(fallen))


def _take_away(scheme: Scheme, state: StageState, down: IntArray) -> None:
    """Take blocks (k,) away that came down: nothing holds them, and they hold nothing."""
    state.fallen.extend(down.tolist())
    state.present = state.present.copy()
    state.present[down] = False
    scheme.remove_and_place_blocks(state.present, np.zeros_like(state.present))
    state.origin[down] = 0.0
    state.bar_forces[~state.present[state.bars.block]] = 0.0


def _note_on_movement(blocks: Blocks, stage: StageResult) -> tuple[str, ...]:
    """Say which blocks at rest lie far from where the stage found them: they gave way first, and lie somewhere."""
    moved = np.hypot(*stage.stage_displacement[:, :2].T)
    far = np.flatnonzero(moved > FAR * np.sqrt(blocks.moments.area))
    if stage.status is not Status.STABLE or not far.size:
        return ()
    return (
        f"before it came to rest, {counted(far.size, 'block')} moved by more than a tenth of its size, up to "
        f"{moved[far].max():.3g} m: block {listing(far)}; where that is a failure, give a smaller displacement_limit",
    )


def _confirmed(stage: StageResult, check: Checker) -> StageResult:
    """Return a stage; at rest by the scheme alone and not by the independent check, it counts as not converged."""
    against = check(stage) if stage.status is Status.STABLE else ()
    if not against:
        return stage
    reason = f"{stage.reason} by the solution, but not by the independent check: {'; '.join(against)}"
    return replace(stage, status=Status.NOT_CONVERGED, reason=reason)


def displacement_at(blocks: Blocks, displacement: FloatArray, bolts: BoltForces) -> FloatArray:
    """Return the displacement of the rock at the bolts' nodes, (n_nodes, 2) [m]."""
    arm = bolts.original - blocks.moments.centroid[bolts.block]
    u, v, turn = displacement[bolts.block].T
    versed, sine = -2 * np.sin(turn / 2) ** 2, np.sin(turn)  # cos(turn) - 1 without loss of digits
    return np.column_stack([u + versed * arm[:, 0] - sine * arm[:, 1], v + sine * arm[:, 0] + versed * arm[:, 1]])


def _all_forces(state: StageState) -> PointForces:
    left = [(forces, 1 - released) for forces, released in state.unreleased_forces if released < 1]
    return concatenate([*state.forces, *(replace(forces, force=part * forces.force) for forces, part in left)])


def concatenate(parts: list[PointForces]) -> PointForces:
    """Return the point forces of several tables in one."""
    block, point, force = (np.concatenate([getattr(p, name) for p in parts]) for name in ("block", "point", "force"))
    return PointForces(block=block, point=point, force=force)


def _forces_on_new_faces(scheme: Scheme, contacts: ContactForces, stays: BoolArray, leaves: BoolArray) -> PointForces:
    """Return the excavation forces: those of the removed blocks on the others."""
    on_b, on_a = (
        np.flatnonzero(stays[one] & leaves[other])
        for one, other in ((contacts.block_b, contacts.block_a), (contacts.block_a, contacts.block_b))
    )
    block = np.concatenate([contacts.block_b[on_b], contacts.block_a[on_a]])
    point = np.concatenate([contacts.point[on_b], contacts.point[on_a]])
    force = np.concatenate([contacts.force[on_b], -contacts.force[on_a]])
    return PointForces(block=block, point=scheme.as_given(block, point), force=force)


def _pressure_on_new_faces(model: Model, stays: BoolArray, leaves: BoolArray, pressure: float) -> PointForces:
    """Return a pressure on the faces between blocks that stay and blocks that leave, into those that stay."""
    from bsm_mesh.model.faces import find_faces

    faces, owner = find_faces(model.blocks), model.blocks.owner
    a, b = owner[faces.edge_a], owner[faces.edge_b]
    bare = (stays[b] & leaves[a]) | (stays[a] & leaves[b])
    start, end = faces.start[bare], faces.end[bare]
    along = end - start  # in the direction of b's edge, b to its left
    inward = np.stack([-along[:, 1], along[:, 0]], axis=1) * np.where(stays[b[bare]], 1.0, -1.0)[:, None]
    return PointForces(
        block=np.repeat(np.where(stays[b], b, a)[bare], 2),
        point=np.stack([start, end], axis=1).reshape(-1, 2),
        force=np.repeat(pressure * inward / 2, 2, axis=0),
    )


def _in_whole(stage: StageResult, part: SubModel) -> StageResult:
    """Return a part's result in the numbers of the whole."""
    contacts, supports = stage.contacts, stage.supports
    return replace(
        stage,
        present=part.present,
        stress=part.in_whole(stage.stress),
        stress_effective=part.in_whole(stage.stress_effective),
        loads=part.in_whole(stage.loads),
        reactions=part.in_whole(stage.reactions),
        water=part.in_whole(stage.water),
        contacts=replace(contacts, block_a=part.block[contacts.block_a], block_b=part.block[contacts.block_b]),
        supports=replace(supports, block=part.block[supports.block]),
        unstable_blocks=part.block[stage.unstable_blocks],
    )
