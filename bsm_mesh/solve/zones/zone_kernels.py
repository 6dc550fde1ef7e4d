"""Compiled cycles of zones in explicit motion: forces of rock, joints and bolts, nodes accelerated by them.

Nodes are moved like blocks that do not turn. Joints have the compiled laws of contacts. Their openings and slips are
changes from the begin of a window of cycles; forces are whole ones. Rock is elastic. In small displacement its strain
is linear; in large displacement rock is that of `large_rock`, and joints turn as in `moving_points`.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.compiled import njit
from bsm_mesh.solve.motion.contact_columns import WIDTH, ChunkArray
from bsm_mesh.solve.motion.contact_kernels import ROOM, respond
from bsm_mesh.solve.motion.kernels import CHECK_EVERY
from bsm_mesh.solve.motion.shaken_kernels import move_shaken

Rock = tuple[IntArray, FloatArray, FloatArray, FloatArray, FloatArray, bool]
"""Nodes (t, w) uint32, gradient (t, i, w, 2), weight (t, i), stiffness (t, 3, 3), stress without strain (t, i, 3), and
whether displacements are large."""

Points = tuple[IntArray, FloatArray, FloatArray, FloatArray, FloatArray]
"""Nodes (q, m) uint32; opening and slip from their displacements (q, 2, m, 2), in large displacement r and e from them
(q, 2, m, 2) in its first column; these as given (q, 2, 2), empty in small displacement; opening and slip at the begin
of the window (q, 2), slip up to the place (q,) behind them in a third column; water's pressure (q,)."""

Laws = tuple[ChunkArray, ChunkArray, ChunkArray, ChunkArray, ChunkArray, ChunkArray]
"""Contacts, strengths, closures, slips, growths and works, as `respond` takes them."""

Means = tuple[IntArray, IntArray, FloatArray, FloatArray, FloatArray, FloatArray]
"""Nodes of blocks in rows (n + 1,), (z,), and their part of the block's mass (z,); direction of the base's acceleration
(2,), 0 where none acts; mean velocity (n, 2) [m] and the square of the greatest mean acceleration (n,) [m2], which
change in place."""

Spread = tuple[IntArray, IntArray, FloatArray, FloatArray, FloatArray]
"""Stiffness of bolts on components of nodes, in rows (2 k + 1,), (z,), (z,); their forces (k, 3) at the begin, and
where nodes were then (k, 3)."""


@njit(nogil=True, allocates=True)
def advance_zones(
    cycles: int,
    reach: FloatArray,
    own: IntArray,
    supports: tuple[IntArray, FloatArray, FloatArray],
    rock: Rock,
    points: Points,
    laws: Laws,
    bolts: Spread,
    loads: tuple[FloatArray, FloatArray, FloatArray],
    inverse_mass: FloatArray,
    damping: tuple[float, float, IntArray, FloatArray],
    velocity: FloatArray,
    moved: FloatArray,
    room: FloatArray,
    shaken: tuple[FloatArray, FloatArray],
    wave: tuple[FloatArray, FloatArray, FloatArray],
    means: Means,
) -> int:  # pragma: no cover - compiled
    """Go through cycles of unit time, and return how many: fewer where a point has slid far, or broken.

    Parameters
    ----------
    cycles : int, reach : (q,) float64 [m], own : (f,) uint32
        How many; by how much points of joints may slide; nodes without a support.
    supports, shaken : nodes (l,), projectors (l, 3, 3), prescribed (k, 3); drag (k, 3), work (k, 5)
        As `move_shaken` takes them.
    rock, points, laws, bolts, means : tuples of arrays
        See above; laws as of contacts. They carry on their state.
    loads : acting (k, 3), pushed (k, 3), size (cycles,)
        Constant forces; less the others times their size in a cycle.
    inverse_mass : (k, 3) float64; damping : part, of vibrations, pieces (k,), room (p, 5)
        Over the square of a cycle; parts of forces against the velocity (Cundall 1987), piece of every node, -1: none.
    velocity : (k, 3) float64 [m]
        Movement in a cycle; it changes in place.
    moved, room : (2, k, 3) float64
        Displacements after an even and an odd number of cycles; room to work in.
    wave : push (k, 3), size (cycles,), work (1,)
        Forces of a wave that enters, over its size, that size in a cycle, and the work that they do.
    """
    state, turned, vectors = np.zeros(1, ROOM)[0], np.empty((2, points[0].shape[1], 2)), np.empty((3, 3))
    went = cycles
    for cycle in range(cycles):
        here, there, forces = moved[cycle % 2], moved[(cycle + 1) % 2], room[0]
        _set_loads(loads, wave, cycle, forces)
        _add_rock(here, rock, forces)
        ends = _add_points(here, points, laws, reach, state, turned, forces)
        _set_bolts(here, bolts, room[1])
        _damp(damping, inverse_mass, velocity, room[1], forces)
        base, half = (loads[1], loads[2][cycle]), wave[1][cycle] / 2
        wave[2][0] += half * _power(half, wave[0], velocity)
        move_shaken(own, supports, inverse_mass, base, shaken, None, cycle, room, vectors, velocity, here, there)
        wave[2][0] += half * _power(half, wave[0], velocity)
        _keep_means(means, velocity, loads[2][cycle])
        if ends or _is_nowhere(cycle, there):
            went = cycle + 1
            break
    _add_points(moved[went % 2], points, laws, reach, state, turned, room[0])  # the work of the last cycle
    return went


