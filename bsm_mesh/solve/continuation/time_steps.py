"""How long shaken stages will take: time step, number of time steps and processor time, before the run."""

from __future__ import annotations

from dataclasses import dataclass
from time import process_time

from bsm_mesh.model.in_stage import model_in_stage, water_in_stage
from bsm_mesh.model.loads import point_forces_of
from bsm_mesh.model.model import Model
from bsm_mesh.model.options import Options
from bsm_mesh.model.shaking import Shaking
from bsm_mesh.model.stages import presence
from bsm_mesh.model.submodel import submodel_of
from bsm_mesh.model.supports import bars_of
from bsm_mesh.solve.continuation.scheme import ContinuationScheme
from bsm_mesh.solve.continuation.shaken import ShakenBlocks
from bsm_mesh.solve.motion.shaken_motion import UNDAMPED
from bsm_mesh.solve.stages.new_faces import concatenate


@dataclass(frozen=True, slots=True, kw_only=True)
class TimeSteps:
    """An estimate of the time steps of a shaken stage: the blocks are where they are given.

    Contacts that close in earlier stages, or during the shaking, make time steps shorter. The implicit integrator
    takes more where it halves them.

    Attributes
    ----------
    stage : str
        Name of the stage.
    integrator : str
        Its integrator.
    time_step : float [s]
        The longest time step.
    steps : int
        Number of time steps of the shaking.
    seconds : float [s]
        Processor time of the shaking on this machine, from a few of its time steps. Following blocks to rest is not
        in it.
    """

    stage: str
    integrator: str
    time_step: float
    steps: int
    seconds: float


def time_steps_of(model: Model, options: Options) -> list[TimeSteps]:
    """Return an estimate for every shaken stage of a model that can be analysed, by the first steps of each.

    Parameters
    ----------
    model : Model
        With the pressure of flow at the start.
    options : Options
        Of the scheme ``continuation``.
    """
    if all(stage.shaking is None for stage in model.stages):
        return []
    scheme = ContinuationScheme(model, options, lambda text: None)
    if model.in_situ is not None and model.in_situ.method == "direct":
        scheme.set_in_situ()
    there, bars = presence(model.stages, model.blocks), bars_of(model.supports, model.blocks)
    forces = [point_forces_of(model.acting_loads, model.blocks)]
    found = []
    for number, stage in enumerate(model.stages, start=1):
        before, now = there[number - 1], there[number]
        scheme.remove_and_place_blocks(before & now, now & ~before)
        scheme.install(number)
        forces.append(point_forces_of(model.worked_out(stage.loads), model.blocks))
        if stage.shaking is None:
            continue
        in_stage, water = model_in_stage(model, number), water_in_stage(model, number)
        part = submodel_of(in_stage, now, bars, concatenate(forces), water, model.face_water)
        found.append(_estimate(stage.name, stage.shaking, scheme.blocks_before_shaking(part, number)))
    return found


def _estimate(name: str, shaking: Shaking, blocks: ShakenBlocks) -> TimeSteps:
    """Return the estimate of a stage, whose blocks are followed for a few time steps."""
    intervals = round(shaking.length / shaking.interval)
    each = blocks.steps_to(shaking.interval)
    time_step = shaking.interval / each
    sample = min(each, UNDAMPED.cycles) * time_step  # a whole window at most
    blocks.go_on(sample)
    steps, began = blocks.memory.cycles, process_time()
    blocks.go_on(min(blocks.memory.time + sample, shaking.length))
    spent, taken = process_time() - began, blocks.memory.cycles - steps
    seconds = intervals * each * spent / taken if taken else 0.0
    return TimeSteps(
        stage=name, integrator=shaking.integrator, time_step=time_step, steps=intervals * each, seconds=seconds
    )
