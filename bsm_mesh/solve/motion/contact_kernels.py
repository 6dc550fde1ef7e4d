"""Compiled contact forces of explicit motion: how they change in the moving geometry within a window of cycles.

All forces are known in double precision at the window's reference position. Only their changes are worked out, from
movements since by exact finite rotations. So constants of contacts may be in single precision, which halves the
memory that a cycle reads: they give changes of forces to 1e-7 of these, and a block comes to rest as exactly as its
residual at the reference is known.

A chunk of contacts goes through short loops. Those that every contact needs have no branch, so that the compiler takes
several contacts at once; all that is loaded or stored is so unconditionally.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.compiled import njit
from bsm_mesh.solve.motion.contact_columns import WIDTH, ChunkArray, SingleArray
from bsm_mesh.solve.motion.joint_kernels import close, dilate, fail, grow, hold, slide, weaken
from bsm_mesh.solve.motion.work_kernels import add_dilation, add_work, begin_work, shear_with_dashpots

ZERO, ONE = np.float32(0.0), np.float32(1.0)
ROOM = np.dtype(
    [
        (name, "f4", (WIDTH,))
        for name in (
            *("x", "y", "sine_a", "versine_a", "sine_b", "versine_b"),  # movement of a's centroid from b's; turns
            *("turned_x", "turned_y", "gap", "along", "trial"),  # by which a's turn moves the corner; trial pressure
            *("tension", "pressure", "shear", "strength", "lasting", "closed", "excess"),  # see `weaken`; shear cut off
            *("force_x", "force_y", "moment_a", "moment_b"),
        )
    ]
)  # of a chunk within a cycle


@njit(nogil=True)
def add_contact_forces(
    here: FloatArray,
    sine: SingleArray,
    versine: SingleArray,
    block_a: IntArray,
    block_b: IntArray,
    contacts: ChunkArray,
    strengths: ChunkArray,
    closures: ChunkArray,
    slips: ChunkArray,
    growths: ChunkArray,
    works: ChunkArray | None,
    room: ChunkArray,
    forces: FloatArray,
) -> None:  # pragma: no cover - compiled
    """Add to forces (n, 3) by what those of contacts have changed since the reference, and carry on their state.

    Parameters
    ----------
    here, sine, versine : (n, 3) float64 [m, m, rad], (n,) float32
        Movement since the reference, sine and versine of the turns in it.
    block_a, block_b : (m,) uint32
        Blocks of the corner and of the edge.
    contacts : (c,) CONTACT
        Their state changes in place, as in the others.
    strengths, closures, slips, growths, works : (c,) STRENGTH, CLOSURE, SLIP, GROWTH, WORK or None
        Each empty where no contact needs it, the last None where no work is asked for.
    room : (1,) ROOM
        To work in.
    """
    t = room[0]
    for k in range(contacts.size):
        chunk, first, count = contacts[k], k * WIDTH, min(WIDTH, block_a.size - k * WIDTH)
        _gather(here, sine, versine, block_a, block_b, first, count, t)
        _approach(chunk, t)
        respond(k, contacts, strengths, closures, slips, growths, works, t)
        _change_forces(chunk, t)
        _scatter(block_a, block_b, first, count, t, forces)


@njit(nogil=True, forceinline=True)
def respond(
    k: int,
    contacts: ChunkArray,
    strengths: ChunkArray,
    closures: ChunkArray,
    slips: ChunkArray,
    growths: ChunkArray,
    works: ChunkArray | None,
    t: Any,
) -> None:  # pragma: no cover - compiled
    """Set pressures and shear forces of a chunk of contacts at its gaps and movements along edges, and carry on."""
    chunk = contacts[k]
    if works is not None:
        begin_work(chunk, works[k])
    if slips.size:
        dilate(slips[k], t)
    _set_trial_pressures(chunk, t)
    if closures.size:
        close(chunk, closures[k], t)
    if growths.size:
        grow(chunk, growths[k], t)
    if strengths.size:
        hold(strengths[k], t)
    _press(chunk, t)
    if strengths.size:
        weaken(strengths[k], t)
    if works is None:
        _shear(chunk, t)
    else:
        shear_with_dashpots(chunk, works[k], t)
    if strengths.size:
        fail(strengths[k], t)
    if works is not None:
        if slips.size:
            add_dilation(slips[k], works[k], t)
        add_work(chunk, works[k], t)
    if slips.size:
        slide(chunk, slips[k], t)


@njit(nogil=True, forceinline=True)
def _gather(
    here: FloatArray,
    sine: SingleArray,
    versine: SingleArray,
    block_a: IntArray,
    block_b: IntArray,
    first: int,
    count: int,
    t: Any,
) -> None:  # pragma: no cover - compiled
    """Set the movements and turns of the blocks of a chunk's contacts: from `first` on, so many."""
    for i in range(count):
        a, b = block_a[first + i], block_b[first + i]
        t.x[i], t.y[i] = np.float32(here[a, 0] - here[b, 0]), np.float32(here[a, 1] - here[b, 1])
        t.sine_a[i], t.versine_a[i], t.sine_b[i], t.versine_b[i] = sine[a], versine[a], sine[b], versine[b]


