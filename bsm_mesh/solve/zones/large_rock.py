"""Elastic rock whose blocks turn by any angle: total Lagrangian forces and tangent.

Positions are x = X + u, with nodal displacements alone: no unknown is a rotation. The strain is Green's,
``E = (F^T F - 1) / 2`` with ``F = 1 + du/dX``, and the second Piola-Kirchhoff stress ``S = S0 + C E`` (St. Venant and
Kirchhoff). Both stay as they are where a block turns as a whole, and strains of rock are small.

References
----------
Bonet & Wood (2008), Nonlinear continuum mechanics for finite element analysis, 2nd ed., sections 4.5, 6.4 and 9.4.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class DeformedCells:
    """Cells at a displacement, (t, i) integration points.

    Attributes
    ----------
    F : (t, i, 2, 2) float64
        Deformation gradient.
    S : (t, i, 2, 2) float64 [Pa]
        Second Piola-Kirchhoff stress.
    """

    F: FloatArray
    S: FloatArray


@dataclass(frozen=True, eq=False, kw_only=True)
class LargeRock:
    """The cells in large displacement.

    Attributes
    ----------
    gradient : (t, i, nodes, 2) float64 [1/m]
        Derivatives of the shape functions in the given geometry.
    weight : (t, i) float64 [m2]
        Weights of the integration points; zero in cells that are not there.
    stiffness : (t, 3, 3) float64 [Pa]
        From (E_xx, E_yy, 2 E_xy) to (S_xx, S_yy, S_xy).
    initial : (t, i, 3) float64 or None [Pa]
        Stress S0 without strain: in situ.
    """

    gradient: FloatArray
    weight: FloatArray
    stiffness: FloatArray
    initial: FloatArray | None

    @classmethod
    def of(cls, basis: Any, stiffness: FloatArray, on: BoolArray, initial: FloatArray | None) -> LargeRock:
        """Return the rock of some cells (t,) of a vector-valued basis; `initial` is (3, t, i) [Pa]."""
        fields = [np.asarray(field[0].grad[0]) for field in basis.basis[::2]]
        return cls(
            gradient=np.stack(fields, axis=-1).transpose(1, 2, 3, 0),
            weight=basis.dx * on[:, None],
            stiffness=stiffness,
            initial=None if initial is None else np.moveaxis(initial, 0, -1),
        )

    def relieved(self, cells: IntArray, relief: FloatArray) -> LargeRock:
        """Return the rock with a stress (c, i, 4) [Pa] less in some cells (c,)."""
        initial = np.zeros((*self.weight.shape, 3)) if self.initial is None else self.initial.copy()
        initial[cells] -= relief[..., :3]
        return replace(self, initial=initial)

    def at(self, u: FloatArray, dofs: IntArray) -> DeformedCells:
        """Return the cells, whose unknowns are `dofs` (2 nodes, t), at displacements u (N,)."""
        H = self._gradients(u, dofs)
        stress = np.matmul(green_strains(H), self.stiffness)
        if self.initial is not None:
            stress = stress + self.initial
        xx, yy, xy = np.moveaxis(stress, -1, 0)
        return DeformedCells(F=H + np.eye(2), S=np.stack([xx, xy, xy, yy], axis=-1).reshape(H.shape))

    def forces(self, at: DeformedCells, dofs: IntArray, size: int) -> FloatArray:
        """Return the internal forces (size,) [N/m] on the unknowns `dofs` (2 nodes, t)."""
        first = at.F @ at.S * self.weight[:, :, None, None]
        nodal = np.matmul(self.gradient, first.swapaxes(-1, -2)).sum(axis=1)  # (t, nodes, 2)
        return np.bincount(dofs.T.ravel(), nodal.ravel(), minlength=size).astype(np.float64)

    def energy(self, u: FloatArray, dofs: IntArray) -> float:
        """Return the strain energy at displacements u (N,), with that of the stress without strain, [N]."""
        at = self.at(u, dofs)
        twice = at.F.swapaxes(-1, -2) @ at.F - np.eye(2)
        stress = at.S.copy()
        if self.initial is not None:  # S0 does its whole work, the rest half of it
            xx, yy, xy = np.moveaxis(self.initial, -1, 0)
            stress += np.stack([xx, xy, xy, yy], axis=-1).reshape(stress.shape)
        return float((np.einsum("tiab,tiab->ti", stress, twice) * self.weight).sum() / 4)

    def entries(self, at: DeformedCells) -> FloatArray:
        """Return the derivatives (t, 2 nodes, 2 nodes) of the forces of every cell by its unknowns."""
        rows = strain_rows(self.gradient, at.F)
        weighed = np.matmul(self.stiffness[:, None], rows) * self.weight[:, :, None, None]
        K: FloatArray = np.matmul(rows.swapaxes(-1, -2), weighed).sum(axis=1)
        return K + turning_entries(self.gradient, at.S, self.weight)

    def greatest_gradient(self, u: FloatArray, dofs: IntArray) -> float:
        """Return the greatest entry of the gradient of displacements u (N,)."""
        return float(np.abs(self._gradients(u, dofs)).max(initial=0.0))

    def area(self, at: DeformedCells) -> FloatArray:
        """Return the areas of the cells as they are, (t,) [m2]; zero where there is none."""
        area: FloatArray = (np.linalg.det(at.F) * self.weight).sum(axis=1)
        return area

    def stress(self, at: DeformedCells) -> FloatArray:
        """Return the average Cauchy stress of every cell, (t, 2, 2) [Pa]; zero where there is none."""
        total = (at.F @ at.S @ at.F.swapaxes(-1, -2) * self.weight[:, :, None, None]).sum(axis=1)
        area = self.area(at)[:, None, None]
        stress: FloatArray = np.divide(total, area, out=np.zeros_like(total), where=area > 0)
        return stress

    def greatest_strains(self, u: FloatArray, dofs: IntArray) -> FloatArray:
        """Return the greatest principal strain, by size, of every cell that is there, (t,); 0 of others."""
        xx, yy, twice_xy = np.moveaxis(green_strains(self._gradients(u, dofs)), -1, 0)
        greatest = np.abs(xx + yy) / 2 + np.hypot((xx - yy) / 2, twice_xy / 2)
        found: FloatArray = (greatest * (self.weight > 0)).max(axis=1)
        return found

    def _gradients(self, u: FloatArray, dofs: IntArray) -> FloatArray:
        nodal = u[dofs.T].reshape(len(self.gradient), 1, -1, 2)
        gradients: FloatArray = np.matmul(nodal.swapaxes(-1, -2), self.gradient)  # d u_i / d X_j
        return gradients


def green_strains(H: FloatArray) -> FloatArray:
    """Return Green's strains xx, yy and 2 xy, (t, i, 3), under displacement gradients (t, i, 2, 2)."""
    twice = H + H.swapaxes(-1, -2) + H.swapaxes(-1, -2) @ H  # F^T F - 1, with the rounding of H
    return np.stack([twice[..., 0, 0] / 2, twice[..., 1, 1] / 2, twice[..., 0, 1]], axis=-1)


