"""How long shaken stages of rigid blocks will take, before the run."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from bsm_mesh.arrays import IntArray
from bsm_mesh.model.in_stage import model_in_stage, water_in_stage
from bsm_mesh.model.loads import point_forces_of
from bsm_mesh.model.model import Model
from bsm_mesh.model.options import Options
from bsm_mesh.model.quantities import MASS_SCALING
from bsm_mesh.model.stages import presence
from bsm_mesh.model.submodel import submodel_of
from bsm_mesh.model.supports import bars_of
from bsm_mesh.solve.continuation.scheme import ContinuationScheme
from bsm_mesh.solve.motion.shaken_motion import ShakenMotion
from bsm_mesh.solve.motion.time_steps import TimeSteps, estimated, shortest
from bsm_mesh.solve.stages.new_faces import concatenate


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
        blocks = scheme.blocks_before_shaking(part, number)
        estimate = estimated(stage.name, stage.shaking, blocks)
        if isinstance(blocks, ShakenMotion):
            estimate = replace(estimate, **_shortest(blocks, stage.shaking.mass_scaling, part.block))
        found.append(estimate)
    return found


def _shortest(blocks: ShakenMotion, given: float, number: IntArray) -> dict[str, Any]:
    """Return the block with the shortest time step by its number, and the effect of a usual mass scaling."""
    steps = blocks.steps_of_blocks(given)
    found = shortest(steps, number)
    assert MASS_SCALING.usual is not None
    scaling = MASS_SCALING.usual[1]
    if not found or given >= scaling:
        return found
    least = float(blocks.steps_of_blocks(scaling).min())
    heavier = int((blocks.steps_of_blocks(1.0) < least).sum())
    return found | {"scaling": scaling, "longer": least / float(steps.min()), "heavier": heavier}
