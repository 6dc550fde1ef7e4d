"""The stages of rigid blocks: excavated and placed, the others keep their forces (Wang 4.5.2).

A scheme (`LinearScheme`, `ContinuationScheme`) keeps the state of contacts and blocks from stage to stage. It has the
numbers of the whole model, and solves the blocks present as a submodel.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from bsm_mesh.arrays import BoolArray
from bsm_mesh.model.in_stage import model_in_stage, water_in_stage
from bsm_mesh.model.loads import point_forces_of
from bsm_mesh.model.model import Model
from bsm_mesh.model.stages import INITIAL, Stage, presence
from bsm_mesh.model.supports import bars_of
from bsm_mesh.results.records import ContactForces, StageResult
from bsm_mesh.solve.stages.checkpoint import Checkpoint, StageProgress
from bsm_mesh.solve.stages.new_faces import pressure_on_new_faces
from bsm_mesh.solve.stages.relaxation import forces_on_new_faces
from bsm_mesh.solve.stages.scheme import Reporter, Scheme
from bsm_mesh.solve.stages.solution import Analysis, StageSolution
from bsm_mesh.solve.stages.state import StageState


class BlockStages:
    """The stages of a model of rigid blocks.

    Parameters
    ----------
    run : Analysis
        What all stages have in common.
    report : callable
        Called with a short text on progress.
    notes : tuple of str
        Notes that belong to the first stage.

    Attributes
    ----------
    name : str
        Of the scheme.
    """

    _state: StageState

    def __init__(self, run: Analysis, report: Reporter, notes: tuple[str, ...] = ()) -> None:
        self._run, self._report, self._notes = run, report, notes
        self.name: str = run.scheme.options.scheme
        model = run.model
        self._here, self._bars = presence(model.stages, model.blocks), bars_of(model.supports, model.blocks)

    @property
    def linear_solver(self) -> str:
        """Name of the solver used."""
        return self._run.scheme.linear_solver

    def start(self) -> None:
        """Begin under the in-situ field, where it is given directly."""
        run, model = self._run, self._run.model
        self._state = StageState(
            model=model,
            present=self._here[0],
            bars=self._bars,
            bar_forces=np.zeros(len(self._bars.block)),
            forces=[point_forces_of(model.acting_loads, model.blocks)],
            water=model.water,
            origin=np.zeros_like(run.scheme.moved),
            flow=None if run.flow is None else run.flow.first,
        )
        if model.in_situ is not None and model.in_situ.method == "direct":
            from bsm_mesh.contact.in_situ import in_situ_bars

            self._report("in-situ stress")
            self._notes = (*self._notes, *run.scheme.set_in_situ())
            self._state.bar_forces = in_situ_bars(model, self._bars)

    def recall(self, begun: Checkpoint) -> None:
        """Continue at a checkpoint."""
        model = self._run.model
        self._run.scheme.restore(begun.scheme)
        number = begun.last_stage
        water = water_in_stage(model, number)
        self._state = StageState.recalled(begun, model_in_stage(model, number), self._bars, water)

    def solution(
        self, number: int, before: StageResult | None, progress: StageProgress | None
    ) -> Callable[[], StageResult]:
        """Return what solves a stage; its blocks are removed and placed and its loads added, unless it is under way."""
        run, state = self._run, self._state
        stage = run.model.stages[number - 1] if number else None
        if stage is not None and before is not None and progress is None:
            now = self._here[number].copy()
            now[state.fallen] = False
            _begin(run.model, run.scheme, state, stage, now, before.contacts)
            state.flow = None if run.flow is None else run.flow.begin(number, now, state.flow)
            state.model = model_in_stage(run.model, number)
            run.scheme.install(number)
        name, parts = (INITIAL, (1.0,)) if stage is None else (stage.name, stage.relaxation)
        found = StageSolution(run, state, name, number, () if number else self._notes, progress)
        return partial(found.result, parts)

    def end(self, number: int) -> None:
        """End a stage: displacements count from the in-situ state."""
        if number == 0 and self._run.model.in_situ is not None:
            self._state.origin = self._run.scheme.moved.copy()

    def checkpoint(self, finished: int) -> Checkpoint:
        """Return the checkpoint after so many finished stages."""
        return self._state.checkpoint(finished, self._run.scheme)


def _begin(
    model: Model, scheme: Scheme, state: StageState, stage: Stage, now: BoolArray, contacts: ContactForces
) -> None:
    """Remove and place the blocks of a stage, and add its loads."""
    stays, leaves = state.present & now, state.present & ~now
    state.relaxation.add(forces_on_new_faces(scheme, contacts, stays, leaves))
    scheme.remove_and_place_blocks(stays, now & ~state.present)
    if stage.pressure:
        state.forces.append(pressure_on_new_faces(model.blocks, stays, leaves, stage.pressure))
    state.forces.append(point_forces_of(model.worked_out(stage.loads), model.blocks))
    state.water = state.water if stage.water is None else stage.water
    state.origin[~stays] = scheme.moved[~stays]
    state.bar_forces[~stays[state.bars.block]] = 0.0
    state.present = now