@njit(nogil=True)
def _set_loads(
    loads: tuple[FloatArray, FloatArray, FloatArray],
    wave: tuple[FloatArray, FloatArray, FloatArray],
    cycle: int,
    forces: FloatArray,
) -> None:  # pragma: no cover - compiled
    """Set forces (k, 3) to the loads of a cycle, as `advance_zones` takes them."""
    (acting, pushed, size), (push, entering, _) = loads, wave
    for i in range(forces.shape[0]):
        for axis in range(2):
            forces[i, axis] = acting[i, axis] - size[cycle] * pushed[i, axis] + entering[cycle] * push[i, axis]


@njit(nogil=True)
def _add_rock(here: FloatArray, rock: Rock, forces: FloatArray) -> None:  # pragma: no cover - compiled
    """Take the internal forces of cells off forces (k, 3)."""
    cells, gradient, weights, stiffness, initial, is_large = rock
    for e in range(cells.shape[0]):
        C = stiffness[e]
        for p in range(gradient.shape[1]):
            weight = weights[e, p]
            if weight == 0.0:
                continue
            h00, h01, h10, h11 = 0.0, 0.0, 0.0, 0.0
            for j in range(cells.shape[1]):
                i, gx, gy = cells[e, j], gradient[e, p, j, 0], gradient[e, p, j, 1]
                h00 += here[i, 0] * gx
                h01 += here[i, 0] * gy
                h10 += here[i, 1] * gx
                h11 += here[i, 1] * gy
            xx, yy, xy = h00, h11, h01 + h10
            if is_large:
                xx += (h00 * h00 + h10 * h10) / 2
                yy += (h01 * h01 + h11 * h11) / 2
                xy += h00 * h01 + h10 * h11
            s00 = C[0, 0] * xx + C[0, 1] * yy + C[0, 2] * xy + initial[e, p, 0]
            s11 = C[1, 0] * xx + C[1, 1] * yy + C[1, 2] * xy + initial[e, p, 1]
            s01 = C[2, 0] * xx + C[2, 1] * yy + C[2, 2] * xy + initial[e, p, 2]
            p00, p01, p10, p11 = s00, s01, s01, s11
            if is_large:
                p00 += h00 * s00 + h01 * s01
                p01 += h00 * s01 + h01 * s11
                p10 += h10 * s00 + h11 * s01
                p11 += h10 * s01 + h11 * s11
            for j in range(cells.shape[1]):
                i, gx, gy = cells[e, j], weight * gradient[e, p, j, 0], weight * gradient[e, p, j, 1]
                forces[i, 0] -= p00 * gx + p01 * gy
                forces[i, 1] -= p10 * gx + p11 * gy


