"""Pressures on the faces that an excavation lays bare."""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import BoolArray
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.model.faces import pressure_between
from bsm_mesh.model.kinds import in_space
from bsm_mesh.model.loads import PointForces


def concatenate(parts: list[PointForces]) -> PointForces:
    """Return the point forces of several tables in one."""
    block, point, force = (np.concatenate([getattr(p, name) for p in parts]) for name in ("block", "point", "force"))
    return PointForces(block=block, point=point, force=force)


def pressure_on_new_faces(blocks: Blocks, stays: BoolArray, leaves: BoolArray, pressure: float) -> PointForces:
    """Return a pressure [Pa] on the faces between blocks that stay (n,) and that leave (n,), into the former."""
    if in_space(blocks):
        return blocks.pressure_on_new_faces(stays, leaves, pressure)
    return pressure_between(blocks, stays, leaves, pressure)
