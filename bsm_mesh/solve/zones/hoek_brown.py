"""Hoek-Brown rock with a tension cut-off: its yield surface in principal stresses.

Rock yields where ``s1 - s3 = sigma_ci (s - mb s1 / sigma_ci)^a`` (shear) or ``s1 = T`` (tension). Circles of Mohr at
yield are given by ``y = (s1 - s3) / sigma_ci``: their centre, their radius, and the sine of the curve's friction angle.
A return to the face s1, s3 or to one of its edges lies on a line in the space of principal stresses. Its y is the root
of one equation that increases with y.

Strength reduction by F divides the shear strength of Mohr's envelope by F at every normal stress. Circles that touch
the reduced envelope follow from those that touch the given one, without a fit.

Plastic strain in shear follows the dilation angle or, where that is smaller, the friction angle of the curve: rock
never creates energy. In tension it follows the normal of the plane.

References
----------
Hoek, Carranza-Torres & Corkum (2002), Hoek-Brown failure criterion - 2002 edition, Proc. NARMS-TAC, Toronto, 267-273.
Hammah, Yacoub, Corkum & Curran (2005), The shear strength reduction method for the generalized Hoek-Brown criterion,
ARMA/USRMS 05-810.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from math import radians, sin
from typing import NamedTuple

import numpy as np

from bsm_mesh.arrays import ROUNDING, FloatArray, IntArray
from bsm_mesh.model.hoek_brown import HoekBrown
from bsm_mesh.solve.zones.yield_surface import End, Return, YieldSurface

CIRCLES = np.array([(1.0, 0.0, -1.0), (1.0, 1.0, -1.0), (1.0, -1.0, -1.0)])  # signs of the radius: face, two edges


class Envelope(NamedTuple):
    """Circles at yield: centre and radius [Pa], sine of the friction angle, and their derivatives by y, (n,) each."""

    centre: FloatArray
    radius: FloatArray
    sine: FloatArray
    d_centre: FloatArray
    d_radius: FloatArray
    d_sine: FloatArray


class _Map(NamedTuple):
    """The return to fixed stresses: ``matrix @ trial + shift``; multipliers ``factor @ (trial[fixed] - target)``."""

    matrix: FloatArray
    shift: FloatArray
    factor: FloatArray
    fixed: list[int]
    target: FloatArray


@dataclass(frozen=True)
class HoekBrownYielding(YieldSurface):
    """The strength of a rock by Hoek and Brown.

    Attributes
    ----------
    lame, shear : float [Pa]
        Lame's constant and shear modulus.
    given : HoekBrown
        The curve.
    dilation : float [degrees]
        Dilation angle; where the curve's friction angle is smaller, that.
    """

    lame: float
    shear: float
    given: HoekBrown
    dilation: float

    def envelope(self, y: FloatArray) -> Envelope:
        """Return the circles at y > 0."""
        (mb, s, a), unit, F = self.given.constants, self.given.sigma_ci, self.given.reduction
        m = y ** (1 / a - 1) / (mb * a)
        sine, radius = 1 / (1 + 2 * m), unit * y / 2
        d_sine = -2 * (1 / a - 1) * m / y * sine**2
        d_radius, d_centre = unit / 2, -unit * (1 + 2 * m) / 2
        centre = (s - y ** (1 / a)) * unit / mb - radius
        k = 1 - 1 / F**2
        w = np.sqrt(1 - k * sine**2)
        d_w = -k * sine * d_sine / w
        return Envelope(
            centre=centre + k * radius * sine,
            radius=radius * w / F,
            sine=sine / (F * w),
            d_centre=d_centre + k * (d_radius * sine + radius * d_sine),
            d_radius=(d_radius * w + radius * d_w) / F,
            d_sine=d_sine / (F * w**3),
        )

    def at_centre(self, centre: FloatArray) -> FloatArray:
        """Return y of the circles with centres (n,) [Pa]; the least where there are none."""
        mb, s, a = self.given.constants
        y = np.maximum(s - mb * centre / self.given.sigma_ci, 0.0) ** a + ROUNDING

        def beyond(y: FloatArray, rows: IntArray) -> tuple[FloatArray, FloatArray]:
            at = self.envelope(y)
            return centre[rows] - at.centre, -at.d_centre

        return _root(beyond, np.full_like(y, ROUNDING), y)

    def at_greatest(self, stress: float) -> FloatArray:
        """Return y (1,) of the circle whose greatest principal stress is given [Pa], that of the tip at most."""

        def beyond(y: FloatArray, _rows: IntArray) -> tuple[FloatArray, FloatArray]:
            at = self.envelope(y)
            return stress - at.centre - at.radius, -at.d_centre - at.d_radius

        high = np.ones(1)
        while beyond(high, np.arange(1))[0] < 0:
            high = 2 * high
        return _root(beyond, np.array([ROUNDING]), high)

    @cached_property
    def cut_off(self) -> tuple[float, float, float]:
        """Return y, s1 and s3 [Pa] where tension cuts the curve off, or at its tip."""
        tension = self.given.tension
        y = self.at_greatest(tension)
        return float(y[0]), tension, tension - 2 * float(self.envelope(y).radius[0])

    @cached_property
    def strength(self) -> float:
        """Compressive strength of rock without lateral pressure [Pa]."""
        return 2 * float(self.envelope(self.at_greatest(0.0)).radius[0])

    def excess(self, stress: FloatArray) -> FloatArray:
        """Return by how much principal stresses (n, 3) in order are beyond the curve, (n,) [Pa]; negative within."""
        greatest, least = stress[:, 0], stress[:, 2]
        allowed = self.envelope(self.at_centre((greatest + least) / 2)).radius
        most: FloatArray = np.maximum(greatest - self.cut_off[1], greatest - least - 2 * allowed)
        return most

    def ends(self, trial: FloatArray, slack: FloatArray) -> Iterator[End]:
        """Yield where stresses (n, 3) in order end: face, its edges, then where tension acts; `slack` is rounding."""
        for which in range(len(CIRCLES)):
            yield self._on_curve(which, trial)
        for one in self.maps:
            to = trial @ one.matrix.T + one.shift
            multipliers = (trial[:, one.fixed] - one.target) @ one.factor.T
            yield End(to, multipliers, to[:, 2] >= self.cut_off[2] - slack, np.zeros(len(to)))

    def by_trial(self, found: Return, rows: IntArray) -> FloatArray:
        """Return the derivatives (k, 3, 3) of principal stresses by those of the trial, both in order."""
        number = found.set[rows]
        plain = np.zeros((len(CIRCLES), 3, 3))
        matrices: FloatArray = np.stack([np.eye(3), *plain, *(one.matrix for one in self.maps)])[number]
        for which in range(len(CIRCLES)):
            here = np.flatnonzero(number == which + 1)
            matrices[here] = self._by_trial_on_curve(which, found.trial[rows[here]], found.place[rows[here]])
        return matrices

    @cached_property
    def maps(self) -> tuple[_Map, ...]:
        """The returns where tension acts: its plane, two edges, three corners, one of them with two ways to flow."""
        y, tension, other = self.cut_off
        sine = float(self._flow(self.envelope(np.array([y])))[0][0])
        plus, minus = (1 + sine) / 2, (1 - sine) / 2
        first, second, third = np.array([(plus, 0.0, -minus), (0.0, plus, -minus), (plus, -minus, 0.0)])
        x, y_, z = np.eye(3)
        cases = (
            ([0], (x,), (tension,)),
            ([0, 2], (first, x), (tension, other)),
            ([0, 1], (x, y_), (tension, tension)),
            ([0, 1, 2], (first, x, y_), (tension, tension, other)),
            ([0, 1, 2], (first, second, x), (tension, tension, other)),
            ([0, 1, 2], (first, third, x), (tension, other, other)),
            ([0, 1, 2], (x, y_, z), (tension, tension, tension)),
        )
        found = []
        for fixed, flows, goal in cases:
            b, target = self.elasticity @ np.stack(flows, axis=1), np.array(goal)
            factor: FloatArray = np.linalg.inv(b[fixed]).astype(np.float64)
            matrix = np.eye(3)
            matrix[:, fixed] -= b @ factor
            if len(fixed) == 3:
                matrix = np.zeros((3, 3))
            found.append(_Map(matrix, b @ factor @ target, factor, fixed, target))
        return tuple(found)

    def _flow(self, at: Envelope) -> tuple[FloatArray, FloatArray]:
        """Return the sine of the dilation angle at circles, and its derivative by y."""
        most = sin(radians(self.dilation))
        follows = at.sine < most
        return np.where(follows, at.sine, most), np.where(follows, at.d_sine, 0.0)

    @cached_property
    def lines(self) -> tuple[FloatArray, FloatArray]:
        """Normals (3, 3) to the directions of return without dilation, and their change by its sine, of `CIRCLES`."""
        lame, G = self.lame, self.shear
        inverse = np.linalg.inv(self.elasticity)
        edges = (
            np.array([(1.0, 1.0, 1.0), (1.0, 1.0, 1.0)]) @ inverse,
            np.array([(-1.0, -1, 1), (-1.0, 1, 1)]) @ inverse,
        )
        return np.vstack([(G, 0.0, G), edges[0]]), np.vstack([(-lame - G, 0.0, lame + G), edges[1]])

    def _off_line(self, which: int, trial: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return how far trials are from the line of return to circles at y, its derivative by y and by the trial."""
        at, sign = self.envelope(y), CIRCLES[which]
        sine, d_sine = self._flow(at)
        first, change = self.lines[0][which], self.lines[1][which]
        normal = first + sine[:, None] * change
        apart = trial - at.centre[:, None] - at.radius[:, None] * sign
        along = normal @ sign
        value = np.einsum("ni,ni->n", normal, apart)
        slope = d_sine * (apart @ change) - at.d_centre * normal.sum(axis=1) - at.d_radius * along
        return value, slope, normal

    def _on_curve(self, which: int, trial: FloatArray) -> End:
        """Return where trials end on the face or one of its edges."""
        G, given = self.shear, self.given
        F = given.reduction
        low = np.full(len(trial), self.cut_off[0])
        high = low + (trial[:, 0] - trial[:, 2]) / given.sigma_ci * F * max(1.0, F)

        def beyond(y: FloatArray, rows: IntArray) -> tuple[FloatArray, FloatArray]:
            value, slope, _ = self._off_line(which, trial[rows], y)
            return value, slope

        y = _root(beyond, low, high)
        at = self.envelope(y)
        sine = self._flow(at)[0]
        (a, b, c), r = trial.T, at.radius
        stress = at.centre[:, None] + r[:, None] * CIRCLES[which]
        if which == 0:
            amount = (a - c - 2 * r) / (2 * G)
            stress[:, 1] = b - self.lame * sine * amount
        elif which == 1:
            amount = ((b - c - 2 * r) / (2 * G) - (a - b) / (2 * G) * (1 - sine) / (1 + sine)) / (3 - sine)
        else:
            amount = ((a - b - 2 * r) / (2 * G) - (b - c) / (2 * G) * (1 + sine) / (1 - sine)) / (3 + sine)
        return End(stress, amount[:, None], (y > low) & (y < high), y)

    def _by_trial_on_curve(self, which: int, trial: FloatArray, y: FloatArray) -> FloatArray:
        """Return the derivatives (k, 3, 3) of stresses on the face or one of its edges by those of the trial."""
        at = self.envelope(y)
        _, slope, normal = self._off_line(which, trial, y)
        by = -normal / slope[:, None]
        moved = at.d_centre[:, None] + at.d_radius[:, None] * CIRCLES[which]
        found: FloatArray = moved[:, :, None] * by[:, None, :]
        if which == 0:
            sine, d_sine = self._flow(at)
            amount = (trial[:, 0] - trial[:, 2] - 2 * at.radius) / (2 * self.shear)
            by_amount = np.array([1.0, 0.0, -1.0]) / (2 * self.shear) - (at.d_radius / self.shear)[:, None] * by
            flow = (d_sine * amount)[:, None] * by + sine[:, None] * by_amount
            found[:, 1] = np.array([0.0, 1.0, 0.0]) - self.lame * flow
        return found


