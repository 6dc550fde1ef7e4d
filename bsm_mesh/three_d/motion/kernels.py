"""Compiled cycles of explicit motion in space: forces of contact points, blocks accelerated by them."""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.compiled import njit
from bsm_mesh.solve.motion.kernels import faster
from bsm_mesh.three_d.bolts.kernels import add_bolts

CHECK_EVERY = 10  # cycles between looks at how far blocks have moved
CLOSED, BROKEN, SLID = 1, 2, 4  # bits of what happened to a contact in a window


@njit(nogil=True)
def advance(
    cycles: int,
    farthest: float,
    blocks: tuple[IntArray, IntArray],
    geometry: FloatArray,
    springs: FloatArray,
    shear: FloatArray,
    place: FloatArray,
    marks: IntArray,
    supports: tuple[IntArray, FloatArray, FloatArray],
    free: IntArray,
    loads: tuple[FloatArray, FloatArray, FloatArray],
    bolts: tuple[FloatArray, ...] | None,
    constants: tuple[FloatArray, FloatArray, float],
    velocity: FloatArray,
    moved: FloatArray,
    shift: FloatArray,
    matrix: FloatArray,
    room: tuple[FloatArray, FloatArray],
) -> int:  # pragma: no cover - compiled
    """Go through cycles of unit time, and return how many: fewer where a block has moved too far.

    Parameters
    ----------
    cycles, farthest : int, float [m]
        How many at most; a block that moved further since the window began ends it.
    blocks, geometry : block_a, block_b (m,), (m, 12) float64
        As `relative_positions` takes them.
    springs : (m, 14) float64
        Stiffness (normal, shear), offset, tension, dashpot, line of strength (at no pressure, slope), reach, last gap,
        slip in the window. Second line (the lower counts); slope of dilation, slip left. Opening takes tension.
    shear, place, marks : (m, 3), (m, 3) float64, (m,) int8
        Shear force on a, movement against the face at it, in b's frame, and what happened; they change in place.
    supports, free : blocks (l,), projectors (l, 6, 6), prescribed (n, 6); (k,) int64
        Supported blocks; onto their free axes; movement that supports prescribe in a cycle. The other blocks.
    loads, bolts : acting (n, 6), ramped_load (n, 6), unramped_fraction (cycles,); tuple of arrays or None
        As in the plane, without the contacts' forces; as `add_bolts` takes them.
    constants : inverse_mass (n, 6), scale (n, 6), damping
        As in the plane.
    velocity, moved, shift, matrix : (n, 6), (n, 6), (n, 3), (n, 3, 3) float64
        Movement in a cycle, and since the window began, rotations added up; displacements, and rotation matrices less
        the unit matrix. They change in place.
    room : (n, 6), (7, 6) float64
        To work in: forces, and vectors of a contact or a block.
    """
    (acting, ramped_load, unramped_fraction), (inverse_mass, scale, damping) = loads, constants
    forces, vectors = room
    for cycle in range(cycles):
        _set_loads(acting, ramped_load, unramped_fraction[cycle], forces)
        _add_contacts(blocks[0], blocks[1], geometry, springs, shear, place, marks, shift, matrix, vectors, forces)
        if bolts is not None:
            add_bolts(shift, matrix, *bolts, forces)
        for i in free:
            for axis in range(6):
                velocity[i, axis] = faster(forces[i, axis], velocity[i, axis], inverse_mass[i, axis], damping)
            _carry(velocity[i], moved[i], shift[i], matrix[i])
        _move_supported(*supports, forces, inverse_mass, damping, velocity, moved, shift, matrix, vectors[5:])
        if cycle % CHECK_EVERY == CHECK_EVERY - 1 and _is_beyond(moved, scale, farthest):
            return cycle + 1
    return cycles


@njit(nogil=True)
def _set_loads(
    acting: FloatArray, ramped_load: FloatArray, left: float, forces: FloatArray
) -> None:  # pragma: no cover - compiled
    """Set the forces (n, 6) of blocks to the loads of a cycle, of whose ramped part so much does not act yet."""
    for i in range(acting.shape[0]):
        for axis in range(6):
            forces[i, axis] = acting[i, axis] - left * ramped_load[i, axis]


