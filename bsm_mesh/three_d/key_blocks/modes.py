"""How single blocks move between planes (Goodman & Shi 1985), many blocks at a time.

A block is bounded by planes with unit normals into it; rows of fewer planes, two at least, are
filled up with zeros. A movement s is
possible where ``normal @ s >= 0`` for all of them: the block leaves its planes or slides along them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray

PARALLEL = 1e-6  # rad: planes that differ by less are parallel
CHUNK = 2_000_000  # numbers in an array of directions by planes
HELD, STAYS, FALLS, ONE, TWO, NOT_JUDGED = range(6)  # the last: it reaches a side, and the rock beyond is unknown
MODES = ("not removable", "stays", "falls", "slides on one plane", "slides on two planes", "not judged")


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Movement:
    """How blocks move under a load.

    Attributes
    ----------
    mode : (n,) int8
        Number of the mode in `MODES`.
    direction : (n, 3) float64
        Unit vector of the movement; zero where there is none.
    planes : (n, 2) int32
        The planes on which it slides, -1 for none.
    normal_force : (n, 2) float64 [N]
        Effective forces on them, compression positive.
    driving : (n,) float64 [N]
        Part of the load along the movement.
    """

    mode: IntArray
    direction: FloatArray
    planes: IntArray
    normal_force: FloatArray
    driving: FloatArray


def removable(normals: FloatArray) -> BoolArray:
    """Return which blocks can move at all: whether their joint pyramid holds a direction.

    A cone of directions that is not empty holds the line of two planes, a direction straight off one, or, of parallel
    planes, one along them.

    Parameters
    ----------
    normals : (n, k, 3) float64
        Normals of the planes, into the blocks; zeros where there are fewer.
    """
    found = np.zeros(len(normals), dtype=bool)
    for rows in _chunks(normals):
        part = normals[rows]
        lines = _lines(part)
        axes = np.broadcast_to(np.concatenate([np.eye(3), -np.eye(3)]), (len(part), 6, 3))  # of no plane at all
        along = np.cross(part[:, :1], axes)  # of parallel planes alone
        candidates = np.concatenate([lines, -lines, part, along, axes], axis=1)
        found[rows] = _possible(part, candidates).any(axis=1)
    return found


def movements(normals: FloatArray, load: FloatArray) -> Movement:
    """Return how blocks move under loads (n, 3) [N]: they fall, slide on one plane or on two, or stay.

    Friction plays no part: it decides the factor, not the mode. Blocks that stay may be removable: their load presses
    them on.
    """
    count = len(normals)
    mode, direction = np.full(count, STAYS, np.int8), np.zeros((count, 3))
    planes, force = np.full((count, 2), -1, np.int32), np.zeros((count, 2))
    size = np.linalg.norm(load, axis=1)
    for rows in _chunks(normals):
        part, unit = normals[rows], load[rows] / np.maximum(size[rows], 1e-300)[:, None]
        for found, along, on, reaction in (_two(part, unit), _one(part, unit), _fall(part, unit)):
            chosen, local = rows[found], np.flatnonzero(found)
            mode[chosen] = TWO if on.shape[1] == 2 else ONE if on.shape[1] else FALLS
            direction[chosen], planes[chosen], force[chosen] = along[local], -1, 0
            planes[chosen, : on.shape[1]] = on[local]
            force[chosen, : on.shape[1]] = reaction[local] * size[chosen, None]
    mode[size == 0] = STAYS
    return Movement(
        mode=mode,
        direction=direction,
        planes=planes,
        normal_force=force,
        driving=np.einsum("ij,ij->i", load, direction),
    )


Found = tuple[BoolArray, FloatArray, IntArray, FloatArray]  # which blocks, direction, planes, reactions


def _fall(normals: FloatArray, unit: FloatArray) -> Found:
    found = _possible(normals, unit[:, None])[:, 0]
    return found, unit, np.empty((len(unit), 0), np.int32), np.empty((len(unit), 0))


def _one(normals: FloatArray, unit: FloatArray) -> Found:
    """Sliding on the plane along which the load, less its part across it, is possible."""
    across = np.einsum("nkj,nj->nk", normals, unit)
    along = unit[:, None] - across[:, :, None] * normals
    length = np.linalg.norm(along, axis=2)
    along = along / np.maximum(length, 1e-300)[:, :, None]
    possible = _possible(normals, along) & (across < -PARALLEL) & (length > PARALLEL)
    plane = np.argmax(possible, axis=1)
    rows = np.arange(len(plane))
    return possible.any(axis=1), along[rows, plane], plane[:, None], -across[rows, plane][:, None]


def _two(normals: FloatArray, unit: FloatArray) -> Found:
    """Sliding along the line of two planes that the load, less its part along the line, presses on."""
    first, second = np.triu_indices(normals.shape[1], 1)
    lines = _lines(normals)
    lines = lines * np.where(np.einsum("npj,nj->np", lines, unit) < 0, -1.0, 1.0)[:, :, None]
    along = np.einsum("npj,nj->np", lines, unit)
    one, other = normals[:, first], normals[:, second]
    cosine = np.einsum("npj,npj->np", one, other)
    on_one, on_other = (-np.einsum("npj,nj->np", n, unit) for n in (one, other))  # the line is across both normals
    sine = np.maximum(1 - cosine**2, 1e-300)
    reaction = np.stack([on_one - cosine * on_other, on_other - cosine * on_one], axis=2) / sine[:, :, None]
    there = np.linalg.norm(lines, axis=2) > 0
    possible = _possible(normals, lines) & there & (along > PARALLEL) & (reaction > -PARALLEL).all(axis=2)
    pair = np.argmax(possible, axis=1)
    rows = np.arange(len(pair))
    on = np.stack([first[pair], second[pair]], axis=1)
    return possible.any(axis=1), lines[rows, pair], on, np.maximum(reaction[rows, pair], 0.0)


def _lines(normals: FloatArray) -> FloatArray:
    """Return the unit vectors along which every two planes meet, (n, pairs, 3); zero where they are parallel."""
    first, second = np.triu_indices(normals.shape[1], 1)
    line = np.cross(normals[:, first], normals[:, second])
    length = np.linalg.norm(line, axis=2, keepdims=True)
    return np.where(length > PARALLEL, line / np.maximum(length, 1e-300), 0.0)


def _possible(normals: FloatArray, directions: FloatArray) -> BoolArray:
    """Return which directions (n, d, 3) of every block are possible, and are any."""
    least = np.einsum("ndj,nkj->ndk", directions, normals).min(axis=2)
    possible: BoolArray = (least > -PARALLEL) & (np.abs(directions).max(axis=2) > 0)
    return possible


def _chunks(normals: FloatArray) -> list[IntArray]:
    """Return blocks in parts of which the directions by planes fit in memory."""
    count, planes = normals.shape[:2]
    size = max(1, CHUNK // max(1, planes**3))
    return [np.arange(k, min(k + size, count)) for k in range(0, count, size)]
