"""Parts of a model that the continuum leaves out or treats in its own way."""

from __future__ import annotations

import numpy as np

from bsm_mesh.errors import ModelError, raise_faults
from bsm_mesh.model.face_stiffness import face_joints
from bsm_mesh.model.faces import find_faces
from bsm_mesh.model.loads import PointLoad
from bsm_mesh.model.model import Model
from bsm_mesh.solve.zones.elasticity import rigid_rock_faults, rocks_in_use


def is_all_rigid(model: Model) -> bool:
    """Whether no rock in use has an elasticity of its own."""
    used = rocks_in_use(model)
    return all(rock.is_rigid for rock in model.rocks if rock.name in used)


def refuse(model: Model, joints: bool, at_rest: bool) -> None:
    """Raise for models that the continuum cannot solve, with interfaces at joints or without, or at rest only."""
    if model.flow is not None:
        raise ModelError(
            "the continuum knows no flow in joints; compare it with a model with [water] instead of [flow]"
        )
    for stage in model.stages:
        if at_rest and stage.shaking is not None:
            raise ModelError(f"the continuum is at rest, and stage '{stage.name}' is shaken; remove this stage")
    if not joints:
        raise_faults(rigid_rock_faults(model.rocks, rocks_in_use(model)))


def notes(model: Model, joints: bool, rock_breaks: bool) -> tuple[str, ...]:
    """Return the parts that the continuum leaves out of the model or treats in its own way, a sentence each."""
    found = []
    joint = face_joints(model, find_faces(model.blocks))
    count = int((joint >= 0).sum())
    if count:
        names = ", ".join(f"'{model.joints[number].name}'" for number in np.unique(joint[joint >= 0]))
        elastic = [k for k in np.unique(joint[joint >= 0]) if model.joints[k].law is None]
        what = "are taken as unbroken rock"
        if joints:
            what = "are interfaces of zero thickness" + ("; without a law they neither slip nor open" * bool(elastic))
        found.append(f"joints{'' if joints else ' are ignored'}: {count} of {len(joint)} faces ({names}) {what}")
    used = [rock for rock in model.rocks if rock.name in rocks_in_use(model)]
    if not rock_breaks and (joint < 0).any() and any(rock.has_strength for rock in used):
        found.append("rock is elastic: the strength of faces without a joint is left out")
    if any(isinstance(load, PointLoad) for load in model.loads):
        found.append("point loads are spread over their blocks, with the same force, moment and average stress")
    return tuple(found)
