"""Kernels of contact forces in the current geometry: exact rotations, forces, tangent with geometric stiffness.

A contact is a corner of block a, fixed to a, and an edge of block b, fixed to b. Pressure is positive; on b acts
``-pressure * n + shear * t``, on a its negative, at the corner.
"""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.compiled import njit


@njit(allocates=True)
def given_geometry(
    block_a: IntArray,
    block_b: IntArray,
    corner: IntArray,
    edge: IntArray,
    centroid: FloatArray,
    corners: FloatArray,
    directions: FloatArray,
) -> FloatArray:  # pragma: no cover - compiled
    """Return the given geometry of contacts, (m, 8) [m; -], as `relative_positions` takes it.

    `centroid` (n, 2), `corners` (n_vertices, 2) and `directions` of their edges are as in `Outlines`.
    """
    given = np.empty((block_a.size, 8))
    for k in range(block_a.size):
        for axis in range(2):
            given[k, axis] = centroid[block_a[k], axis] - centroid[block_b[k], axis]
            given[k, 2 + axis] = corners[corner[k], axis]
            given[k, 4 + axis] = corners[edge[k], axis]
            given[k, 6 + axis] = directions[edge[k], axis]
    return given


@njit(allocates=True)
def relative_positions(
    position: FloatArray,
    block_a: IntArray,
    block_b: IntArray,
    geometry: FloatArray,
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]:  # pragma: no cover - compiled
    """Return gap and coordinate along the edge (m,), edge direction (m, 2), and both arms to the corner (m, 2).

    Positions are displacements from the given geometry; rounding is then that of displacements, not of coordinates.
    `geometry` (m, 8) is read in one stream (see `given_geometry`): vectors from b's centroid to a's, from a's to the
    corner, from b's to the start of the edge, and the edge's direction.
    """
    m = block_a.size
    gap, coordinate = np.empty(m), np.empty(m)
    tangent, arm_a, arm_b = np.empty((m, 2)), np.empty((m, 2)), np.empty((m, 2))
    cosine, sine = np.cos(position[:, 2]), np.sin(position[:, 2])
    for k in range(m):
        a, b = block_a[k], block_b[k]
        ax = cosine[a] * geometry[k, 2] - sine[a] * geometry[k, 3]
        ay = sine[a] * geometry[k, 2] + cosine[a] * geometry[k, 3]
        tx = cosine[b] * geometry[k, 6] - sine[b] * geometry[k, 7]
        ty = sine[b] * geometry[k, 6] + cosine[b] * geometry[k, 7]
        rx = geometry[k, 0] + (position[a, 0] - position[b, 0]) + ax
        ry = geometry[k, 1] + (position[a, 1] - position[b, 1]) + ay
        dx = rx - (cosine[b] * geometry[k, 4] - sine[b] * geometry[k, 5])
        dy = ry - (sine[b] * geometry[k, 4] + cosine[b] * geometry[k, 5])
        gap[k] = dx * ty - dy * tx
        coordinate[k] = dx * tx + dy * ty
        tangent[k, 0], tangent[k, 1] = tx, ty
        arm_a[k, 0], arm_a[k, 1] = ax, ay
        arm_b[k, 0], arm_b[k, 1] = rx, ry
    return gap, coordinate, tangent, arm_a, arm_b


@njit()
def max_relative_movement(
    block_a: IntArray, block_b: IntArray, movement: FloatArray, size: FloatArray
) -> float:  # pragma: no cover - compiled
    """Return how far blocks that have a contact move past each other, at most [m].

    Blocks of a `size` (n,) [m] turn by that times the angle in their `movement` (n, 3).
    """
    farthest = 0.0
    for k in range(block_a.size):
        a, b = block_a[k], block_b[k]
        past = np.hypot(movement[a, 0] - movement[b, 0], movement[a, 1] - movement[b, 1])
        past += abs(movement[a, 2]) * size[a] + abs(movement[b, 2]) * size[b]
        farthest = max(farthest, past)
    return farthest


@njit(allocates=True)
def pressures_and_trial_shears(
    gap: FloatArray,
    tangential: FloatArray,
    offset: FloatArray,
    edge_length: FloatArray,
    edge_overhang: FloatArray,
    normal_stiffness: FloatArray,
    shear_stiffness: FloatArray,
    tension: FloatArray,
    old_tangential: FloatArray,
    old_shear: FloatArray,
) -> tuple[FloatArray, FloatArray, BoolArray, BoolArray]:  # pragma: no cover - compiled
    """Return pressure, trial shear, which contacts are closed, and which corners are over the edge, (m,) each.

    Open contacts have no pressure; those without history (`old_tangential` not a number) no shear.
    """
    m = gap.size
    pressure, trial = np.empty(m), np.empty(m)
    closed, in_range = np.empty(m, np.bool_), np.empty(m, np.bool_)
    for k in range(m):
        pressing = -normal_stiffness[k] * (gap[k] - offset[k])
        in_range[k] = (tangential[k] >= -edge_overhang[k]) & (tangential[k] <= edge_length[k] + edge_overhang[k])
        closed[k] = in_range[k] & (pressing >= -tension[k]) & ((pressing > 0.0) | (tension[k] > 0.0))
        pressure[k] = pressing if closed[k] else 0.0
        moved = tangential[k] - old_tangential[k]
        trial[k] = 0.0 if np.isnan(moved) else old_shear[k] + shear_stiffness[k] * moved
    return pressure, trial, closed, in_range


