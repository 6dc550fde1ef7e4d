"""Compiled cycles of dynamic relaxation: contact forces with the slip that they have come to, blocks moved by them.

Constants of contacts are in single precision, which halves what a cycle reads from memory. They give by what forces
change, to 1e-7 of that: so blocks come to rest as exactly as what was out of balance at first is known. Positions,
velocities and sums of forces are in double.
"""

from __future__ import annotations

import numba as nb
import numpy as np
from numpy.typing import NDArray

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray

BROKEN = np.float32(-1.0)  # instead of a tensile strength


@nb.njit(cache=True)
def frames_of(
    position: FloatArray, block_a: IntArray, block_b: IntArray, geometry: FloatArray, rows: IntArray
) -> tuple[NDArray[np.float32], FloatArray]:  # pragma: no cover - compiled
    """Return the frames (m, 6) of contacts as `relax_cycles` takes them, and the lengths of both arms (m, 2) [m].

    `block_a`, `block_b` (m,) are those of the `rows` (m,) of `geometry`, which `relative_positions` describes.
    """
    frame, length = np.empty((rows.size, 6), np.float32), np.empty((rows.size, 2))
    cosine, sine = np.cos(position[:, 2]), np.sin(position[:, 2])
    for k in range(rows.size):
        a, b, given = block_a[k], block_b[k], geometry[rows[k]]
        ax, ay = cosine[a] * given[2] - sine[a] * given[3], sine[a] * given[2] + cosine[a] * given[3]
        tx, ty = cosine[b] * given[6] - sine[b] * given[7], sine[b] * given[6] + cosine[b] * given[7]
        bx = given[0] + (position[a, 0] - position[b, 0]) + ax
        by = given[1] + (position[a, 1] - position[b, 1]) + ay
        frame[k, 0], frame[k, 1] = tx, ty
        frame[k, 2], frame[k, 3] = -ax * tx - ay * ty, -bx * tx - by * ty
        frame[k, 4], frame[k, 5] = ax * ty - ay * tx, bx * ty - by * tx
        length[k, 0], length[k, 1] = np.hypot(ax, ay), np.hypot(bx, by)
    return frame, length


@nb.njit(cache=True)
def masses(
    block_a: IntArray, block_b: IntArray, spring: FloatArray, length: FloatArray, n: int
) -> FloatArray:  # pragma: no cover - compiled
    """Return sums over the contacts of n blocks, (n, 3): of their stiffer spring twice, of that times the arm squared.

    Columns of `spring` (m, 6) are as `relax_cycles` takes them, `length` (m, 2) as `frames_of` returns it.
    """
    mass = np.zeros((n, 3))
    for k in range(block_a.size):
        stiffness = np.float64(max(spring[k, 0], spring[k, 1]))
        mass[block_a[k], 0] += stiffness
        mass[block_b[k], 0] += stiffness
        mass[block_a[k], 2] += stiffness * length[k, 0] ** 2
        mass[block_b[k], 2] += stiffness * length[k, 1] ** 2
    mass[:, 1] = mass[:, 0]
    return mass