@njit(nogil=True)
def _add_contacts(
    block_a: IntArray,
    block_b: IntArray,
    geometry: FloatArray,
    springs: FloatArray,
    shear: FloatArray,
    place: FloatArray,
    marks: IntArray,
    shift: FloatArray,
    matrix: FloatArray,
    room: FloatArray,
    forces: FloatArray,
) -> None:  # pragma: no cover - compiled
    """Add force and moment of all contacts to `forces` (n, 6); arrays as in `advance`; `room` (5, >= 3) to work in."""
    arm_a, arm_b, moved, now, force = room[0], room[1], room[2], room[3], room[4]
    for k in range(block_a.size):
        a, b, g, s, old, at = block_a[k], block_b[k], geometry[k], springs[k], shear[k], place[k]
        for u in range(3):
            swung = matrix[a, u, 0] * g[0] + matrix[a, u, 1] * g[1] + matrix[a, u, 2] * g[2]
            turned = matrix[b, u, 0] * g[3] + matrix[b, u, 1] * g[4] + matrix[b, u, 2] * g[5]
            step = g[9 + u] + shift[a, u] - shift[b, u] + swung
            arm_a[u], arm_b[u], moved[u] = g[u] + swung, g[3 + u] + step, step - turned
        gap, along = 0.0, 0.0
        for u in range(3):
            now[u] = moved[u] + matrix[b, 0, u] * moved[0] + matrix[b, 1, u] * moved[1] + matrix[b, 2, u] * moved[2]
            gap += now[u] * g[6 + u]
        for u in range(3):
            along += (now[u] - gap * g[6 + u]) ** 2
        trial = s[0] * (s[2] + s[12] * min(s[9], s[13]) - gap)
        bears = (trial > 0.0) | ((s[3] > 0.0) & (trial >= -s[3]))
        if not bears or along > s[7] * s[7]:
            if s[3] > 0.0:
                marks[k] |= BROKEN
                s[3], s[5], s[10] = 0.0, 0.0, 0.0
            for u in range(3):
                old[u], at[u] = 0.0, now[u]
            s[8] = gap
            continue
        marks[k] |= CLOSED
        pressure = max(trial - s[4] * (gap - s[8]), -s[3])
        s[8] = gap
        strength = max(min(s[5] + s[6] * pressure, s[10] + s[11] * pressure), 0.0)
        slid = _shear(now, gap, g, s[1], strength, old, at)
        if slid > 0.0:
            marks[k] |= SLID
            s[9] += slid
        for u in range(3):
            moved[u] = pressure * g[6 + u] + old[u]
        for u in range(3):
            force[u] = moved[u] + matrix[b, u, 0] * moved[0] + matrix[b, u, 1] * moved[1] + matrix[b, u, 2] * moved[2]
        for u in range(3):
            v, w = (u + 1) % 3, (u + 2) % 3
            forces[a, u] += force[u]
            forces[b, u] -= force[u]
            forces[a, 3 + u] += arm_a[v] * force[w] - arm_a[w] * force[v]
            forces[b, 3 + u] -= arm_b[v] * force[w] - arm_b[w] * force[v]


@njit(nogil=True)
def _shear(
    now: FloatArray, gap: float, g: FloatArray, stiffness: float, strength: float, old: FloatArray, at: FloatArray
) -> float:  # pragma: no cover - compiled
    """Set the shear force `old` (3,) and its place `at` (3,) to those at a movement `now` (3,); return the slip [m]."""
    before = at[0] * g[6] + at[1] * g[7] + at[2] * g[8]
    square = 0.0
    for u in range(3):
        old[u] -= stiffness * (now[u] - at[u] - (gap - before) * g[6 + u])
        at[u] = now[u]
        square += old[u] * old[u]
    if square <= strength * strength:
        return 0.0
    size = np.sqrt(square)
    for u in range(3):
        old[u] *= strength / size
    return (size - strength) / stiffness if stiffness > 0.0 else 0.0


@njit(nogil=True)
def _carry(
    velocity: FloatArray, moved: FloatArray, shift: FloatArray, matrix: FloatArray
) -> None:  # pragma: no cover - compiled
    """Move a block by its velocity (6,) for a cycle; Cayley's map keeps the rotation exact."""
    for axis in range(6):
        moved[axis] += velocity[axis]
    for u in range(3):
        shift[u] += velocity[u]
    x, y, z = velocity[3] / 2, velocity[4] / 2, velocity[5] / 2
    if x == 0.0 and y == 0.0 and z == 0.0:
        return
    factor = 2.0 / (1.0 + x * x + y * y + z * z)
    for v in range(3):
        p, q, r = matrix[0, v], matrix[1, v], matrix[2, v]
        if v == 0:
            p += 1.0
        elif v == 1:
            q += 1.0
        else:
            r += 1.0
        c0, c1, c2 = y * r - z * q, z * p - x * r, x * q - y * p
        matrix[0, v] += factor * (c0 + y * c2 - z * c1)
        matrix[1, v] += factor * (c1 + z * c0 - x * c2)
        matrix[2, v] += factor * (c2 + x * c1 - y * c0)


@njit(nogil=True)
def _move_supported(
    supported: IntArray,
    projector: FloatArray,
    prescribed: FloatArray,
    forces: FloatArray,
    inverse_mass: FloatArray,
    damping: float,
    velocity: FloatArray,
    moved: FloatArray,
    shift: FloatArray,
    matrix: FloatArray,
    room: FloatArray,
) -> None:  # pragma: no cover - compiled
    """Move blocks with supports along their free axes for a cycle, and by what supports prescribe; `room` (2, 6)."""
    along, whole = room[0], room[1]
    for j in range(supported.size):
        i = supported[j]
        for axis in range(6):
            pushed = 0.0
            for other in range(6):
                pushed += projector[j, other, axis] * forces[i, other]
            along[axis] = faster(pushed, velocity[i, axis], inverse_mass[i, axis], damping)
        for axis in range(6):
            velocity[i, axis] = 0.0
            for other in range(6):
                velocity[i, axis] += projector[j, axis, other] * along[other]
            whole[axis] = velocity[i, axis] + prescribed[i, axis]
        _carry(whole, moved[i], shift[i], matrix[i])


@njit(nogil=True)
def _is_beyond(moved: FloatArray, scale: FloatArray, most: float) -> bool:  # pragma: no cover - compiled
    """Return whether a block moved further than `most` [m], or is nowhere any more."""
    for i in range(moved.shape[0]):
        for axis in range(6):
            if not abs(moved[i, axis]) <= most * scale[i, axis]:
                return True
    return False
