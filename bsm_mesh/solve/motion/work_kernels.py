"""Compiled work of contacts in cycles of explicit motion, in double precision, by the trapezoidal rule.

A central-difference integrator moves blocks by forces at whole cycles. Its kinetic energy changes by the mean of the
forces at both ends of a cycle times the movement in it, so the parts of that work are summed by the same rule.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from bsm_mesh.compiled import njit
from bsm_mesh.solve.motion.contact_columns import WIDTH

ZERO, ONE = np.float32(0.0), np.float32(1.0)


@njit(nogil=True, forceinline=True)
def begin_work(c: Any, w: Any) -> None:  # pragma: no cover - compiled
    """Keep shear forces, shear stiffness and gaps as they are before a cycle."""
    for i in range(WIDTH):
        w.shear[i], w.stiffness[i] = c.carried[i], c.shear_stiffness[i]
        w.along[i], w.gap[i] = c.along[i], c.gap[i]


@njit(nogil=True, forceinline=True)
def shear_with_dashpots(c: Any, w: Any, t: Any) -> None:  # pragma: no cover - compiled
    """Set the shear force within the strength, and the rest cut off; open contacts have none.

    A dashpot lies parallel to the spring, both in series with the slip: while it slips their sum is the strength. The
    force of the spring is stored, without the dashpot's part.
    """
    begun = np.float32(w.begun[0])  # of all contacts; what the last window cut off at its end is in `carried`
    for i in range(WIDTH):
        along, closed, lag, k = t.along[i], t.closed[i], np.float32(w.lag[i]), c.shear_stiffness[i]
        moved = along - c.along[i]
        trial, strength = c.carried[i] + k * moved, max(t.strength[i], ZERO)
        total = trial + lag * k * (begun * moved + (ONE - begun) * np.float32(w.last[i]))
        cut = begun * total + (ONE - begun) * trial
        excess = max(abs(cut) - strength, ZERO) / (ONE + begun * lag)
        shear, spring = min(max(total, -strength), strength), trial - np.copysign(excess, cut)
        t.shear[i] = shear if closed > ZERO else ZERO
        t.excess[i] = excess if closed > ZERO else ZERO
        spring = shear if lag == ZERO else spring
        c.carried[i] = spring if closed > ZERO else ZERO
        c.along[i] = along
        c.contacted[i] = max(c.contacted[i], closed)


@njit(nogil=True, forceinline=True)
def add_dilation(slip: Any, w: Any, t: Any) -> None:  # pragma: no cover - compiled
    """Take off the work that slip does where it opens a joint against its pressure."""
    for i in range(WIDTH):
        opening = np.float64(slip.dilation[i] * min(slip.slid[i], slip.room[i]))
        w.dissipated[i] -= (w.pressure[i] + _spring(t, i)) / 2 * (opening - w.opening[i])
        w.opening[i] = opening


@njit(nogil=True, forceinline=True)
def add_work(c: Any, w: Any, t: Any) -> None:  # pragma: no cover - compiled
    """Add what slip, softer springs, broken bonds and dashpots take in a cycle; before slip opens joints further."""
    for i in range(WIDTH):
        stiffness, shear, pressure = np.float64(c.shear_stiffness[i]), np.float64(c.carried[i]), _spring(t, i)
        if stiffness > 0.0:
            before, moved = w.shear[i], np.float64(t.along[i]) - w.along[i]
            if stiffness != w.stiffness[i]:  # it grows with pressure, and the shear force falls with it
                after = before * min(stiffness / w.stiffness[i], 1.0)
                w.dissipated[i] += before**2 / (2 * w.stiffness[i]) - after**2 / (2 * stiffness)
                w.dissipated[i] += (before - after) / 2 * moved
                before = after
            trial, drag = before + stiffness * moved, np.float64(t.shear[i]) - shear
            excess = np.copysign(np.float64(t.excess[i]), trial + drag) if t.closed[i] > ZERO else trial
            w.dissipated[i] += (before + w.shear_drag[i] + shear + drag) / 2 * excess / stiffness
            w.damped[i] += w.begun[i] * (w.shear_drag[i] + drag) / 2 * (moved - excess / stiffness)
            w.shear_drag[i] = drag
        if t.closed[i] == ZERO and w.pressure[i] < 0.0:  # a bond breaks
            w.dissipated[i] += w.pressure[i] ** 2 / (2 * np.float64(c.normal_stiffness[i]))
        drag = np.float64(t.pressure[i]) - pressure
        w.damped[i] -= w.begun[i] * (w.drag[i] + drag) / 2 * (np.float64(t.gap[i]) - w.gap[i])
        w.pressure[i], w.drag[i], w.begun[i] = pressure, drag, 1.0


@njit(nogil=True, forceinline=True)
def _spring(t: Any, i: int) -> float:  # pragma: no cover - compiled
    """Return the pressure of a contact's spring, the dashpot's apart."""
    return np.float64(max(t.trial[i], -t.tension[i])) if t.closed[i] > ZERO else 0.0
