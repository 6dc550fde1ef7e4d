"""The solution of one stage: its parts one after the other, and again without every unstable block."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.contact.rules import CONTACT_TOLERANCE
from bsm_mesh.errors import ModelError, counted
from bsm_mesh.flow.coupling import FlowCoupling
from bsm_mesh.model.falls import Falls
from bsm_mesh.model.in_stage import present_bolts
from bsm_mesh.model.model import Model
from bsm_mesh.model.submodel import SubModel, submodel_of
from bsm_mesh.movements import distances
from bsm_mesh.results.evidence import OF_SHAKEN, Proof
from bsm_mesh.results.movement import displacement_of
from bsm_mesh.results.records import StageResult, Status, StepRecord
from bsm_mesh.solve.stages.checkpoint import Checkpoint, Keep, StageProgress
from bsm_mesh.solve.stages.crushing import notes_on_crushing
from bsm_mesh.solve.stages.falls import after_falls, falls_of, note_on_others, notes_on_movement
from bsm_mesh.solve.stages.given_position import notes_on_given_position
from bsm_mesh.solve.stages.scheme import Checker, Observer, Outcome, Scheme, Watchers
from bsm_mesh.solve.stages.shaken import notes_on_shaking
from bsm_mesh.solve.stages.state import StageState


@dataclass(frozen=True, slots=True)
class Analysis:
    """The parts that all stages of a run have in common.

    Attributes
    ----------
    model : Model
        The whole.
    scheme : Scheme
        Keeps the state of contacts and blocks.
    watchers : Watchers
        Get every step, check and measure it.
    falls : Falls
        The treatment of unstable blocks.
    keep : callable
        Gets a checkpoint after every step.
    flow : FlowCoupling or None
        Flow in the joints.
    """

    model: Model
    scheme: Scheme
    watchers: Watchers
    falls: Falls
    keep: Keep
    flow: FlowCoupling | None = None


class StageSolution:
    """The solution of one stage.

    Parameters
    ----------
    run : Analysis
        What all stages have in common.
    state : StageState
        The state at its start; it changes in place.
    name : str
        Name of the stage.
    number : int
        Its number, from 0.
    notes : tuple of str
        Notes that belong to it.
    progress : StageProgress, optional
        How far it is already, `state` and the scheme being there.
    """

    def __init__(
        self,
        run: Analysis,
        state: StageState,
        name: str,
        number: int,
        notes: tuple[str, ...] = (),
        progress: StageProgress | None = None,
    ) -> None:
        self._run, self._state, self._name, self._number = run, state, name, number
        if progress is None:
            before = run.scheme.moved.copy()
            progress = StageProgress(part=0, before=before, steps=(), fallen=(), start_residual=None, notes=notes)
        self._now, self._before, self._notes = progress.part, progress.before, progress.notes
        self._steps, self._fallen = list(progress.steps), list(progress.fallen)
        self._start_residual = progress.start_residual
        self._began_at = self._before  # where blocks were when the last part began

    def result(self, parts: Sequence[float]) -> StageResult:
        """Return the equilibrium after every released part of the excavation forces, or the first failure."""
        run, state = self._run, self._state
        while True:
            state.relaxation.release(parts[self._now])
            part = self._submodel()
            self._began_at = run.scheme.moved.copy()
            outcome = run.scheme.solve(part, self._number, state.bar_forces[part.bar], self._watch(part), self._keep)
            stage = self._ended(part, outcome)
            if stage is not None:
                self._now += 1
                if not stage.status.is_at_rest or self._now == len(parts):
                    break
            self._keep()
        state.relaxation.forget_released()
        stage = replace(stage, small_blocks=self._small_blocks())
        movement, crushing = notes_on_movement(run.model.blocks, stage), notes_on_crushing(run.model, stage)
        others = note_on_others(run.model.blocks, stage, self._free_blocks()) if outcome.down.size else []
        given = notes_on_given_position(run.model, stage, self._proof)
        found = (*notes_on_shaking(run.model, stage), *movement, *others, *given, *crushing)
        stage = replace(stage, notes=(*stage.notes, *found))
        if stage.status is Status.UNSTABLE:
            stage = replace(stage, proof=self._proof(stage.unstable_blocks))
        return after_falls(stage, tuple(self._fallen), run.model.blocks.bulk_unit)

    def _ended(self, part: SubModel, outcome: Outcome) -> StageResult | None:
        """Return where blocks ended under the forces that act now; None where they are to be solved for again.

        So they are without those that fall and are taken away, and under the water that flows as they lie.
        """
        run, state = self._run, self._state
        state.bar_forces[part.bar] = outcome.bar_forces
        if self._start_residual is None:
            self._start_residual = outcome.stage.start_residual
        stage = confirmed(self._placed(outcome.stage, part, run.scheme.moved), run.watchers.check)
        if outcome.down.size == len(part.block) or not run.falls.takes_away(outcome.small):  # some blocks stay
            stage, is_settled = self._with_flow(stage)
            return stage if is_settled else None
        down = part.block[outcome.down]
        self._fallen.extend(falls_of(run.model, down, outcome.small, stage, run.scheme.moved))
        state.take_away(down)
        run.scheme.remove_and_place_blocks(state.present, np.zeros_like(state.present))
        if run.flow is not None:
            state.flow = run.flow.begin(self._number, state.present, state.flow)
        return None

    def _small_blocks(self) -> IntArray:
        """Return the blocks that are there and too small to count, (k,)."""
        free = self._free_blocks()
        small: IntArray = np.flatnonzero(self._run.falls.small(self._run.model.blocks, free) & free).astype(np.int32)
        return small

    def _free_blocks(self) -> BoolArray:
        """Return which blocks are there and not fixed, (n,)."""
        free: BoolArray = self._state.present & ~self._state.bars.held_blocks(self._run.model.blocks)
        return free

    def _submodel(self) -> SubModel:
        """Return the blocks that are there, under what acts on them."""
        state = self._state
        bars = self._run.scheme.stage_bars(state.bars, self._number)
        on_faces = None if state.flow is None else state.flow.water
        return submodel_of(state.model, state.present, bars, state.all_forces, state.water, on_faces)

    def _with_flow(self, stage: StageResult) -> tuple[StageResult, bool]:
        """Return a stage with the flow in its joints, and whether the water that presses on them is that flow's."""
        run, state, number = self._run, self._state, self._number
        if run.flow is None or state.flow is None:
            return stage, True
        if not stage.status.is_at_rest:  # joints between unstable blocks are no network
            return replace(stage, flow=run.flow.result(state.flow, number, state.present)), True
        in_rows = run.scheme.in_rows
        try:
            state.flow, found = run.flow.go_on(
                state.flow, number, state.present, stage, run.scheme.moved, in_rows=in_rows
            )
        except ModelError as error:
            return replace(stage, status=Status.NOT_CONVERGED, reason=str(error)), True
        stage = replace(stage, flow=found)
        if run.flow.is_settled(found, number):
            return stage, True
        if found.rounds < run.flow.most_rounds(number):
            return stage, False
        asked = run.flow.tolerance(number)
        reason = (
            f"flow and blocks do not settle: after {counted(found.rounds, 'turn')} pressures still change by "
            f"{found.change:.2g} of the greatest (asked: {asked:.2g}); where changes become less, give [flow] a larger "
            "max_rounds, or a larger tolerance; where not, change levels in smaller stages"
        )
        return replace(stage, status=Status.NOT_CONVERGED, reason=reason), True

    def _keep(self) -> None:
        """Have the state between two steps kept."""

        def make() -> Checkpoint:
            progress = StageProgress(
                part=self._now,
                before=self._before,
                steps=tuple(self._steps),
                fallen=tuple(self._fallen),
                start_residual=self._start_residual,
                notes=self._notes,
            )
            return self._state.checkpoint(self._number, self._run.scheme, progress)

        self._run.keep(make, False)

    def _proof(self, down: IntArray) -> Proof:
        """Return what limit analysis says of the blocks that are there, of which some (k,) fall."""
        run, state = self._run, self._state
        if self._number and run.model.stages[self._number - 1].shaking is not None:
            return OF_SHAKEN
        moved = float(distances(self._began_at[state.present]).max(initial=0.0))
        if moved > CONTACT_TOLERANCE * run.model.blocks.moments.median_size:
            return Proof(text=f"no proof was sought: blocks moved by {moved:.3g} m before")
        part, bolts = self._submodel(), present_bolts(run.model, self._number, state.present)
        proof = run.watchers.prove(part.model.replace(bolts=bolts), np.searchsorted(part.block, down).astype(np.int32))
        return replace(proof, witness=None if proof.witness is None else proof.witness.in_whole(part))

    def _watch(self, part: SubModel) -> Observer:
        """Return what gets the steps of a part."""

        def watch(record: StepRecord, stage: Callable[[], StageResult]) -> None:
            def as_it_stands() -> StageResult:
                now, moved = stage(), self._run.scheme.moved.copy()
                moved[part.block] = now.displacement
                return self._placed(now, part, moved)

            recorded = self._run.watchers.record(as_it_stands)
            self._steps.append(replace(record, stage=self._number, step=len(self._steps), recorded=recorded))
            self._run.watchers.observer(self._steps[-1], as_it_stands)

        return watch

    def _placed(self, stage: StageResult, part: SubModel, moved: FloatArray) -> StageResult:
        """Return a part's result in the numbers of the whole, with the displacements (n, 3) since the start."""
        state, blocks = self._state, self._run.model.blocks
        displacement = (moved - state.origin) * state.present[:, None]
        bolts = stage.bolts
        if bolts.count:
            bolts = replace(bolts, displacement=displacement_of(blocks, displacement, bolts.block, bolts.original))
        return replace(
            _in_whole(stage, part),
            name=self._name,
            displacement=displacement,
            bolts=bolts,
            stage_displacement=(moved - self._before) * state.present[:, None],
            origin=state.origin.copy(),
            start_residual=stage.start_residual if self._start_residual is None else self._start_residual,
            steps=tuple(self._steps),
            notes=(*self._notes, *stage.notes),
        )


def confirmed(stage: StageResult, check: Checker) -> StageResult:
    """Return a stage; at rest by the scheme alone and not by the independent check, it counts as not converged."""
    against = check(stage) if stage.status.is_at_rest else ()
    if not against:
        return stage
    reason = f"{stage.reason} was found, but the independent check refuses it: {'; '.join(against)}"
    return replace(stage, status=Status.NOT_CONVERGED, reason=reason)


def _in_whole(stage: StageResult, part: SubModel) -> StageResult:
    """Return a part's result in the numbers of the whole."""
    supports = stage.supports
    return replace(
        stage,
        present=part.present,
        stress=part.in_whole(stage.stress),
        stress_effective=part.in_whole(stage.stress_effective),
        loads=part.in_whole(stage.loads),
        reactions=part.in_whole(stage.reactions),
        water=part.in_whole(stage.water),
        contacts=stage.contacts.in_whole(part),
        supports=replace(supports, block=part.block[supports.block]),
        unstable_blocks=part.block[stage.unstable_blocks],
        evidence=None if stage.evidence is None else stage.evidence.in_whole(part),
        shaking=None if stage.shaking is None else stage.shaking.in_whole(part),
    )
