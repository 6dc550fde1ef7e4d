"""Bodies that deform by large displacements, with answers in closed form."""

from __future__ import annotations

from itertools import pairwise
from math import pi, sqrt

import numpy as np
from scipy.optimize import brentq
from scipy.special import ellipe, ellipeinc, ellipk, ellipkinc

import bsm_mesh as bsm
from tests.scenes.shapes import rectangle, turned

LONG, E = 20.0, 1e9  # m, Pa: a strip 1 m high
FRICTION = 30.0  # degrees, under a block that is pushed
BOLT_STIFFNESS = 1e5  # N, of a soft bolt: E A


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


def pushed(by, *, order=1, degrees=0.0, base=(0.0, 4.0), block=(1.0, 2.0), size=0.5, number=None, ramp=None):
    """Return a block, 1 m high, on a base with zones of .5 m, whose left side is pushed along it.

    Parameters
    ----------
    by : float [m]
        How far.
    order : int
        Of zones.
    degrees : float
        By which everything is turned.
    base : tuple of float [m]
        From where to where the blocks of the base reach.
    block : tuple of float [m]
        The same of the block that is pushed.
    size : float [m]
        Of its zones.
    number : int, optional
        Of the block that is pushed; None: the last.
    ramp : float, optional [degrees]
        By which the base rises in front of the block.
    """
    polygons = [np.array([(a, -1.1), (b, -0.9), (b, 0), (a, 0)]) for a, b in pairwise(base)]
    if ramp is not None:
        foot, end = block[1] + 0.25, base[-1]
        polygons[-1][2, 1] = (end - foot) * np.tan(np.radians(ramp))
        polygons[-1] = np.insert(polygons[-1], 3, (foot, 0), axis=0)
    number = len(polygons) if number is None else number
    # Not quite rectangles: rounding would decide which of two equal sides of a zone is halved.
    polygons.insert(number, np.array([(block[0], 0), (block[1], 0), (block[1], 1.1), (block[0], 0.9)]))
    rock = ["base"] * len(polygons)
    rock[number] = "block"

    def low(x, y):
        return turned(np.stack([x, y], axis=1), -degrees)[:, 1] < -0.5

    def behind(x, y):
        x, y = turned(np.stack([x, y], axis=1), -degrees).T
        return (np.abs(x - block[0]) < 1e-9) & (y > -1e-9)

    blocks = bsm.Blocks.from_polygons([turned(each, degrees) for each in polygons], rock=rock)
    blocks = blocks.with_boundary("low", low).with_boundary("behind", behind)
    rocks = [
        bsm.Rock(name, 25e3, young=2e9, poisson=0.25, zones=bsm.Zones(size=zone, order=order, displacement="large"))
        for name, zone in (("base", 0.5), ("block", size))
    ]
    push = bsm.PrescribedDisplacement(boundary="behind", direction=degrees, displacement=by)
    return bsm.Model(
        blocks=blocks,
        rocks=rocks,
        joints=[bsm.Joint("J", 1e9, 5e8, law=bsm.MohrCoulomb(friction=FRICTION))],
        default_joint="J",
        supports=[bsm.Fixed(boundary="low"), push],
        gravity_direction=degrees - 90.0,
    )


def bolted(degrees=0.0, *, slope=30.0, tilt=20.0, length=2.0, order=1, young=1e12, kn=1e11, friction=0.0, **given):
    """Return a block on a slope, by default a smooth one, on a bolt so soft that it slides by a quarter of its length.

    The bolt is at an angle `tilt` to the slope.
    """
    base, block = ([(-4, -2), (4, -2), (4, 0), (-4, 0)], [(-1, 0), (1, 0), (1, 1), (-1, 1)])
    turn, way = degrees - slope, np.radians(tilt)
    end = np.array([0.0, 0.5])
    start, end = turned(np.array([end - length * np.array([np.cos(way), np.sin(way)]), end]), turn)
    blocks = bsm.Blocks.from_polygons([turned(np.array(each), turn) for each in (base, block)], rock="rock")
    zones = bsm.Zones(size=1.0, order=order, displacement="large")
    soft = bsm.Bolt(start=tuple(start), end=tuple(end), diameter=0.025, young=BOLT_STIFFNESS / (np.pi / 4 * 0.025**2))
    return bsm.Model(
        blocks=blocks,
        rocks=[bsm.Rock("rock", unit_weight=25e3, young=young, poisson=0.2, zones=zones)],
        joints=[bsm.Joint("J", kn, kn, law=bsm.MohrCoulomb(friction=friction))],
        default_joint="J",
        supports=[bsm.Fixed(blocks=[0])],
        bolts=[soft],
        gravity_direction=degrees - 90.0,
        **given,
    )


def bolted_exact(*, slope=30.0, tilt=20.0, length=2.0):
    """Return how far the block slides [m], and the tension of the bolt [N], in closed form."""
    along, across = length * np.cos(np.radians(tilt)), length * np.sin(np.radians(tilt))

    def tension(slid):
        return BOLT_STIFFNESS * (np.hypot(along + slid, across) / length - 1)

    def left(slid):
        weight = 2 * 25e3 * np.sin(np.radians(slope))
        return tension(slid) * (along + slid) / np.hypot(along + slid, across) - weight

    slid = brentq(left, 0.0, 10 * length)
    return slid, tension(slid)


def forces_below(results, degrees=0.0):
    """Return the forces on the block that is pushed at the points below it, (q, 2) [N/m], along the base and across."""
    contacts, blocks = results.stages[0].contacts, results.blocks
    number = np.flatnonzero(blocks.rock == blocks.rock_names.index("block"))[0]
    sign = 1.0 * (contacts.block_b == number) - (contacts.block_a == number)
    return turned(sign[:, None] * contacts.force, -degrees)[sign != 0]
