"""Rock that yields, with answers in closed form: a hole under a far pressure, a strip footing on clay."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from math import cos, pi, radians, sin, sqrt

import numpy as np

import bsm_mesh as bsm
from tests.scenes.shapes import rectangle, turned


class Hole:
    """Salencon's hole of radius 1 m under a far pressure, without support.

    Salencon (1969), Contraction quasi-statique d'une cavite a symetrie spherique ou cylindrique dans un milieu
    elastoplastique, Annales des Ponts et Chaussees 4. The numbers are those of the manuals of other programs.
    """

    far, cohesion, friction, young, poisson, outer = 30e6, 3.45e6, 30.0, 6.777e9, 0.21, 10.0
    support = 0.0

    def __init__(self):
        self.passive = (1 + sin(radians(self.friction))) / (1 - sin(radians(self.friction)))
        self.cone = 2 * self.cohesion * sqrt(self.passive) / (self.passive - 1)
        self.at_radius = (2 * self.far - self.cone * (self.passive - 1)) / (self.passive + 1)
        ratio = 2 / (self.passive + 1) * (self.far + self.cone) / self.cone
        self.radius = ratio ** (1 / (self.passive - 1))

    def stress(self, r):
        """Return the radial and the hoop stress [Pa] at radii, tension positive."""
        away = (self.far - self.at_radius) * (self.radius / r) ** 2
        inside = r < self.radius
        grows = r ** (self.passive - 1)
        radial = np.where(inside, self.cone * (grows - 1), self.far - away)
        hoop = np.where(inside, self.cone * (self.passive * grows - 1), self.far + away)
        return -radial, -hoop

    def rock(self, order, dilation):
        """Return the rock that yields."""
        return bsm.Rock(
            "rock",
            unit_weight=0.0,
            young=self.young,
            poisson=self.poisson,
            cohesion=self.cohesion,
            friction=self.friction,
            tensile_strength=1e9,
            zones=bsm.Zones(order=order, law="mohr_coulomb", dilation=dilation),
        )

    def model(self, rings, sectors, *, dilation=30.0, order=2, parts=(1.0,)):
        """Return a quarter, whose core is excavated, under the exact pressure at its outer side."""
        r, angle = self.outer ** (np.arange(rings + 1) / rings), pi / 2 * np.arange(sectors + 1) / sectors
        x, y = (np.round(np.multiply.outer(r, of(angle)), 12) for of in (np.cos, np.sin))
        at = np.stack([x, y], axis=-1)
        core = [[(0.0, 0.0), at[0, j], at[0, j + 1]] for j in range(sectors)]
        ring = [[at[i, j], at[i + 1, j], at[i + 1, j + 1], at[i, j + 1]] for i in range(rings) for j in range(sectors)]
        blocks = (
            bsm.Blocks.from_polygons([*ring, *core], rock="rock")
            .with_boundary("outer", lambda x, y: np.hypot(x, y) > 0.99 * self.outer)
            .with_boundary("low", lambda x, y: y < 1e-9)
            .with_boundary("left", lambda x, y: x < 1e-9)
        )
        change = -float(self.stress(self.outer)[0]) - self.far
        more = bsm.Pressure(boundary="outer", pressure=change)
        gone = list(range(len(ring), len(ring) + sectors))
        return bsm.Model(
            blocks=blocks,
            rocks=[self.rock(order, dilation)],
            supports=[bsm.NormalRoller(boundary=side) for side in ("low", "left")],
            loads=[bsm.Pressure(boundary="outer", pressure=self.far)],
            in_situ=bsm.InSitu(stress={"xx": -self.far, "yy": -self.far, "xy": 0.0}),
            stages=[bsm.Stage(name="hole", excavate=gone, relaxation=list(parts), loads=[more], pressure=self.support)],
        )

    def errors(self, zones):
        """Return errors, relative: of stresses up to three radii, of the plastic radius by stress and by area.

        By the radial stress of the elastic rock outside, which depends on that radius alone, and by the area of the
        parts of zones that yielded, which is as exact as zones are small.
        """
        corner = zones.points[zones.cells[:, :3]]
        one, other = (corner[:, k] - corner[:, 0] for k in (1, 2))
        area, centre = np.abs(one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0]) / 2, corner.mean(axis=1)
        r = np.hypot(*centre.T)
        out = centre / r[:, None]
        along = np.stack([-out[:, 1], out[:, 0]], axis=1)
        found = [np.einsum("ni,nij,nj->n", e, zones.stress, e) for e in (out, along)]
        exact, near = self.stress(r), r < 3
        square = sum((area * (f - e) ** 2)[near].sum() for f, e in zip(found, exact, strict=True))
        stress = sqrt(square / sum((area * e**2)[near].sum() for e in exact))
        outside = (r > self.radius) & near & (zones.yielded == 0)
        by_stress = np.average((r * np.sqrt((self.far + found[0]) / (self.far - self.at_radius)))[outside])
        by_area = sqrt(1 + 4 / pi * (area * zones.yielded).sum())
        return stress, by_stress / self.radius - 1, by_area / self.radius - 1


CLAY = 1e5  # Pa: cohesion


def strut(part, *, degrees=0.0, young=1e10, friction=30.0, dilation=30.0, order=2):
    """Return a strut of 1 by 2 m under a part of the load at which it yields, turned by some degrees.

    In plane strain that is 2 c cos(phi) / (1 - sin(phi)).
    """
    polygons = [turned(np.array(rectangle(0, low, 1, low + 1)), degrees) for low in (0, 1)]

    def at(height):
        return lambda x, y: np.abs(turned(np.stack([x, y], axis=1), -degrees)[:, 1] - height) < 1e-9

    blocks = bsm.Blocks.from_polygons(polygons, rock="clay")
    rock = bsm.Rock(
        "clay",
        unit_weight=0.0,
        young=young,
        poisson=0.3,
        cohesion=CLAY,
        friction=friction,
        tensile_strength=1e9,
        zones=bsm.Zones(size=1.0, order=order, law="mohr_coulomb", dilation=dilation, displacement="large"),
    )
    carries = 2 * CLAY * cos(radians(friction)) / (1 - sin(radians(friction)))
    return bsm.Model(
        blocks=blocks.with_boundary("low", at(0)).with_boundary("high", at(2)),
        rocks=[rock],
        supports=[bsm.NormalRoller(boundary="low"), bsm.Fixed(point=tuple(polygons[0][0]))],
        loads=[bsm.Pressure(boundary="high", pressure=part * carries)],
    )


def in_large_displacement(model, **rock):
    """Return a model in large displacement, with some properties of its rocks changed."""
    rocks = [replace(each, zones=replace(each.zones, displacement="large"), **rock) for each in model.rocks]
    return model.replace(rocks=rocks)


def footing(loads, *, size=0.2, order=2, strength=None):
    """Return half of a strip footing, 2 m wide, on clay without weight, under parts of (2 + pi) c, a stage each.

    Prandtl (1921). `strength`: a last stage with so much of the clay's strength.
    """
    x, y = [0.0, 1.0, 2.0, 3.5, 5.0], [-2.5, -1.5, -0.75, 0.0]
    polygons, names = [], []
    for i in range(4):
        for j in range(3):
            polygons.append([(x[i], y[j]), (x[i + 1], y[j]), (x[i + 1], y[j + 1]), (x[i], y[j + 1])])
            names.append("near" if i < 2 and j == 2 else "about" if i < 3 and j > 0 else "far")
    blocks = (
        bsm.Blocks.from_polygons(polygons, rock=names)
        .with_boundary("footing", lambda x, y: (y > -1e-9) & (x < 1 + 1e-9))
        .with_boundary("bottom", lambda x, y: y < -2.5 + 1e-9)
        .with_boundary("sides", lambda x, y: (x < 1e-9) | (x > 5 - 1e-9))
    )
    rocks = [
        bsm.Rock(
            name,
            unit_weight=0.0,
            young=1e10,
            poisson=0.3,
            cohesion=CLAY,
            tensile_strength=1e9,
            zones=bsm.Zones(size=times * size, order=order, law="mohr_coulomb"),
        )
        for name, times in (("near", 1), ("about", 2), ("far", 3))
    ]

    def pressure(part):
        return [bsm.Pressure(boundary="footing", pressure=part * (2 + pi) * CLAY)]

    steps = pairwise(loads)
    stages = [bsm.Stage(name=f"{after:g}", loads=pressure(after - before)) for before, after in steps]
    if strength is not None:
        stages.append(bsm.Stage(name="weaker", strength={"rock:*": strength}))
    return bsm.Model(
        blocks=blocks,
        rocks=rocks,
        supports=[bsm.Fixed(boundary="bottom"), bsm.NormalRoller(boundary="sides")],
        loads=pressure(loads[0]),
        stages=stages,
    )


def slope(*, friction=20.0, cohesion=1e4, height=10.0, run=2.0, young=1e9, dilation=0.0, size=1.5, order=2):
    """Return a slope of 1 : run on rock, its crest 1.2 heights wide: by default Example 1 of Griffiths & Lane (1999).

    There phi = 20 degrees, c / (gamma H) = 0.05 and the flow has no dilation: factor 1.4, and 1.380 by Bishop &
    Morgenstern (1960). D. V. Griffiths, P. A. Lane (1999), Slope stability analysis by finite elements, Geotechnique
    49(3), 387-403.
    """
    crest = 1.2 * height
    x = [*np.linspace(0.0, crest, 4), *(crest + run * height * np.linspace(0, 1, 5)[1:])]
    polygons = []
    for a, b in pairwise(x[:-1]):
        low, high = (min(height, height - (at - crest) / run) * np.linspace(0, 1, 4) for at in (a, b))
        polygons += [[(a, low[k]), (b, high[k]), (b, high[k + 1]), (a, low[k + 1])] for k in range(3)]
    polygons.append([(x[-2], 0.0), (x[-1], 0.0), (x[-2], high[-1])])
    blocks = (
        bsm.Blocks.from_polygons(polygons, rock="soil")
        .with_boundary("bottom", lambda x, y: y < 1e-9)
        .with_boundary("side", lambda x, y: x < 1e-9)
    )
    soil = bsm.Rock(
        "soil",
        unit_weight=cohesion / (0.05 * height),
        young=young,
        poisson=0.3,
        cohesion=cohesion,
        friction=friction,
        tensile_strength=1e9,
        zones=bsm.Zones(size=size, order=order, law="mohr_coulomb", dilation=dilation),
    )
    return bsm.Model(
        blocks=blocks, rocks=[soil], supports=[bsm.Fixed(boundary="bottom"), bsm.NormalRoller(boundary="side")]
    )
