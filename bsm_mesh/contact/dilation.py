"""Contacts whose joints open as they slide: slip and pressure of a step, each of which depends on the other.

Within a step a contact that was closed slides by x >= 0 where its trial shear T is beyond the strength S at the
pressure P that it comes to: ``S(P(c + d(x))) + k x = |T|``, with the shear stiffness k, the overlap c without slip and
the opening ``d(x) = tan(dilation angle) min(x, what is left of the dilation slip)``. The left side rises with x, so
that there is one solution: a non-associated flow rule gives it over the step (backward Euler). Opening counts
the way that a contact has slid, back and forth; so it is not undone by sliding back, and no work comes of it as long as
the strength is at least ``P tan(dilation angle)``, which `bsm_mesh.model.materials` sees to.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.model.joint_laws.some_contacts import SomeContacts

ITERATIONS = 60  # of Newton's method, halved where that leads out of the interval: then of bisection alone
EXACT = 1e-14  # of the slip if nothing held: where it is found

Strength = Callable[[FloatArray], tuple[FloatArray, FloatArray]]
"""Strength and its derivative at pressures, (h,) each."""
Pressures = Callable[[FloatArray], tuple[FloatArray, FloatArray]]
"""Pressures and their derivatives at overlaps, (h,) each; below 0 in tension."""


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Dilating(SomeContacts):
    """The contacts that open as they slide.

    Attributes
    ----------
    slope : (h,) float64
        Tangent of the dilation angle.
    last : (h,) float64 [m]
        Slip path on which it has worn off.
    """

    slope: FloatArray
    last: FloatArray

    @classmethod
    def among(cls, slope: FloatArray, last: FloatArray) -> Dilating:
        """Return those of contacts (m,) whose slope is not 0."""
        rows = np.flatnonzero(slope)
        return cls(rows=rows, slope=slope[rows], last=last[rows])

    def opening(self, slip_path: FloatArray) -> FloatArray:
        """Return by how much slip paths (m,) [m] have opened the contacts, (h,) [m]."""
        opened: FloatArray = self.slope * np.minimum(slip_path[self.rows], self.last)
        return opened

    def opened(self, offset: FloatArray, before: FloatArray, after: FloatArray) -> FloatArray:
        """Return the offsets (m,) [m] of contacts after slip paths continued from `before` to `after`, (m,) [m]."""
        if not len(self.rows):
            return offset
        offset = offset.copy()
        offset[self.rows] += self.opening(after) - self.opening(before)
        return offset

    def room(self, slip_path: FloatArray) -> FloatArray:
        """Return the slip that still opens the contacts after slip paths (m,) [m], (h,) [m]."""
        left: FloatArray = np.maximum(self.last - slip_path[self.rows], 0.0)
        return left


def slip_of_step(
    overlap: FloatArray,
    trial: FloatArray,
    shear_stiffness: FloatArray,
    slope: FloatArray,
    room: FloatArray,
    pressures: Pressures,
    strength: Strength,
) -> FloatArray:
    """Return the slip (h,) [m] of contacts in a step, not negative.

    Parameters
    ----------
    overlap : (h,) float64 [m]
        How far they would be closed without slip.
    trial : (h,) float64 [N/m]
        Shear force if they stuck.
    shear_stiffness : (h,) float64 [N/m2]
        Of their springs; where it is 0 they do not slip.
    slope, room : (h,) float64 [-], [m]
        Tangent of the dilation angle, and the slip that still opens.
    pressures, strength : callable
        What overlaps and pressures come to.
    """
    force, stiffness = np.abs(trial), np.where(shear_stiffness > 0, shear_stiffness, np.inf)
    low, high = np.zeros_like(force), force / stiffness
    least, slip = EXACT * high, low
    for _ in range(ITERATIONS):
        pressure, by_overlap = pressures(overlap + slope * np.minimum(slip, room))
        found, by_pressure = strength(np.maximum(pressure, 0.0))
        excess = force - found - np.where(slip > 0, stiffness, 0.0) * slip
        low, high = np.where(excess > 0, slip, low), np.where(excess > 0, high, slip)
        opens = (slip < room) & (pressure > 0)
        correction = excess / (stiffness + np.where(opens, by_pressure * by_overlap * slope, 0.0))
        done = (np.abs(correction) <= least) | (high - low <= least)
        if done.all():
            break
        newton = slip + correction
        inside = (newton > low) & (newton < high)
        slip = np.where(done, slip, np.where(inside, newton, 0.5 * (low + high)))
    return slip
