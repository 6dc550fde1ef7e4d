"""Compiled contact forces of explicit motion: how they change in the moving geometry within a window of cycles.

All forces are known in double precision at the window's reference position. Only their changes are worked out, from
movements since by exact finite rotations. So constants of contacts may be in single precision, which halves what a
cycle reads from memory: they give changes of forces to 1e-7 of these, and a block comes to rest as exactly as its
residual at the reference is known.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.compiled import njit
from bsm_mesh.model.joint_laws.barton_bandis import STEEPEST
from bsm_mesh.model.joint_laws.shear_stiffness import ShearCurve

SingleArray = NDArray[np.float32]
RecordArray = NDArray[np.void]  # of SPRING, STATE: a record is no reference that would be counted, unlike an array

SPRING = np.dtype(
    [
        ("normal_stiffness", "f4"),
        ("shear_stiffness", "f4"),
        ("trial_pressure", "f4"),  # at the reference: below 0 what it would take to close the contact
        ("pressure", "f4"),  # that the reference forces contain
        ("shear", "f4"),
        ("low", "f4"),  # least and greatest movement along the edge within which the corner meets it
        ("high", "f4"),
        ("first", "f4"),  # intercept of a line of the shear strength over the pressure; of two lines the lower governs
        ("first_slope", "f4"),
        ("second", "f4"),
        ("second_slope", "f4"),
        ("residual", "f4"),  # of the line once it has failed
        ("residual_slope", "f4"),
        ("dashpot", "f4"),  # of the normal force, over a cycle
        ("stiffening", "f4"),  # of a joint that closes by a hyperbola, as in `Hyperbolic.stiffening`; 0: of none
        ("rock_share", "f4"),
    ]
)  # what is constant of a contact in a window [N/m2, N/m, m]
STATE = np.dtype([("shear", "f4"), ("along", "f4"), ("gap", "f4"), ("tension", "f4")])  # `along`, `gap`: movements
SLIP = np.dtype([("slid", "f4"), ("dilation", "f4"), ("room", "f4")])
"""How far a contact has slid in the window [m], the slope by which that opens it, and on which slip it does so."""
GROWTH = np.dtype(
    [(name, "f4") for name in (*ShearCurve._fields, "length", "compliance", "stiffest", "stiffness", "pressure")]
)
"""Shear stiffness by the pressure, as `Growing` has it; not above `stiffest`, which masses allow for; both of last."""
ZERO = np.float32(0.0)
LEAST_SHARE = np.float32(1 / 16)  # of the rock in the compliance: in a window a joint becomes at most so much stiffer
LEANS = np.float32(STEEPEST)  # greatest angle of Barton's strength [degrees]
DEGREE = np.float32(np.pi / 180)
ONE = np.float32(1.0)
FLATTEST = np.float32(1e-2)  # least denominator of a hyperbola's change: the joint is closed as far as it goes
CONTACTED, BROKEN, FAILED = np.uint8(1), np.uint8(2), np.uint8(4)  # what happened to a contact in the window
FIRST_LASTS, SECOND_LASTS = np.uint8(8), np.uint8(16)  # slip on the first, the second line is for good


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
    block_a: IntArray, block_b: IntArray, frame: SingleArray, spring: RecordArray, n: int
) -> FloatArray:  # pragma: no cover - compiled
    """Return what bounds the highest frequency of n blocks, (n, 3) [N/m2, N/m2, N]: Gershgorin sums over contacts.

    A cycle of unit time is stable if no mass is below them: the stiffer spring of a contact counts twice, for both
    its blocks' movement and for translation and turn, the latter times the square of the arm.
    """
    sums = np.zeros((n, 3))
    for k in range(block_a.size):
        normal = spring[k].normal_stiffness / max(spring[k].rock_share, LEAST_SHARE)  # as stiff as it may become
        stiffness = np.float64(max(normal, spring[k].shear_stiffness))
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
    spring: RecordArray,
    state: RecordArray,
    events: NDArray[np.uint8],
    slips: RecordArray,
    growths: RecordArray,
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
    spring : (m,) SPRING
        Constants of the contacts.
    state : (m,) STATE
        Shear force, movement along the edge, gap since the reference, tensile strength; they change in place.
    events : (m,) uint8
        FIRST_LASTS, SECOND_LASTS, as they come; CONTACTED, BROKEN, FAILED are added, in place.
    slips : (m,) SLIP
        How far contacts have slid, in place; empty where nothing depends on it.
    growths : (m,) GROWTH
        Shear stiffness that grows with pressure; empty where none does.
    """
    for k in range(block_a.size):
        a, b = block_a[k], block_b[k]
        rx, ry, ax, ay, tx, ty = frame[k, 0], frame[k, 1], frame[k, 2], frame[k, 3], frame[k, 4], frame[k, 5]
        sb, vb = sine[b], versine[b]
        dax, day = _change_by_turn(ax, ay, sine[a], versine[a])  # by which a's turn moves the corner
        ex, ey = np.float32(here[a, 0] - here[b, 0]) + dax, np.float32(here[a, 1] - here[b, 1]) + day
        gap, along = _as_b_sees_it(ex, ey, rx, ry, tx, ty, sb, vb)
        if slips.size:
            gap -= slips[k].dilation * min(slips[k].slid, slips[k].room)
        pressure, stiffness, kept = _pressure(gap, spring[k]), spring[k].shear_stiffness, ONE
        if growths.size and growths[k].factor > ZERO:
            stiffness, kept = _grown(pressure, growths[k])
        pressure, shear, excess, event = _respond(pressure, gap, along, stiffness, kept, spring[k], state[k], events[k])
        events[k] |= event
        if slips.size and excess > ZERO and stiffness > ZERO:
            slips[k].slid += excess / stiffness
        p0, s0 = spring[k].pressure, spring[k].shear
        if pressure == ZERO and shear == ZERO and p0 == ZERO and s0 == ZERO:
            continue
        fx, fy = _change_of_force(pressure - p0, shear - s0, p0, s0, tx, ty, sb, vb)
        fx0, fy0 = p0 * ty - s0 * tx, -p0 * tx - s0 * ty
        _add_force(forces, a, fx, fy, (ax + dax) * fy - (ay + day) * fx + dax * fy0 - day * fx0)
        _add_force(forces, b, -fx, -fy, -((rx + ex) * fy - (ry + ey) * fx + ex * fy0 - ey * fx0))


