"""Movements of rigid blocks: translation, rotation, distance, and the points that blocks carry with them.

A movement has three numbers a block in the plane (u, v, theta) and six in space: three displacements and a rotation
vector, whose length is the angle. This is the one place that reads the kind from the number of columns.
"""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray

PLANE = 3  # columns of a movement in the plane
MOVES = 1e-6  # of the greatest velocity in a mechanism


def translations(movement: FloatArray) -> FloatArray:
    """Return the displacements of centroids, (n, 2) or (n, 3) [m]."""
    return movement[:, :2] if movement.shape[1] == PLANE else movement[:, :3]


def turns(movement: FloatArray) -> FloatArray:
    """Return the angles (n,), in space the rotation vectors (n, 3) [rad]."""
    return movement[:, 2] if movement.shape[1] == PLANE else movement[:, 3:]


def distances(movement: FloatArray) -> FloatArray:
    """Return how far centroids are displaced, (n,) [m]."""
    return lengths(translations(movement))


def angles(movement: FloatArray) -> FloatArray:
    """Return how far blocks have turned, either way, (n,) [rad]."""
    found: FloatArray = np.abs(movement[:, 2]) if movement.shape[1] == PLANE else lengths(turns(movement))
    return found


def in_mechanism(velocity: FloatArray, gyration: FloatArray) -> BoolArray:
    """Return the blocks that move in a mechanism, (n,), of velocities (n, k) and radii of gyration (n,) [m]."""
    moves: BoolArray = np.maximum(distances(velocity), angles(velocity) * gyration) > MOVES
    return moves


def lengths(vectors: FloatArray) -> FloatArray:
    """Return the lengths (n,) of vectors (n, 2) or (n, 3)."""
    found: FloatArray = np.hypot(vectors[:, 0], vectors[:, 1])
    return found if vectors.shape[1] == 2 else np.hypot(found, vectors[:, 2])


def turned(vectors: FloatArray, turn: FloatArray | float) -> FloatArray:
    """Return vectors (k, 2) turned counter-clockwise by angles, or (k, 3) by rotation vectors (k, 3) [rad]."""
    if vectors.shape[1] == 2:
        cosine, sine = np.cos(turn), np.sin(turn)
        x, y = vectors.T
        return np.stack([cosine * x - sine * y, sine * x + cosine * y], axis=1)
    return vectors + _swing(vectors, np.asarray(turn, dtype=float))


def carried(arm: FloatArray, movement: FloatArray) -> FloatArray:
    """Return the displacements (k, 2) or (k, 3) [m] of points of moved blocks, by exact rotation about the centroid.

    Parameters
    ----------
    arm : (k, 2) or (k, 3) float64 [m]
        From the centroid to each point, in the given geometry.
    movement : (k, 3) or (k, 6) float64 [m, rad]
        Of each point's block.
    """
    if arm.shape[1] > 2:
        return translations(movement) + _swing(arm, turns(movement))
    x, y = arm.T
    u, v, theta = movement.T
    versed, sine = -2 * np.sin(theta / 2) ** 2, np.sin(theta)  # cos(theta) - 1 without loss of digits
    return np.stack([u + versed * x - sine * y, v + sine * x + versed * y], axis=1)


def by_movement(arm: FloatArray) -> FloatArray:
    """Return the derivatives of places `carried` by the movements of blocks, (k, 2, 3) or (k, 3, 6); arms as turned."""
    count, axes = arm.shape
    along = np.broadcast_to(np.eye(axes), (count, axes, axes))
    if axes == 2:
        round_centroid = np.stack([-arm[:, 1], arm[:, 0]], axis=1)[:, :, None]
    else:
        round_centroid = np.stack([cross(np.broadcast_to(unit, arm.shape), arm) for unit in np.eye(axes)], axis=2)
    return np.concatenate([along, round_centroid], axis=2)


def cross(one: FloatArray, other: FloatArray) -> FloatArray:
    """Return the vector products of vectors (k, 3); NumPy's own takes many times as long for few."""
    x, y, z = one.T
    a, b, c = other.T
    product: FloatArray = np.stack([y * c - z * b, z * a - x * c, x * b - y * a], axis=1)
    return product


def _swing(vectors: FloatArray, turn: FloatArray) -> FloatArray:
    """Return the change of vectors (k, 3) by rotation vectors (k, 3), without loss of digits (Rodrigues)."""
    angle = np.linalg.norm(turn, axis=1)[:, None]
    sine, versed = np.sinc(angle / np.pi), np.sinc(angle / (2 * np.pi)) ** 2 / 2
    across = cross(turn, vectors)
    swing: FloatArray = sine * across + versed * cross(turn, across)
    return swing