@nb.njit(cache=True, nogil=True)
def relax_cycles(
    lacking: FloatArray,
    begun: int,
    own: IntArray,
    block_a: IntArray,
    block_b: IntArray,
    frame: FloatArray,
    spring: FloatArray,
    tension: FloatArray,
    stuck: FloatArray,
    bore: BoolArray,
    slipped: BoolArray,
    unbalanced: FloatArray,
    missing: FloatArray,
    inverse_mass: FloatArray,
    supported: IntArray,
    projector: FloatArray,
    damping: float,
    forces: FloatArray,
    velocity: FloatArray,
    moved: FloatArray,
) -> None:  # pragma: no cover - compiled
    """Go on by some cycles of unit time, of some of the blocks; the others are where they are in the meantime.

    Parameters
    ----------
    lacking : (cycles,) float64
        Part of `missing` that does not act yet, in every cycle.
    begun : int
        Cycles before: from where blocks are after an even number they move to where they are after an odd one.
    own : (l,) int64
        The blocks that move, but those with a support.
    block_a, block_b : (m,) int32
        Blocks of the corner and of the edge, of all contacts that they have.
    frame : (m, 6) float32 [-, m]
        Edge direction t, moments of the normal n = (t_y, -t_x) about a and b, moments of t about a and b.
    spring : (m, 6) float32 [N/m**2, N/m, -]
        Normal and shear stiffness; pressure where nothing has moved, or less than none: what it would take to close the
        contact; what the shear force lacks there of the strength, and of the negative one; slope of the strength over
        the pressure.
    tension : (m,) float32 [N/m]
        Tensile strength; negative, in place, where a contact breaks.
    stuck : (m,) float32 [N/m]
        By what the shear force would have changed had blocks not moved along the edge; it changes in place with slip.
    bore, slipped : (m,) bool
        Become true, in place, where a contact bears, and slips, in any of the cycles.
    unbalanced, missing : (n, 3) float64 [N/m, N/m, N]
        Forces out of balance where nothing has moved, and what of the loads is brought on little by little.
    inverse_mass : (n, 3) float64
        Over the square of a cycle.
    supported : (k,) int32
        Those with a support.
    projector : (k, 3, 3) float64
        Onto the movements that it lets them make.
    damping : float
        Part of a force out of balance that acts against the velocity.
    forces : (n, 3) float64
        Room to work in.
    velocity : (n, 3) float64 [m, m, rad]
        Movement in a cycle; it changes in place.
    moved : (2, n, 3) float64 [m, m, rad]
        Movement in all, after an even and after an odd number of cycles; they change in place, in turns.
    """
    nothing = np.float32(0.0)
    for cycle in range(lacking.size):
        here, there = moved[(begun + cycle) % 2], moved[(begun + cycle + 1) % 2]
        for i in own:
            _load(forces[i], unbalanced[i], lacking[cycle], missing[i])
        for i in supported:
            _load(forces[i], unbalanced[i], lacking[cycle], missing[i])
        for k in range(block_a.size):
            a, b = block_a[k], block_b[k]
            tx, ty = frame[k, 0], frame[k, 1]
            dx, dy = np.float32(here[a, 0] - here[b, 0]), np.float32(here[a, 1] - here[b, 1])
            turn_a, turn_b = np.float32(here[a, 2]), np.float32(here[b, 2])
            gap = ty * dx - tx * dy + frame[k, 2] * turn_a - frame[k, 3] * turn_b
            tangential = tx * dx + ty * dy + frame[k, 4] * turn_a - frame[k, 5] * turn_b
            borne = spring[k, 2] if spring[k, 2] > nothing or tension[k] != nothing else nothing
            pressure = spring[k, 2] - borne - spring[k, 0] * gap
            if borne + pressure <= -max(tension[k], nothing):
                pressure, shear = -borne, np.float32(0.5) * (spring[k, 3] - spring[k, 4])
                if tension[k] > nothing:
                    tension[k] = BROKEN
            else:
                bore[k] = True
                shear = stuck[k] + spring[k, 1] * tangential
                most, least = spring[k, 3] + spring[k, 5] * pressure, -spring[k, 4] - spring[k, 5] * pressure
                if most < least:
                    most = least = np.float32(0.5) * (most + least)
                held = min(max(shear, least), most)
                slipped[k] |= held != shear
                shear = held
            stuck[k] = shear - spring[k, 1] * tangential
            fx, fy = pressure * ty - shear * tx, -pressure * tx - shear * ty
            forces[a, 0] += fx
            forces[a, 1] += fy
            forces[a, 2] += pressure * frame[k, 2] - shear * frame[k, 4]
            forces[b, 0] -= fx
            forces[b, 1] -= fy
            forces[b, 2] -= pressure * frame[k, 3] - shear * frame[k, 5]
        for i in own:
            _accelerate(forces[i], velocity[i], damping, inverse_mass[i])
            _move(forces[i], velocity[i], here[i], there[i])
        for j in range(supported.size):
            i = supported[j]
            _project(projector[j].T, forces[i])
            _accelerate(forces[i], velocity[i], damping, inverse_mass[i])
            _project(projector[j], forces[i])
            _move(forces[i], velocity[i], here[i], there[i])


@nb.njit(cache=True)
def _load(
    forces: FloatArray, unbalanced: FloatArray, lacking: float, missing: FloatArray
) -> None:  # pragma: no cover - compiled
    for axis in range(3):
        forces[axis] = unbalanced[axis] - lacking * missing[axis]


@nb.njit(cache=True)
def _accelerate(
    forces: FloatArray, velocity: FloatArray, damping: float, inverse_mass: FloatArray
) -> None:  # pragma: no cover - compiled
    for axis in range(3):
        along_it = np.sign(forces[axis] * velocity[axis])
        forces[axis] *= (1 - damping * along_it) * inverse_mass[axis]


@nb.njit(cache=True)
def _move(
    acceleration: FloatArray, velocity: FloatArray, here: FloatArray, there: FloatArray
) -> None:  # pragma: no cover - compiled
    for axis in range(3):
        velocity[axis] += acceleration[axis]
        there[axis] = here[axis] + velocity[axis]


@nb.njit(cache=True, nogil=True)
def changed_shears(
    block_a: IntArray, block_b: IntArray, frame: FloatArray, spring: FloatArray, stuck: FloatArray, moved: FloatArray
) -> FloatArray:  # pragma: no cover - compiled
    """Return by what shear forces have changed after cycles, (m,) float32 [N/m]; arrays as in `relax_cycles`.

    The movement `moved` (n, 3) of the last cycle counts too: springs that forgot it would drive blocks, the more so the
    fewer cycles go by at once. Shears may be more than the strength in the end: a law takes what slips by that.
    """
    changed = np.empty_like(stuck)
    for k in range(block_a.size):
        a, b = block_a[k], block_b[k]
        dx, dy = np.float32(moved[a, 0] - moved[b, 0]), np.float32(moved[a, 1] - moved[b, 1])
        turn_a, turn_b = np.float32(moved[a, 2]), np.float32(moved[b, 2])
        tangential = frame[k, 0] * dx + frame[k, 1] * dy + frame[k, 4] * turn_a - frame[k, 5] * turn_b
        changed[k] = stuck[k] + spring[k, 1] * tangential
    return changed


@nb.njit(cache=True)
def _project(projector: FloatArray, vector: FloatArray) -> None:  # pragma: no cover - compiled
    x, y, z = vector[0], vector[1], vector[2]
    for axis in range(3):
        vector[axis] = projector[axis, 0] * x + projector[axis, 1] * y + projector[axis, 2] * z
