"""Kernels of water under a table: forces of linear heads on faces, and their change as the faces move (Wang ch. 6)."""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.compiled import njit


@njit()
def pieces_above(x0: float, dx: float, breaks: FloatArray) -> tuple[int, int]:  # pragma: no cover - compiled
    """Return the first and the last straight piece of the table above a face from x0 to x0 + dx."""
    low, high = min(x0, x0 + dx), max(x0, x0 + dx)
    first, last = int(np.searchsorted(breaks, low, side="right")), int(np.searchsorted(breaks, high, side="left"))
    return first, max(first, last)


@njit()
def wet_part(
    face: tuple[float, float, float, float],
    piece: int,
    ends: tuple[int, int],
    breaks: FloatArray,
    level: FloatArray,
    slope: FloatArray,
) -> tuple[float, float, float, float]:  # pragma: no cover - compiled
    """Return where a face's wet part under a piece of the table begins and ends, and the heads there [m].

    Parameters
    ----------
    face : tuple of float [m]
        Its start x0, y0, and dx, dy from there to its end; a part runs from 0 to 1 along it.
    piece : int
        The piece.
    ends : (int, int)
        As from `pieces_above`.
    breaks, level, slope : float64
        As in `WaterSurface`.
    """
    x0, y0, dx, dy = face
    first, last = ends
    t0, t1 = 0.0, 1.0
    if level[piece] == -np.inf:
        return 0.0, 0.0, 0.0, 0.0
    if first < last:
        if piece > first:
            t = (breaks[piece - 1] - x0) / dx
            t0, t1 = (t, t1) if dx > 0 else (t0, t)
        if piece < last:
            t = (breaks[piece] - x0) / dx
            t0, t1 = (t0, t) if dx > 0 else (t, t1)
    head = level[piece] + slope[piece] * x0 - y0  # head at t: head + rise * t
    rise = slope[piece] * dx - dy
    h0, h1 = head + rise * t0, head + rise * t1
    if h0 <= 0.0 and h1 <= 0.0:
        return 0.0, 0.0, 0.0, 0.0
    if h0 < 0.0 or h1 < 0.0:  # one end is dry: only the wet length counts (Wang Eq. 6.5)
        t = t0 + (t1 - t0) * h0 / (h0 - h1)
        t0, t1, h0, h1 = (t, t1, 0.0, h1) if h0 < 0.0 else (t0, t, h0, 0.0)
    return t0, t1, h0, h1


@njit(allocates=True)
def end_forces(
    start: FloatArray,
    end: FloatArray,
    breaks: FloatArray,
    level: FloatArray,
    slope: FloatArray,
    factor: FloatArray,
    unit_weight: float,
) -> FloatArray:  # pragma: no cover - compiled
    """Return the two forces at the ends of every face with resultant and moment of its water pressure, (k, 2) [N/m].

    With t running from 0 to 1 along a face of length l, they are ``l * integral of q (1 - t)`` and ``l * integral of
    q t``. For q linear from q1 to q2 these are Wang's Eq. 6.2; where one end is dry, his Eqs. 6.3-6.5.

    Parameters
    ----------
    start, end : (k, 2) float64 [m]
        Ends of the faces.
    breaks, level, slope, factor : float64
        As in `WaterSurface`.
    unit_weight : float [N/m3]
        Of the water.
    """
    forces = np.zeros((start.shape[0], 2))
    for k in range(start.shape[0]):
        dx, dy = end[k, 0] - start[k, 0], end[k, 1] - start[k, 1]
        face, length = (start[k, 0], start[k, 1], dx, dy), np.hypot(dx, dy)
        ends = pieces_above(face[0], dx, breaks)
        for piece in range(ends[0], ends[1] + 1):
            t0, t1, h0, h1 = wet_part(face, piece, ends, breaks, level, slope)
            scale = unit_weight * factor[piece] * length * (t1 - t0)
            total = scale * (h0 + h1) / 2
            moment = t0 * total + scale * (t1 - t0) * (h0 + 2 * h1) / 6
            forces[k, 0] += total - moment
            forces[k, 1] += moment
    return forces


