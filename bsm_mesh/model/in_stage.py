"""A model as it is in a stage: its strength, its gravity with an earthquake's part, its bolts."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from bsm_mesh.arrays import BoolArray
from bsm_mesh.errors import ModelError, as_given, nearest
from bsm_mesh.model.bolt_layout import cut_bolts
from bsm_mesh.model.bolts import Bolt
from bsm_mesh.model.model import Model
from bsm_mesh.model.stages import INITIAL
from bsm_mesh.model.strength import joints_and_rocks_at, resolved
from bsm_mesh.model.water import Water


def model_in_stage(model: Model, number: int) -> Model:
    """Return a model with the strength and the gravity of a stage; itself where no stage so far changes either.

    Blocks, loads and water are those of the start, without changes by stages. A model that is changed
    has no stages and no bolts, which belong to stages.

    Parameters
    ----------
    model : Model
        The model.
    number : int
        Of the stage; 0: before the first.
    """
    strength, gravity, trend = strength_in_stage(model, number), None, model.gravity_trend
    for stage in model.stages[:number]:
        if stage.gravity is not None:
            gravity = stage.gravity
            trend = model.gravity_trend if stage.gravity_trend is None else stage.gravity_trend
    if not strength and gravity is None:
        return model
    joints, rocks = joints_and_rocks_at(model, strength)
    horizontal, vertical = gravity or (model.gravity_horizontal, model.gravity_vertical)
    return without_stages(
        model,
        joints=joints,
        rocks=rocks,
        gravity_horizontal=horizontal,
        gravity_vertical=vertical,
        gravity_trend=trend,
    )


def without_stages(model: Model, **changes: Any) -> Model:
    """Return a model with changes, without stages and bolts, and without histories, which may be of bolts."""
    return model.replace(stages=(), bolts=(), histories=(), **changes)


def strength_in_stage(model: Model, number: int) -> dict[str, float]:
    """Return the part of its strength that joints and rocks have in a stage, by name, where a stage so far named them.

    A part is one of the strength given to the model; it stays until a later stage gives another. Rocks are
    ``rock:NAME``.
    """
    strength: dict[str, float] = {}
    for stage in model.stages[:number]:
        strength |= resolved(model, stage.strength)
    return strength


def water_in_stage(model: Model, number: int) -> Water | None:
    """Return the water in a stage: that of the last one so far which changed it."""
    stages = model.stages[:number]
    return next((stage.water for stage in reversed(stages) if stage.water is not None), model.water)


def bolts_in_stage(model: Model, number: int) -> list[Bolt]:
    """Return the bolts that a stage and those before it install, of so many stages; 0: those there from the start."""
    there = [None, *(stage.name for stage in model.stages[:number])]
    return [bolt for bolt in model.bolts if bolt.stage in there]


def present_bolts(model: Model, number: int, present: BoolArray) -> list[Bolt]:
    """Return the parts of the bolts of a stage that act on its present blocks (n,), for a model without stages."""
    installed = bolts_in_stage(model, number)
    return [replace(bolt, stage=None) for bolt in cut_bolts(installed, model.blocks, model.stages, present)]


def model_up_to(model: Model, number: int) -> Model:
    """Return a model with its first stages, so many, without the record and the bolts that later ones install."""
    stages, bolts = model.stages[:number], bolts_in_stage(model, number)
    return model.replace(stages=stages, bolts=bolts, histories=())  # which may be of bolts that are not there


def resting_stage(model: Model, stage: str | None, what: str) -> int:
    """Return the number of a stage for `what` looks at blocks at rest, as `stage_number`.

    Raises
    ------
    ModelError
        If there is none of that name, or it or one before it is shaken.
    """
    number = stage_number(model, stage)
    shaken = [each.name for each in model.stages[:number] if each.shaking is not None]
    if shaken:
        raise ModelError(
            f"{what} is of blocks at rest, and stage '{shaken[0]}' is shaken; ask about a stage before it, or give the "
            "earthquake as a part of the weights: gravity horizontal and vertical"
        )
    return number


def stage_number(model: Model, stage: str | None) -> int:
    """Return the number of a stage, 0 for ``initial``; None is the last.

    Raises
    ------
    ModelError
        If there is none of that name.
    """
    names = [INITIAL, *(each.name for each in model.stages)]
    if stage is None:
        return len(model.stages)
    if not isinstance(stage, str) or stage not in names:
        raise ModelError(f"there is no stage {as_given(stage)}{nearest(stage, names)}")
    return names.index(stage)
