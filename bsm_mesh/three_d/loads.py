"""Weights, loads and water on polyhedra where they were given."""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.model.loads import point_forces_of
from bsm_mesh.model.model import Model
from bsm_mesh.movements import cross
from bsm_mesh.three_d.water import WaterOnPolyhedra


def loads_as_given(model: Model) -> tuple[FloatArray, FloatArray]:
    """Return weights, loads and water on every block, and the water's part, (n, 6) each [N, N m].

    Moments are about the centroid.
    """
    blocks, applied = model.blocks, point_forces_of(model.acting_loads, model.blocks)
    water, _ = WaterOnPolyhedra(model).on_blocks(np.zeros((blocks.count, 6)))
    loads = water.copy()
    loads[:, :3] += model.gravity_forces
    arm = applied.point - blocks.moments.centroid[applied.block]
    np.add.at(loads, applied.block, np.hstack([applied.force, cross(arm, applied.force)]))
    return loads, water
