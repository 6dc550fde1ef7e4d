"""Blocks with zones through the stages of a model, with the results that all schemes have."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np

from bsm_mesh.errors import ModelError, named_stage, raise_faults
from bsm_mesh.model.model import Model
from bsm_mesh.model.notes import notes_of
from bsm_mesh.model.options import Options
from bsm_mesh.model.start import start_faults
from bsm_mesh.model.zones import large_zones, zone_order
from bsm_mesh.results.falls import Fall
from bsm_mesh.results.records import StageResult, StepRecord
from bsm_mesh.solve.motion.time_steps import TimeSteps, estimated, shortest
from bsm_mesh.solve.stages.checkpoint import Checkpoint, StageProgress
from bsm_mesh.solve.stages.crushing import notes_on_crushing
from bsm_mesh.solve.stages.falls import after_falls, falls_of, notes_on_movement, within_limit
from bsm_mesh.solve.stages.scheme import Reporter, Watchers
from bsm_mesh.solve.stages.shaken import notes_on_shaking
from bsm_mesh.solve.stages.solution import confirmed
from bsm_mesh.solve.zones.collapse import notes_on_rest, with_proof
from bsm_mesh.solve.zones.elasticity import nominal_constants
from bsm_mesh.solve.zones.mesh import Discretization
from bsm_mesh.solve.zones.shaken_stage import as_given
from bsm_mesh.solve.zones.shaken_zones import ShakenZones
from bsm_mesh.solve.zones.shaking_run import shaken_step
from bsm_mesh.solve.zones.stage_result import Before, stage_result
from bsm_mesh.solve.zones.stage_run import StageRun
from bsm_mesh.solve.zones.stage_solution import StageEnd
from bsm_mesh.solve.zones.stages import Continuum
from bsm_mesh.solve.zones.zone_mesh import zone_mesh
from bsm_mesh.solve.zones.zones_state import ZonesMemory

SOLVER = "superlu"


def zoned(model: Model, options: Options) -> Continuum:
    """Return a model with zones that can be analysed.

    Raises
    ------
    ModelError
        With everything that forbids it, as `bsm_mesh.run` says.
    """
    faults = start_faults(model)
    if options.scheme != "continuation":
        faults.append(
            f"scheme = '{options.scheme}' is of rigid blocks; take 'continuation' with zones, or leave zones out"
        )
    if options.linear_solver not in ("auto", SOLVER):
        faults.append(f"linear_solver = '{options.linear_solver}' does not solve zones; take 'auto' or '{SOLVER}'")
    raise_faults(faults)
    breaks = any(rock.has_strength for rock in model.rocks)
    elements = Discretization(order=zone_order(model), joints=True, rock_breaks=breaks, large=large_zones(model))
    return Continuum(model, elements, mesh=zone_mesh(model))


def zone_time_steps(model: Model, options: Options) -> list[TimeSteps]:
    """Return an estimate for every shaken stage of a model with zones, by the first steps of each."""
    found = []
    for number, stage in enumerate(model.stages, start=1):
        if stage.shaking is not None:
            of = zoned(model, options)
            run = StageRun(of, nominal_constants(model).stiffness[of.mesh.block])
            blocks = as_given(run, number, stage.shaking)
            least = shortest(blocks.steps_of_blocks(), np.arange(model.blocks.count))
            found.append(replace(estimated(stage.name, stage.shaking, blocks), **least))
    return found


class ZoneStages:
    """The stages of a model with zones.

    Parameters
    ----------
    model : Model
        Some of its rocks have zones.
    options : Options
        Tolerance, limit of displacement, and what falls.
    watchers : Watchers
        Get the step of every stage, check and measure it.
    report : callable
        Gets the progress of long motion, in words.

    Attributes
    ----------
    name : str
        Of the scheme.
    linear_solver : str
        Name of the solver used.

    Raises
    ------
    ModelError
        If the model cannot be analysed.
    """

    linear_solver = SOLVER

    def __init__(
        self, model: Model, options: Options, watchers: Watchers, report: Reporter = lambda text: None
    ) -> None:
        self._model, self._options, self._watchers = model, options, watchers
        self._began = time.perf_counter()
        self.name = "large zones" if large_zones(model) else "zones"
        self._continuum = zoned(model, options)
        stiffness = nominal_constants(model).stiffness[self._continuum.mesh.block]
        self._run = StageRun(self._continuum, stiffness, options.displacement_limit)
        self._run.report = report

    def start(self) -> None:
        """Begin at the start."""

    def recall(self, begun: Checkpoint) -> None:
        """Begin at a checkpoint."""
        memory = begun.scheme
        assert isinstance(memory, ZonesMemory)
        self._run.recall(memory, begun.last_stage)

    def solution(
        self, number: int, before: StageResult | None, progress: StageProgress | None
    ) -> Callable[[], StageResult]:
        """Return what solves a stage after the one before; none is ever under way at a checkpoint."""
        return partial(self._solved, number, before)

    def _solved(self, number: int, before: StageResult | None) -> StageResult:
        of, model, watchers = self._continuum, self._model, self._watchers
        start = Before.of(before, of.presence[0], time.perf_counter() - self._began)
        steps: list[StepRecord] = []

        def watch(motion: ShakenZones, *, now: Callable[[], StageEnd]) -> None:
            def as_it_stands() -> StageResult:
                return stage_result(of, now(), start, number, self._options)

            step = shaken_step(of, motion, number, len(steps), time.perf_counter() - self._began)
            steps.append(replace(step, recorded=watchers.record(as_it_stands)))
            watchers.observer(steps[-1], as_it_stands)
            self._began = time.perf_counter()

        try:
            end = self._run.end_of(number, watch=watch)
        except ModelError as error:
            if number == 0:
                raise
            name = named_stage(model.stages[number - 1].name)
            raise ModelError([f"{name}: {text}" for text in error.faults]) from error
        start = replace(start, seconds=time.perf_counter() - self._began)
        stage = self._with_falls(number, end, start)
        if number == 0:
            stage = replace(stage, notes=(*notes_of(model), *stage.notes))
        last = replace(stage.steps[0], step=len(steps), recorded=watchers.record(lambda: stage))
        stage = replace(stage, steps=(*steps, last))
        watchers.observer(last, lambda: stage)
        return stage

    def _with_falls(self, number: int, end: StageEnd, start: Before) -> StageResult:
        """Return the result of a stage after the blocks that fall and are taken away in it."""
        model, fallen = self._model, list[Fall]()
        while True:
            stage = self._ended(number, end, start)
            down = stage.unstable_blocks
            small = np.isin(down, stage.small_blocks)
            if end.collapse is not None or stage.shaking is not None or not self._options.falls.takes_away(small):
                return after_falls(stage, tuple(fallen), model.blocks.bulk_unit)
            fallen.extend(falls_of(model, down, small, stage, stage.origin + stage.displacement))
            end = self._run.without(down)

    def _ended(self, number: int, end: StageEnd, start: Before) -> StageResult:
        """Return the result of a stage at its end, with proofs and notes."""
        of, model, watchers = self._continuum, self._model, self._watchers
        stage = stage_result(of, end, start, number, self._options)
        stage = within_limit(stage, self._options.displacement_limit)
        stage = confirmed(with_proof(of, end, stage, number, watchers.prove), watchers.check)
        found = [*notes_on_shaking(model, stage), *notes_on_crushing(model, stage)]
        if end.large is not None:
            found += [*notes_on_movement(model.blocks, stage), *notes_on_rest(of, end, stage, number, watchers.prove)]
        return replace(stage, notes=(*stage.notes, *found))

    def end(self, number: int) -> None:
        """End a stage."""
        self._began = time.perf_counter()

    def checkpoint(self, finished: int) -> Checkpoint:
        """Return the checkpoint after so many finished stages."""
        present = self._continuum.presence[finished - 1] & ~self._run.state.fallen
        return Checkpoint(finished=finished, scheme=self._run.memory, present=present)
