"""Construction stages: blocks are excavated and placed, the others keep their forces (Wang 4.5.2).

A scheme (`LinearScheme`, `ContinuationScheme`) keeps the state of contacts and blocks from stage to stage, in the
numbers of the whole model, and solves the blocks present as a submodel.
"""

from __future__ import annotations

from functools import partial

import numpy as np

from bsm_mesh.arrays import BoolArray
from bsm_mesh.errors import counted, named_stage
from bsm_mesh.flow.coupling import FlowCoupling
from bsm_mesh.model.falls import Falls
from bsm_mesh.model.in_stage import model_in_stage
from bsm_mesh.model.loads import point_forces_of
from bsm_mesh.model.model import Model
from bsm_mesh.model.stages import INITIAL, Stage, presence
from bsm_mesh.model.supports import Bars, bars_of
from bsm_mesh.model.water import Water
from bsm_mesh.results.records import ContactForces, StageResult
from bsm_mesh.solve.stages.checkpoint import Checkpoint, Resumption
from bsm_mesh.solve.stages.new_faces import forces_on_new_faces, pressure_on_new_faces
from bsm_mesh.solve.stages.scheme import Checker, Finished, Observer, Prover, Recording, Reporter, Scheme
from bsm_mesh.solve.stages.solution import Analysis, StageSolution, StageState

AT_THE_START = Resumption()


def solve_stages(
    model: Model,
    scheme: Scheme,
    report: Reporter,
    observer: Observer,
    check: Checker,
    prove: Prover,
    finished: Finished,
    falls: Falls,
    notes: tuple[str, ...] = (),
    resumption: Resumption = AT_THE_START,
    record: Recording = lambda stage: (),
    flow: FlowCoupling | None = None,
) -> tuple[StageResult, ...]:
    """Return the results of all stages up to the first that is not stable; ``initial``, with `notes`, is the first.

    A stage that a scheme calls stable is so only where `check` finds nothing against it. `prove` is asked about the
    start of one that is unstable. `finished` gets the stages so far at the end of each. `falls` says the
    treatment of unstable blocks. `notes` belong to the first. `resumption` says where the run continues, if it was
    interrupted, and where it ends. `record` measures the histories at every step. `flow` is that in the joints, if any.

    Raises
    ------
    ModelError
        If the start cannot be analysed.
    """
    here, begun = presence(model.stages, model.blocks), resumption.begun
    bars = bars_of(model.supports, model.blocks)
    if begun is None:
        state, notes = _first_state(model, scheme, report, bars, here[0], notes, flow)
    else:
        scheme.restore(begun.scheme)
        number = _stage_at(begun)
        state = StageState.recalled(begun, model_in_stage(model, number), bars, _water(model, number))
    run = Analysis(model, scheme, observer, check, prove, falls, resumption.keep, record, flow)
    results = list(resumption.stages)
    last = len(model.stages) if resumption.until is None else resumption.until
    for number in range(len(results), 1 + last):
        if results and not results[-1].status.is_at_rest:
            break
        stage = model.stages[number - 1] if number else None
        name, parts = (INITIAL, (1.0,)) if stage is None else (stage.name, stage.relaxation)
        progress = begun.stage if begun is not None and begun.finished == number else None
        if progress is not None:
            report(f"{named_stage(name)} continues after {counted(len(progress.steps), 'step')}")
        elif stage is not None:
            report(named_stage(name))
            now = here[number].copy()
            now[state.fallen] = False
            _begin(model, scheme, state, stage, now, results[-1].contacts)
            state.flow = None if flow is None else flow.begin(number, now, state.flow)
            state.model = model_in_stage(model, number)
            scheme.install(number)
        solution = StageSolution(run, state, name, number, () if number else notes, progress)
        results.append(solution.result(parts))
        finished(tuple(results))
        if number == 0 and model.in_situ is not None:
            state.origin = scheme.moved.copy()
        resumption.keep(partial(state.checkpoint, number + 1, scheme), True)
    return tuple(results)


def _first_state(
    model: Model,
    scheme: Scheme,
    report: Reporter,
    bars: Bars,
    present: BoolArray,
    notes: tuple[str, ...],
    flow: FlowCoupling | None,
) -> tuple[StageState, tuple[str, ...]]:
    """Return the state before the first stage, under the in-situ field where it is given directly, and the notes."""
    state = StageState(
        model=model,
        present=present,
        bars=bars,
        bar_forces=np.zeros(len(bars.block)),
        forces=[point_forces_of(model.acting_loads, model.blocks)],
        water=model.water,
        origin=np.zeros_like(scheme.moved),
        flow=None if flow is None else flow.first,
    )
    if model.in_situ is not None and model.in_situ.method == "direct":
        from bsm_mesh.contact.in_situ import in_situ_bars

        report("in-situ stress")
        notes = (*notes, *scheme.set_in_situ())
        state.bar_forces = in_situ_bars(model, bars)
    return state, notes


def _stage_at(begun: Checkpoint) -> int:
    """Return the number of the stage at a checkpoint: of that under way, or of the last finished."""
    return begun.finished if begun.stage is not None else max(0, begun.finished - 1)


def _water(model: Model, number: int) -> Water | None:
    """Return the water in a stage: that of the last one so far which changed it."""
    stages = model.stages[:number]
    return next((stage.water for stage in reversed(stages) if stage.water is not None), model.water)


def _begin(
    model: Model, scheme: Scheme, state: StageState, stage: Stage, now: BoolArray, contacts: ContactForces
) -> None:
    """Remove and place the blocks of a stage, and add its loads."""
    stays, leaves = state.present & now, state.present & ~now
    state.unreleased_forces.append((forces_on_new_faces(scheme, contacts, stays, leaves), 0.0))
    scheme.remove_and_place_blocks(stays, now & ~state.present)
    if stage.pressure:
        state.forces.append(pressure_on_new_faces(model.blocks, stays, leaves, stage.pressure))
    state.forces.append(point_forces_of(model.worked_out(stage.loads), model.blocks))
    state.water = state.water if stage.water is None else stage.water
    state.origin[~stays] = 0.0
    state.bar_forces[~stays[state.bars.block]] = 0.0
    state.present = now
