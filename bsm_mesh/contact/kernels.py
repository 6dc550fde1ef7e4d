"""Compiled passes over the contact table: spring forces, sums of forces and stresses on the blocks.

Pure functions of their arrays. Block a is Wang's block j (its corner moves), block b his block i (its edge
has the normal): delta = u_a - u_b, so that normal forces are positive in tension (Wang Eqs. 3.8-3.15).
"""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.compiled import njit


@njit(allocates=True)
def spring_forces(
    block_a: IntArray,
    block_b: IntArray,
    point: FloatArray,
    normal: FloatArray,
    stiffness_n: FloatArray,
    stiffness_s: FloatArray,
    centroid: FloatArray,
    U: FloatArray,
) -> tuple[FloatArray, FloatArray]:  # pragma: no cover - compiled
    """Return normal and shear force of every contact for small displacements U (n, 3) (Wang Eqs. 3.11-3.15)."""
    m = block_a.size
    normal_force = np.empty(m)
    shear_force = np.empty(m)
    for c in range(m):
        a, b = block_a[c], block_b[c]
        du = U[a, 0] - U[a, 2] * (point[c, 1] - centroid[a, 1]) - U[b, 0] + U[b, 2] * (point[c, 1] - centroid[b, 1])
        dv = U[a, 1] + U[a, 2] * (point[c, 0] - centroid[a, 0]) - U[b, 1] - U[b, 2] * (point[c, 0] - centroid[b, 0])
        normal_force[c] = stiffness_n[c] * (du * normal[c, 0] + dv * normal[c, 1])
        shear_force[c] = stiffness_s[c] * (-du * normal[c, 1] + dv * normal[c, 0])
    return normal_force, shear_force


@njit()
def add_contact_forces(
    block_a: IntArray,
    block_b: IntArray,
    point: FloatArray,
    normal: FloatArray,
    normal_force: FloatArray,
    shear_force: FloatArray,
    centroid: FloatArray,
    total: FloatArray,
) -> None:  # pragma: no cover - compiled
    """Add force and moment about the centroid of all contacts to `total` (n, 3) (Wang Eqs. 3.16, 3.17)."""
    for c in range(block_a.size):
        a, b = block_a[c], block_b[c]
        fx = normal_force[c] * normal[c, 0] - shear_force[c] * normal[c, 1]
        fy = normal_force[c] * normal[c, 1] + shear_force[c] * normal[c, 0]
        total[b, 0] += fx
        total[b, 1] += fy
        total[b, 2] += (point[c, 0] - centroid[b, 0]) * fy - (point[c, 1] - centroid[b, 1]) * fx
        total[a, 0] -= fx
        total[a, 1] -= fy
        total[a, 2] -= (point[c, 0] - centroid[a, 0]) * fy - (point[c, 1] - centroid[a, 1]) * fx


@njit()
def add_contact_moments(
    block_a: IntArray,
    block_b: IntArray,
    point: FloatArray,
    normal: FloatArray,
    normal_force: FloatArray,
    shear_force: FloatArray,
    centroid: FloatArray,
    dyad: FloatArray,
) -> None:  # pragma: no cover - compiled
    """Add x_i F_j of all contacts to `dyad` (n, 2, 2), x from the centroid (the sum in Wang Eq. 3.45)."""
    for c in range(block_a.size):
        fx = normal_force[c] * normal[c, 0] - shear_force[c] * normal[c, 1]
        fy = normal_force[c] * normal[c, 1] + shear_force[c] * normal[c, 0]
        for block, sign in ((block_b[c], 1.0), (block_a[c], -1.0)):
            x = point[c, 0] - centroid[block, 0]
            y = point[c, 1] - centroid[block, 1]
            dyad[block, 0, 0] += sign * x * fx
            dyad[block, 0, 1] += sign * x * fy
            dyad[block, 1, 0] += sign * y * fx
            dyad[block, 1, 1] += sign * y * fy
