"""Forces on the faces that an excavation lays bare."""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import BoolArray
from bsm_mesh.model.loads import PointForces
from bsm_mesh.model.model import Model
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


def pressure_on_new_faces(model: Model, stays: BoolArray, leaves: BoolArray, pressure: float) -> PointForces:
    """Return a pressure on the faces between blocks that stay and blocks that leave, into those that stay."""
    from bsm_mesh.model.faces import find_faces

    faces, owner = find_faces(model.blocks), model.blocks.owner
    a, b = owner[faces.edge_a], owner[faces.edge_b]
    bare = (stays[b] & leaves[a]) | (stays[a] & leaves[b])
    start, end = faces.start[bare], faces.end[bare]
    along = end - start  # in the direction of b's edge, b to its left
    inward = np.stack([-along[:, 1], along[:, 0]], axis=1) * np.where(stays[b[bare]], 1.0, -1.0)[:, None]
    return PointForces(
        block=np.repeat(np.where(stays[b], b, a)[bare], 2),
        point=np.stack([start, end], axis=1).reshape(-1, 2),
        force=np.repeat(pressure * inward / 2, 2, axis=0),
    )


def concatenate(parts: list[PointForces]) -> PointForces:
    """Return the point forces of several tables in one."""
    block, point, force = (np.concatenate([getattr(p, name) for p in parts]) for name in ("block", "point", "force"))
    return PointForces(block=block, point=point, force=force)
