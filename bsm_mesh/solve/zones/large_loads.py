"""Loads on blocks in large displacement as forces at points: they keep their direction and move with the rock."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.model.loads import PointForces, PointLoad, point_forces_of
from bsm_mesh.movements import turned
from bsm_mesh.solve.algebra.loads import force_sums
from bsm_mesh.solve.zones.loads import load_vector, weightless
from bsm_mesh.solve.zones.placement import Placement

if TYPE_CHECKING:
    from bsm_mesh.solve.zones.stage_solution import StageEnd
    from bsm_mesh.solve.zones.stages import Continuum


def moved_loads(of: Continuum, end: StageEnd, place: Placement, turn: FloatArray) -> PointForces:
    """Return loads, pressures on new faces, and excavation forces that are held back, with their exact moments.

    Tractions and the like act at nodes. A load at a point is spread over its block. It is given where the block's
    rotation `turn` (n,) [rad] brings that point; a couple represents the moment that bending adds.
    """
    assert of.apart is not None
    apart, model = of.apart, weightless(end.model)
    given = [load for load in end.acting if isinstance(load, PointLoad | PointForces)]
    others = [load for load in end.acting if not isinstance(load, PointLoad | PointForces)]
    spread, at_nodes = (load_vector(model, apart.mesh, apart.basis, loads, end.present) for loads in (given, others))
    nodal = apart.nodal_forces(at_nodes + end.pressures - apart.held_back(end), place.node)
    points = point_forces_of(given, model.blocks)
    here = end.present[points.block]
    block, arm = points.block[here], (points.point - model.blocks.moments.centroid[points.block])[here]
    at_points = PointForces(
        block=block, point=place.centroid[block] + turned(arm, turn[block]), force=points.force[here]
    )
    left = apart.sums(spread, place.node, place.centroid) - force_sums(at_points, place.centroid)
    return joined(nodal, at_points, couples(left[:, 2], place.centroid, model.blocks.moments.gyration))


def couples(moment: FloatArray, centroid: FloatArray, gyration: FloatArray) -> PointForces:
    """Return moments (n,) [N] on blocks as pairs of forces, a radius of gyration (n,) [m] from their centroids."""
    block = np.flatnonzero(moment).astype(np.int32)
    arm = np.stack([gyration, np.zeros_like(gyration)], axis=1)[block]
    force = np.stack([np.zeros(len(block)), moment[block] / (2 * gyration[block])], axis=1)
    return PointForces(
        block=np.tile(block, 2),
        point=np.concatenate([centroid[block] + arm, centroid[block] - arm]),
        force=np.concatenate([force, -force]),
    )


def joined(*parts: PointForces) -> PointForces:
    """Return several lists of forces as one."""
    columns = ([getattr(part, name) for part in parts] for name in ("block", "point", "force"))
    block, point, force = (np.concatenate(column) for column in columns)
    return PointForces(block=block.astype(np.int32), point=point, force=force)