@njit(nogil=True)
def _add_points(
    here: FloatArray, points: Points, laws: Laws, reach: FloatArray, t: Any, turned: FloatArray, forces: FloatArray
) -> bool:  # pragma: no cover - compiled
    """Add the forces of points of joints to forces (k, 3), and return whether one has slid far, or broken.

    `turned` (2, m, 2): room for the derivatives of opening and slip of a point in large displacement.
    """
    nodes, rows, given, begun, water = points
    strengths, ends = laws[1], False
    for chunk in range(laws[0].size):
        first = chunk * WIDTH
        count = min(WIDTH, nodes.shape[0] - first)
        for i in range(count):
            q = first + i
            if given.shape[0]:
                opening, slip = _relative(here, nodes[q], rows[q], given[q], begun[q, 2])
            else:
                opening, slip = 0.0, 0.0
                for j in range(nodes.shape[1]):
                    for axis in range(2):
                        u = here[nodes[q, j], axis]
                        opening += rows[q, 0, j, axis] * u
                        slip += rows[q, 1, j, axis] * u
            slid = slip - begun[q, 1]
            t.gap[i], t.along[i] = np.float32(opening - begun[q, 0]), np.float32(slid)
            ends = ends or not abs(slid) <= reach[q]
        respond(chunk, *laws, t)
        for i in range(count):
            q, pressure, shear = first + i, t.pressure[i] + water[first + i], np.float64(t.shear[i])
            if strengths.size:
                ends = ends or strengths[chunk].broken[i] > 0
            if pressure == 0.0 and shear == 0.0:
                continue
            row = rows[q]
            if given.shape[0]:
                row = turned
                _set_gradients(here, nodes[q], rows[q], given[q], row)
            for j in range(nodes.shape[1]):
                for axis in range(2):
                    forces[nodes[q, j], axis] += pressure * row[0, j, axis] - shear * row[1, j, axis]
    return ends


@njit(nogil=True, forceinline=True)
def _vectors(
    here: FloatArray, nodes: IntArray, parts: FloatArray, given: FloatArray
) -> tuple[float, float, float, float]:  # pragma: no cover - compiled
    """Return r and e of a point (`moving_points`)."""
    rx, ry, ex, ey = given[0, 0], given[0, 1], given[1, 0], given[1, 1]
    for j in range(nodes.size):
        x, y = here[nodes[j], 0], here[nodes[j], 1]
        rx += parts[0, j, 0] * x
        ry += parts[0, j, 0] * y
        ex += parts[1, j, 0] * x
        ey += parts[1, j, 0] * y
    return rx, ry, ex, ey


@njit(nogil=True, forceinline=True)
def _relative(
    here: FloatArray, nodes: IntArray, parts: FloatArray, given: FloatArray, slid: float
) -> tuple[float, float]:  # pragma: no cover - compiled
    """Return opening and slip of a point in large displacement."""
    rx, ry, ex, ey = _vectors(here, nodes, parts, given)
    length = np.sqrt(ex * ex + ey * ey)
    return (ey * rx - ex * ry) / length, (ex * rx + ey * ry) / length + slid


@njit(nogil=True, forceinline=True)
def _set_gradients(
    here: FloatArray, nodes: IntArray, parts: FloatArray, given: FloatArray, row: FloatArray
) -> None:  # pragma: no cover - compiled
    """Set the derivatives of opening and slip by the displacements of nodes (2, m, 2)."""
    rx, ry, ex, ey = _vectors(here, nodes, parts, given)
    square = ex * ex + ey * ey
    length = np.sqrt(square)
    opening, along = (ey * rx - ex * ry) / square, (ex * rx + ey * ry) / square
    for j in range(nodes.size):
        by_r, by_e = parts[0, j, 0] / length, parts[1, j, 0] / length
        row[0, j, 0] = by_r * ey + by_e * (-ry - opening * ex)
        row[0, j, 1] = -by_r * ex + by_e * (rx - opening * ey)
        row[1, j, 0] = by_r * ex + by_e * (rx - along * ex)
        row[1, j, 1] = by_r * ey + by_e * (ry - along * ey)


