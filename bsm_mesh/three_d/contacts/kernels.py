"""Kernels of contact points in space: exact rotations, forces, tangent with geometric stiffness.

A contact is a point fixed to block a on a face fixed to block b. In b's frame the face's unit normal n points into a;
the force on a is ``pressure * n + shear``, its negative acts on b at the same point, so that moments balance.
"""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.compiled import njit


@njit(allocates=True)
def relative_positions(
    position: FloatArray, swing: FloatArray, block_a: IntArray, block_b: IntArray, geometry: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:  # pragma: no cover - compiled
    """Return the movement of points against their faces in b's frame, and both arms to them, (m, 3) each [m].

    Parameters
    ----------
    position : (n, 6) float64 [m, rad]
        Where blocks are.
    swing : (n, 3, 3) float64
        Rotation matrices less the unit matrix.
    block_a, block_b : (m,) int32
        Blocks of the point and of the face.
    geometry : (m, 12) float64 [m; -; m]
        In the given geometry: arms from a's and b's centroids to the point, normal, and from b's point to a's, which
        are one where the polygon is that of the given geometry.
    """
    m = block_a.size
    place, arm_a, arm_b = np.empty((m, 3)), np.empty((m, 3)), np.empty((m, 3))
    moved = np.empty(3)
    for k in range(m):
        a, b = block_a[k], block_b[k]
        for u in range(3):
            swung_a = (
                swing[a, u, 0] * geometry[k, 0] + swing[a, u, 1] * geometry[k, 1] + swing[a, u, 2] * geometry[k, 2]
            )
            swung_b = (
                swing[b, u, 0] * geometry[k, 3] + swing[b, u, 1] * geometry[k, 4] + swing[b, u, 2] * geometry[k, 5]
            )
            shift = geometry[k, 9 + u] + position[a, u] - position[b, u] + swung_a
            arm_a[k, u] = geometry[k, u] + swung_a
            arm_b[k, u] = geometry[k, 3 + u] + shift
            moved[u] = shift - swung_b
        for u in range(3):
            turned = swing[b, 0, u] * moved[0] + swing[b, 1, u] * moved[1] + swing[b, 2, u] * moved[2]
            place[k, u] = moved[u] + turned
    return place, arm_a, arm_b


@njit(allocates=True)
def add_forces(
    block_a: IntArray,
    block_b: IntArray,
    swing: FloatArray,
    arm_a: FloatArray,
    arm_b: FloatArray,
    geometry: FloatArray,
    pressure: FloatArray,
    shear: FloatArray,
    total: FloatArray,
) -> None:  # pragma: no cover - compiled
    """Add force and moment of all contacts to `total` (n, 6); `shear` (m, 3) acts on a, in b's frame."""
    own, force = np.empty(3), np.empty(3)
    for k in range(block_a.size):
        a, b = block_a[k], block_b[k]
        for u in range(3):
            own[u] = pressure[k] * geometry[k, 6 + u] + shear[k, u]
        if own[0] == 0.0 and own[1] == 0.0 and own[2] == 0.0:
            continue
        for u in range(3):
            force[u] = own[u] + swing[b, u, 0] * own[0] + swing[b, u, 1] * own[1] + swing[b, u, 2] * own[2]
        for u in range(3):
            v, w = (u + 1) % 3, (u + 2) % 3
            total[a, u] += force[u]
            total[b, u] -= force[u]
            total[a, 3 + u] += arm_a[k, v] * force[w] - arm_a[k, w] * force[v]
            total[b, 3 + u] -= arm_b[k, v] * force[w] - arm_b[k, w] * force[v]


@njit(allocates=True)
def fill_tangent(
    places: IntArray,
    n_places: int,
    block_b: IntArray,
    swing: FloatArray,
    arm_a: FloatArray,
    arm_b: FloatArray,
    geometry: FloatArray,
    stiffness: FloatArray,
    way: FloatArray,
    pressure: FloatArray,
    shear: FloatArray,
) -> FloatArray:  # pragma: no cover - compiled
    """Return the 6 x 6 blocks of the tangent of minus the contact forces, (n_places, 6, 6); not symmetric.

    Parameters
    ----------
    places : (m, 4) int32
        Places of the blocks aa, ab, ba, bb of every contact.
    stiffness : (m, 5) float64 [N/m]
        Of the pressure by the gap; of the shear across the way of slip, along it, and along it by the gap; of the
        pressure by slip that opens.
    way : (m, 3) float64
        Unit direction of the shear force in b's frame; zero where it does not slip.
    pressure, shear : (m,), (m, 3) float64 [N]
        Their turning with face and arms (geometric stiffness) is included.
    """
    data = np.zeros((n_places, 6, 6))
    local, half, turned, force = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3)), np.empty(3)
    by_a, by_b, spin = np.empty((3, 6)), np.empty((3, 6)), np.zeros((3, 3))
    for k in range(places.shape[0]):
        kn, across, along, coupled, opening = stiffness[k]
        if kn == 0.0 and across == 0.0 and along == 0.0:
            continue
        b, n, t = block_b[k], geometry[k, 6:9], way[k]
        for u in range(3):
            for v in range(3):
                local[u, v] = kn * n[u] * n[v] - across * n[u] * n[v] - (across - along) * t[u] * t[v]
                local[u, v] += coupled * t[u] * n[v] + opening * n[u] * t[v]
            local[u, u] += across
            force[u] = pressure[k] * n[u] + shear[k, u]
        _turn(local, swing[b], half, turned)
        _turn_vector(force, swing[b])
        _set_spin(force, spin)
        _set_derivatives(turned, spin, arm_a[k], arm_b[k], by_a, by_b)
        _add_rows(data[places[k, 0]], by_a, arm_a[k], 1.0)
        _add_rows(data[places[k, 1]], by_b, arm_a[k], 1.0)
        _add_rows(data[places[k, 2]], by_a, arm_b[k], -1.0)
        _add_rows(data[places[k, 3]], by_b, arm_b[k], -1.0)
        _add_arms(data, places[k], spin, arm_a[k])
    return data


