"""Construction stages: blocks are excavated and placed, the others keep their forces (Wang 4.5.2).

A scheme (`LinearScheme`, `ContinuationScheme`) keeps the state of contacts and blocks from stage to stage, in the
numbers of the whole model, and solves the blocks present as a submodel.
"""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import BoolArray
from bsm_mesh.model.loads import point_forces_of
from bsm_mesh.model.model import Model
from bsm_mesh.model.stages import Stage, presence
from bsm_mesh.model.supports import bars_of
from bsm_mesh.results.records import ContactForces, StageResult
from bsm_mesh.solve.stages.falls import Falls
from bsm_mesh.solve.stages.new_faces import forces_on_new_faces, pressure_on_new_faces
from bsm_mesh.solve.stages.scheme import Checker, Finished, Observer, Prover, Reporter, Scheme
from bsm_mesh.solve.stages.solution import Analysis, StageSolution, StageState


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
) -> tuple[StageResult, ...]:
    """Return the results of all stages up to the first that is not stable; ``initial``, with `notes`, is the first.

    A stage that a scheme calls stable is so only where `check` finds nothing against it. `prove` is asked about the
    start of one that is unstable. `finished` gets the stages so far at the end of each. `falls` says what is done with
    blocks that come down. `notes` belong to the first.

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
    run = Analysis(model=model, scheme=scheme, observer=observer, check=check, prove=prove, falls=falls)
    results = [StageSolution(run, state, "initial", 0, notes).result((1.0,))]
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
        results.append(StageSolution(run, state, stage.name, number).result(stage.relaxation))
        finished(tuple(results))
    return tuple(results)


def _begin(
    model: Model, scheme: Scheme, state: StageState, stage: Stage, now: BoolArray, contacts: ContactForces
) -> None:
    """Remove and place the blocks of a stage, and add its loads."""
    stays, leaves = state.present & now, state.present & ~now
    state.unreleased_forces.append((forces_on_new_faces(scheme, contacts, stays, leaves), 0.0))
    scheme.remove_and_place_blocks(stays, now & ~state.present)
    if stage.pressure:
        state.forces.append(pressure_on_new_faces(model, stays, leaves, stage.pressure))
    state.forces.append(point_forces_of(model.worked_out(stage.loads), model.blocks))
    state.water = state.water if stage.water is None else stage.water
    state.origin[~stays] = 0.0
    state.bar_forces[~stays[state.bars.block]] = 0.0
    state.present = now
