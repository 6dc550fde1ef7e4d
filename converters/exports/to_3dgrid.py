"""3DEC: blocks as prisms of 1 m in a grid file (.3dgrid), and a data file (.dat) that imports and solves it.

Written after the manual of 3DEC 9 (Itasca, *block import command*); 3DEC itself was not there to run it. Blocks have
a group of their own in the slot ``bsm``, that identifies joints: ``group-intersection`` of two of them.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from bsm_mesh.converters.exports.parts import (
    GRAVITY,
    STIFF,
    JointedFaces,
    fixed_blocks,
    forces_on_blocks,
    friction_and_cohesion,
    heading,
    left_out,
    quoted,
    unit_weights,
)
from bsm_mesh.converters.exports.prisms import refuse_concave
from bsm_mesh.errors import ModelError
from bsm_mesh.files import write_text
from bsm_mesh.model.materials import Joint
from bsm_mesh.model.model import Model
from bsm_mesh.model.values import is_plain

UNBROKEN = "friction 45 cohesion 1e20 tension 1e20"
PAIRS = 8  # of blocks in a line
AROUND = 1e-3  # of the root of a block's area: half the box around its centroid


def write(model: Model, path: Path) -> tuple[str, ...]:
    """Write a model to ``NAME.3dgrid`` and ``NAME.dat``; return omissions.

    Raises
    ------
    ModelError
        If the file's name does not end in ``.3dgrid``, or a block is not convex.
    """
    if path.suffix != ".3dgrid":
        raise ModelError(f"{path}: a grid of 3DEC is written, and a .dat next to it; give a name that ends in .3dgrid")
    if not is_plain(path.name) or "'" in path.name:
        raise ModelError(f"{path}: 3DEC reads the grid by this name, in quotation marks; give one without any")
    refuse_concave(model)
    jointed = JointedFaces.of(model)
    pairs = np.stack([model.blocks.owner[edge] for edge in (jointed.faces.edge_a, jointed.faces.edge_b)], axis=1)
    told, remarks = _joint_of_pairs(np.sort(pairs, axis=1), jointed)
    remarks = left_out(model, ("laws", "earthquake")) + remarks
    remarks.append("blocks are prisms of 1 m that nothing holds out of the plane but their own contacts")
    if forces_on_blocks(model).any():
        remarks.append("loads: weights alone are written")
    write_text(path, "\n".join(_grid(model, told)) + "\n")
    write_text(path.with_suffix(".dat"), "\n".join(_commands(model, path.name, told, remarks)) + "\n")
    return tuple(remarks)


def _joint_of_pairs(pairs: np.ndarray, jointed: JointedFaces) -> tuple[dict[int, np.ndarray], list[str]]:
    """Return the pairs of blocks, from 0, by joint (-1 for rock without one): that of a pair's longest face."""
    order = np.lexsort([-np.hypot(*(jointed.faces.end - jointed.faces.start).T), pairs[:, 1], pairs[:, 0]])
    distinct, first, owner = np.unique(pairs[order], axis=0, return_index=True, return_inverse=True)
    joint = jointed.joint[order[first]]
    mixed = int((np.bincount(owner.reshape(-1), jointed.joint[order] != joint[owner.reshape(-1)]) > 0).sum())
    several = f"{mixed} pairs of blocks with faces of several joints: all are the longest face's"
    return {int(k): distinct[joint == k] for k in np.unique(joint)}, [several] if mixed else []


