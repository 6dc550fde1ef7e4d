"""Compiled cycles of explicit motion: forces of contacts and bolts, blocks accelerated by them.

A window of cycles starts from a reference position at which all forces are known; see `contact_kernels`.
"""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.compiled import njit
from bsm_mesh.solve.motion.bolt_kernels import add_bolts
from bsm_mesh.solve.motion.contact_columns import ChunkArray, SingleArray
from bsm_mesh.solve.motion.contact_kernels import add_contact_forces
from bsm_mesh.solve.motion.meeting import meet
from bsm_mesh.solve.motion.shaken_kernels import Ends, move_shaken

CHECK_EVERY = 10  # cycles between looks at how far blocks have moved: a look reads every position once more


@njit(nogil=True)
def advance(
    cycles: int,
    meeting: IntArray,
    farthest: float,
    own: IntArray,
    supports: tuple[IntArray, IntArray, FloatArray, FloatArray],
    contacts: tuple[IntArray, IntArray, ChunkArray, ChunkArray, ChunkArray, ChunkArray, ChunkArray, ChunkArray | None],
    bolts: tuple[FloatArray, ...] | None,
    loads: tuple[FloatArray, FloatArray, FloatArray],
    constants: tuple[FloatArray, FloatArray, float],
    velocity: FloatArray,
    moved: FloatArray,
    turns: SingleArray,
    room: FloatArray,
    shaken: tuple[FloatArray, FloatArray] | None,
    ends: Ends | None,
) -> int:  # pragma: no cover - compiled
    """Go through cycles of unit time, and return how many: fewer where a block has moved too far.

    Parameters
    ----------
    cycles : int, meeting : (3,) int64, farthest : float [m], own : (k,) uint32
        How many, and the meeting of all threads; a block that moved further ends them. Blocks without a support.
    supports : rows, blocks (l,), projectors (l, 3, 3), prescribed (n, 3)
        Which of the supported ones are moved here; all of them; onto their free axes; prescribed in a cycle.
    contacts : block_a, block_b, contacts, strengths, closures, slips, growths, works
        As `add_contact_forces` takes them: all contacts of the blocks that are moved here.
    bolts, shaken, ends : tuples of arrays or None
        As `add_bolts` takes them. Drag (n, 3) and work (n, 5) of shaken blocks as `move_shaken` takes them, and the
        ends of their quiet boundaries. Parts that are None are not compiled in.
    loads : acting (n, 3), ramped_load (n, 3), unramped_fraction (cycles,)
        Forces at the reference without the bolts'; part of them that is brought on in a ramp; how much of that part
        does not act yet, by cycle. Of shaken blocks: masses along the base's movement, its acceleration.
    constants : inverse_mass (n, 3), scale (n, 3), damping, velocity : (n, 3) float64 [m, m, rad]
        Masses over the square of a cycle; as in `BlockSystem`; as `accelerate` takes it. Movement in a cycle.
    moved : (2, n, 3) float64, turns : (2, 2, n) float32, room : (1 or 2, n, 3) float64
        Movement since the reference, sine and versine of its turns, after an even and an odd number of cycles: so
        threads may each move a part of the blocks. Room to work in.
    """
    held, forces = supports[1][supports[0]], room[0]
    for cycle in range(cycles):
        here, there = moved[cycle % 2], moved[(cycle + 1) % 2]
        now, then = turns[cycle % 2], turns[(cycle + 1) % 2]
        _set_loads(own, loads, cycle, forces)
        _set_loads(held, loads, cycle, forces)
        add_contact_forces(here, now[0], now[1], *contacts, forces)
        if shaken is not None:
            room[1] = 0.0
        if bolts is not None:
            add_bolts(here, *bolts, room[-1])
        if shaken is None:
            _move(own, supports, constants, forces, velocity, here, there, then)
        else:
            given = (loads[1], loads[2][cycle]), shaken, ends, cycle
            move_shaken(own, supports, constants[0], *given, room, velocity, here, there)
            set_turns(there, own, then[0], then[1])
            set_turns(there, held, then[0], then[1])
        if not meet(meeting, cycle + 1) or _ends(cycle, there, constants[1], farthest):
            return cycle + 1
    return cycles


@njit(nogil=True)
def _set_loads(
    blocks: IntArray, loads: tuple[FloatArray, FloatArray, FloatArray], cycle: int, forces: FloatArray
) -> None:  # pragma: no cover - compiled
    """Set the forces (n, 3) of some blocks (k,) to the loads of a cycle, as `advance` takes them."""
    acting, ramped_load, unramped_fraction = loads
    left = unramped_fraction[cycle]
    for i in blocks:
        for axis in range(3):
            forces[i, axis] = acting[i, axis]
        if left != 0.0:  # once it all acts, nothing more is read
            for axis in range(3):
                forces[i, axis] -= left * ramped_load[i, axis]


