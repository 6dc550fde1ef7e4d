"""Forces on the faces that an excavation lays bare."""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import BoolArray
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.model.faces import pressure_between
from bsm_mesh.model.kinds import in_space
from bsm_mesh.model.loads import PointForces
from bsm_mesh.results.records import ContactForces
from bsm_mesh.solve.stages.scheme import Scheme


def forces_on_new_faces(scheme: Scheme, contacts: ContactForces, stays: BoolArray, leaves: BoolArray) -> PointForces:
    """Return the excavation forces: those of the removed blocks on the others."""
    on_b, on_a = (
        np.flatnonzero(stays[one] & leaves[other])
        for one, other in ((contacts.block_b, contacts.block_a), (contacts.block_a, contacts.block_b))
    )
    block = np.concatenate([contacts.block_b[on_b], contacts.block_a[on_a]])
    point = np.concatenate([contacts.point[on_b], contacts.point[on_a]])
    force = np.concatenate([contacts.force[on_b], -contacts.force[on_a]])
    return PointForces(block=block, point=scheme.as_given(block, point), force=force)


def concatenate(parts: list[PointForces]) -> PointForces:
    """Return the point forces of several tables in one."""
    block, point, force = (np.concatenate([getattr(p, name) for p in parts]) for name in ("block", "point", "force"))
    return PointForces(block=block, point=point, force=force)


def pressure_on_new_faces(blocks: Blocks, stays: BoolArray, leaves: BoolArray, pressure: float) -> PointForces:
    """Return a pressure [Pa] on the faces between blocks that stay (n,) and that leave (n,), into the former."""
    if in_space(blocks):
        return blocks.pressure_on_new_faces(stays, leaves, pressure)
    return pressure_between(blocks, stays, leaves, pressure)
