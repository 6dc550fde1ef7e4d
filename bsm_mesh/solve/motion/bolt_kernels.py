"""Bolts and dowels in cycles of explicit motion."""

from __future__ import annotations

from typing import Any

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.compiled import njit
from bsm_mesh.solve.bolts.kernels import add_bolt_forces, element_lines, node_movements, solve_bolts
from bsm_mesh.solve.step.block_system import BlockSystem


def bolt_arrays(system: BlockSystem, reference: FloatArray) -> tuple[Any, ...] | None:
    """Return the bolts as `add_bolts` takes them, or None where there are none."""
    bolts = system.bolts
    if not bolts.alive.any():
        return None
    dowels = bolts.dowels
    acts = bolts.alive[dowels.element]
    return (
        reference,
        np.arange(len(bolts.layout.block)),
        *bolts.arrays,
        np.column_stack([dowels.near, dowels.far])[acts],
        np.column_stack([dowels.arm_near, dowels.arm_far])[acts],
        dowels.across[acts],
        np.column_stack([dowels.stiffness / dowels.spacing, dowels.strength / dowels.spacing, dowels.rest])[acts],
    )


@njit(nogil=True, allocates=True)
def add_bolts(
    here: FloatArray,
    reference: FloatArray,
    node: IntArray,
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
    dowel_arm: FloatArray,
    across: FloatArray,
    dowel: FloatArray,
    forces: FloatArray,
) -> None:  # pragma: no cover - compiled
    """Add the forces of bolts and dowels at the reference (n, 3) moved by `here` (n, 3) to forces (n, 3).

    Parameters
    ----------
    node : (n_nodes,) int
        Their numbers, 0, 1, 2 ...
    node_start, block, arm, point, first, alive, stiffness, rest, yield_force, capacity, bond_stiffness, anchor, spacing
        As in `InstalledBolts` and its layout.
    sides : (k, 2) int32
        Near and far block of every dowel that acts.
    dowel_arm : (k, 4) float64 [m]
        From their centroids to the crossing, in the blocks' own axes.
    across : (k, 2) float64
        Unit vector across the bolt, in the near block's axes.
    dowel : (k, 3) float64 [N/m2, N/m, m]
        Stiffness and strength over the spacing; coordinate at which its force is zero.
    """
    where = np.empty((node.size, 3))
    for k in range(node.size):
        for axis in range(3):
            where[k, axis] = reference[block[k], axis] + here[block[k], axis]
    moved, turned = node_movements(where, node, arm)
    length, direction = element_lines(point, moved, first)
    tension, _ = solve_bolts(node_start, alive, stiffness, length - rest, yield_force, capacity, bond_stiffness, anchor)
    add_bolt_forces(node_start, block, spacing, turned, direction, tension, forces)
    for k in range(sides.shape[0]):
        _add_dowel(reference, here, sides[k, 0], sides[k, 1], dowel_arm[k], across[k], dowel[k], forces)


@njit(nogil=True)
def _add_dowel(
    reference: FloatArray,
    here: FloatArray,
    near: int,
    far: int,
    arm: FloatArray,
    across: FloatArray,
    dowel: FloatArray,
    forces: FloatArray,
) -> None:  # pragma: no cover - compiled
    turn_near, turn_far = reference[near, 2] + here[near, 2], reference[far, 2] + here[far, 2]
    cn, sn, cf, sf = np.cos(turn_near), np.sin(turn_near), np.cos(turn_far), np.sin(turn_far)
    ox, oy = cn * across[0] - sn * across[1], sn * across[0] + cn * across[1]
    nx, ny = cn * arm[0] - sn * arm[1], sn * arm[0] + cn * arm[1]  # to where the near block has the crossing
    fx, fy = cf * arm[2] - sf * arm[3], sf * arm[2] + cf * arm[3]
    rx = arm[0] + (fx - arm[2]) + reference[far, 0] + here[far, 0] - reference[near, 0] - here[near, 0]
    ry = arm[1] + (fy - arm[3]) + reference[far, 1] + here[far, 1] - reference[near, 1] - here[near, 1]
    shear = (rx - nx) * ox + (ry - ny) * oy - dowel[2]
    size = min(max(dowel[0] * shear, -dowel[1]), dowel[1])
    forces[near, 0] += size * ox
    forces[near, 1] += size * oy
    forces[near, 2] += rx * size * oy - ry * size * ox
    forces[far, 0] -= size * ox
    forces[far, 1] -= size * oy
    forces[far, 2] -= fx * size * oy - fy * size * ox