@njit(nogil=True)
def _move(
    own: IntArray,
    supports: tuple[IntArray, IntArray, FloatArray, FloatArray],
    constants: tuple[FloatArray, FloatArray, float],
    forces: FloatArray,
    velocity: FloatArray,
    here: FloatArray,
    there: FloatArray,
    turns: SingleArray,
) -> None:  # pragma: no cover - compiled
    """Move blocks under forces (n, 3) for a cycle, from `here` to `there`; set the turns (2, n) there."""
    rows, supported, projector, prescribed = supports
    inverse_mass, _, damping = constants
    accelerate(own, forces, inverse_mass, damping, velocity, here, there)
    accelerate_supported(rows, supported, projector, forces, inverse_mass, damping, prescribed, velocity, here, there)
    set_turns(there, own, turns[0], turns[1])
    set_turns(there, supported[rows], turns[0], turns[1])


@njit(nogil=True)
def set_turns(
    here: FloatArray, own: IntArray, sine: SingleArray, versine: SingleArray
) -> None:  # pragma: no cover - compiled
    """Set sine and versine (1 - cosine) of the turns of blocks `own` in a movement (n, 3).

    Those of most turns by their series, which leave out less than 1e-9 of them. Splinters may spin within a window.
    """
    for i in own:
        turn = here[i, 2]
        square = turn * turn
        if square < 0.01:  # a turn of a tenth
            sine[i] = turn * (1.0 - square / 6.0 * (1.0 - square / 20.0))
            versine[i] = square / 2.0 * (1.0 - square / 12.0 * (1.0 - square / 30.0))
        else:
            sine[i], versine[i] = np.sin(turn), 2.0 * np.sin(turn / 2.0) ** 2


@njit(nogil=True)
def accelerate(
    own: IntArray,
    forces: FloatArray,
    inverse_mass: FloatArray,
    damping: float,
    velocity: FloatArray,
    here: FloatArray,
    there: FloatArray,
) -> None:  # pragma: no cover - compiled
    """Move the blocks `own` for a cycle; a part `damping` of each force acts against the velocity (Cundall 1987)."""
    for i in own:
        for axis in range(3):
            force = forces[i, axis]
            damped = damping if force * velocity[i, axis] > 0.0 else -damping
            velocity[i, axis] += (1.0 - damped) * force * inverse_mass[i, axis]
            there[i, axis] = here[i, axis] + velocity[i, axis]


@njit(nogil=True)
def accelerate_supported(
    rows: IntArray,
    supported: IntArray,
    projector: FloatArray,
    forces: FloatArray,
    inverse_mass: FloatArray,
    damping: float,
    prescribed: FloatArray,
    velocity: FloatArray,
    here: FloatArray,
    there: FloatArray,
) -> None:  # pragma: no cover - compiled
    """Move blocks with supports along their free axes for a cycle, and by `prescribed` (n, 3) with their supports.

    `rows` (k,) are those of `supported` (l,) and of the `projector` (l, 3, 3) onto the free axes.
    """
    pushed, along = np.empty(3), np.empty(3)
    for j in rows:
        i = supported[j]
        _project(projector[j].T, forces[i], pushed)
        for axis in range(3):
            damped = damping if pushed[axis] * velocity[i, axis] > 0.0 else -damping
            along[axis] = velocity[i, axis] + (1.0 - damped) * pushed[axis] * inverse_mass[i, axis]
        _project(projector[j], along, velocity[i])
        for axis in range(3):
            there[i, axis] = here[i, axis] + velocity[i, axis] + prescribed[i, axis]


@njit(nogil=True)
def _project(projector: FloatArray, vector: FloatArray, out: FloatArray) -> None:  # pragma: no cover - compiled
    for axis in range(3):
        out[axis] = projector[axis, 0] * vector[0] + projector[axis, 1] * vector[1] + projector[axis, 2] * vector[2]


@njit(nogil=True)
def _ends(cycle: int, here: FloatArray, scale: FloatArray, most: float) -> bool:  # pragma: no cover - compiled
    """Return whether a block moved further than `most` [m], or is nowhere any more; not after every cycle."""
    if cycle % CHECK_EVERY != CHECK_EVERY - 1:
        return False
    for i in range(here.shape[0]):
        for axis in range(3):
            if not abs(here[i, axis]) <= most * scale[i, axis]:
                return True
    return False
