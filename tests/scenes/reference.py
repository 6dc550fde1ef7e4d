"""Slow, obvious solutions that compiled ones are compared with: common faces, and joints by dense matrices."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

import bsm_mesh as bsm
from bsm_mesh.solve.algebra.block_matrix import BlockPattern


@dataclass
class Reference:
    """A model solved with dense matrices and Lagrange multipliers."""

    K: np.ndarray
    displacement: np.ndarray
    reactions: np.ndarray
    face_forces: dict[tuple[int, int], np.ndarray]


def corner_row(centroid: np.ndarray, point: np.ndarray, direction: np.ndarray) -> np.ndarray:
    """Return the row that turns (u, v, theta) into the displacement of a point in a direction (Wang Eq. 3.6)."""
    x, y = point - centroid
    return np.array([direction[0], direction[1], x * direction[1] - y * direction[0]])


def brute_faces(polygons: Sequence[np.ndarray]) -> list[tuple[int, int, np.ndarray, np.ndarray]]:
    """Return (i, j, start, end) of all common parts of edges, by comparing every edge with every other."""
    found = []
    for i, p in enumerate(polygons):
        for j in range(i + 1, len(polygons)):
            q = polygons[j]
            for a0, a1 in zip(p, np.roll(p, -1, axis=0), strict=True):
                for b0, b1 in zip(q, np.roll(q, -1, axis=0), strict=True):
                    length = np.hypot(*(a1 - a0))
                    t = (a1 - a0) / length
                    n = np.array([t[1], -t[0]])
                    if max(abs((b0 - a0) @ n), abs((b1 - a0) @ n)) > 1e-6 or (b1 - b0) @ t > 0:
                        continue
                    low, high = max(0.0, (b1 - a0) @ t), min(length, (b0 - a0) @ t)
                    if high - low > 1e-6:
                        found.append((i, j, a0 + low * t, a0 + high * t))
    return found


def dense_solution(
    polygons: Sequence[np.ndarray],
    stiffness: tuple[float, float],
    loads: np.ndarray,
    bars: Sequence[tuple[int, np.ndarray, float, float]],
) -> Reference:
    """Solve rigid blocks on joints; bars are (block, point, degrees, displacement)."""
    blocks = bsm.Blocks.from_polygons(polygons, rock="any")
    centroid, n = blocks.moments.centroid, 3 * len(polygons)
    K = np.zeros((n, n))
    springs = []
    for i, j, start, end in brute_faces(polygons):
        length = np.hypot(*(end - start))
        t = (end - start) / length
        for point in (start, end):
            for k, d in zip(stiffness, (np.array([t[1], -t[0]]), t), strict=True):
                row = np.zeros(n)
                row[3 * i : 3 * i + 3] = -corner_row(centroid[i], point, d)
                row[3 * j : 3 * j + 3] = corner_row(centroid[j], point, d)
                K += k * length / 2 * np.outer(row, row)
                springs.append((i, j, k * length / 2, row, d))
    C, w = np.zeros((len(bars), n)), np.zeros(len(bars))
    for r, (block, point, degrees, displacement) in enumerate(bars):
        direction = np.array([np.cos(np.radians(degrees)), np.sin(np.radians(degrees))])
        C[r, 3 * block : 3 * block + 3] = corner_row(centroid[block], np.asarray(point), direction)
        w[r] = displacement
    scale = K.diagonal().mean()  # keeps the two halves of the saddle point of one size
    system = np.block([[K / scale, C.T], [C, np.zeros((len(bars), len(bars)))]])
    right = np.concatenate([loads.reshape(-1) / scale, w])
    solution = np.linalg.lstsq(system, right, rcond=1e-13)[0]
    solution += np.linalg.lstsq(system, right - system @ solution, rcond=1e-13)[0]
    U = solution[:n]
    forces: dict[tuple[int, int], np.ndarray] = {}
    for i, j, k, row, d in springs:
        forces[i, j] = forces.get((i, j), np.zeros(2)) + k * (row @ U) * d  # on block i
    reactions = -(C.T @ solution[n:]).reshape(-1, 3) * scale
    return Reference(K=K, displacement=U.reshape(-1, 3), reactions=reactions, face_forces=forces)


def face_forces(contacts: bsm.results.ContactForces) -> dict[tuple[int, int], np.ndarray]:
    """Return the sum of the contact forces on the lower-numbered block of every pair of blocks."""
    forces: dict[tuple[int, int], np.ndarray] = {}
    for a, b, force in zip(contacts.block_a, contacts.block_b, contacts.force, strict=True):
        pair, sign = ((int(b), int(a)), 1.0) if b < a else ((int(a), int(b)), -1.0)
        forces[pair] = forces.get(pair, np.zeros(2)) + sign * force
    return forces


def full_matrix(pattern: BlockPattern, data: np.ndarray) -> np.ndarray:
    """Return the full matrix of blocks (n, 3, 3); of a symmetric pattern the lower triangle is that above."""
    full = np.zeros((3 * pattern.rows, 3 * pattern.rows))
    for i in range(pattern.rows):
        for p in range(pattern.row_start[i], pattern.row_start[i + 1]):
            j = pattern.column[p]
            full[3 * i : 3 * i + 3, 3 * j : 3 * j + 3] = data[p]
            if pattern.symmetric and i != j:
                full[3 * j : 3 * j + 3, 3 * i : 3 * i + 3] = data[p].T
    return full