@njit(nogil=True, forceinline=True)
def _add_force(
    forces: FloatArray, block: int, fx: float, fy: float, moment: float
) -> None:  # pragma: no cover - compiled
    """Add a force and its moment to a block's of forces (n, 3)."""
    forces[block, 0] += fx
    forces[block, 1] += fy
    forces[block, 2] += moment


@njit(nogil=True, forceinline=True)
def _as_b_sees_it(
    ex: float, ey: float, rx: float, ry: float, tx: float, ty: float, sine: float, versine: float
) -> tuple[float, float]:  # pragma: no cover - compiled
    """Return gap and movement along the edge of a corner that moves by (ex, ey) from (rx, ry), as b turns."""
    qx = ex + sine * (ry + ey) - versine * (rx + ex)
    qy = ey - sine * (rx + ex) - versine * (ry + ey)
    return qx * ty - qy * tx, qx * tx + qy * ty


@njit(nogil=True, forceinline=True)
def _change_by_turn(
    x: float, y: float, sine: float, versine: float
) -> tuple[float, float]:  # pragma: no cover - compiled
    """Return by how much a turn changes a vector, from its sine and versine."""
    return -versine * x - sine * y, sine * x - versine * y


@njit(nogil=True, forceinline=True)
def _pressure(gap: np.float32, spring: Any) -> Any:  # pragma: no cover - compiled
    """Return the pressure of a contact that has opened by `gap` [m] since the reference; below 0: as if in tension."""
    pressure = spring.trial_pressure - spring.normal_stiffness * gap
    if spring.stiffening > ZERO:
        pressure = _hyperbolic(pressure, spring.trial_pressure, spring.stiffening, spring.rock_share)
    return pressure