@njit(nogil=True)
def _set_bolts(here: FloatArray, bolts: Spread, forces: FloatArray) -> None:  # pragma: no cover - compiled
    """Set the forces of bolts (k, 3), as stiff as at the begin of the window."""
    start, column, value, begun, before = bolts
    for i in range(forces.shape[0]):
        for axis in range(3):
            forces[i, axis] = begun[i, axis]
    for row in range(start.size - 1):
        total = 0.0
        for z in range(start[row], start[row + 1]):
            i, axis = column[z] // 2, column[z] % 2
            total += value[z] * (here[i, axis] - before[i, axis])
        forces[row // 2, row % 2] -= total


@njit(nogil=True)
def _damp(
    damping: tuple[float, float, IntArray, FloatArray],
    inverse_mass: FloatArray,
    velocity: FloatArray,
    bolts: FloatArray,
    forces: FloatArray,
) -> None:  # pragma: no cover - compiled
    """Let a part of each force (k, 3), with that of bolts (k, 3), act against the velocity.

    A piece of rock that slides is damped by the force on all of it. Forces that let it vibrate would drag it to a stop;
    another part of them damps these vibrations.
    """
    part, of_vibrations, piece, whole = damping
    if part == 0.0:
        return
    _set_whole(piece, inverse_mass, velocity, bolts, forces, whole)
    for i in range(forces.shape[0]):
        p = piece[i]
        for axis in range(2):
            force, speed = forces[i, axis] + bolts[i, axis], velocity[i, axis]
            of_whole, drift = force, speed
            if p >= 0:
                of_whole = whole[p, 1 + axis] / (inverse_mass[i, axis] * whole[p, 0])
                drift = whole[p, 3 + axis] / whole[p, 0]
            vibrates = _along(force - of_whole, speed - drift)
            forces[i, axis] -= part * _along(of_whole, drift) + of_vibrations * vibrates


@njit(nogil=True)
def _set_whole(
    piece: IntArray,
    inverse_mass: FloatArray,
    velocity: FloatArray,
    bolts: FloatArray,
    forces: FloatArray,
    whole: FloatArray,
) -> None:  # pragma: no cover - compiled
    """Set mass, forces in x and y and momentum of pieces, (p, 5)."""
    whole[:] = 0.0
    for i in range(forces.shape[0]):
        p = piece[i]
        if p < 0:
            continue
        mass = 1.0 / inverse_mass[i, 0]
        whole[p, 0] += mass
        for axis in range(2):
            whole[p, 1 + axis] += forces[i, axis] + bolts[i, axis]
            whole[p, 3 + axis] += mass * velocity[i, axis]


@njit(nogil=True, forceinline=True)
def _along(force: float, velocity: float) -> float:  # pragma: no cover - compiled
    """Return the size of a force in the direction of a velocity."""
    return force if force * velocity > 0.0 else -force


@njit(nogil=True)
def _keep_means(means: Means, velocity: FloatArray, base: float) -> None:  # pragma: no cover - compiled
    """Set mean velocities of blocks (n, 2), and keep their greatest change, with that of the base."""
    first, nodes, parts, along, mean, greatest = means
    for block in range(first.size - 1):
        x, y = 0.0, 0.0
        for z in range(first[block], first[block + 1]):
            x += parts[z] * velocity[nodes[z], 0]
            y += parts[z] * velocity[nodes[z], 1]
        if first[block + 1] > first[block]:
            dx, dy = x - mean[block, 0] + base * along[0], y - mean[block, 1] + base * along[1]
            greatest[block] = max(greatest[block], dx * dx + dy * dy)
        mean[block, 0], mean[block, 1] = x, y


@njit(nogil=True)
def _power(size: float, push: FloatArray, velocity: FloatArray) -> float:  # pragma: no cover - compiled
    """Return the power of forces (k, 3) with velocities (k, 3); 0 where their size is."""
    total = 0.0
    if size != 0.0:
        for i in range(push.shape[0]):
            total += push[i, 0] * velocity[i, 0] + push[i, 1] * velocity[i, 1]
    return total


@njit(nogil=True)
def _is_nowhere(cycle: int, here: FloatArray) -> bool:  # pragma: no cover - compiled
    """Return whether a node is nowhere any more; not after every cycle."""
    if cycle % CHECK_EVERY != CHECK_EVERY - 1:
        return False
    total = 0.0
    for i in range(here.shape[0]):
        total += here[i, 0] + here[i, 1]
    return not np.isfinite(total)
