"""Initial state of the ground: in-situ stress in rock and joints, and the water's pressure in both.

Rock that is full of water carries effective stress: the total stress and the water's pressure p. The water's whole load
on it, pore pressure and pressure on its faces together, is then the force -grad p per volume, and nothing on the faces.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray
from bsm_mesh.model.in_stage import without_stages
from bsm_mesh.model.model import Model
from bsm_mesh.model.stress_field import StressField
from bsm_mesh.model.water import Water
from bsm_mesh.model.water_pressure import WaterLoad
from bsm_mesh.solve.zones.joint_history import JointHistory
from bsm_mesh.solve.zones.joint_points import JointPoints
from bsm_mesh.solve.zones.loads import assemble_load
from bsm_mesh.solve.zones.mesh import ContinuumMesh
from bsm_mesh.solve.zones.moving_points import MovingPoints

WATER_ORDER = 12  # of integration: the pressure has a bend where the table crosses a cell


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class PoreWater:
    """The water of a stage.

    Attributes
    ----------
    pressure : (t, i) float64 [Pa]
        In the rock, at the integration points of every cell.
    at_joints : (q,) float64 [Pa]
        In the joints, at their points.
    beyond_table : (q,) float64 [Pa]
        Of `at_joints` the excess of a joint's own pressure over the table's.
    load : WaterLoad
        The table.
    """

    pressure: FloatArray
    at_joints: FloatArray
    beyond_table: FloatArray
    load: WaterLoad


def pore_water(
    model: Model, water: Water | None, basis: Any, joints: JointPoints | None, u: FloatArray | None = None
) -> PoreWater | None:
    """Return the pressures under a water table, None where there is no water.

    With displacements u (N,) they are those where rock and joints are in large displacement.
    """
    if water is None:
        return None
    load = WaterLoad(without_stages(model, water=water, in_situ=None))
    x = np.asarray(basis.global_coordinates())
    x = x if u is None else x + np.asarray(basis.interpolate(u))
    none = np.full(x[0].size, -1)
    pressure = load.pressure(x.reshape(2, -1).T.copy(), none).reshape(x.shape[1:])
    own = table = np.zeros(0)
    if joints is not None:
        point = joints.placed(u) if u is not None and isinstance(joints, MovingPoints) else joints.point
        own = load.pressure(point, np.where(joints.are_joints, joints.joint, -1))
        table = load.pressure(point, np.full(len(joints.joint), -1))
    return PoreWater(pressure=pressure, at_joints=own, beyond_table=own - table, load=load)


def seepage_forces(
    water: PoreWater, present: BoolArray, mesh: ContinuumMesh, basis: Any, u: FloatArray | None = None
) -> FloatArray:
    """Return the forces (N,) [N/m] of -grad p in the blocks that are there, at displacements u (N,) if they count."""
    import skfem

    fine = skfem.CellBasis(basis.mesh, basis.elem, intorder=WATER_ORDER)
    where = np.asarray(fine.global_coordinates())
    x, y = where if u is None else where + np.asarray(fine.interpolate(u))
    surface = water.load.surface
    piece = np.searchsorted(surface.breaks, x)
    below = surface.level[piece] + surface.slope[piece] * x > y
    weight = water.load.water.unit_weight * surface.factor[piece] * (below & present[mesh.block][:, None])
    slope = np.where(below, surface.slope[piece], 0.0)
    return assemble_load(fine, np.stack([-weight * slope, weight]))


def initial_stress(model: Model, mesh: ContinuumMesh, basis: Any, water: PoreWater | None) -> FloatArray | None:
    """Return the effective in-situ stress (3, t, i) [Pa] at the integration points: xx, yy, xy; None if not given."""
    if model.in_situ is None or model.in_situ.method != "direct":
        return None
    x = np.asarray(basis.global_coordinates())
    block = np.repeat(mesh.block, x.shape[2])
    stress: FloatArray = StressField(model).at(x.reshape(2, -1).T.copy(), block).T.reshape(3, *x.shape[1:])
    if water is not None:
        stress = stress + water.pressure * np.array([1.0, 1.0, 0.0])[:, None, None]
    return stress


def initial_history(model: Model, joints: JointPoints, water: PoreWater | None) -> JointHistory:
    """Return the joints' history at the start: their part of the in-situ stress, where that is given."""
    history = joints.unstressed()
    if model.in_situ is None or model.in_situ.method != "direct":
        return history
    field = StressField(model)
    first, second = (field.at(joints.point, side) for side in joints.block.T.copy())
    xx, yy, xy = (first + second).T / 2
    n, t = joints.normal.T, joints.tangent_direction.T
    x, y = xx * n[0] + xy * n[1], xy * n[0] + yy * n[1]
    pressure = -joints.lumped(x * n[0] + y * n[1])
    if water is not None:
        pressure = pressure - joints.lumped(water.at_joints)
    shear = joints.lumped(x * t[0] + y * t[1])
    return replace(history, initial_pressure=pressure, pressure=np.maximum(pressure, 0.0), shear=shear)
