"""Allowed but unusual input of a model of polyhedra, a sentence each."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.errors import nearest, place
from bsm_mesh.model.bolt_voids import of_bolts_across_voids
from bsm_mesh.model.excavated_water import of_water_on_excavations
from bsm_mesh.model.faint_strength import of_faint_strength
from bsm_mesh.model.kinds import in_space
from bsm_mesh.model.notes import (
    of_idle_apertures,
    of_idle_options,
    of_idle_rocks,
    of_size,
    of_stages,
    of_strength,
    of_unlimited,
    of_unusual,
    of_weights,
    of_what_is_held,
)
from bsm_mesh.model.open_water import of_sloping_open_water
from bsm_mesh.model.overburden import LEAST, of_blocks_above, of_field_and_weights
from bsm_mesh.model.signs import of_signs
from bsm_mesh.model.supports import bars_of
from bsm_mesh.model.unused import of_single_bolts, used_rocks
from bsm_mesh.three_d.blocks.polygons import vector_areas

if TYPE_CHECKING:
    from bsm_mesh.model.materials import Joint
    from bsm_mesh.model.model import Model
    from bsm_mesh.three_d.blocks.polyhedra import Polyhedra


def notes_in_space(model: Model) -> list[str]:
    """Return notes on a model of polyhedra that limit the trust in its verdict, a sentence each."""
    assert in_space(model.blocks)
    rocks, joints = used_rocks(model), _used_joints(model)
    found = [
        *of_size(model),
        *of_what_is_held(model),
        *_unused("rock", "block", [rock.name for rock in model.rocks], [rock.name for rock in rocks]),
        *_unused("joint", "face", [joint.name for joint in model.joints], [joint.name for joint in joints]),
        *_of_ends_in_blocks(model.blocks),
        *of_weights(rocks),
        *of_strength(rocks, joints),
        *of_idle_rocks(model, rocks),
        *of_idle_apertures(model, joints),
        *of_unlimited(model, rocks, joints),
        *of_single_bolts(model),
        *of_bolts_across_voids(model),
        *of_unusual(model, rocks, joints),
        *of_faint_strength(model, rocks, joints),
        *_of_water(model),
        *of_water_on_excavations(model),
        *of_sloping_open_water(model, _ground),
        *of_blocks_above(model),
        *_of_overburden(model),
        *of_field_and_weights(model),
        *of_signs(model),
        *of_stages(model),
        *of_idle_options(model.options),
    ]
    return list(dict.fromkeys(found))


def _used_joints(model: Model) -> list[Joint]:
    assert in_space(model.blocks)
    names = joints_between(model.blocks) | {model.default_joint}
    return [joint for joint in model.joints if joint.name in names]


def unused_joints(model: Model) -> set[str]:
    """Return the joints of a model, and those of its faces, in which no two blocks touch."""
    assert in_space(model.blocks)
    named = {joint.name for joint in model.joints} | set(model.blocks.joint_names)
    return named - joints_between(model.blocks) - {str(model.default_joint)}


def joints_between(blocks: Polyhedra) -> set[str]:
    """Return the names of the joints of faces in which two blocks touch."""
    numbers = np.unique(blocks.contact_polygons.joint)
    return {blocks.joint_names[k] for k in numbers[numbers >= 0]}


def _of_ends_in_blocks(blocks: Polyhedra) -> Iterator[str]:
    """Say which part of a joint has the same block on both sides."""
    inside = blocks.face_blocks[:, 0] == blocks.face_blocks[:, 1]
    for k, name in enumerate(blocks.joint_names):
        mine = np.flatnonzero((blocks.face_joint == k) & (blocks.face_blocks[:, 1] >= 0))
        ends = mine[inside[mine]]
        if ends.size:
            area = blocks.areas[ends].sum()
            where = place(blocks.polygon(int(ends[0])).mean(axis=0))
            yield (
                f"{area:.4g} m2 of the {blocks.areas[mine].sum():.4g} m2 of joint '{name}' end in the rock with the "
                f"same block on both sides and bound none (near {where})"
            )


def _unused(kind: str, part: str, defined: list[str], used: list[str]) -> Iterator[str]:
    for name in defined:
        if name not in used:
            yield f"{kind} '{name}' is used by no {part}{nearest(name, used)}"


def _of_water(model: Model) -> Iterator[str]:
    """Say which planes of head lie above the model by more than its height, or below all of it."""
    vertices = model.blocks.vertices
    low, high = float(vertices[:, 2].min()), float(vertices[:, 2].max())
    waters = (("water", model.water), *((f"stage '{stage.name}': water", stage.water) for stage in model.stages))
    for where, water in waters:
        if water is None or water.plane is None:
            continue
        depth = (water.plane.point - vertices) @ water.plane.up
        if depth.min() > high - low:
            yield f"{where}: the plane lies {depth.min():.6g} m above the top of the model (z = {high:.6g} m)"
        if depth.max() < 0:
            yield f"{where}: the plane lies below all blocks (the lowest point of the model is at z = {low:.6g} m)"


def _ground(blocks: Polyhedra) -> FloatArray:
    """Return the middles of outer faces that look upwards, (k, 3) [m]."""
    corners, offsets, outer = blocks.vertices[blocks.face_vertices], blocks.face_offsets, blocks.outer_faces
    middle = np.add.reduceat(corners, offsets[:-1]) / np.diff(offsets)[:, None]
    up = vector_areas(corners, offsets)[:, 2] > 0
    found: FloatArray = middle[outer[up[outer]]]
    return found


def _of_overburden(model: Model) -> Iterator[str]:
    """Say how much ground of the in-situ field lies over a top that nothing loads or holds."""
    field, bars = model.in_situ, bars_of(model.supports, model.blocks)
    if field is None or field.surface is None:
        return
    held, blocks = np.flatnonzero(bars.held_blocks(model.blocks)), model.blocks
    assert in_space(blocks)
    surface, high = float(field.level(np.zeros(1))[0]), float(blocks.vertices[:, 2].max())
    near = LEAST * (high - float(blocks.vertices[:, 2].min()))
    lowest = np.minimum.reduceat(blocks.vertices[blocks.face_vertices, 2], blocks.face_offsets[:-1])
    top = blocks.outer_faces[lowest[blocks.outer_faces] > high - near]
    given = {getattr(part, "boundary", None) for part in (*model.supports, *model.loads)}
    names = [name for name in blocks.boundaries if name in given]
    taken = np.concatenate([top[:0], *(blocks.boundary_faces(name) for name in names)])
    bare = ~np.isin(top, taken) & ~np.isin(blocks.face_blocks[top, 0], held)
    if bare.any() and surface - high > near:
        weight = float(model.unit_weights.max()) * (surface - high)
        bounds = [name for name, own in blocks.boundaries.items() if np.isin(top[bare], own).any()]
        yield (
            f"in_situ: the surface lies {surface - high:.4g} m above the top of the model, and nothing loads that top. "
            "The stress has the weight of this ground, the model has not. Give "
            f'[[load]] boundary = "{bounds[0] if bounds else "top"}", pressure = {weight:.4g}, or lower the surface'
        )
