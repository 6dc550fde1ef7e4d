"""Weights, loads and water on the blocks, and the reference by which residuals are measured."""

from __future__ import annotations

from typing import Any

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray
from bsm_mesh.model.loads import PointForces, point_forces_of
from bsm_mesh.model.model import Model
from bsm_mesh.model.water_pressure import WaterLoad


def external_loads(model: Model) -> FloatArray:
    """Return weight, loads and water on every block, (n, 3): Fx, Fy, moment (Wang Eqs. 3.37, 3.38, 6.7)."""
    blocks = model.blocks
    total = WaterLoad(model).on_blocks(blocks.vertices, blocks.moments.centroid)
    total[:, :2] += model.gravity_forces
    return total + force_sums(point_forces_of(model.acting_loads, blocks), blocks.moments.centroid)


def force_sums(forces: PointForces, centroid: FloatArray) -> FloatArray:
    """Return the sum of forces at points on every block, (n, 3): Fx, Fy, moment about its centroid, (n, 2) [m]."""
    total = np.zeros((len(centroid), 3))
    arm = forces.point - centroid[forces.block]
    moment = arm[:, 0] * forces.force[:, 1] - arm[:, 1] * forces.force[:, 0]
    np.add.at(total, forces.block, np.column_stack([forces.force, moment]))
    return total


def given_of(model: Model, water: WaterLoad, loads: PointForces) -> dict[str, Any]:
    """Return the fields of `Evidence` that describe what acts on the blocks, from loads worked out to forces."""
    surface = water.surface
    gradient = water.water.unit_weight * surface.factor
    pieces = np.column_stack([surface.level, surface.slope, gradient])
    return {
        "weight": model.gravity_forces,
        "unit_weight": model.unit_weights,
        "gravity": model.gravity_vector,
        "load_block": loads.block,
        "load_point": loads.point,
        "load_force": loads.force,
        "water_breaks": surface.breaks if water.patches is None else None,
        "water_pieces": pieces if water.patches is None else None,
    }


def reference_weight(model: Model, loads: FloatArray, bolt_forces: FloatArray, among: BoolArray | None = None) -> float:
    """Return the reference of residuals [N/m]: the mean weight, or mean load of a loaded block, if greater.

    `among` (n,): blocks that count, all by default. Where nothing acts on them it is that of all, else the mean force
    of the bolts' pretension on a bolted block.
    """
    everywhere = np.ones(len(loads), dtype=bool)
    for blocks in (everywhere,) if among is None else (among, everywhere):
        weight = float(model.weights[blocks].mean()) if blocks.any() else 0.0
        reference = max(weight, mean_force(*loads[blocks, :2].T))
        if reference > 0:
            return reference
    return mean_force(*bolt_forces[:, :2].T)


def mean_force(first: FloatArray, second: FloatArray) -> float:
    """Return the mean of forces, given by their two components (k,), that are not zero; 0 where all are [N/m]."""
    size = np.hypot(first, second)
    acting = size[size > 0]
    return float(acting.mean()) if acting.size else 0.0


def relative_residual(model: Model, residual: FloatArray, reference: float) -> float:
    """Return the maximum norm of `residual` (n, 3), moments over radii of gyration, over the reference."""
    scaled = residual / np.column_stack([np.ones((len(residual), 2)), model.blocks.moments.gyration])
    max_norm = float(np.abs(scaled).max())
    return max_norm / reference if reference > 0 else max_norm
