"""Rocks, joints, water tables and bolts of a model that act on nothing: most often slips, which make wrong verdicts."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from bsm_mesh.arrays import BoolArray
from bsm_mesh.errors import counted, nearest
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.model.bolt_layout import label, pass_blocks
from bsm_mesh.model.water import Water

if TYPE_CHECKING:
    from bsm_mesh.model.materials import Joint, Rock
    from bsm_mesh.model.model import Model


def unused_in(model: Model) -> Iterator[str]:
    """Return a sentence on every rock, joint and water table that acts on nothing."""
    rocks, joints = used_rocks(model), used_joints(model)
    known_rocks, known_joints = [rock.name for rock in rocks], [joint.name for joint in joints]
    for rock in model.rocks:
        if rock not in rocks:
            yield f"rock '{rock.name}' is used by no block{nearest(rock.name, known_rocks)}"
    for joint in model.joints:
        if joint not in joints:
            yield f"joint '{joint.name}' is used by no face{nearest(joint.name, known_joints)}"
    yield from _dry_tables(model)


def used_rocks(model: Model) -> list[Rock]:
    """Return the rocks that blocks are of."""
    names = {model.blocks.rock_names[k] for k in np.unique(model.blocks.rock)}
    return [rock for rock in model.rocks if rock.name in names]


def used_joints(model: Model) -> list[Joint]:
    """Return the joints that edges carry, and the default one."""
    numbers = np.unique(model.blocks.edge_joint)
    names = {model.blocks.joint_names[k] for k in numbers[numbers >= 0]} | {model.default_joint}
    return [joint for joint in model.joints if joint.name in names]


def unused_bolts(model: Model) -> BoolArray:
    """Return which bolts lie in a single block, and carry nothing, (n_bolts,)."""
    if not model.bolts:
        return np.zeros(0, dtype=np.bool_)
    passed = pass_blocks(model.bolts, model.blocks, model.stages)
    least, most = np.full(len(model.bolts), model.blocks.count), np.full(len(model.bolts), -1)
    np.minimum.at(least, passed.bolt, passed.block)
    np.maximum.at(most, passed.bolt, passed.block)
    alone: BoolArray = least == most
    return alone


def in_single_blocks(model: Model, bolts: Sequence[int]) -> str:
    """Return a sentence on bolts that lie in a single block each, by their numbers in the model."""
    named = ", ".join(label(model.bolts, k) for k in bolts[:3]) + (", ..." if len(bolts) > 3 else "")
    each = "lies in a single block and carries" if len(bolts) == 1 else "lie in a single block each and carry"
    return f"{counted(len(bolts), 'bolt')} {each} nothing ({named})"


def of_single_bolts(model: Model) -> Iterator[str]:
    """Say which bolts lie in a single block each."""
    if (alone := np.flatnonzero(unused_bolts(model))).size:
        yield in_single_blocks(model, alone.tolist())


def _dry_tables(model: Model) -> Iterator[str]:
    """Say which water tables lie below all blocks; that of a stage may where there was water before."""
    low = model.blocks.vertices[:, 1].min()
    wet = False
    stages = ((f"stage '{stage.name}': water", stage.water) for stage in model.stages)
    for place, water in (("water", model.water), *stages):
        if water is None or not water.table:
            continue
        here = is_wet(model.blocks, water)
        if not (here or wet):
            yield f"{place}: the table lies below all blocks (the lowest point of the model is at y = {low:.6g} m)"
        wet |= here


def is_wet(blocks: Blocks, water: Water) -> bool:
    """Return whether a part of a block lies below the water tables."""
    surface = water.surface()
    x, y = blocks.vertices.T
    if np.any(surface.at(x) > y):
        return True
    start, end = blocks.vertices, blocks.vertices[blocks.following]
    for at in surface.breaks:  # a table has its highest points there
        left, right = np.minimum(start[:, 0], end[:, 0]), np.maximum(start[:, 0], end[:, 0])
        over = (left <= at) & (at <= right) & (left < right)
        share = (at - start[over, 0]) / (end[over, 0] - start[over, 0])
        if np.any(surface.at(np.array([at])) > start[over, 1] + share * (end[over, 1] - start[over, 1])):
            return True
    return False
