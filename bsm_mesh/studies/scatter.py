"""Scatter of a joint's strength from face to face: every face takes one of a few classes of it, by a seeded draw."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.errors import ModelError, nearest, placed
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.model.kinds import in_space
from bsm_mesh.model.materials import Joint
from bsm_mesh.model.model import Model
from bsm_mesh.model.stages import Stage
from bsm_mesh.model.water import Water

CLASSES = 9
SCATTERING = ("friction", "cohesion")


@dataclass(frozen=True, slots=True, kw_only=True)
class Scatter:
    """How a joint's friction or cohesion scatters from face to face.

    A face takes one of `classes` values, equally likely. They lie at the middle quantiles of a normal distribution
    about the joint's own value and have its deviation. The joint ``J1`` becomes ``J1~1`` (the least) to ``J1~9``. Both
    sides of a face take the same; where faces do not match from end to end each side has its own, and a contact has
    that of the edge. A residual friction moves along with the friction.

    Attributes
    ----------
    joint : str
        Its name.
    strength : {"friction", "cohesion"}
        What scatters.
    deviation : float [degrees, Pa]
        Standard deviation.
    classes : int
        Number of classes, 2 or more.
    """

    joint: str
    strength: str
    deviation: float
    classes: int = CLASSES

    @property
    def offsets(self) -> FloatArray:
        """How far the classes lie from the joint's own value, rising, (classes,)."""
        from scipy.special import ndtri

        scores = ndtri((np.arange(self.classes) + 0.5) / self.classes)
        offsets: FloatArray = self.deviation * scores / np.sqrt(np.mean(scores**2))
        return offsets


def scatter_joint(model: Model, scatter: Scatter, seed: tuple[int, ...]) -> Model:
    """Return a model in which the strength of a joint scatters from face to face.

    Parameters
    ----------
    model : Model
        With the joint's own value.
    scatter : Scatter
        Which joint, and by how much.
    seed : tuple of int
        Of the draw; the same seed and blocks draw the same.

    Raises
    ------
    ModelError
        If there is no such joint, it has no such strength, or a class of it is out of range.
    """
    if in_space(model.blocks):
        raise ModelError("[scatter]: strength from face to face is for the plane; leave [scatter] out")
    names = [joint.name for joint in model.joints]
    if scatter.joint not in names:
        raise ModelError(f"[scatter]: there is no joint '{scatter.joint}'{nearest(scatter.joint, names)}")
    joint = model.joints[names.index(scatter.joint)]
    with placed(f"[scatter] joint.{scatter.joint}.{scatter.strength}"):
        classes = [_of_class(joint, scatter.strength, k + 1, offset) for k, offset in enumerate(scatter.offsets)]
    is_default = model.default_joint == scatter.joint
    blocks = _with_classes(model.blocks, joint.name, [part.name for part in classes], is_default, seed)
    # Contacts that arise where no edge has a joint still take the default one; otherwise the joint itself is gone.
    others = tuple(other for other in model.joints if other is not joint or is_default)
    part_names = tuple(part.name for part in classes)
    return model.replace(
        blocks=blocks,
        joints=(*others, *classes),
        water=None if model.water is None else _water_in(model.water, joint.name, part_names),
        stages=tuple(_stage_in(stage, joint.name, part_names, is_kept=is_default) for stage in model.stages),
    )


def _of_class(joint: Joint, strength: str, number: int, offset: float) -> Joint:
    """Return a joint of one class."""
    value = getattr(joint.law, strength, None)
    if value is None:
        raise ModelError(f"the joint has no {strength}; give it a law with one")
    changes = {strength: float(value + offset)}
    residual = getattr(joint.law, "residual_friction", None)
    if strength == "friction" and residual is not None:
        changes["residual_friction"] = float(residual + offset)
    assert joint.law is not None
    law = replace(joint.law, **changes)  # type: ignore[type-var]  # laws with these names are dataclasses
    return replace(joint, name=f"{joint.name}~{number}", law=law)


def _with_classes(blocks: Blocks, joint: str, classes: list[str], is_default: bool, seed: tuple[int, ...]) -> Blocks:
    """Return blocks whose edges of a joint carry one of its classes, both sides of a face the same."""
    mine = blocks.edge_joint == blocks.joint_names.index(joint) if joint in blocks.joint_names else None
    if is_default:
        bare = blocks.edge_joint < 0
        mine = bare if mine is None else mine | bare
    if mine is None:
        return blocks
    table = blocks.edge_table
    _, face = np.unique(table.keys, return_inverse=True)
    drawn = np.random.default_rng(seed).integers(0, len(classes), int(face.max()) + 1)
    chosen = np.empty(len(face), dtype=np.int32)
    chosen[table.order] = drawn[face]
    names = (*blocks.joint_names, *classes)
    edge_joint: IntArray = np.where(mine, len(blocks.joint_names) + chosen, blocks.edge_joint).astype(np.int32)
    kept = [name for name in names if name != joint]
    number = np.array([kept.index(name) if name != joint else -1 for name in names], dtype=np.int32)
    return blocks.with_edge_joints(np.where(edge_joint < 0, -1, number[edge_joint]), tuple(kept))


def _water_in(water: Water, joint: str, classes: tuple[str, ...]) -> Water:
    """Return water whose pressure in the faces of a joint is that in all its classes."""
    if joint not in water.joint_pressure:
        return water
    others = {name: pressure for name, pressure in water.joint_pressure.items() if name != joint}
    return replace(water, joint_pressure={**others, **dict.fromkeys(classes, water.joint_pressure[joint])})


def _stage_in(stage: Stage, joint: str, classes: tuple[str, ...], *, is_kept: bool) -> Stage:
    """Return a stage whose water and strength of a joint are those of all its classes; of itself too if it is kept."""
    strength = dict(stage.strength)
    if joint in strength:
        part = strength[joint] if is_kept else strength.pop(joint)
        strength |= dict.fromkeys(classes, part)
    water = None if stage.water is None else _water_in(stage.water, joint, classes)
    return replace(stage, strength=strength, water=water)