@njit()
def add_moving_forces(
    block_a: IntArray,
    block_b: IntArray,
    tangent: FloatArray,
    arm_a: FloatArray,
    arm_b: FloatArray,
    pressure: FloatArray,
    shear: FloatArray,
    total: FloatArray,
) -> None:  # pragma: no cover - compiled
    """Add force and moment of all contacts to `total` (n, 3). `shear` acts on a against the edge's direction."""
    for k in range(block_a.size):
        if pressure[k] == 0.0 and shear[k] == 0.0:
            continue
        a, b = block_a[k], block_b[k]
        tx, ty = tangent[k, 0], tangent[k, 1]
        fx = pressure[k] * ty - shear[k] * tx
        fy = -pressure[k] * tx - shear[k] * ty
        total[a, 0] += fx
        total[a, 1] += fy
        total[a, 2] += arm_a[k, 0] * fy - arm_a[k, 1] * fx
        total[b, 0] -= fx
        total[b, 1] -= fy
        total[b, 2] -= arm_b[k, 0] * fy - arm_b[k, 1] * fx


@njit(allocates=True)
def fill_tangent(
    places: IntArray,
    n_places: int,
    tangent: FloatArray,
    arm_a: FloatArray,
    arm_b: FloatArray,
    normal_stiffness: FloatArray,
    shear_by_gap: FloatArray,
    shear_stiffness: FloatArray,
    pressure: FloatArray,
    shear: FloatArray,
    pressure_by_along: FloatArray,
) -> FloatArray:  # pragma: no cover - compiled
    """Return the 3 x 3 blocks of the tangent of minus the contact forces, (n_places, 3, 3); not symmetric.

    ``d pressure = -normal_stiffness d gap + pressure_by_along d along`` and ``d shear = shear_by_gap d gap +
    shear_stiffness d along``. The turning of normal and arms under the forces (geometric stiffness) is included.

    Parameters
    ----------
    places : (m, 4) int32
        Places of the blocks aa, ab, ba, bb of every contact.
    pressure_by_along : (m,) float64 [N/m2]
        Of contacts that open as they slide; empty where there are none.
    """
    data = np.zeros((n_places, 3, 3))
    gn, gs, ds = np.empty(6), np.empty(6), np.empty(6)
    for k in range(places.shape[0]):
        kn, kg, ks = normal_stiffness[k], shear_by_gap[k], shear_stiffness[k]
        if kn == 0.0 and ks == 0.0 and kg == 0.0:
            continue
        tx, ty = tangent[k, 0], tangent[k, 1]
        nx, ny = ty, -tx
        ax, ay, rx, ry = arm_a[k, 0], arm_a[k, 1], arm_b[k, 0], arm_b[k, 1]
        gn[0], gn[1], gn[2] = nx, ny, ax * ny - ay * nx
        gn[3], gn[4], gn[5] = -nx, -ny, -(rx * ny - ry * nx)
        gs[0], gs[1], gs[2] = tx, ty, ax * ty - ay * tx
        gs[3], gs[4], gs[5] = -tx, -ty, -(rx * ty - ry * tx)
        for i in range(6):
            ds[i] = kg * gn[i] + ks * gs[i]
        for r in range(2):
            for s in range(2):
                place = places[k, 2 * r + s]
                for i in range(3):
                    for j in range(3):
                        data[place, i, j] += kn * gn[3 * r + i] * gn[3 * s + j] + gs[3 * r + i] * ds[3 * s + j]
        if pressure_by_along.size and pressure_by_along[k] != 0.0:
            _add_coupling(places[k], data, -pressure_by_along[k], gn, gs)
        if pressure[k] != 0.0 or shear[k] != 0.0:
            _add_geometric(places[k], data, -pressure[k], nx, ny, tx, ty, ax, ay, rx, ry)
            _add_geometric(places[k], data, shear[k], tx, ty, -nx, -ny, ax, ay, rx, ry)
    return data


@njit()
def _add_coupling(
    place: IntArray, data: FloatArray, factor: float, gn: FloatArray, gs: FloatArray
) -> None:  # pragma: no cover - compiled
    """Add a factor times the normal movement's gradient (6,) by the tangential one's, (6,)."""
    for r in range(2):
        for s in range(2):
            for i in range(3):
                for j in range(3):
                    data[place[2 * r + s], i, j] += factor * gn[3 * r + i] * gs[3 * s + j]


@njit()
def _add_geometric(
    place: IntArray,
    data: FloatArray,
    force: float,
    ux: float,
    uy: float,
    vx: float,
    vy: float,
    ax: float,
    ay: float,
    rx: float,
    ry: float,
) -> None:  # pragma: no cover - compiled
    """Add force times the second derivative of the coordinate along u, where du/d theta_b = v."""
    aa, ab, ba, bb = place[0], place[1], place[2], place[3]
    data[aa, 2, 2] -= force * (ax * ux + ay * uy)
    data[ab, 0, 2] += force * vx
    data[ab, 1, 2] += force * vy
    data[ba, 2, 0] += force * vx
    data[ba, 2, 1] += force * vy
    turn = force * (ax * vy - ay * vx)
    data[ab, 2, 2] += turn
    data[ba, 2, 2] += turn
    data[bb, 0, 2] -= force * vx
    data[bb, 1, 2] -= force * vy
    data[bb, 2, 0] -= force * vx
    data[bb, 2, 1] -= force * vy
    data[bb, 2, 2] -= force * (rx * ux + ry * uy)
