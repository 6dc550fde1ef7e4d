"""Blocks as prisms of 1 m for programs in space: x stays x, y becomes z, the thickness lies along y."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from bsm_mesh.converters.exports.parts import (
    GRAVITY,
    fixed_blocks,
    forces_on_blocks,
    friction_and_cohesion,
    left_out,
    unit_weights,
)
from bsm_mesh.errors import ModelError, numbered
from bsm_mesh.files import write_text
from bsm_mesh.model.model import Model

OF_THEIR_PACKAGES = ("compas", "compas_dem", "compas_cra", "compas_lmgc90")
UNLIMITED = 10.0  # coefficient of friction where a model gives none: no slip short of 84 degrees


def write_script(model: Model, path: Path, script: str, *, loads: bool = True) -> tuple[str, ...]:
    """Write a Python script with the model's blocks in it, in place of ``DATA_OF_THE_MODEL``; return omissions.

    Raises
    ------
    ModelError
        If the file's name does not end in ``.py``, or a block is not convex.
    """
    if path.suffix != ".py":
        raise ModelError(f"{path}: a Python script is written; give a name that ends in .py")
    if path.stem in OF_THEIR_PACKAGES:
        raise ModelError(f"{path}: a script of that name would replace the package of that name; give another one")
    refuse_concave(model)
    remarks = left_out(model, ("laws",))
    blocks = model.blocks
    held, of_supports = fixed_blocks(model)
    remarks += of_supports
    data = {
        "title": model.title,
        "blocks": [blocks.vertices[a:b].tolist() for a, b in zip(blocks.offsets[:-1], blocks.offsets[1:], strict=True)],
        "density": (unit_weights(model) / GRAVITY).tolist(),
        "fixed": held.tolist(),
        "loads": {str(b): row.tolist() for b, row in enumerate(forces_on_blocks(model)) if row.any()},
        "friction": _friction(model, remarks),
    }
    text = json.dumps(data, indent=None)
    write_text(path, script.replace("DATA_OF_THE_MODEL", text))
    if not loads and data["loads"]:
        remarks.append("loads: the solvers RBE and CRA take weights alone")
    return tuple(remarks)


def _friction(model: Model, remarks: list[str]) -> float:
    """Return the one coefficient of friction that these programs take: the lowest."""
    found: dict[str, float] = {}
    for joint in model.joints:
        friction, cohesion = friction_and_cohesion(joint)
        found[joint.name] = UNLIMITED if friction is None else float(np.tan(np.radians(friction)))
        if cohesion or joint.tensile_strength:
            remarks.append(f"joint '{joint.name}': cohesion and tensile strength")
    if not found:
        remarks.append("faces of rock without a joint: they are contacts that carry any shear and no tension")
        return UNLIMITED
    lowest = min(found, key=lambda name: found[name])
    if len(set(found.values())) > 1:
        remarks.append(f"one coefficient of friction for all contacts: that of joint '{lowest}', the lowest")
    remarks.append("stiffness of joints: contacts are rigid")
    return found[lowest]


def refuse_concave(model: Model) -> None:
    """Raise `ModelError` where blocks are not convex."""
    blocks = model.blocks
    along, following = blocks.edge_vectors, blocks.following
    turn = along[:, 0] * along[following, 1] - along[:, 1] * along[following, 0]
    size = np.sqrt(blocks.moments.area)[blocks.owner]
    concave = np.unique(blocks.owner[turn < -1e-9 * size**2])
    if concave.size:
        raise ModelError(
            f'{numbered("block", concave)}: concave, which this program does not take; mesh finer: blocks = "elements"'
        )