def _root(
    beyond: Callable[[FloatArray, IntArray], tuple[FloatArray, FloatArray]], low: FloatArray, high: FloatArray
) -> FloatArray:
    """Return the roots (n,) of increasing functions between bounds, or the bound that is nearer.

    Newton's method from the upper bound. The bracket is halved where a step leaves it or is not half of the last one.
    """
    low, high = low.copy(), high.copy()
    every = np.arange(len(low))
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        above, below = beyond(low, every)[0] >= 0, beyond(high, every)[0] <= 0
        y: FloatArray = np.where(above, low, high)
        rows, step = np.flatnonzero(~above & ~below), np.full_like(low, np.inf)
        while rows.size:
            value, slope = beyond(y[rows], rows)
            now = y[rows]
            high[rows], low[rows] = np.where(value > 0, now, high[rows]), np.where(value > 0, low[rows], now)
            new = now - value / slope
            inside = (new >= low[rows]) & (new <= high[rows])
            inside &= np.abs(new - now) <= step[rows] / 2  # else the bracket is halved, so that the search ends
            y[rows] = np.where(inside, new, (low[rows] + high[rows]) / 2)
            step[rows] = np.abs(y[rows] - now)
            rows = rows[np.abs(y[rows] - now) > ROUNDING * now]  # the step after it would be below double precision
    return y
