"""Stiffness of the rock in scikit-fem, and averages of its fields over cells and blocks."""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.sparse as sp

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.solve.zones.supports import nodal_unknowns


def block_averages(basis: Any, block: IntArray, area: FloatArray) -> tuple[Any, Any]:
    """Return the sparse matrices (n_blocks, N) that give the blocks' average displacement in x and in y."""
    weight = (
        np.stack([np.einsum("itq,tq->it", np.asarray(field[0]), basis.dx) for field in basis.basis], axis=1)
        / area[block]
    )
    rows, columns = np.tile(block, basis.Nbfun), basis.element_dofs.ravel()
    x, y = (sp.csr_matrix((part.ravel(), (rows, columns)), shape=(len(area), basis.N)) for part in weight)
    return x, y


class RockStiffness:
    """Stiffness matrices of all cells, from which the rock that is there is assembled.

    A form of scikit-fem is evaluated for every pair of shape functions; here all are one product a cell.

    Parameters
    ----------
    basis : skfem.CellBasis
        Of the vector-valued element.
    stiffness : (t, 3, 3) float64 [Pa]
        Of the material of every cell.
    """

    def __init__(self, basis: Any, stiffness: FloatArray) -> None:
        self._of_cell = np.zeros((basis.nelems, basis.Nbfun, basis.Nbfun))
        for point, weight in enumerate(basis.dx.T):
            H = np.stack([field[0].grad[:, :, :, point] for field in basis.basis], axis=-1)  # (2, 2, t, shapes)
            B = np.stack([H[0, 0], H[1, 1], H[0, 1] + H[1, 0]], axis=1)
            self._of_cell += B.transpose(0, 2, 1) @ (weight[:, None, None] * stiffness @ B)
        self._dofs, self._size = basis.element_dofs.T, basis.N

    def forces(self, cells: BoolArray, u: FloatArray, dofs: IntArray, size: int) -> FloatArray:
        """Return the internal forces (size,) [N/m] of some cells (t,) whose unknowns u (size,) are `dofs` (shapes, t).

        So the forces of cells are found on a mesh whose cells share fewer nodes.
        """
        own = dofs.T[cells]
        found = np.einsum("tij,tj->ti", self._of_cell[cells], u[own])
        return np.bincount(own.ravel(), found.ravel(), minlength=size).astype(np.float64)

    def of(self, cells: BoolArray) -> Any:
        """Return the stiffness matrix (N, N) of some cells (t,)."""
        dofs = self._dofs[cells]
        rows, columns = np.repeat(dofs, dofs.shape[1], axis=1), np.tile(dofs, dofs.shape[1])
        entries = self._of_cell[cells].ravel()
        return sp.csr_matrix((entries, (rows.ravel(), columns.ravel())), shape=(self._size, self._size))


def forces_of_stress(basis: Any, stress: FloatArray) -> FloatArray:
    """Return the internal forces (N,) [N/m] of a stress (3, t, i) [Pa]."""
    import skfem
    from skfem.helpers import sym_grad

    @skfem.LinearForm
    def form(v: Any, w: Any) -> Any:
        e, (xx, yy, xy) = sym_grad(v), w["stress"]
        return xx * e[0, 0] + yy * e[1, 1] + 2 * xy * e[0, 1]

    forces: FloatArray = form.assemble(basis, stress=stress)
    return forces


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
