"""Water under a table on blocks in large displacement: its pressure acts where their faces are.

As in small displacement the load on rock is the force -grad p per volume, and stresses are effective. A block's whole
load is that of the pressure on its outline as it deformed. Integration over zones whose volume changed, or which the
table crosses, leaves a part of it. That part is spread over the block, with its force and moment.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray
from bsm_mesh.model.water_pressure import WaterLoad
from bsm_mesh.solve.zones.apart import Apart
from bsm_mesh.solve.zones.equilibrium import BALANCED, Equations
from bsm_mesh.solve.zones.ground import PoreWater, seepage_forces
from bsm_mesh.solve.zones.placement import outline_of
from bsm_mesh.solve.zones.supports import nodal_unknowns

if TYPE_CHECKING:
    from bsm_mesh.solve.zones.stage_run import StageRun


def table_on_outlines(
    load: WaterLoad, apart: Apart, node: FloatArray, centroid: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return force and moment of the table's water on every block (n, 3), and their stiffness (n, 3, 3).

    Nodes (k, 2) and centroids (n, 2) are where they are [m].
    """
    corner, offsets = outline_of(apart.mesh, node)
    owner = np.repeat(np.arange(len(centroid), dtype=np.int32), np.diff(offsets))
    following = np.arange(1, len(corner) + 1)
    following[offsets[1:] - 1] = offsets[:-1]
    return load.on_outlines(owner, np.ascontiguousarray(corner), np.ascontiguousarray(corner[following]), centroid)


def water_forces(water: PoreWater, apart: Apart, u: FloatArray, present: BoolArray) -> FloatArray:
    """Return the forces of the water on the blocks that are there (n,), (M,) [N/m].

    Parameters
    ----------
    water : PoreWater
        The table.
    apart : Apart
        The cells.
    u : (N,) float64 [m]
        Displacements of the unknowns that are solved for.
    present : (n,) bool
        Which blocks are there.
    """
    own, unknowns = u[apart.merged_dof], nodal_unknowns(apart.basis)
    found = seepage_forces(water, present, apart.mesh, apart.basis, own)
    node = apart.basis.doflocs[:, unknowns[:, 0]].T + own[unknowns]
    moved = np.stack([part @ own for part in apart.averages], axis=1)
    centroid = apart.model.blocks.moments.centroid + moved
    left = table_on_outlines(water.load, apart, node, centroid)[0] - apart.sums(found, node, centroid)
    return found + _spread(apart, left * present[:, None], node, centroid)


def wetted(run: StageRun, equations: Equations, u: FloatArray, present: BoolArray) -> Equations | None:
    """Return equations with the water where blocks (n,) are at displacements u (N,); None: it is there already."""
    water, apart = run.state.water, run.of.apart
    if water is None or apart is None or equations.water is None:
        return None
    now = run.of.merged(water_forces(water, apart, u, present))
    change = now - equations.water
    if np.abs(change).max(initial=0.0) <= BALANCED * np.abs(equations.load).max(initial=0.0):
        return None
    return replace(equations, load=equations.load + change, water=now)


def _spread(apart: Apart, left: FloatArray, node: FloatArray, centroid: FloatArray) -> FloatArray:
    """Return forces and moments on blocks (n, 3) as forces per volume, linear over each block, (M,) [N/m]."""
    mass, unknowns, block = _unit_mass(apart.basis), nodal_unknowns(apart.basis), apart.node_block
    arm = node - centroid[block]
    across = np.stack([-arm[:, 1], arm[:, 0]], axis=1)

    def on_unknowns(field: FloatArray) -> FloatArray:
        values = np.zeros(apart.basis.N)
        values[unknowns] = field
        found: FloatArray = mass @ values
        return found

    polar = np.bincount(block, (across * on_unknowns(across)[unknowns]).sum(axis=1), minlength=len(left))
    level = left[:, :2] / apart.model.blocks.moments.area[:, None]
    return on_unknowns(level[block] + (left[:, 2] / polar)[block, None] * across)


def _unit_mass(basis: Any) -> Any:
    """Return the mass matrix (M, M) of a unit mass per area [m2]."""
    import skfem
    from skfem.helpers import dot

    return skfem.BilinearForm(lambda u, v, _: dot(u, v)).assemble(basis)