@njit(nogil=True)
def _grown(pressure: Any, growth: Any) -> tuple[Any, Any]:  # pragma: no cover - compiled
    """Return the shear stiffness at a pressure, and the part of the shear force that is left as it falls to that."""
    stress = min(max(pressure / growth.length, growth.least), growth.most)
    own = growth.factor * stress**growth.exponent * growth.length
    if growth.roughness > ZERO:
        decades = np.log10(max(growth.wall / stress, ONE))
        own *= np.tan(min(growth.angle + growth.roughness * decades, LEANS) * DEGREE)
    stiffness = min(ONE / (growth.compliance + ONE / own), growth.stiffest)
    kept = min(stiffness / growth.stiffness, ONE)
    growth.stiffness, growth.pressure = stiffness, pressure
    return stiffness, kept


@njit(nogil=True, forceinline=True)
def _respond(
    pressure: Any, gap: np.float32, along: np.float32, stiffness: Any, kept: Any, spring: Any, state: Any, flags: Any
) -> tuple[Any, Any, Any, Any]:  # pragma: no cover - compiled
    """Return pressure, shear, by how much that is cut, and what happened to a contact moved by `gap`, `along` [m].

    Its shear stiffness is given, and the part of its shear force that is `kept`. Its state is updated.
    """
    shear, excess, tension, event = ZERO, ZERO, state.tension, np.uint8(0)
    closed = pressure > ZERO or (tension > ZERO and pressure >= -tension)
    if closed and along >= spring.low and along <= spring.high:
        event = CONTACTED
        pressure = max(pressure - spring.dashpot * (gap - state.gap), -tension)
        shear = kept * state.shear + stiffness * (along - state.along)
        first = spring.first + spring.first_slope * pressure
        second = spring.second + spring.second_slope * pressure
        strength = first if first <= second else second
        if flags & FAILED:
            strength = spring.residual + spring.residual_slope * pressure
        strength = max(strength, ZERO)
        if abs(shear) > strength:
            excess = abs(shear) - strength
            shear = strength if shear > ZERO else -strength
            if flags & (FIRST_LASTS if first <= second else SECOND_LASTS):
                event |= FAILED
    else:
        pressure = ZERO
        if tension > ZERO:
            state.tension = ZERO
            event = BROKEN
    state.shear, state.along, state.gap = shear, along, gap
    return pressure, shear, excess, event


@njit(nogil=True, forceinline=True)
def _hyperbolic(linear: Any, trial: Any, stiffening: Any, share: Any) -> Any:  # pragma: no cover - compiled
    """Return the pressure of a joint that closes by a hyperbola, from that of its tangent (`Hyperbolic.stiffening`)."""
    base = max(trial, np.float32(0.0))
    change = linear - base
    if base + change <= np.float32(0.0):
        return linear
    b = np.float32(1.0) - change * stiffening
    root = np.sqrt(max(b * b + np.float32(4.0) * change * stiffening * share, np.float32(0.0)))
    return base + np.float32(2.0) * change / max(b + root, FLATTEST)


@njit(nogil=True, forceinline=True)
def _change_of_force(
    dp: float, ds: float, p0: float, s0: float, tx: float, ty: float, sine: float, versine: float
) -> tuple[float, float]:  # pragma: no cover - compiled
    """Return by how much the force on a has changed: pressure and shear p0, s0 turn with the edge, dp and ds are new.

    The edge has the direction (tx, ty) at the reference, and has turned since; `sine` and `versine` are of that.
    """
    dtx, dty = _change_by_turn(tx, ty, sine, versine)
    fx = dp * (ty + dty) + p0 * dty - ds * (tx + dtx) - s0 * dtx
    fy = -dp * (tx + dtx) - p0 * dtx - ds * (ty + dty) - s0 * dty
    return fx, fy
