"""A hole in rock of Hoek and Brown under a far pressure, with the answers of Carranza-Torres & Fairhurst."""

from __future__ import annotations

from math import exp, log, sqrt

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import bsm_mesh as bsm
from tests.scenes.plastic_zones import Hole


class HoekBrownHole(Hole):
    """A hole of radius 1 m under a far pressure, with a pressure on its wall.

    By default the numbers of the manual of FLAC (verification, "Cylindrical Hole in an Infinite Hoek-Brown Medium").

    Carranza-Torres & Fairhurst (1999), The elasto-plastic response of underground excavations in rock masses that
    satisfy the Hoek-Brown failure criterion, Int. J. Rock Mech. Min. Sci. 36, 777-809. For any exponent a:
    Carranza-Torres (2004), Elasto-plastic solution of tunnel problems using the generalized form of the Hoek-Brown
    failure criterion, Int. J. Rock Mech. Min. Sci. 41, 480-481.

    In yielding rock ``d sr / d ln(r) = st - sr``, with x = mb sr / sigma_ci + s that is ``dx / d ln(r) = mb x^a``.
    """

    def __init__(self, curve=None, *, far=30e6, support=5e6, young=5.5e9, poisson=0.25):
        self.curve = curve or bsm.HoekBrown(sigma_ci=30e6, mb=1.7, s=0.0039, a=0.5)
        self.far, self.support, self.young, self.poisson = far, support, young, poisson
        (self.mb, self.s, self.a), self.unit = self.curve.constants, self.curve.sigma_ci
        self.at_radius = brentq(lambda p: 2 * (far - p) - self.unit * self.x(p) ** self.a, 0.0, far)
        b = 1 - self.a
        self.radius = exp((self.x(self.at_radius) ** b - self.x(support) ** b) / (self.mb * b))

    def x(self, pressure):
        """Return mb sr / sigma_ci + s at a radial pressure [Pa]."""
        return self.mb * pressure / self.unit + self.s

    def stress(self, r):
        """Return the radial and the hoop stress [Pa] at radii, tension positive."""
        away, b = (self.far - self.at_radius) * (self.radius / r) ** 2, 1 - self.a
        x = (self.x(self.support) ** b + self.mb * b * np.log(np.minimum(r, self.radius))) ** (1 / b)
        inside = r < self.radius
        radial = np.where(inside, (x - self.s) * self.unit / self.mb, self.far - away)
        hoop = np.where(inside, radial + self.unit * x**self.a, self.far + away)
        return -radial, -hoop

    def rock(self, order, dilation):
        """Return the rock that yields."""
        zones = bsm.Zones(order=order, law="hoek_brown", dilation=dilation)
        return bsm.Rock(
            "rock", unit_weight=0.0, young=self.young, poisson=self.poisson, zones=zones, hoek_brown=self.curve
        )

    def convergence(self, dilation):
        """Return by how much the wall moves inwards [m]: of a = 0.5, Eq. 10 of Carranza-Torres & Fairhurst (2000).

        The convergence-confinement method in tunnel design, Tunn. Undergr. Space Technol. 15, 187-213.
        """
        sine, ratio, nu = np.sin(np.radians(dilation)), self.radius, self.poisson
        K = (1 + sine) / (1 - sine)
        far, at_radius = (self.x(pressure) / self.mb**2 for pressure in (self.far, self.at_radius))
        first = (
            (K - 1) / (K + 1)
            + 2 / (K + 1) * ratio ** (K + 1)
            + (1 - 2 * nu) / (4 * (far - at_radius)) * log(ratio) ** 2
        )
        second = (1 - 2 * nu) / (K + 1) * sqrt(at_radius) + (1 - nu) / 2 * (K - 1) / (K + 1) ** 2
        third = (K + 1) * log(ratio) - ratio ** (K + 1) + 1
        G = self.young / (2 * (1 + nu))
        return (self.far - self.at_radius) / (2 * G) * (first - second / (far - at_radius) * third)

    def followed(self, dilation):
        """Return the same for any a by integrating ``du/dr + K u/r``, which elastic strains alone drive."""
        nu, G = self.poisson, self.young / (2 * (1 + self.poisson))
        sine = np.sin(np.radians(dilation))
        passive = (1 + sine) / (1 - sine)

        def slope(r, u):
            radial, hoop = (float(-stress) - self.far for stress in self.stress(r * (1 - 1e-12)))
            curve = 1 + self.a * self.mb * self.x(radial + self.far) ** (self.a - 1)
            K = min(passive, curve)
            elastic = ((1 - nu) * radial - nu * hoop) / (2 * G) + K * ((1 - nu) * hoop - nu * radial) / (2 * G)
            return elastic - K * u / r

        start = (self.far - self.at_radius) * self.radius / (2 * G)
        return float(solve_ivp(slope, (self.radius, 1.0), [start], rtol=1e-10, atol=1e-14).y[0, -1])

    def wall(self, zones):
        """Return by how much the wall moved inwards [m]: the mean of the corners on it."""
        r = np.hypot(*zones.points.T)
        on = np.isclose(r, 1.0)
        return -float(np.mean(np.einsum("ni,ni->n", zones.displacement, zones.points)[on] / r[on]))
