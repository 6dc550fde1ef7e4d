"""Compiled movement of blocks that are shaken: central differences with real masses, and the work of each part."""

from __future__ import annotations

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.compiled import njit

BASE, BOLTS, DRAG, SPEED, ACCELERATION = range(5)
"""Columns of the work of blocks: of the base, the bolts and the drag [N]; greatest speed and acceleration."""

DASHPOT, SPRING, INVERSE_MASS, PUSH = range(4)
"""Columns of the constants of the ends of quiet boundaries, in cycles."""

STRETCH, VELOCITY = range(2)
"""Columns of the state of the ends [m]."""

PUSHED, LEFT = range(2)
"""Columns of the work of the ends [N]: put in by waves, taken by dashpots."""

Ends = tuple[IntArray, IntArray, FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]
"""Rows that are moved here; blocks (k,); movement by that of the block (k, 3); constants (k, 4); state
(k, 2) and work (k, 2), which change in place; the input of each cycle."""


@njit(nogil=True)
def _add_ends(ends: Ends, forces: FloatArray) -> None:  # pragma: no cover - compiled
    """Add the forces of the ends of quiet boundaries on their blocks, (n, 3)."""
    rows, block, along, made, state, _, _ = ends
    for j in rows:
        force = made[j, SPRING] * state[j, STRETCH]
        for axis in range(3):
            forces[block[j], axis] += force * along[j, axis]


@njit(nogil=True)
def _move_ends(ends: Ends, cycle: int, velocity: FloatArray) -> None:  # pragma: no cover - compiled
    """Move the ends of quiet boundaries in a cycle in which blocks got velocities (n, 3)."""
    rows, block, along, made, state, work, given = ends
    for j in rows:
        inverse, dashpot = made[j, INVERSE_MASS], made[j, DASHPOT]
        push, half, before = (
            made[j, PUSH] * given[cycle],
            made[j, DASHPOT] * made[j, INVERSE_MASS] / 2,
            state[j, VELOCITY],
        )
        pulled = push - made[j, SPRING] * state[j, STRETCH]
        after = (before * (1.0 - half) + pulled * inverse) / (1.0 + half)
        mean = (before + after) / 2
        work[j, PUSHED] += push * mean
        work[j, LEFT] += dashpot * mean * mean
        state[j, VELOCITY] = after
        state[j, STRETCH] += after
        for axis in range(3):
            state[j, STRETCH] -= along[j, axis] * velocity[block[j], axis]


@njit(nogil=True)
def move_shaken(
    own: IntArray,
    supports: tuple[IntArray, FloatArray, FloatArray],
    inverse_mass: FloatArray,
    base: tuple[FloatArray, float],
    shaken: tuple[FloatArray, FloatArray],
    ends: Ends | None,
    cycle: int,
    room: FloatArray,
    vectors: FloatArray,
    velocity: FloatArray,
    here: FloatArray,
    there: FloatArray,
) -> None:  # pragma: no cover - compiled
    """Move blocks under forces for a cycle, from `here` to `there`.

    Parameters
    ----------
    own : (k,) int64
        Blocks without a support that are moved here.
    supports : blocks (l,), projectors (l, 3, 3), prescribed (n, 3)
        As `kernels.advance` takes them.
    inverse_mass : (n, 3) float64
        Over the square of a cycle.
    base : mass (n, 3), acceleration
        Masses along the movement of the base, and its acceleration in this cycle [m]: the forces contain it.
    shaken : drag (n, 3), work (n, 5)
        Part of its velocity that a block loses in a cycle; the sums, see `BASE` and the others.
    ends, cycle : Ends or None, int
        Ends of quiet boundaries, and the number of the cycle in their input.
    room, vectors : (2, n, 3), (3, 3) float64
        Forces of all, and of the bolts alone, which all are to be added. Room to work in.
    velocity : (n, 3) float64 [m, m, rad]
        Movement in a cycle; it changes in place.
    """
    held, projector, _ = supports
    drag, before, after, pushed = shaken[0], vectors[0], vectors[1], vectors[2]
    if ends is not None:
        _add_ends(ends, room[0])
    for i in own:
        for axis in range(3):
            pushed[axis] = room[0, i, axis] + room[1, i, axis]
        _accelerate(i, pushed, inverse_mass, drag, velocity, before, after)
        _keep(i, before, after, inverse_mass, base, shaken, room, velocity, here, there)
    for j in range(held.size):
        i = held[j]
        for axis in range(3):
            pushed[axis] = 0.0
            for k in range(3):
                pushed[axis] += projector[j, k, axis] * (room[0, i, k] + room[1, i, k])
        _accelerate(i, pushed, inverse_mass, drag, velocity, before, after)
        for axis in range(3):
            pushed[axis] = 0.0
            for k in range(3):
                pushed[axis] += projector[j, axis, k] * after[k]
        _keep(i, before, pushed, inverse_mass, base, shaken, room, velocity, here, there)
    if ends is not None:
        _move_ends(ends, cycle, velocity)


@njit(nogil=True, forceinline=True)
def _accelerate(
    i: int,
    force: FloatArray,
    inverse_mass: FloatArray,
    drag: FloatArray,
    velocity: FloatArray,
    before: FloatArray,
    after: FloatArray,
) -> None:  # pragma: no cover - compiled
    """Set the velocity of a block before and after a cycle under a force (3,)."""
    for axis in range(3):
        half = drag[i, axis] / 2
        before[axis] = velocity[i, axis]
        after[axis] = (before[axis] * (1.0 - half) + force[axis] * inverse_mass[i, axis]) / (1.0 + half)


@njit(nogil=True, forceinline=True)
def _keep(
    i: int,
    before: FloatArray,
    after: FloatArray,
    inverse_mass: FloatArray,
    base: tuple[FloatArray, float],
    shaken: tuple[FloatArray, FloatArray],
    room: FloatArray,
    velocity: FloatArray,
    here: FloatArray,
    there: FloatArray,
) -> None:  # pragma: no cover - compiled
    """Move a block with a velocity, and add up work and peaks."""
    mass, acceleration = base
    drag, work = shaken
    speed, change = 0.0, 0.0
    for axis in range(3):
        mean = (before[axis] + after[axis]) / 2
        work[i, BASE] -= acceleration * mass[i, axis] * mean
        work[i, BOLTS] += room[1, i, axis] * mean
        if drag[i, axis] > 0.0:
            work[i, DRAG] += drag[i, axis] / inverse_mass[i, axis] * mean * mean
        velocity[i, axis] = after[axis]
        there[i, axis] = here[i, axis] + after[axis]
        if axis < 2:
            speed += after[axis] * after[axis]
            change += (after[axis] - before[axis] + acceleration * mass[i, axis] * inverse_mass[i, axis]) ** 2
    work[i, SPEED] = max(work[i, SPEED], speed)
    work[i, ACCELERATION] = max(work[i, ACCELERATION], change)
