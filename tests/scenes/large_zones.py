"""Bodies that deform by large displacements, with answers in closed form."""

from __future__ import annotations

from itertools import pairwise
from math import pi, sqrt

import numpy as np
from scipy.optimize import brentq
from scipy.special import ellipe, ellipeinc, ellipk, ellipkinc

import bsm_mesh as bsm
from tests.scenes.shapes import rectangle

LONG, E = 20.0, 1e9  # m, Pa: a strip 1 m high


def strip(pieces, *, size, order, upright=False):
    """Return a strip that is held at one end, cut into blocks without joints, and its rock."""
    cuts = [LONG * k / pieces for k in range(pieces + 1)]
    across = [(a, 0, b, 1) for a, b in pairwise(cuts)]
    sides = [(0, a, 1, b) for a, _, b, _ in across] if upright else across
    blocks = bsm.Blocks.from_polygons([rectangle(*each) for each in sides], rock="strip")
    axis = int(upright)
    for name, at in (("held", 0.0), ("loaded", LONG)):
        blocks = blocks.with_boundary(name, lambda x, y, at=at: np.abs((x, y)[axis] - at) < 1e-9)
    zones = bsm.Zones(size=size, order=order, displacement="large")
    return blocks, bsm.Rock("strip", unit_weight=0.0, young=E, poisson=0.0, zones=zones)


def elastica(alpha, *, pieces=1, size=0.5, order=2):
    """Return results of a cantilever under an end load P, with alpha = P L^2 / (E I), and its tip's displacement / L.

    The displacement is down, and back towards the support.
    """
    blocks, rock = strip(pieces, size=size, order=order)
    load = bsm.EdgeTractions(boundary="loaded", values=np.array([[(0.0, -alpha * E / 12 / LONG**2)] * 2]))
    results = bsm.run(bsm.Model(blocks=blocks, rocks=[rock], supports=[bsm.Fixed(boundary="held")], loads=[load]))
    zones = results.stages[0].zones
    tip = np.abs(zones.points[:, 0] - LONG) < 1e-9
    return results, -zones.displacement[tip].mean(axis=0)[::-1] / LONG


def elastica_exact(alpha):
    """Return the same in closed form, without stretching and shear.

    Bisshopp & Drucker (1945), Large deflection of cantilever beams, Q. Appl. Math. 3, 272-275.
    """

    def left(k):
        return ellipk(k * k) - ellipkinc(np.arcsin(1 / (k * sqrt(2))), k * k) - sqrt(alpha)

    k = brentq(left, sqrt(0.5) + 1e-12, 1 - 1e-12)
    bent = ellipe(k * k) - ellipeinc(np.arcsin(1 / (k * sqrt(2))), k * k)
    return np.array([1 - 2 * bent / sqrt(alpha), 1 - sqrt(2 * (2 * k * k - 1) / alpha)])


def pressed(part, *, pieces=1):
    """Return results of an upright strip under a part of its Euler load pi^2 E I / (4 L^2), with shear (Engesser)."""
    blocks, rock = strip(pieces, size=0.7, order=2, upright=True)
    euler = pi**2 * E / 12 / (4 * LONG**2)
    critical = euler / (1 + 1.2 * euler / (E / 2))
    load = bsm.Pressure(boundary="loaded", pressure=part * critical)
    return bsm.run(bsm.Model(blocks=blocks, rocks=[rock], supports=[bsm.Fixed(boundary="held")], loads=[load]))