@njit()
def _turn(
    local: FloatArray, swing: FloatArray, half: FloatArray, turned: FloatArray
) -> None:  # pragma: no cover - compiled
    """Set `turned` (3, 3) to a matrix of b's frame in the model's axes; `half` (3, 3) is room."""
    for u in range(3):
        for v in range(3):
            half[u, v] = local[u, v]
            for w in range(3):
                half[u, v] += swing[u, w] * local[w, v]
    for u in range(3):
        for v in range(3):
            turned[u, v] = half[u, v]
            for w in range(3):
                turned[u, v] += half[u, w] * swing[v, w]


@njit()
def _turn_vector(force: FloatArray, swing: FloatArray) -> None:  # pragma: no cover - compiled
    x, y, z = force
    for u in range(3):
        force[u] += swing[u, 0] * x + swing[u, 1] * y + swing[u, 2] * z


@njit()
def _set_spin(vector: FloatArray, spin: FloatArray) -> None:  # pragma: no cover - compiled
    """Set the matrix whose product with another vector is `vector` x that one."""
    x, y, z = vector
    spin[0, 1], spin[0, 2], spin[1, 0], spin[1, 2], spin[2, 0], spin[2, 1] = -z, y, z, -x, -y, x


@njit()
def _set_derivatives(
    stiffness: FloatArray, force: FloatArray, arm_a: FloatArray, arm_b: FloatArray, by_a: FloatArray, by_b: FloatArray
) -> None:  # pragma: no cover - compiled
    """Set the derivatives (3, 6) of minus the force on a by the movements of both blocks.

    The point moves against the face by ``da + turn_a x arm_a - db - turn_b x arm_b``; the force turns with b: `force`
    is its matrix of `_set_spin`.
    """
    for u in range(3):
        for v in range(3):
            by_a[u, v], by_b[u, v] = stiffness[u, v], -stiffness[u, v]
            p, q = (v + 1) % 3, (v + 2) % 3  # column v of turn x arm: the unit vector v times the arm
            by_a[u, 3 + v] = stiffness[u, q] * arm_a[p] - stiffness[u, p] * arm_a[q]
            by_b[u, 3 + v] = stiffness[u, p] * arm_b[q] - stiffness[u, q] * arm_b[p] + force[u, v]


@njit()
def _add_rows(
    block: FloatArray, change: FloatArray, arm: FloatArray, sign: float
) -> None:  # pragma: no cover - compiled
    """Add a change of force (3, 6), and its moment by an arm, to a block (6, 6)."""
    for v in range(6):
        for u in range(3):
            p, q = (u + 1) % 3, (u + 2) % 3
            block[u, v] += sign * change[u, v]
            block[3 + u, v] += sign * (arm[p] * change[q, v] - arm[q] * change[p, v])


@njit()
def _add_arms(
    data: FloatArray, place: IntArray, force: FloatArray, arm_a: FloatArray
) -> None:  # pragma: no cover - compiled
    """Add the change of both moments by the movement of the point; `force` (3, 3) is the matrix of `_set_spin`.

    The arm from a turns with a; that from b changes by ``da + turn_a x arm_a - db``.
    """
    for u in range(3):
        for v in range(3):
            p, q = (v + 1) % 3, (v + 2) % 3
            turning = force[u, q] * arm_a[p] - force[u, p] * arm_a[q]  # force x (turn_a x arm_a)
            data[place[0], 3 + u, 3 + v] += turning
            data[place[2], 3 + u, 3 + v] -= turning
            data[place[2], 3 + u, v] -= force[u, v]
            data[place[3], 3 + u, v] += force[u, v]


@njit()
def max_relative_movement(
    block_a: IntArray, block_b: IntArray, movement: FloatArray, size: FloatArray
) -> float:  # pragma: no cover - compiled
    """Return how far blocks that touch move past each other, at most [m]; turns count by their `size` (n,)."""
    farthest = 0.0
    for k in range(block_a.size):
        a, b = block_a[k], block_b[k]
        shift, turn_a, turn_b = 0.0, 0.0, 0.0
        for u in range(3):
            shift += (movement[a, u] - movement[b, u]) ** 2
            turn_a += movement[a, 3 + u] ** 2
            turn_b += movement[b, 3 + u] ** 2
        farthest = max(farthest, np.sqrt(shift) + np.sqrt(turn_a) * size[a] + np.sqrt(turn_b) * size[b])
    return farthest
