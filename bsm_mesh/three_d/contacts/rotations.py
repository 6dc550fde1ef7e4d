"""Finite rotations of blocks: rotation vectors, matrices, and movements about instant axes.

A rotation vector has the axis as its direction and the angle as its length. It is followed continuously: beyond half a
turn the length goes on growing.
"""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.compiled import njit
from bsm_mesh.movements import cross

SMALL = 1e-4  # rad: below, sums of series are exact to rounding, and quotients of differences are not


@njit(allocates=True)
def swings(turn: FloatArray) -> FloatArray:  # pragma: no cover - compiled
    """Return rotation matrices of rotation vectors (n, 3), less the unit matrix, (n, 3, 3): exact for small ones."""
    found = np.empty((turn.shape[0], 3, 3))
    for i in range(turn.shape[0]):
        x, y, z = turn[i, 0], turn[i, 1], turn[i, 2]
        square = x * x + y * y + z * z
        angle = np.sqrt(square)
        if angle < SMALL:
            s, v = 1.0 - square / 6.0, 0.5 - square / 24.0
        else:
            s, v = np.sin(angle) / angle, 2.0 * (np.sin(angle / 2.0) / angle) ** 2
        found[i, 0, 0], found[i, 1, 1], found[i, 2, 2] = (
            -v * (y * y + z * z),
            -v * (x * x + z * z),
            -v * (x * x + y * y),
        )
        found[i, 0, 1], found[i, 1, 0] = v * x * y - s * z, v * x * y + s * z
        found[i, 0, 2], found[i, 2, 0] = v * x * z + s * y, v * x * z - s * y
        found[i, 1, 2], found[i, 2, 1] = v * y * z - s * x, v * y * z + s * x
    return found


def turned_on(turn: FloatArray, increment: FloatArray) -> FloatArray:
    """Return the rotation vectors (n, 3) after rotations `turn` and then `increment`, followed from `turn`."""
    return _vectors(*_product(_quaternions(increment), _quaternions(turn)), turn)


def turns_of(before: FloatArray, after: FloatArray) -> FloatArray:
    """Return the rotation vectors (n, 3) from rotation matrices less the unit matrix to others, (n, 3, 3) each.

    Rotations of less than half a turn.
    """
    change = after - before
    turn = change + np.einsum("kij,klj->kil", change, before)  # (after - before) times before's transpose
    axis = (
        np.stack([turn[:, 2, 1] - turn[:, 1, 2], turn[:, 0, 2] - turn[:, 2, 0], turn[:, 1, 0] - turn[:, 0, 1]], axis=1)
        / 2
    )
    sine = np.linalg.norm(axis, axis=1)
    cosine = 1 + np.trace(turn, axis1=1, axis2=2) / 2
    angle = np.arctan2(sine, cosine)
    found: FloatArray = axis * np.where(sine > 0, angle / np.where(sine > 0, sine, 1.0), 1.0)[:, None]
    return found


def moved_by(position: FloatArray, movement: FloatArray) -> FloatArray:
    """Return positions (n, 6) after a finite movement (n, 6) about instant axes: the exponential map of SE(3).

    A block that rotates about a stiff corner keeps the corner in place, as in the plane.
    """
    shift, turn = movement[:, :3], movement[:, 3:]
    first, second = _screw(turn)
    across = cross(turn, shift)
    shifted = position[:, :3] + shift + first * across + second * cross(turn, across)
    return np.hstack([shifted, turned_on(position[:, 3:], turn)])


def movement_between(position: FloatArray, other: FloatArray) -> FloatArray:
    """Return the finite movement (n, 6) from one position to another: `moved_by` backwards."""
    nearest = np.zeros((len(position), 3))
    turn = _vectors(*_product(_quaternions(other[:, 3:]), _quaternions(-position[:, 3:])), nearest)
    shift = other[:, :3] - position[:, :3]
    angle = np.linalg.norm(turn, axis=1)[:, None]
    half = np.where(angle > SMALL, angle / 2, 1.0)
    factor = np.where(angle > SMALL, (1 - half / np.tan(half)) / (4 * half**2), 1 / 12)
    across = cross(turn, shift)
    return np.hstack([shift - across / 2 + factor * cross(turn, across), turn])


def _screw(turn: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return (1 - cos a) / a^2 and (a - sin a) / a^3 of the angles a of rotation vectors (n, 3), (n, 1) each."""
    angle = np.linalg.norm(turn, axis=1)[:, None]
    large = np.where(angle > SMALL, angle, 1.0)
    first = np.where(angle > SMALL, 2 * (np.sin(large / 2) / large) ** 2, 0.5)
    return first, np.where(angle > SMALL, (large - np.sin(large)) / large**3, 1 / 6)


def _quaternions(turn: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the scalar (n, 1) and vector (n, 3) parts of unit quaternions."""
    half = np.linalg.norm(turn, axis=1)[:, None] / 2
    return np.cos(half), turn * np.sinc(half / np.pi) / 2


def _product(one: tuple[FloatArray, FloatArray], other: tuple[FloatArray, FloatArray]) -> tuple[FloatArray, FloatArray]:
    (s, v), (t, w) = one, other
    return s * t - (v * w).sum(axis=1)[:, None], s * w + t * v + cross(v, w)


def _vectors(scalar: FloatArray, vector: FloatArray, near: FloatArray) -> FloatArray:
    """Return the rotation vectors (n, 3) of unit quaternions, of those a whole turn apart the nearest to `near`."""
    size = np.linalg.norm(vector, axis=1)[:, None]
    length = np.linalg.norm(near, axis=1)[:, None]
    axis = np.where(size > 0, vector / np.where(size > 0, size, 1.0), near / np.where(length > 0, length, 1.0))
    angle = 2 * np.arctan2(size, scalar)
    whole = np.round(((axis * near).sum(axis=1)[:, None] - angle) / (2 * np.pi))
    found: FloatArray = axis * (angle + 2 * np.pi * whole)
    return found
