"""A model as it is in a stage: the strength that is left, and the gravity with what an earthquake adds."""

from __future__ import annotations

from bsm_mesh.model.model import Model
from bsm_mesh.model.strength import joints_and_rocks_at, resolved


def model_in_stage(model: Model, number: int) -> Model:
    """Return a model with the strength and the gravity of a stage; itself where no stage so far changes either.

    Blocks, loads and water are those of the start: what stages do to them is not looked at. A model that is changed
    has no stages and no bolts, which belong to stages.

    Parameters
    ----------
    model : Model
        What is given.
    number : int
        Of the stage; 0: before the first.
    """
    strength: dict[str, float] = {}
    gravity = None
    for stage in model.stages[:number]:
        strength |= resolved(model, stage.strength)
        gravity = gravity if stage.gravity is None else stage.gravity
    if not strength and gravity is None:
        return model
    joints, rocks = joints_and_rocks_at(model, strength)
    horizontal, vertical = gravity or (model.gravity_horizontal, model.gravity_vertical)
    return model.replace(
        joints=joints, rocks=rocks, gravity_horizontal=horizontal, gravity_vertical=vertical, stages=(), bolts=()
    )