@njit()
def add_face_forces(
    block: IntArray, start: FloatArray, end: FloatArray, centroid: FloatArray, ends: FloatArray, total: FloatArray
) -> None:  # pragma: no cover - compiled
    """Add force and moment of pressures on faces of blocks, from their `end_forces`, to `total` (n, 3).

    The block lies to the left of each face; the pressure acts into it (Wang Eqs. 6.6, 6.7).
    """
    for k in range(block.size):
        b = block[k]
        dx, dy = end[k, 0] - start[k, 0], end[k, 1] - start[k, 1]
        length = np.hypot(dx, dy)
        for side in range(2):
            x, y = (end[k, 0], end[k, 1]) if side else (start[k, 0], start[k, 1])
            fx, fy = -ends[k, side] * dy / length, ends[k, side] * dx / length
            total[b, 0] += fx
            total[b, 1] += fy
            total[b, 2] += (x - centroid[b, 0]) * fy - (y - centroid[b, 1]) * fx


@njit()
def add_field_change(
    block: IntArray,
    start: FloatArray,
    end: FloatArray,
    centroid: FloatArray,
    breaks: FloatArray,
    level: FloatArray,
    slope: FloatArray,
    factor: FloatArray,
    unit_weight: float,
    share: float,
    total: FloatArray,
) -> None:  # pragma: no cover - compiled
    """Add `share` times what forces and moments of the faces change by as their blocks move, to `total` (n, 3, 3).

    Faces keep their direction here: each of their points goes where the table presses otherwise. A unit pressure on a
    face d at the arm r has the force and moment N = (-dy, dx, r.d). A movement changes the pressure by G = (g, r x g),
    g its gradient. The change is the integral of N G^T over t, of degree 2, for which Simpson's rule is exact.
    Where the pressure jumps from one piece of the table to the next, the jump moves along the face.

    Parameters
    ----------
    block : (k,) int32
        Block of every face.
    start, end : (k, 2) float64 [m]
        Ends of the faces.
    centroid : (n, 2) float64 [m]
        Of the blocks.
    breaks, level, slope, factor, unit_weight : as in `end_forces`
        The table.
    share : float
        1, or -1 where something else presses instead.
    total : (n, 3, 3) float64
        Forces by movements of each block.
    """
    for k in range(block.size):
        b, change = block[k], total[block[k]]
        dx, dy = end[k, 0] - start[k, 0], end[k, 1] - start[k, 1]
        face = (start[k, 0], start[k, 1], dx, dy)
        rx, ry = face[0] - centroid[b, 0], face[1] - centroid[b, 1]
        ends = pieces_above(face[0], dx, breaks)
        for piece in range(ends[0], ends[1] + 1):
            t0, t1, _, _ = wet_part(face, piece, ends, breaks, level, slope)
            per_head = share * unit_weight * factor[piece]
            for t, weight in ((t0, 1 / 6), ((t0 + t1) / 2, 2 / 3), (t1, 1 / 6)):
                gradient = (per_head * slope[piece], -per_head) if t1 > t0 else (0.0, 0.0)
                _add_product(change, (rx + t * dx, ry + t * dy), (dx, dy), gradient, weight * (t1 - t0))
            if piece == ends[1]:
                continue
            t, x = (breaks[piece] - face[0]) / dx, breaks[piece]
            y = face[1] + t * dy
            jump = factor[piece + 1] * max(level[piece + 1] + slope[piece + 1] * x - y, 0.0)
            jump -= factor[piece] * max(level[piece] + slope[piece] * x - y, 0.0)
            if jump != 0.0:
                by_x = (share * unit_weight * jump / abs(dx), 0.0)
                _add_product(change, (rx + t * dx, ry + t * dy), (dx, dy), by_x, 1.0)


@njit()
def _add_product(
    change: FloatArray,
    arm: tuple[float, float],
    face: tuple[float, float],
    gradient: tuple[float, float],
    weight: float,
) -> None:  # pragma: no cover - compiled
    """Add a weight times the force and moment of a unit pressure at a point of a face by the change of the pressure."""
    force = (-face[1], face[0], arm[0] * face[0] + arm[1] * face[1])
    by_movement = (gradient[0], gradient[1], arm[0] * gradient[1] - arm[1] * gradient[0])
    for i in range(3):
        for j in range(3):
            change[i, j] += weight * force[i] * by_movement[j]
