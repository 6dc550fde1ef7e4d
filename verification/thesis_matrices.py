"""The matrices of the thesis written out as they be there, dense and slow, to compare the program's with."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def matrix_b(centroid: Array, point: Array) -> Array:
    """Return [B] of Eq. 3.6, (2, 3), with the local coordinates of Eq. 3.4."""
    x, y = point - centroid
    return np.array([[1.0, 0.0, -y], [0.0, 1.0, x]])


def matrix_d(centroid_i: Array, centroid_j: Array, point: Array) -> Array:
    """Return [D]ij = [-Bi | Bj] of Eq. 3.10, (2, 6)."""
    return np.hstack([-matrix_b(centroid_i, point), matrix_b(centroid_j, point)])


def matrix_t(degrees: float) -> Array:
    """Return [T] of Eq. 3.12, (2, 2), for a normal at an angle from the x axis."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.array([[c, s], [-s, c]])


def matrix_k(normal: float, shear: float) -> Array:
    """Return [k] of Eq. 3.14, (2, 2)."""
    return np.diag([normal, shear])


def vector_c(degrees: float) -> Array:
    """Return {c} of Eq. 3.29, (2,)."""
    return np.array([np.cos(np.radians(degrees)), np.sin(np.radians(degrees))])


class GlobalSystem:
    """The equations [K]{U} = {P} of Eqs. 3.40 and 3.41, summed block by block with the thesis's signs.

    Parameters
    ----------
    centroid : (n, 2) float64 [m]
        Of the blocks.
    """

    def __init__(self, centroid: Array) -> None:
        self.centroid = centroid
        self.K = np.zeros((3 * len(centroid), 3 * len(centroid)))
        self.P = np.zeros(3 * len(centroid))

    def add_contact(self, i: int, j: int, point: Array, degrees: float, normal: float, shear: float) -> None:
        """Add [K]ij to the rows of block i, and [K]ji to those of block j, whose outward normal is the opposite one."""
        for this, other, angle in ((i, j, degrees), (j, i, degrees + 180.0)):
            T, B = matrix_t(angle), matrix_b(self.centroid[this], point)
            D = matrix_d(self.centroid[this], self.centroid[other], point)
            block = B.T @ T.T @ matrix_k(normal, shear) @ T @ D  # Eq. 3.19
            rows = slice(3 * this, 3 * this + 3)
            self.K[rows, rows] += block[:, :3]
            self.K[rows, 3 * other : 3 * other + 3] += block[:, 3:]

    def add_bar(self, i: int, point: Array, degrees: float, displacement: float, stiffness: float) -> None:
        """Add a boundary bar: [Kd]i of Eq. 3.35 and {R0}i of Eq. 3.34."""
        B, c = matrix_b(self.centroid[i], point), vector_c(degrees)
        rows = slice(3 * i, 3 * i + 3)
        self.K[rows, rows] -= stiffness * B.T @ np.outer(c, c) @ B
        self.P[rows] -= stiffness * displacement * B.T @ c

    def add_force(self, i: int, force: Sequence[float]) -> None:
        """Add {W}i or {Pc}i (Eqs. 3.37, 3.38), force and moment (3,)."""
        self.P[3 * i : 3 * i + 3] -= np.asarray(force)

    def solve(self) -> Array:
        """Return the displacements, (n, 3)."""
        found: Array = np.linalg.solve(self.K, self.P).reshape(-1, 3)
        return found