@njit(nogil=True, forceinline=True)
def _approach(c: Any, t: Any) -> None:  # pragma: no cover - compiled
    """Set the movement along the edge and the gap since the reference, as b sees them while it turns."""
    for i in range(WIDTH):
        tx, ty, sine, versine = c.tx[i], c.ty[i], t.sine_b[i], t.versine_b[i]
        turned_x, turned_y = _change_by_turn(c.ax[i], c.ay[i], t.sine_a[i], t.versine_a[i])
        ex, ey = t.x[i] + turned_x, t.y[i] + turned_y
        x, y = c.bx[i] + ex, c.by[i] + ey
        qx = ex + sine * y - versine * x
        qy = ey - sine * x - versine * y
        t.turned_x[i], t.turned_y[i] = turned_x, turned_y
        t.gap[i], t.along[i] = qx * ty - qy * tx, qx * tx + qy * ty


@njit(nogil=True, forceinline=True)
def _change_by_turn(
    x: float, y: float, sine: float, versine: float
) -> tuple[float, float]:  # pragma: no cover - compiled
    """Return by how much a turn changes a vector, from its sine and versine."""
    return -versine * x - sine * y, sine * x - versine * y


@njit(nogil=True, forceinline=True)
def _set_trial_pressures(c: Any, t: Any) -> None:  # pragma: no cover - compiled
    """Set the pressure of contacts that have opened by the gap since the reference; below 0: as if in tension."""
    for i in range(WIDTH):
        t.trial[i] = c.trial_pressure[i] - c.normal_stiffness[i] * t.gap[i]


@njit(nogil=True, forceinline=True)
def _press(c: Any, t: Any) -> None:  # pragma: no cover - compiled
    """Set which contacts are closed, their pressure with the dashpot's, and the shear strength at that."""
    for i in range(WIDTH):
        trial, tension, along, gap = t.trial[i], t.tension[i], t.along[i], t.gap[i]
        bears = (trial > ZERO) | ((tension > ZERO) & (trial >= -tension))
        closed = bears & (along >= c.low[i]) & (along <= c.high[i])
        pressure = max(trial - c.dashpot[i] * (gap - c.gap[i]), -tension)
        t.closed[i] = ONE if closed else ZERO
        t.pressure[i] = pressure if closed else ZERO
        t.strength[i] = c.first[i] + c.first_slope[i] * pressure
        c.gap[i] = gap


@njit(nogil=True, forceinline=True)
def _shear(c: Any, t: Any) -> None:  # pragma: no cover - compiled
    """Set the shear force within the strength, and the rest cut off; open contacts have none."""
    for i in range(WIDTH):
        along, closed = t.along[i], t.closed[i]
        trial = c.carried[i] + c.shear_stiffness[i] * (along - c.along[i])
        strength = max(t.strength[i], ZERO)
        shear = min(max(trial, -strength), strength) if closed > ZERO else ZERO
        excess = max(abs(trial) - strength, ZERO) if closed > ZERO else ZERO
        t.shear[i], t.excess[i] = shear, excess
        c.carried[i], c.along[i] = shear, along
        c.contacted[i] = max(c.contacted[i], closed)


@njit(nogil=True, forceinline=True)
def _change_forces(c: Any, t: Any) -> None:  # pragma: no cover - compiled
    """Set by how much the forces on a and their moments have changed: known ones turn with the edge, others are new."""
    for i in range(WIDTH):
        tx, ty, p0, s0 = c.tx[i], c.ty[i], c.pressure[i], c.shear[i]
        dp, ds = t.pressure[i] - p0, t.shear[i] - s0
        dtx, dty = _change_by_turn(tx, ty, t.sine_b[i], t.versine_b[i])
        fx = dp * (ty + dty) + p0 * dty - ds * (tx + dtx) - s0 * dtx
        fy = -dp * (tx + dtx) - p0 * dtx - ds * (ty + dty) - s0 * dty
        fx0, fy0 = p0 * ty - s0 * tx, -p0 * tx - s0 * ty
        turned_x, turned_y = t.turned_x[i], t.turned_y[i]
        ex, ey = t.x[i] + turned_x, t.y[i] + turned_y
        t.force_x[i], t.force_y[i] = fx, fy
        t.moment_a[i] = (c.ax[i] + turned_x) * fy - (c.ay[i] + turned_y) * fx + turned_x * fy0 - turned_y * fx0
        t.moment_b[i] = -((c.bx[i] + ex) * fy - (c.by[i] + ey) * fx + ex * fy0 - ey * fx0)


@njit(nogil=True, forceinline=True)
def _scatter(
    block_a: IntArray, block_b: IntArray, first: int, count: int, t: Any, forces: FloatArray
) -> None:  # pragma: no cover - compiled
    """Add the forces of a chunk's contacts and their moments to those of blocks (n, 3)."""
    for i in range(count):
        a, b = block_a[first + i], block_b[first + i]
        fx, fy = t.force_x[i], t.force_y[i]
        forces[a, 0] += fx
        forces[a, 1] += fy
        forces[a, 2] += t.moment_a[i]
        forces[b, 0] -= fx
        forces[b, 1] -= fy
        forces[b, 2] += t.moment_b[i]