def _grid(model: Model, told: dict[int, np.ndarray]) -> list[str]:
    """Return the grid: x stays x, y becomes z, the thickness lies along y; faces clockwise as seen from outside."""
    blocks = model.blocks
    lines = [f"* {heading(model)}", "* GRIDPOINTS"]
    corners = len(blocks.vertices)
    for depth in (0, 1):
        lines += [f"G {k + depth * corners} {x:.17g} {depth}. {z:.17g}" for k, (x, z) in enumerate(blocks.vertices, 1)]
    lines.append("* FACES")
    faces: list[list[int]] = []
    number = 0
    for first, last in zip(blocks.offsets[:-1], blocks.offsets[1:], strict=True):
        front = np.arange(first, last) + 1  # at y = 0; counter-clockwise in (x, z) as seen from there, from -y
        back = front + corners
        after = np.roll(front, -1)
        own = [front[::-1], back, *np.stack([front, after, after + corners, back], axis=1)]
        lines += [f"F {number + k} " + " ".join(map(str, face)) for k, face in enumerate(own, 1)]
        faces.append(list(range(number + 1, number + len(own) + 1)))
        number += len(own)
    lines.append("* BLOCKS, BY ROCK")
    lines += [
        f"B {block} {rock + 1} F " + " ".join(map(str, own))
        for block, (rock, own) in enumerate(zip(blocks.rock, faces, strict=True), 1)
    ]
    lines.append("* JOINT SETS: " + ", ".join(f"{k} {quoted(joint.name)}" for k, joint in enumerate(model.joints, 1)))
    for joint, pairs in told.items():
        if joint >= 0:
            texts = [f"{a + 1}-{b + 1}" for a, b in pairs]
            lines += [f"JS {joint + 1} " + " ".join(texts[k : k + PAIRS]) for k in range(0, len(texts), PAIRS)]
    return lines


def _commands(model: Model, grid: str, told: dict[int, np.ndarray], remarks: list[str]) -> list[str]:
    lines = [f"; {heading(model)}, for 3DEC"]
    lines += ["model new", "model large-strain on", f"block import '{grid}'"]
    centre, half = model.blocks.moments.centroid, AROUND * np.sqrt(model.blocks.moments.area)
    for block, ((x, z), r) in enumerate(zip(centre, half, strict=True), 1):
        box = f"pos-x {x - r:.9g} {x + r:.9g} pos-z {z - r:.9g} {z + r:.9g}"
        lines.append(f"block group 'b{block}' slot 'bsm' range {box}")
    weights = unit_weights(model)
    common = np.unique(weights)[0]
    lines.append(f"block property density {common / GRAVITY:.9g}")
    lines += [
        f"block property density {weights[block] / GRAVITY:.9g} range group 'bsm=b{block + 1}'"
        for block in np.flatnonzero(weights != common)
    ]
    unjointed = f"stiffness-normal {STIFF:g} stiffness-shear {STIFF:g} {UNBROKEN}"
    lines += ["block contact generate-subcontacts", "block contact jmodel assign mohr"]
    lines.append(f"block contact property {unjointed}")
    contacts = {k: _properties(joint) for k, joint in enumerate(model.joints)}
    later = [contacts[joint] for joint in sorted(told) if joint >= 0] or [unjointed]
    for joint, pairs in told.items():
        if joint >= 0:
            lines.append(f"; joint {quoted(model.joints[joint].name)}")
            ranges = (f"range group-intersection 'bsm=b{a + 1}' 'bsm=b{b + 1}'" for a, b in pairs)
            lines += [f"block contact property {contacts[joint]} {where}" for where in ranges]
    lines.append(f"block contact material-table default property {later[0]}")
    if len(set(later)) > 1:
        first = model.joints[min(joint for joint in told if joint >= 0)].name
        remarks.append(f"contacts that come about in motion: all are of joint '{first}'")
    horizontal, vertical = model.gravity_horizontal, model.gravity_vertical
    lines.append(f"model gravity {GRAVITY * horizontal:.9g} 0 {-GRAVITY * (1 - vertical):.9g}")
    held, of_supports = fixed_blocks(model)
    lines += [f"block fix range group 'bsm=b{block + 1}'" for block in held]
    remarks += of_supports
    return [*lines, "block mech damp local 0.8", "model solve ratio-local 1e-6", "model save 'solved'"]


def _properties(joint: Joint) -> str:
    friction, cohesion = friction_and_cohesion(joint)
    normal, shear = joint.contact_stiffness
    strength = f"friction {friction:g} cohesion {cohesion:g} tension {joint.tensile_strength:g}"
    return f"stiffness-normal {normal:g} stiffness-shear {shear:g} {UNBROKEN if friction is None else strength}"
