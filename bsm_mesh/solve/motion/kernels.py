"""Kernels of explicit motion: cycles of contact forces with slip, and of the movement of blocks.

Constants of contacts are in single precision, which halves the memory traffic of a cycle. They give changes of forces
to 1e-7: the final residual is as accurate as the initial one. Positions, velocities and sums of forces are in double.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.compiled import njit

BROKEN = np.float32(-1.0)  # instead of a tensile strength


@njit()
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


@njit()
def masses(
    block_a: IntArray, block_b: IntArray, spring: FloatArray, length: FloatArray, n: int
) -> FloatArray:  # pragma: no cover - compiled
    """Return sums over the contacts of n blocks, (n, 3): twice their stiffer spring, and that times the arm squared.

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


@njit(nogil=True)
def relax_cycles(
    unramped_fraction: FloatArray,
    begun: int,
    own: IntArray,
    block_a: IntArray,
    block_b: IntArray,
    frame: FloatArray,
    spring: FloatArray,
    tension: FloatArray,
    shear_offset: FloatArray,
    contacted: BoolArray,
    slipped: BoolArray,
    residual: FloatArray,
    ramped_load: FloatArray,
    inverse_mass: FloatArray,
    supported: IntArray,
    projector: FloatArray,
    damping: float,
    forces: FloatArray,
    velocity: FloatArray,
    moved: FloatArray,
) -> None:  # pragma: no cover - compiled
    """Advance some of the blocks by cycles of unit time (central differences); others are advanced elsewhere.

    Parameters
    ----------
    unramped_fraction : (cycles,) float64
        Part of `ramped_load` that does not act yet, of every cycle.
    begun : int
        Number of cycles before: it decides between the two arrays of `moved`.
    own : (l,) int64
        The blocks to advance, without those with a support.
    block_a, block_b : (m,) int32
        Blocks of the corner and of the edge, of all their contacts.
    frame : (m, 6) float32 [-, m]
        Edge direction t, moments of the normal n = (t_y, -t_x) about a and b, moments of t about a and b.
    spring : (m, 6) float32 [N/m**2, N/m, -]
        Normal and shear stiffness; pressure before any movement, negative where open: stiffness times gap; distance of
        the shear force from the strength, and from the negative one; slope of the strength over the pressure.
    tension : (m,) float32 [N/m]
        Tensile strength; set negative, in place, where it is exceeded.
    shear_offset : (m,) float32 [N/m]
        Change of the shear force by slip alone; it changes in place.
    contacted, slipped : (m,) bool
        Set true, in place, where a contact is closed, and slips, in any of the cycles.
    residual, ramped_load : (n, 3) float64 [N/m, N/m, N]
        Residual before any movement, and the part of the loads that is ramped.
    inverse_mass : (n, 3) float64
        Inverse masses times the square of a cycle.
    supported : (k,) int32
        Blocks with a support.
    projector : (k, 3, 3) float64
        Onto their free axes.
    damping : float
        Part of the residual that acts against the velocity.
    forces : (n, 3) float64
        Work array.
    velocity : (n, 3) float64 [m, m, rad]
        Movement in a cycle; it changes in place.
    moved : (2, n, 3) float64 [m, m, rad]
        Total movement after an even, and after an odd number of cycles; they change in place, alternately.
    """
    nothing = np.float32(0.0)
    for cycle in range(unramped_fraction.size):
        here, there = moved[(begun + cycle) % 2], moved[(begun + cycle + 1) % 2]
        for i in own:
            _load(forces[i], residual[i], unramped_fraction[cycle], ramped_load[i])
        for i in supported:
            _load(forces[i], residual[i], unramped_fraction[cycle], ramped_load[i])
        for k in range(block_a.size):
            a, b = block_a[k], block_b[k]
            tx, ty = frame[k, 0], frame[k, 1]
            dx, dy = np.float32(here[a, 0] - here[b, 0]), np.float32(here[a, 1] - here[b, 1])
            turn_a, turn_b = np.float32(here[a, 2]), np.float32(here[b, 2])
            gap = ty * dx - tx * dy + frame[k, 2] * turn_a - frame[k, 3] * turn_b
            tangential = tx * dx + ty * dy + frame[k, 4] * turn_a - frame[k, 5] * turn_b
            initial = spring[k, 2] if spring[k, 2] > nothing or tension[k] != nothing else nothing
            pressure = spring[k, 2] - initial - spring[k, 0] * gap
            if initial + pressure <= -max(tension[k], nothing):
                pressure, shear = -initial, np.float32(0.5) * (spring[k, 3] - spring[k, 4])
                if tension[k] > nothing:
                    tension[k] = BROKEN
            else:
                contacted[k] = True
                shear = shear_offset[k] + spring[k, 1] * tangential
                most, least = spring[k, 3] + spring[k, 5] * pressure, -spring[k, 4] - spring[k, 5] * pressure
                if most < least:
                    most = least = np.float32(0.5) * (most + least)
                limited = min(max(shear, least), most)
                slipped[k] |= limited != shear
                shear = limited
            shear_offset[k] = shear - spring[k, 1] * tangential
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


@njit()
def _load(
    forces: FloatArray, residual: FloatArray, unramped_fraction: float, ramped_load: FloatArray
) -> None:  # pragma: no cover - compiled
    for axis in range(3):
        forces[axis] = residual[axis] - unramped_fraction * ramped_load[axis]


@njit()
def _accelerate(
    forces: FloatArray, velocity: FloatArray, damping: float, inverse_mass: FloatArray
) -> None:  # pragma: no cover - compiled
    for axis in range(3):
        along_it = np.sign(forces[axis] * velocity[axis])
        forces[axis] *= (1 - damping * along_it) * inverse_mass[axis]


@njit()
def _move(
    acceleration: FloatArray, velocity: FloatArray, here: FloatArray, there: FloatArray
) -> None:  # pragma: no cover - compiled
    for axis in range(3):
        velocity[axis] += acceleration[axis]
        there[axis] = here[axis] + velocity[axis]


@njit(nogil=True)
def changed_shears(
    block_a: IntArray,
    block_b: IntArray,
    frame: FloatArray,
    spring: FloatArray,
    shear_offset: FloatArray,
    moved: FloatArray,
) -> FloatArray:  # pragma: no cover - compiled
    """Return the change of shear forces after cycles, (m,) float32 [N/m]; arrays as in `relax_cycles`.

    The movement `moved` (n, 3) of the last cycle counts too: without it springs would do work on the blocks. Shears may
    exceed the strength in the end: the law limits them at the next evaluation.
    """
    changed = np.empty_like(shear_offset)
    for k in range(block_a.size):
        a, b = block_a[k], block_b[k]
        dx, dy = np.float32(moved[a, 0] - moved[b, 0]), np.float32(moved[a, 1] - moved[b, 1])
        turn_a, turn_b = np.float32(moved[a, 2]), np.float32(moved[b, 2])
        tangential = frame[k, 0] * dx + frame[k, 1] * dy + frame[k, 4] * turn_a - frame[k, 5] * turn_b
        changed[k] = shear_offset[k] + spring[k, 1] * tangential
    return changed


@njit()
def _project(projector: FloatArray, vector: FloatArray) -> None:  # pragma: no cover - compiled
    x, y, z = vector[0], vector[1], vector[2]
    for axis in range(3):
        vector[axis] = projector[axis, 0] * x + projector[axis, 1] * y + projector[axis, 2] * z
