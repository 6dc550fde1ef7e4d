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
    supports: tuple[IntArray, FloatArray, FloatArray],
    contacts: tuple[IntArray, IntArray, ChunkArray, ChunkArray, ChunkArray, ChunkArray, ChunkArray, ChunkArray | None],
    bolts: tuple[FloatArray, ...] | None,
    loads: tuple[FloatArray, FloatArray, FloatArray],
    constants: tuple[FloatArray, FloatArray, float],
    velocity: FloatArray,
    moved: FloatArray,
    turns: SingleArray,
    room: tuple[FloatArray, FloatArray, ChunkArray],
    shaken: tuple[FloatArray, FloatArray] | None,
    ends: Ends | None,
) -> int:  # pragma: no cover - compiled
    """Go through cycles of unit time, and return how many: fewer where a block has moved too far.

    Parameters
    ----------
    cycles : int, meeting : (3,) int64, farthest : float [m], own : (k,) uint32
        How many, and the meeting of all threads; a block that moved further ends them. Blocks without a support.
    supports : blocks (l,) uint32, projectors (l, 3, 3), prescribed (n, 3)
        Supported ones that are moved here; onto their free axes; movement prescribed in a cycle.
    contacts : block_a, block_b, contacts, strengths, closures, slips, growths, works
        As `add_contact_forces` takes them: all contacts of the blocks that are moved here.
    bolts, shaken, ends : tuples of arrays or None
        As `add_bolts` takes them. Drag (n, 3) and work (n, 5) of shaken blocks as `move_shaken` takes them, and the
        ends of their quiet boundaries. Parts that are None are not compiled in.
    loads : acting (n, 3), ramped_load (n, 3), unramped_fraction (cycles,)
        Forces at the reference without the bolts'; part of them that is brought on in a ramp; how much of that part
        does not act yet, by cycle. Of shaken blocks: masses along the base's movement, its acceleration.
    constants : inverse_mass (n, 3), scale (n, 3), damping, velocity : (n, 3) float64 [m, m, rad]
        Masses over the square of a cycle; as in `BlockSystem`; as `faster` takes it. Movement in a cycle.
    moved : (2, n, 3) float64, turns : (2, 2, n) float32
        Movement since the reference, sine and versine of its turns, after an even and an odd number of cycles. So
        threads may each move a part of the blocks.
    room : (1 or 2, n, 3), (3, 3) float64, (1,) ROOM
        To work in: forces, a block's vectors, a chunk of contacts.
    """
    held, forces = supports[0], room[0][0]
    for cycle in range(cycles):
        here, there = moved[cycle % 2], moved[(cycle + 1) % 2]
        now, then = turns[cycle % 2], turns[(cycle + 1) % 2]
        _begin(own, held, loads, cycle, room[0])
        add_contact_forces(here, now[0], now[1], *contacts, room[2], forces)
        if bolts is not None:
            add_bolts(here, *bolts, room[0][-1])
        if shaken is None:
            _move(own, supports, constants, forces, velocity, here, there, then)
        else:
            given = (loads[1], loads[2][cycle]), shaken, ends, cycle
            move_shaken(own, supports, constants[0], *given, room[0], room[1], velocity, here, there)
            set_turns(there, own, then[0], then[1])
            set_turns(there, held, then[0], then[1])
        if not meet(meeting, cycle + 1) or _ends(cycle, there, constants[1], farthest):
            return cycle + 1
    return cycles


@njit(nogil=True)
def _begin(
    own: IntArray, held: IntArray, loads: tuple[FloatArray, FloatArray, FloatArray], cycle: int, forces: FloatArray
) -> None:  # pragma: no cover - compiled
    """Set forces (1 or 2, n, 3) of blocks without and with supports to the loads of a cycle; those of bolts to zero."""
    _set_loads(own, loads, cycle, forces[0])
    _set_loads(held, loads, cycle, forces[0])
    for part in range(1, forces.shape[0]):
        for i in range(forces.shape[1]):
            for axis in range(3):
                forces[part, i, axis] = 0.0


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
    supports: tuple[IntArray, FloatArray, FloatArray],
    constants: tuple[FloatArray, FloatArray, float],
    forces: FloatArray,
    velocity: FloatArray,
    here: FloatArray,
    there: FloatArray,
    turns: SingleArray,
) -> None:  # pragma: no cover - compiled
    """Move blocks under forces (n, 3) for a cycle, from `here` to `there`; set the turns (2, n) there."""
    inverse_mass, _, damping = constants
    _accelerate(own, forces, inverse_mass, damping, velocity, here, there)
    _accelerate_supported(*supports, forces, inverse_mass, damping, velocity, here, there)
    set_turns(there, own, turns[0], turns[1])
    set_turns(there, supports[0], turns[0], turns[1])


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
def _accelerate(
    own: IntArray,
    forces: FloatArray,
    inverse_mass: FloatArray,
    damping: float,
    velocity: FloatArray,
    here: FloatArray,
    there: FloatArray,
) -> None:  # pragma: no cover - compiled
    """Move the blocks `own` for a cycle."""
    for i in own:
        for axis in range(3):
            velocity[i, axis] = faster(forces[i, axis], velocity[i, axis], inverse_mass[i, axis], damping)
            there[i, axis] = here[i, axis] + velocity[i, axis]


@njit(nogil=True, forceinline=True)
def faster(force: float, velocity: float, inverse_mass: float, damping: float) -> float:  # pragma: no cover - compiled
    """Return the velocity after a cycle; a part `damping` of the force acts against the velocity (Cundall 1987)."""
    damped = damping if force * velocity > 0.0 else -damping
    return velocity + (1.0 - damped) * force * inverse_mass


@njit(nogil=True)
def _accelerate_supported(
    held: IntArray,
    projector: FloatArray,
    prescribed: FloatArray,
    forces: FloatArray,
    inverse_mass: FloatArray,
    damping: float,
    velocity: FloatArray,
    here: FloatArray,
    there: FloatArray,
) -> None:  # pragma: no cover - compiled
    """Move blocks with supports along their free axes for a cycle, and by `prescribed` (n, 3) with their supports."""
    for j in range(held.size):
        i = held[j]
        v, mass = velocity[i], inverse_mass[i]
        x, y, turn = _projected(projector[j].T, forces[i, 0], forces[i, 1], forces[i, 2])
        x, y = faster(x, v[0], mass[0], damping), faster(y, v[1], mass[1], damping)
        turn = faster(turn, v[2], mass[2], damping)
        v[0], v[1], v[2] = _projected(projector[j], x, y, turn)
        for axis in range(3):
            there[i, axis] = here[i, axis] + v[axis] + prescribed[i, axis]


@njit(nogil=True)
def _projected(
    projector: FloatArray, x: float, y: float, turn: float
) -> tuple[float, float, float]:  # pragma: no cover - compiled
    return (
        projector[0, 0] * x + projector[0, 1] * y + projector[0, 2] * turn,
        projector[1, 0] * x + projector[1, 1] * y + projector[1, 2] * turn,
        projector[2, 0] * x + projector[2, 1] * y + projector[2, 2] * turn,
    )


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
