"""Stiffness of the rock in scikit-fem, and averages of its fields over cells and blocks."""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.sparse as sp

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.converters.continuum.supports import nodal_unknowns


def block_averages(basis: Any, block: IntArray, area: FloatArray) -> tuple[Any, Any]:
    """Return the sparse matrices (n_blocks, N) that give the blocks' average displacement in x and in y."""
    import skfem

    constant = basis.with_element(skfem.ElementQuad0() if basis.mesh.t.shape[0] == 4 else skfem.ElementTriP0())
    gather = sp.csr_matrix((np.ones(len(block)), (block, np.arange(len(block)))), shape=(len(area), len(block)))
    gather = sp.diags(1 / area) @ gather
    x, y = (
        sp.csr_matrix(gather @ skfem.BilinearForm(lambda u, v, _, axis=axis: u[axis] * v).assemble(basis, constant))
        for axis in (0, 1)
    )
    return x, y


def rock_stiffness(basis: Any, stiffness: FloatArray) -> Any:
    """Return the stiffness matrix of a material that differs from cell to cell, (t, 3, 3)."""
    import skfem
    from skfem.helpers import sym_grad

    C = stiffness.transpose(1, 2, 0)[:, :, :, None]

    def strain(field: Any) -> tuple[Any, Any, Any]:
        e = sym_grad(field)
        return e[0, 0], e[1, 1], 2 * e[0, 1]

    @skfem.BilinearForm
    def form(u: Any, v: Any, _: Any) -> Any:
        of_u, of_v = strain(u), strain(v)
        return sum(sum(C[i, j] * of_u[j] for j in range(3)) * of_v[i] for i in range(3))

    return form.assemble(basis)


def mean_gradient(basis: Any, u: FloatArray) -> FloatArray:
    """Return the average displacement gradient H[i, j] = du_i/dx_j of every cell, (t, 2, 2)."""
    total = np.einsum("ijtq,tq->tij", basis.interpolate(u).grad, basis.dx)
    mean: FloatArray = total / basis.dx.sum(axis=1)[:, None, None]
    return mean


def stress_of(gradient: FloatArray, stiffness: FloatArray) -> FloatArray:
    """Return the stress (t, 2, 2) [Pa] under a displacement gradient."""
    H = gradient
    strain = np.stack([H[:, 0, 0], H[:, 1, 1], H[:, 0, 1] + H[:, 1, 0]], axis=1)
    xx, yy, xy = np.einsum("tij,tj->it", stiffness, strain)
    return np.stack([xx, xy, xy, yy], axis=1).reshape(-1, 2, 2)


def over_blocks(values: FloatArray, area: FloatArray, block: IntArray, block_area: FloatArray) -> FloatArray:
    """Return the area-weighted mean over each block of a value a cell (t, ...)."""
    total = np.zeros((len(block_area), *values.shape[1:]))
    np.add.at(total, block, values * area.reshape(-1, *(1,) * (values.ndim - 1)))
    mean: FloatArray = total / block_area.reshape(-1, *(1,) * (values.ndim - 1))
    return mean


def vtk_cells(basis: Any) -> tuple[IntArray, FloatArray]:
    """Return the cells' nodes in VTK's order, counter-clockwise: corners, then middles; and all nodes' coordinates."""
    mesh = basis.mesh
    x, y = mesh.p[:, mesh.t]
    clockwise = (x * np.roll(y, -1, axis=0) - np.roll(x, -1, axis=0) * y).sum(axis=0) < 0
    # Sides of skfem's triangles are 0-1, 1-2, 0-2; of its quads 0-1, 1-2, 2-3, 0-3. Turned round, the corners are
    # 0, 2, 1 and the sides 0-2, 2-1, 1-0; or 0, 3, 2, 1 and the sides 0-3, 3-2, 2-1, 1-0.
    nodes, order = mesh.t, ([0, 2, 1], [0, 3, 2, 1])[len(mesh.t) - 3]
    if basis.facet_dofs.size:
        nodes = np.vstack([nodes, mesh.p.shape[1] + mesh.t2f])
        order = [*order, *range(2 * len(mesh.t) - 1, len(mesh.t) - 1, -1)]
    cells: IntArray = np.where(clockwise, nodes[order], nodes).T.astype(np.int32)
    points: FloatArray = basis.doflocs[:, nodal_unknowns(basis)[:, 0]].T
    return np.ascontiguousarray(cells), np.ascontiguousarray(points)
