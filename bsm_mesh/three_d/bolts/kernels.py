"""Bolts and dowels in cycles of explicit motion in space."""

from __future__ import annotations

from typing import Any

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.compiled import njit
from bsm_mesh.solve.bolts.installed import InstalledBolts
from bsm_mesh.solve.bolts.kernels import add_action, add_bolt_forces, element_lines, solve_bolts


def bolt_arrays(bolts: InstalledBolts) -> tuple[Any, ...] | None:
    """Return the bolts as `add_bolts` takes them, or None where there are none."""
    if not bolts.alive.any():
        return None
    dowels = bolts.dowels
    acts = bolts.alive[dowels.element]
    return (
        *bolts.arrays,
        np.column_stack([dowels.near, dowels.far])[acts],
        np.column_stack([dowels.arm_near, dowels.arm_far, dowels.across, dowels.rest])[acts],
        np.column_stack([dowels.stiffness, dowels.strength])[acts],
    )


@njit(nogil=True, allocates=True)
def add_bolts(
    shift: FloatArray,
    matrix: FloatArray,
    node_start: IntArray,
    block: IntArray,
    arm: FloatArray,
    point: FloatArray,
    first: IntArray,
    alive: BoolArray,
    stiffness: FloatArray,
    rest: FloatArray,
    yield_force: FloatArray,
    capacity: FloatArray,
    bond_stiffness: FloatArray,
    anchor: FloatArray,
    spacing: FloatArray,
    sides: IntArray,
    crossing: FloatArray,
    dowel: FloatArray,
    forces: FloatArray,
) -> None:  # pragma: no cover - compiled
    """Add the forces of bolts and dowels to `forces` (n, 6).

    Parameters
    ----------
    shift, matrix : (n, 3), (n, 3, 3) float64
        Displacements of centroids, and rotation matrices less the unit matrix.
    node_start, block, arm, point, first, alive, stiffness, rest, yield_force, capacity, bond_stiffness, anchor, spacing
        As in `InstalledBolts` and its layout.
    sides : (k, 2) int32
        Near and far block of every dowel that acts.
    crossing : (k, 12) float64
        In the blocks' own axes: from their centroids to the crossing; unit vector along the bolt; shear at zero force.
    dowel : (k, 2) float64 [N/m, N]
        Stiffness and strength.
    """
    moved, turned = np.empty((block.size, 3)), np.empty((block.size, 3))
    for k in range(block.size):
        _swing(matrix[block[k]], arm[k], moved[k])
        for axis in range(3):
            turned[k, axis] = arm[k, axis] + moved[k, axis]
            moved[k, axis] += shift[block[k], axis]
    length, direction = element_lines(point, moved, first)
    tension, _ = solve_bolts(node_start, alive, stiffness, length - rest, yield_force, capacity, bond_stiffness, anchor)
    add_bolt_forces(node_start, block, spacing, turned, direction, tension, forces)
    for k in range(sides.shape[0]):
        _add_dowel(shift, matrix, sides[k, 0], sides[k, 1], crossing[k], dowel[k], forces)


@njit(nogil=True)
def _swing(matrix: FloatArray, vector: FloatArray, found: FloatArray) -> None:  # pragma: no cover - compiled
    """Set `found` (3,) to the change of a vector by a rotation less the unit matrix."""
    for u in range(3):
        found[u] = matrix[u, 0] * vector[0] + matrix[u, 1] * vector[1] + matrix[u, 2] * vector[2]


@njit(nogil=True, allocates=True)
def _add_dowel(
    shift: FloatArray,
    matrix: FloatArray,
    near: int,
    far: int,
    crossing: FloatArray,
    dowel: FloatArray,
    forces: FloatArray,
) -> None:  # pragma: no cover - compiled
    """Add the force of a dowel on its two blocks, as `SpaceDowels.evaluate` and `SpaceDowels.add_forces` do."""
    own, away, sheared, push = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    _swing(matrix[near], crossing[:3], own)
    _swing(matrix[far], crossing[3:6], away)
    for u in range(3):  # `own`: from where the near block has the crossing to where the far one has it
        own[u] = away[u] + shift[far, u] - shift[near, u] - own[u]
    along = 0.0
    for u in range(3):  # in the near block's axes
        sheared[u] = own[u] + matrix[near, 0, u] * own[0] + matrix[near, 1, u] * own[1] + matrix[near, 2, u] * own[2]
        along += sheared[u] * crossing[6 + u]
    size = 0.0
    for u in range(3):
        sheared[u] -= along * crossing[6 + u] + crossing[9 + u]
        size += sheared[u] ** 2
    size = np.sqrt(size)
    if size == 0.0:
        return
    force = min(dowel[0] * size, dowel[1]) / size
    for u in range(3):
        sheared[u] *= force
    _swing(matrix[near], sheared, push)
    for u in range(3):
        push[u] += sheared[u]
        away[u] += crossing[3 + u]  # the arm of the far block; that of the near one ends at the same point
        own[u] = crossing[u] + away[u] - crossing[3 + u] + shift[far, u] - shift[near, u]
    add_action(1.0, own, push, forces[near])
    add_action(-1.0, away, push, forces[far])
