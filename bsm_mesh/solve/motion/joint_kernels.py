"""Compiled behaviour of joints in cycles of explicit motion that few models have: a chunk of contacts each.

Dilation, closure by a hyperbola, shear stiffness that grows with pressure, strength of two lines or that is lost.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from bsm_mesh.compiled import njit
from bsm_mesh.model.joint_laws.barton_bandis import STEEPEST
from bsm_mesh.solve.motion.contact_columns import WIDTH

ZERO, ONE = np.float32(0.0), np.float32(1.0)
LEANS = np.float32(STEEPEST)  # greatest angle of Barton's strength [degrees]
DEGREE = np.float32(np.pi / 180)
FLATTEST = np.float32(1e-2)  # least denominator of a hyperbola's change: the joint is closed as far as it goes


@njit(nogil=True, forceinline=True)
def dilate(slip: Any, t: Any) -> None:  # pragma: no cover - compiled
    """Open contacts by their slip so far."""
    for i in range(WIDTH):
        t.gap[i] -= slip.dilation[i] * min(slip.slid[i], slip.room[i])


@njit(nogil=True, forceinline=True)
def slide(c: Any, slip: Any, t: Any) -> None:  # pragma: no cover - compiled
    """Add the slip of a cycle to that of the window."""
    for i in range(WIDTH):
        if t.excess[i] > ZERO and c.shear_stiffness[i] > ZERO:
            slip.slid[i] += t.excess[i] / c.shear_stiffness[i]


@njit(nogil=True, forceinline=True)
def close(c: Any, closure: Any, t: Any) -> None:  # pragma: no cover - compiled
    """Set the pressure of joints that close by a hyperbola, from that of its tangent (`Hyperbolic.stiffening`)."""
    for i in range(WIDTH):
        stiffening, share, trial = closure.stiffening[i], closure.rock_share[i], t.trial[i]
        base = max(c.trial_pressure[i], ZERO)
        change = trial - base
        b = ONE - change * stiffening
        root = np.sqrt(max(b * b + np.float32(4.0) * change * stiffening * share, ZERO))
        pressed = base + np.float32(2.0) * change / max(b + root, FLATTEST)
        t.trial[i] = pressed if (stiffening > ZERO) & (base + change > ZERO) else trial


@njit(nogil=True)
def grow(c: Any, growth: Any, t: Any) -> None:  # pragma: no cover - compiled
    """Set the shear stiffness at the trial pressure; the shear force falls as much as the stiffness does."""
    for i in range(WIDTH):
        if growth.factor[i] > ZERO:
            stress = min(max(t.trial[i] / growth.length[i], growth.least[i]), growth.most[i])
            own = growth.factor[i] * stress ** growth.exponent[i] * growth.length[i]
            if growth.roughness[i] > ZERO:
                decades = np.log10(max(growth.wall[i] / stress, ONE))
                own *= np.tan(min(growth.angle[i] + growth.roughness[i] * decades, LEANS) * DEGREE)
            stiffness = min(ONE / (growth.compliance[i] + ONE / own), growth.stiffest[i])
            c.carried[i] *= min(stiffness / growth.stiffness[i], ONE)
            c.shear_stiffness[i] = growth.stiffness[i] = stiffness
            growth.last_pressure[i] = t.trial[i]


@njit(nogil=True, forceinline=True)
def hold(strength: Any, t: Any) -> None:  # pragma: no cover - compiled
    """Set the tensile strengths."""
    for i in range(WIDTH):
        t.tension[i] = strength.tension[i]


@njit(nogil=True, forceinline=True)
def weaken(strength: Any, t: Any) -> None:  # pragma: no cover - compiled
    """Set the lower of two lines of strength, or the residual one, and whether slip on it is for good (`lasting`)."""
    for i in range(WIDTH):
        pressure, first, failed = t.pressure[i], t.strength[i], strength.failed[i]
        first_lasts, second_lasts = strength.first_lasts[i], strength.second_lasts[i]
        second = strength.second[i] + strength.second_slope[i] * pressure
        residual = strength.residual[i] + strength.residual_slope[i] * pressure
        lower = first if first <= second else second
        t.lasting[i] = first_lasts if first <= second else second_lasts
        t.strength[i] = residual if failed > ZERO else lower


@njit(nogil=True, forceinline=True)
def fail(strength: Any, t: Any) -> None:  # pragma: no cover - compiled
    """Keep which contacts have slipped for good, and which have opened and lost their tensile strength."""
    for i in range(WIDTH):
        closed, lasting, tension = t.closed[i], t.lasting[i], strength.tension[i]
        failed, broken = strength.failed[i], strength.broken[i]
        fails = lasting if t.excess[i] > ZERO else ZERO
        breaks = ONE if tension > ZERO else ZERO
        strength.failed[i] = max(failed, fails)
        strength.broken[i] = max(broken, breaks * (ONE - closed))
        strength.tension[i] = tension * closed
