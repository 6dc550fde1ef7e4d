"""A model as it is in its last stage, without the stages before, for limit analysis."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray
from bsm_mesh.errors import ModelError
from bsm_mesh.model.bolt_layout import cut_bolts
from bsm_mesh.model.falls import Falls
from bsm_mesh.model.in_stage import model_in_stage, model_up_to, present_bolts, resting_stage
from bsm_mesh.model.loads import point_forces_of
from bsm_mesh.model.model import Model
from bsm_mesh.model.stages import INITIAL, presence
from bsm_mesh.model.submodel import SubModel, submodel_of
from bsm_mesh.model.supports import bars_of
from bsm_mesh.solve.stages.new_faces import concatenate, pressure_on_new_faces


def as_built(model: Model) -> SubModel:
    """Return the blocks that are there in the last stage, where they were given, under its loads, water and bolts.

    Raises
    ------
    ModelError
        If statics alone cannot determine what acts there: part of the excavation forces is held, water flows.
    """
    if model.stages and model.stages[-1].relaxation[-1] < 1:
        raise ModelError(
            f"stage '{model.stages[-1].name}' holds part of the excavation forces, which statics cannot determine; "
            "ask about another stage"
        )
    if model.flow is not None:
        raise ModelError(
            "water flows in the joints, whose apertures and pressures statics cannot determine; give [water] for "
            "[flow], or run the model"
        )
    here = presence(model.stages, model.blocks)
    forces = [point_forces_of(model.acting_loads, model.blocks)]
    water = model.water
    for number, stage in enumerate(model.stages):
        stays, leaves = here[number] & here[number + 1], here[number] & ~here[number + 1]
        if stage.pressure:
            forces.append(pressure_on_new_faces(model.blocks, stays, leaves, stage.pressure))
        forces.append(point_forces_of(model.worked_out(stage.loads), model.blocks))
        water = water if stage.water is None else stage.water
    changed = model_in_stage(model, len(model.stages))
    part = submodel_of(changed, here[-1], bars_of(model.supports, model.blocks), concatenate(forces), water)
    return replace(part, model=part.model.replace(bolts=present_bolts(model, len(model.stages), here[-1])))


def in_stage(model: Model, stage: str | None) -> tuple[str, SubModel]:
    """Return the name of a stage, the last by default, and a model's blocks as built there.

    Raises
    ------
    ModelError
        If there is no such stage, or statics cannot determine what acts there.
    """
    number = resting_stage(model, stage, "limit analysis")
    model = model_up_to(model, number)
    return ([INITIAL, *(each.name for each in model.stages)][number], as_built(model))


def counted_blocks(model: Model, falls: Falls) -> BoolArray:
    """Return the blocks whose movement counts, (n,): supports do not hold them fast, and they are not too small."""
    return _free(model) & ~small_blocks(model, falls)


def small_blocks(model: Model, falls: Falls, pieces: FloatArray | None = None) -> BoolArray:
    """Return the blocks that are too small to count, (n,); the mean is that of blocks that supports do not hold fast.

    `pieces` as of `Falls.small`.
    """
    return falls.small(model.blocks, _free(model), pieces)


def _free(model: Model) -> BoolArray:
    return ~bars_of(model.supports, model.blocks).held_blocks(model.blocks)


def part_of(part: SubModel, stays: BoolArray) -> SubModel:
    """Return a part without some of its blocks, (k,) of which stay."""
    model = part.model
    forces = point_forces_of(model.acting_loads, model.blocks)
    inner = submodel_of(model, stays, bars_of(model.supports, model.blocks), forces, model.water, model.face_water)
    bolts = cut_bolts(model.bolts, model.blocks, (), stays)
    present = np.zeros(len(part.present), dtype=bool)
    present[part.block[stays]] = True
    return SubModel(
        model=inner.model.replace(bolts=bolts),
        present=present,
        block=part.block[inner.block],
        corner=part.corner[inner.corner],
        bar=part.bar[inner.bar],
    )