def strain_rows(gradient: FloatArray, F: FloatArray) -> FloatArray:
    """Return the derivatives (t, i, 3, 2 nodes) of the strains xx, yy and 2 xy by the cells' unknowns.

    Parameters
    ----------
    gradient : (t, i, nodes, 2) float64 [1/m]
        Derivatives of the shape functions.
    F : (t, i, 2, 2) float64
        Deformation gradient; 1 in small displacement.
    """
    cells, points, nodes, _ = gradient.shape
    B = np.empty((cells, points, 3, nodes, 2))
    for i in (0, 1):
        B[:, :, i] = gradient[..., i, None] * F[:, :, None, :, i]
    B[:, :, 2] = gradient[..., 0, None] * F[:, :, None, :, 1] + gradient[..., 1, None] * F[:, :, None, :, 0]
    return B.reshape(cells, points, 3, 2 * nodes)


def turning_entries(gradient: FloatArray, S: FloatArray, weight: FloatArray) -> FloatArray:
    """Return the derivatives (t, 2 nodes, 2 nodes) of forces as stresses S (t, i, 2, 2) [Pa] turn with the rock."""
    cells, _, nodes, _ = gradient.shape
    K = np.zeros((cells, nodes, 2, nodes, 2))
    turning = (gradient @ S @ gradient.swapaxes(-1, -2) * weight[:, :, None, None]).sum(axis=1)
    K[:, :, 0, :, 0] = K[:, :, 1, :, 1] = turning
    return K.reshape(cells, 2 * nodes, 2 * nodes)
