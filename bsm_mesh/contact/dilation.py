"""Contacts whose joints open as they slide: slip and pressure of a step, each of which depends on the other.

Within a step a contact that was closed slides by x >= 0 where its trial shear T is beyond the strength S at the
pressure P that it comes to: ``S(P(c + d(x))) + k x = |T|``, with the shear stiffness k, the overlap c without slip and
the opening ``d(x) = tan(dilation angle) min(x, what is left of the dilation slip)``. The left side rises with x, so
that there is one solution: a non-associated flow rule gives it over the step (backward Euler). Opening counts
the way that a contact has slid, back and forth; so it is not undone by sliding back, and no work comes of it as long as
the strength is at least ``P tan(dilation angle)``, which `bsm_mesh.model.materials` sees to.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray
from bsm_mesh.contact.feature import Curve, Feature, Movement, Springs, Tangent

ITERATIONS = 60  # of Newton's method, halved where that leads out of the interval: then of bisection alone
EXACT = 1e-14  # of the slip if nothing held: where it is found


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Dilating(Feature):
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

    def columns(self, slip_path: FloatArray) -> FloatArray:
        """Return slopes, and the slip that still opens, of all contacts after slip paths (m,) [m], (2, m)."""
        return self.spread(len(slip_path), self.slope, self.room(slip_path))

    def slips(
        self, slip: FloatArray, offset: FloatArray, springs: Springs, at: Movement
    ) -> tuple[FloatArray, FloatArray]:
        """Return the slip of these in the step, (h,) [m], and all offsets (m,) [m] opened by it."""
        rows = self.rows
        if not len(rows):
            return slip, offset
        trial, overlap, room = at.trial(rows, springs), at.overlap(rows), self.room(at.contacts.slip_path)
        # Slip presses, and so gives strength: what sticks without it sticks.
        pressure, _ = at.pressures(rows)(overlap)
        slides = np.flatnonzero(np.abs(trial) > at.strength(rows)(np.maximum(pressure, 0.0))[0])
        k, slip = rows[slides], np.zeros(len(rows))
        given = overlap[slides], trial[slides], springs.stiffness[k], self.slope[slides], room[slides]
        slip[slides] = slip_of_step(*given, at.pressures(k), at.strength(k))
        offset = offset.copy()
        offset[rows] += self.slope * np.minimum(slip, room)
        return slip, offset

    def tangent(self, given: Tangent, at: Any, slip_path: FloatArray) -> Tangent:
        """Return the derivatives (m,) where contacts open as they slide, and that of the pressure.

        With the slope t of opening, the strength's slope m and the springs k and s a slipping contact's pressure
        changes by ``k / (1 + t m k / s) (-d gap + t d along)`` where it slides along, and its shear by m times that.
        Where s grows with the closure c at which the contact would stick, so does the trial shear T:
        ``t / s (dT/dc - slip ds/dc)`` comes to the factor 1 of -d gap.
        """
        if not len(at.slip):
            return given
        normal, by_gap, shear = (values.copy() for values in given[:3])
        by_along, springs = np.zeros(len(normal)), at.springs
        slides, softer = self.softening(at, slip_path, springs.stiffness)
        k, t = self.rows[slides], self.slope[slides]
        normal[k] *= softer
        by_gap[k] *= softer
        by_along[k] = np.copysign(t, at.shear[k]) * normal[k]
        if len(springs.by_closure):
            way, slip = np.sign(at.shear[k]), at.slip[slides]
            more = 1 + t / springs.stiffness[k] * (way * springs.trial_by_closure[k] - slip * springs.by_closure[k])
            normal[k] *= more
            by_gap[k] *= more
        shear[k] += at.dshear_dpressure[k] * by_along[k]
        return Tangent(normal, by_gap, shear, by_along)

    def softening(self, at: Any, slip_path: FloatArray, stiffness: FloatArray) -> tuple[BoolArray, FloatArray]:
        """Return which of these open by slip at an `Evaluation`, (h,), and the factor on the normal springs of those.

        Slip paths (m,) [m] are those before the step, `stiffness` (m,) that of shear springs.
        """
        slides = (at.slip > 0) & (at.slip < self.room(slip_path))
        slides &= (at.closed & ~at.sticking)[self.rows]
        k, t = self.rows[slides], self.slope[slides]
        return slides, 1 / (1 + t * np.abs(at.dshear_dpressure[k]) * at.normal_stiffness[k] / stiffness[k])


def slip_of_step(
    overlap: FloatArray,
    trial: FloatArray,
    shear_stiffness: FloatArray,
    slope: FloatArray,
    room: FloatArray,
    pressures: Curve,
    strength: Curve,
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
