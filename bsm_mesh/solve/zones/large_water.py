"""Water under a table on blocks in large displacement: its pressure acts where their faces are.

As in small displacement the load on rock is the force -grad p per volume, and stresses are effective. A block's whole
load is that of the pressure on its outline as it deformed. Integration over zones whose volume changed, or which the
table crosses, leaves a part of it. That part is spread over the block, with its force and moment.

Equilibrium is sought with a load that changes linearly as blocks move and turn, then with the exact load there. With a
constant load a block that water alone rights at a tilt would have no equilibrium.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import scipy.sparse as sp

from bsm_mesh.arrays import BoolArray, FloatArray
from bsm_mesh.model.water_pressure import WaterLoad
from bsm_mesh.solve.zones.apart import Apart
from bsm_mesh.solve.zones.equilibrium import BALANCED, Equations
from bsm_mesh.solve.zones.ground import seepage_forces
from bsm_mesh.solve.zones.placement import outline_of
from bsm_mesh.solve.zones.supports import nodal_unknowns
from bsm_mesh.solve.zones.water_near import WaterNear

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


def water_near(run: StageRun, u: FloatArray, present: BoolArray) -> WaterNear | None:
    """Return the water near displacements u (N,) on the blocks that are there (n,); None: there is none."""
    water, apart = run.state.water, run.of.apart
    if water is None or apart is None or not run.of.discretization.large:
        return None
    node, centroid = apart.placed(u)
    forces = seepage_forces(water, present, apart.mesh, apart.basis, u[apart.merged_dof])
    total, stiffness = table_on_outlines(water.load, apart, node, centroid)
    forces += _spread(apart, (total - apart.sums(forces, node, centroid)) * present[:, None], node, centroid)
    block, arm = apart.node_block, node - centroid[apart.node_block]
    turned = (arm * forces[nodal_unknowns(apart.basis)]).sum(axis=1)  # nodes turn, and the forces on them do not
    stiffness[:, 2, 2] -= np.bincount(block, turned, minlength=len(stiffness))
    stiffness *= present[:, None, None]
    return WaterNear(forces, apart.merged(forces), _on_outlines(apart, stiffness, node, centroid), u)


def wetted(run: StageRun, equations: Equations, u: FloatArray, present: BoolArray) -> Equations | None:
    """Return equations with the water where blocks (n,) are at displacements u (N,); None: it is there already."""
    before = equations.water
    if before is None or (now := water_near(run, u, present)) is None:
        return None
    missed = now.force - before.force - before.change(u)
    if np.abs(missed).max(initial=0.0) <= BALANCED * np.abs(equations.load).max(initial=0.0):
        return None
    return replace(equations, load=equations.load + now.force - before.force, water=now)


def _on_outlines(apart: Apart, stiffness: FloatArray, place: FloatArray, centroid: FloatArray) -> Any:
    """Return the stiffness of blocks (n, 3, 3) as that of the nodes on their outlines, sparse (N, N).

    Nodes (k, 2) and centroids (n, 2) are at `place` and `centroid` [m].
    """
    unknowns, size = nodal_unknowns(apart.basis), len(stiffness)
    node = np.unique(apart.mesh.piece_ends)
    block = apart.node_block[node]
    arm, one, zero = place[node] - centroid[block], np.ones(len(node)), np.zeros(len(node))
    modes = np.stack([np.stack([one, zero, -arm[:, 1]], axis=1), np.stack([zero, one, arm[:, 0]], axis=1)], axis=1)
    gram = np.zeros((size, 3, 3))
    np.add.at(gram, block, np.einsum("kxi,kxj->kij", modes, modes))
    parts = modes @ np.linalg.inv(gram)[block]  # of forces and moments at nodes
    row = np.broadcast_to(apart.merged_dof[unknowns[node]][:, :, None], parts.shape)
    column = np.broadcast_to((3 * block[:, None] + np.arange(3))[:, None, :], parts.shape)
    spread = sp.csr_matrix((parts.ravel(), (row.ravel(), column.ravel())), shape=(apart.unknowns, 3 * size))
    return spread @ sp.block_diag(list(stiffness), format="csr") @ spread.T


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
