"""Displacements of the continuum at points of its blocks."""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.sparse as sp

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.solve.zones.mesh import ContinuumMesh


def sampling(mesh: ContinuumMesh, basis: Any, point: FloatArray, block: IntArray) -> tuple[Any, Any]:
    """Return the sparse matrices (k, N) that give the displacement in x and in y at points of blocks.

    A point on the edge of a block moves with that block, whatever lies on the other side.

    Parameters
    ----------
    mesh, basis
        The cells, and the basis of the vector-valued element on them.
    point : (k, 2) float64 [m]
        Where.
    block : (k,) int32
        The block of every point.
    """
    cell = cells_at(mesh, point, block)
    local = basis.mapping.invF(point.T[:, :, None], tind=cell)
    values = np.stack([basis.elem.gbasis(basis.mapping, local, j, tind=cell)[0] for j in range(basis.Nbfun)])
    columns, rows = basis.element_dofs[:, cell].ravel(), np.tile(np.arange(len(point)), basis.Nbfun)
    x, y = (
        sp.csr_matrix((values[:, axis, :, 0].ravel(), (rows, columns)), shape=(len(point), basis.N)) for axis in (0, 1)
    )
    return x, y


def cells_at(mesh: ContinuumMesh, point: FloatArray, block: IntArray) -> IntArray:
    """Return the cell of its block in which each point lies most, (k,)."""
    order = np.argsort(mesh.block, kind="stable")
    first, last = (np.searchsorted(mesh.block[order], block, side=side) for side in ("left", "right"))
    count = last - first
    of_point = np.repeat(np.arange(len(point)), count)
    cell = order[np.repeat(first, count) + np.arange(len(of_point)) - np.repeat(np.cumsum(count) - count, count)]
    corner = mesh.mesh.p[:, mesh.mesh.t[:, cell]]
    side, to_point = np.roll(corner, -1, axis=1) - corner, point[of_point].T[:, None] - corner
    twice_area = (corner[0] * np.roll(corner[1], -1, axis=0) - np.roll(corner[0], -1, axis=0) * corner[1]).sum(axis=0)
    within = (side[0] * to_point[1] - side[1] * to_point[0]) * np.sign(twice_area) / np.hypot(*side)
    depth = within.min(axis=0)  # to the nearest side, negative outside
    best = np.lexsort([-depth, of_point])
    cells: IntArray = cell[best[np.cumsum(count) - count]]
    return cells
