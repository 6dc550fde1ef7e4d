"""Compiled cycles of explicit motion: contact forces in the moving geometry, blocks accelerated by them.

A window of cycles starts from a reference position at which all forces are known in double precision. Within it
only their changes are worked out, from movements since the reference by exact finite rotations. So constants of
contacts may be in single precision, which halves what a cycle reads from memory: they give changes of forces to
1e-7 of these, and a block comes to rest as exactly as its residual at the reference is known.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.compiled import njit
from bsm_mesh.solve.motion.bolt_kernels import add_bolts

SingleArray = NDArray[np.float32]

CHECK_EVERY = 10  # cycles between looks at how far blocks have moved
CONTACTED, BROKEN, FAILED = np.uint8(1), np.uint8(2), np.uint8(4)  # what happened to a contact in the window


@njit()
def frames(
    position: FloatArray, block_a: IntArray, block_b: IntArray, geometry: FloatArray, rows: IntArray
) -> SingleArray:  # pragma: no cover - compiled
    """Return the reference frames of contacts, (k, 6) [m; -].

    Vectors from b's and from a's centroid to the corner, and the edge's direction. `block_a`, `block_b` (k,) are
    those of the `rows` (k,) of `geometry` (m, 8), which `relative_positions` describes.
    """
    frame = np.empty((rows.size, 6), np.float32)
    cosine, sine = np.cos(position[:, 2]), np.sin(position[:, 2])
    for k in range(rows.size):
        a, b, given = block_a[k], block_b[k], geometry[rows[k]]
        ax, ay = cosine[a] * given[2] - sine[a] * given[3], sine[a] * given[2] + cosine[a] * given[3]
        frame[k, 0] = given[0] + (position[a, 0] - position[b, 0]) + ax
        frame[k, 1] = given[1] + (position[a, 1] - position[b, 1]) + ay
        frame[k, 2], frame[k, 3] = ax, ay
        frame[k, 4] = cosine[b] * given[6] - sine[b] * given[7]
        frame[k, 5] = sine[b] * given[6] + cosine[b] * given[7]
    return frame


@njit()
def stiffness_sums(
    block_a: IntArray, block_b: IntArray, frame: SingleArray, spring: SingleArray, n: int
) -> FloatArray:  # pragma: no cover - compiled
    """Return what bounds the highest frequency of n blocks, (n, 3) [N/m2, N/m2, N]: Gershgorin sums over contacts.

    A cycle of unit time is stable if no mass is below them: the stiffer spring of a contact counts twice, for both
    its blocks' movement and for translation and turn, the latter times the square of the arm.
    """
    sums = np.zeros((n, 3))
    for k in range(block_a.size):
        stiffness = np.float64(max(spring[k, 0], spring[k, 1]))
        rx, ry, ax, ay = frame[k, 0], frame[k, 1], frame[k, 2], frame[k, 3]
        sums[block_a[k], 0] += stiffness
        sums[block_b[k], 0] += stiffness
        sums[block_a[k], 2] += stiffness * (ax * ax + ay * ay)
        sums[block_b[k], 2] += stiffness * (rx * rx + ry * ry)
    sums[:, 1] = sums[:, 0]
    return sums


@njit(nogil=True)
def add_contact_forces(
    here: FloatArray,
    sine: SingleArray,
    versine: SingleArray,
    block_a: IntArray,
    block_b: IntArray,
    frame: SingleArray,
    spring: SingleArray,
    state: SingleArray,
    events: NDArray[np.uint8],
    forces: FloatArray,
) -> None:  # pragma: no cover - compiled
    """Add to forces (n, 3) by what those of contacts have changed since the reference, and carry on their state.

    Parameters
    ----------
    here : (n, 3) float64 [m, m, rad]
        Movement since the reference.
    sine, versine : (n,) float32
        Of the turns in it.
    block_a, block_b : (m,) int32
        Blocks of the corner and of the edge.
    frame : (m, 6) float32
        As `frames` returns it.
    spring : (m, 15) float32
        Normal and shear stiffness; at the reference: pressure, below 0 what it would take to close the contact;
        pressure and shear that the reference forces contain; least and greatest movement along the edge within which
        the corner meets it; intercepts and slopes over the pressure of the two lines of the shear strength, the lower
        of which governs, and of the residual one; 1 and 2 where slip on the first, the second line is for good; dashpot
        of the normal force, over a cycle.
    state : (m, 4) float32
        Shear force, movement along the edge, gap since the reference, tensile strength; they change in place.
    events : (m,) uint8
        CONTACTED, BROKEN, FAILED are added, in place.
    """
    zero = np.float32(0.0)
    for k in range(block_a.size):
        a, b = block_a[k], block_b[k]
        rx, ry, ax, ay = frame[k, 0], frame[k, 1], frame[k, 2], frame[k, 3]
        tx, ty = frame[k, 4], frame[k, 5]
        sa, va, sb, vb = sine[a], versine[a], sine[b], versine[b]
        dax, day = -va * ax - sa * ay, sa * ax - va * ay  # by which a's turn moves the corner
        ex = np.float32(here[a, 0] - here[b, 0]) + dax
        ey = np.float32(here[a, 1] - here[b, 1]) + day
        qx = ex + sb * (ry + ey) - vb * (rx + ex)  # the same as b sees it, which turns too
        qy = ey - sb * (rx + ex) - vb * (ry + ey)
        gap = qx * ty - qy * tx
        along = qx * tx + qy * ty
        kn, ks = spring[k, 0], spring[k, 1]
        borne, held = spring[k, 3], spring[k, 4]
        pressure = spring[k, 2] - kn * gap
        tension = state[k, 3]
        closed = pressure > zero or (tension > zero and pressure >= -tension)
        closed = closed and along >= spring[k, 5] and along <= spring[k, 6]
        shear = zero
        if closed:
            events[k] |= CONTACTED
            pressure = max(pressure - spring[k, 14] * (gap - state[k, 2]), -tension)
            shear = state[k, 0] + ks * (along - state[k, 1])
            first, second = spring[k, 7] + spring[k, 8] * pressure, spring[k, 9] + spring[k, 10] * pressure
            strength = first if first <= second else second
            if events[k] & FAILED:
                strength = spring[k, 11] + spring[k, 12] * pressure
            strength = max(strength, zero)
            if abs(shear) > strength:
                shear = strength if shear > zero else -strength
                if int(spring[k, 13]) & (1 if first <= second else 2):
                    events[k] |= FAILED
        else:
            pressure = zero
            if tension > zero:
                state[k, 3] = zero
                events[k] |= BROKEN
        state[k, 0], state[k, 1], state[k, 2] = shear, along, gap
        if pressure == zero and shear == zero and borne == zero and held == zero:
            continue
        dtx, dty = -vb * tx - sb * ty, sb * tx - vb * ty  # by which b's turn changes the edge's direction
        more, sheared = pressure - borne, shear - held
        fx = more * (ty + dty) + borne * dty - sheared * (tx + dtx) - held * dtx
        fy = -more * (tx + dtx) - borne * dtx - sheared * (ty + dty) - held * dty
        fx0, fy0 = borne * ty - held * tx, -borne * tx - held * ty
        forces[a, 0] += fx
        forces[a, 1] += fy
        forces[a, 2] += (ax + dax) * fy - (ay + day) * fx + dax * fy0 - day * fx0
        forces[b, 0] -= fx
        forces[b, 1] -= fy
        forces[b, 2] -= (rx + ex) * fy - (ry + ey) * fx + ex * fy0 - ey * fx0


@njit(nogil=True)
def go_on(
    cycles: int,
    begun: int,
    farthest: float,
    own: IntArray,
    supports: tuple[IntArray, IntArray, FloatArray, FloatArray],
    contacts: tuple[IntArray, IntArray, SingleArray, SingleArray, SingleArray, NDArray[np.uint8]],
    bolts: tuple[FloatArray, ...],
    loads: tuple[FloatArray, FloatArray, FloatArray],
    constants: tuple[FloatArray, FloatArray, float],
    velocity: FloatArray,
    moved: FloatArray,
    turns: SingleArray,
    forces: FloatArray,
) -> int:  # pragma: no cover - compiled
    """Go through cycles of unit time, and return how many: fewer where a block has moved too far.

    Parameters
    ----------
    cycles, begun : int
        How many, and how many there were in this window.
    farthest : float [m]
        A block that has moved farther since the reference ends it.
    own : (k,) int64
        Blocks without a support that are moved here; others are where `moved` has them.
    supports : rows, blocks (l,), projectors (l, 3, 3), drift (n, 3)
        Which of the supported blocks are moved here; all of them; onto their free axes; movement of their supports
        in a cycle.
    contacts : block_a, block_b, frame, spring, state, events
        As `add_contact_forces` takes them: all contacts of the blocks that are moved here.
    bolts : tuple of arrays
        As `add_bolts` takes them; empty arrays where there are none.
    loads : acting (n, 3), missing (n, 3), unramped (cycles,)
        Forces at the reference without the bolts'; part of them that is brought on in a ramp; how much of that part
        does not act yet, in every cycle.
    constants : inverse_mass (n, 3), scale (n, 3), damping
        Masses over the square of a cycle; as in `BlockSystem`; as `accelerate` takes it.
    velocity : (n, 3) float64 [m, m, rad]
        Movement in a cycle; it changes in place.
    moved : (2, n, 3) float64, turns : (2, 2, n) float32
        Movement since the reference and the sine and versine of its turns, after an even and an odd number of
        cycles; they change in turns, so that threads may each move a part of the blocks.
    forces : (n, 3) float64
        Room to work in.
    """
    rows, supported, projector, drift = supports
    acting, missing, unramped = loads
    inverse_mass, scale, damping = constants
    for cycle in range(cycles):
        here, there = moved[(begun + cycle) % 2], moved[(begun + cycle + 1) % 2]
        now, then = turns[(begun + cycle) % 2], turns[(begun + cycle + 1) % 2]
        left = unramped[cycle]
        for i in own:
            for axis in range(3):
                forces[i, axis] = acting[i, axis] - left * missing[i, axis]
        for j in rows:
            for axis in range(3):
                forces[supported[j], axis] = acting[supported[j], axis] - left * missing[supported[j], axis]
        add_contact_forces(here, now[0], now[1], *contacts, forces)
        add_bolts(here, *bolts, forces)
        accelerate(own, forces, inverse_mass, damping, velocity, here, there)
        accelerate_supported(rows, supported, projector, forces, inverse_mass, damping, drift, velocity, here, there)
        set_turns(there, own, then[0], then[1])
        set_turns(there, supported[rows], then[0], then[1])
        if cycle % CHECK_EVERY == CHECK_EVERY - 1 and _is_beyond(there, scale, farthest):
            return cycle + 1
    return cycles


@njit(nogil=True)
def set_turns(
    here: FloatArray, own: IntArray, sine: SingleArray, versine: SingleArray
) -> None:  # pragma: no cover - compiled
    """Set sine and versine (1 - cosine) of the turns of blocks `own` in a movement (n, 3), by their series.

    Turns within a window are below 0.1; what the series leave out is below 1e-9 of them.
    """
    for i in own:
        turn = here[i, 2]
        square = turn * turn
        sine[i] = turn * (1.0 - square / 6.0 * (1.0 - square / 20.0))
        versine[i] = square / 2.0 * (1.0 - square / 12.0 * (1.0 - square / 30.0))


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
    drift: FloatArray,
    velocity: FloatArray,
    here: FloatArray,
    there: FloatArray,
) -> None:  # pragma: no cover - compiled
    """Move blocks with supports along their free axes for a cycle, and by `drift` (n, 3) with their supports.

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
            there[i, axis] = here[i, axis] + velocity[i, axis] + drift[i, axis]


@njit(nogil=True)
def _project(projector: FloatArray, vector: FloatArray, out: FloatArray) -> None:  # pragma: no cover - compiled
    for axis in range(3):
        out[axis] = projector[axis, 0] * vector[0] + projector[axis, 1] * vector[1] + projector[axis, 2] * vector[2]


@njit(nogil=True)
def _is_beyond(here: FloatArray, scale: FloatArray, most: float) -> bool:  # pragma: no cover - compiled
    """Return whether a block has moved farther than `most` [m], or is nowhere any more."""
    for i in range(here.shape[0]):
        for axis in range(3):
            if not abs(here[i, axis]) <= most * scale[i, axis]:
                return True
    return False
