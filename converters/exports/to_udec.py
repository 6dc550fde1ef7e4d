"""UDEC: a data file of commands. Blocks are the outline cut by cracks, joints by material numbers.

Written after the manual of UDEC 5 (Itasca 2011); UDEC itself was not there to run it.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
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
)
from bsm_mesh.files import write_text
from bsm_mesh.model.edges import LongArray
from bsm_mesh.model.model import Model

ROUNDING = 0.01  # of the shortest edge: radius of rounded corners, which UDEC wants
OFF = 0.5  # degrees: contacts of a face are within it of the face's angle


def write(model: Model, path: Path) -> tuple[str, ...]:
    """Write a model; return omissions."""
    blocks = model.blocks
    jointed = JointedFaces.of(model)
    shortest = float(np.hypot(*blocks.edge_vectors.T).min())
    lines = [f"; {heading(model)}, for UDEC", "new"]
    lines += [f"round {ROUNDING * shortest:.6g}", f"edge {2 * ROUNDING * shortest:.6g}"]
    for first, last in zip(blocks.offsets[:-1], blocks.offsets[1:], strict=True):
        lines.append("block " + " ".join(f"{x:.9g},{y:.9g}" for x, y in blocks.vertices[first:last]))
    remarks = left_out(model, ("earthquake",))
    lines += [";", "; materials of blocks, then of joints", *_materials(model)]
    lines += _joints(model, jointed, remarks)
    horizontal, vertical = model.gravity_horizontal, model.gravity_vertical
    lines += [f"gravity {GRAVITY * horizontal:.9g} {-GRAVITY * (1 - vertical):.9g}"]
    held, of_supports = fixed_blocks(model)
    inside, reach = _inner_points(model), 1e-3 * np.sqrt(blocks.moments.area)
    lines += [f"fix {_near(inside[block], reach[block])}" for block in held] + _loads(model)
    remarks += of_supports
    lines += ["damp auto", "solve ratio 1e-6", "save solved.sav"]
    write_text(path, "\n".join(lines) + "\n")
    return tuple(remarks)


def _near(point: FloatArray, reach: float) -> str:
    x, y = point
    return f"range {x - reach:.9g},{x + reach:.9g} {y - reach:.9g},{y + reach:.9g}"


def _materials(model: Model) -> list[str]:
    lines = []
    for number, name in enumerate(model.blocks.rock_names, start=1):
        (weight,) = {rock.unit_weight for rock in model.rocks if rock.name == name}
        lines.append(f"prop mat={number} dens={weight / GRAVITY:.9g} ; rock {quoted(name)}")
    inside = _inner_points(model)
    reach = 1e-3 * np.sqrt(model.blocks.moments.area)
    for block in np.flatnonzero(model.blocks.rock > 0):
        lines.append(f"change mat={model.blocks.rock[block] + 1} {_near(inside[block], reach[block])}")
    return lines


def _inner_points(model: Model) -> FloatArray:
    import shapely

    rings = shapely.linearrings(model.blocks.vertices, indices=model.blocks.owner)
    inside: FloatArray = shapely.get_coordinates(shapely.point_on_surface(shapely.polygons(rings)))
    return inside


def _joints(model: Model, jointed: JointedFaces, remarks: list[str]) -> list[str]:
    lines = [f"prop jmat=1 jkn={STIFF:g} jks={STIFF:g} jfric=45 jcoh=1e20 jten=1e20 ; faces of rock without a joint"]
    for number, joint in enumerate(model.joints, start=2):
        friction, cohesion = friction_and_cohesion(joint)
        normal, shear = joint.contact_stiffness
        strength = "jfric=45 jcoh=1e20 jten=1e20" if friction is None else f"jfric={friction:g} jcoh={cohesion:g}"
        tension = "" if friction is None else f" jten={joint.tensile_strength:g}"
        lines.append(
            f"prop jmat={number} jkn={normal:g} jks={shear:g} {strength}{tension} ; joint {quoted(joint.name)}"
        )
    lines.append("change jmat=1 jcons=2")
    start, end = jointed.faces.start, jointed.faces.end
    length = np.hypot(*(end - start).T)
    told = np.argsort(-length, kind="stable")  # the last command holds: a box of a long face may have short ones in it
    told = told[jointed.joint[told] >= 0]
    lines += [f"change jmat={jointed.joint[face] + 2} range {box}" for face, box in _boxes(told, start, end)]
    angles = np.degrees(np.arctan2(*(end - start).T[::-1])) % 180
    met, alike = _where_joints_meet(told, start, end, jointed.joint, angles)
    if met.size:
        lines.append("; where different joints meet, contacts are distinguished by their angle from the x axis")
    for face, box in _boxes(met, start, end):
        for turn in (-180, 0, 180):  # whichever half circle the program counts in
            low, high = angles[face] + turn - OFF, angles[face] + turn + OFF
            lines.append(f"change jmat={jointed.joint[face] + 2} range {box} angle {low:.9g},{high:.9g}")
    if met.size:
        remarks.append(
            "where different joints meet: a contact of two corners there takes the joint of the shorter face"
        )
    if alike:
        remarks.append(f"{alike} places where joints in line meet: contacts there take the joint of the shorter face")
    return lines


def _boxes(faces: LongArray, start: FloatArray, end: FloatArray) -> Iterator[tuple[int, str]]:
    """Give faces with the box around each, in the commands' form."""
    length = np.hypot(*(end - start).T)
    for face in faces:
        reach, ends = 1e-3 * length[face], (start[face], end[face])
        low, high = np.minimum(*ends) - reach, np.maximum(*ends) + reach
        yield int(face), f"{low[0]:.9g},{high[0]:.9g} {low[1]:.9g},{high[1]:.9g}"


def _where_joints_meet(
    faces: LongArray, start: FloatArray, end: FloatArray, joint: IntArray, angles: FloatArray
) -> tuple[LongArray, int]:
    """Return the faces whose box holds an end of a face of another joint, and how many of these lie in line."""
    import shapely

    length = np.hypot(*(end - start).T)[faces, None]
    low, high = np.minimum(start, end)[faces] - 1e-3 * length, np.maximum(start, end)[faces] + 1e-3 * length
    ends = shapely.points(np.concatenate([start[faces], end[faces]]))
    one, other = shapely.STRtree(ends).query(shapely.box(*low.T, *high.T), predicate="intersects")
    one, other = faces[one], np.tile(faces, 2)[other]
    differ = joint[one] != joint[other]
    one, other = one[differ], other[differ]
    turn = (angles[one] - angles[other] + 90) % 180 - 90
    return faces[np.isin(faces, one)], int((np.abs(turn) <= 2 * OFF).sum()) // 2


def _loads(model: Model) -> list[str]:
    inside, reach = _inner_points(model), 1e-3 * np.sqrt(model.blocks.moments.area)
    forces = forces_on_blocks(model)
    return [
        f"load {_near(inside[block], reach[block])} xload={x:.9g} yload={y:.9g} ; moment {m:.6g}"
        for block, (x, y, m) in enumerate(forces)
        if x or y
    ]
