"""Blocks with zones that meet where they touched nothing before."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

import bsm_mesh as bsm
from tests.scenes.shapes import rectangle, turned

WEIGHT = 25e3  # N/m3


def meeting(polygons, *, young=1e13, friction=35.0, degrees=0.0, held=(0,), size=2.0, order=1, kn=1e9, **given):
    """Return a model of blocks with zones in large displacement, some of them fixed; everything turned."""
    zones = bsm.Zones(size=size, order=order, displacement="large")
    return bsm.Model(
        blocks=bsm.Blocks.from_polygons([turned(np.array(each), degrees) for each in polygons], rock="rock"),
        rocks=[bsm.Rock("rock", unit_weight=WEIGHT, young=young, poisson=0.2, zones=zones)],
        joints=[bsm.Joint("J", kn, kn / 2, law=bsm.MohrCoulomb(friction=friction))],
        default_joint="J",
        supports=[bsm.Fixed(blocks=list(held))],
        gravity_direction=degrees - 90.0,
        **given,
    )


def rigid(model):
    """Return the same blocks without zones."""
    return model.replace(rocks=[replace(model.rocks[0], zones=None, young=None, poisson=None)])


def row(seed, *, smooth=False):
    """Return blocks with gaps in a row on a base, some above it, that gravity drives against a stop, if there is one.

    Joints without friction (`smooth`) leave one place of rest; there is a stop then.
    """
    rng = np.random.default_rng(seed)
    count, x, polygons = int(rng.integers(1, 4)), 0.0, []
    for _ in range(count):
        width, height, lift = rng.uniform(0.4, 1.0), rng.uniform(0.4, 1.6), max(0.0, rng.uniform(-2e-3, 4e-3))
        polygons.append(rectangle(x, lift, x + width, lift + height))
        x += width + rng.uniform(2e-3, 8e-3)
    base, stop = rectangle(-0.5, -1, x + 2, 0), rectangle(x, 0, x + 0.6, 2.0 if smooth else rng.uniform(0.5, 1.5))
    held = (0, 1) if smooth or rng.random() < 0.8 else (0,)
    friction, push = (0.0, rng.uniform(0.05, 0.2)) if smooth else (rng.uniform(20, 40), rng.uniform(0.0, 0.6))
    return meeting([base, stop, *polygons], held=held, friction=friction, gravity_horizontal=push)


def dropped(gap=0.02, *, degrees=0.0, **given):
    """Return a block of 1 m x 1 m above a floor."""
    return meeting([rectangle(-1, -1, 3, 0), rectangle(0.2, gap, 1.2, 1 + gap)], degrees=degrees, **given)


def beside(side=1.0, *, displacement="large", **given):
    """Return a block on a floor, and one that hangs in the air beside the floor."""
    model = meeting([rectangle(-1, -1, 3, 0), rectangle(0, 0, 1, 1), rectangle(4, 0, 4 + side, side)], **given)
    zones = bsm.Zones(size=2.0, order=1, displacement=displacement)
    return model.replace(rocks=[replace(model.rocks[0], young=1e10, zones=zones)])


def leaning(degrees=0.0, *, gap=0.02, lean=20.0, wide=0.4, high=3.0, **given):
    """Return a column on its lower corner, on a rough floor, that falls onto a smooth wall."""
    column = turned(np.array([(0, 0), (wide, 0), (wide, high), (0, high)]), -lean)
    column -= column.min(axis=0)
    right = column[:, 0].max() + gap
    polygons = [rectangle(-1, -1, 4, 0), rectangle(right, 0, right + 1, 3.5), column]
    model = meeting(polygons, held=(0, 1), friction=45.0, degrees=degrees, **given)

    def at_wall(x, y):
        return np.abs(turned(np.stack([x, y], axis=1), -degrees)[:, 0] - right) < 1e-6

    smooth = bsm.Joint("smooth", 1e9, 5e8, law=bsm.MohrCoulomb(friction=0.0))
    return model.replace(blocks=model.blocks.with_joint("smooth", at_wall), joints=[*model.joints, smooth])


def leaning_force(results, degrees=0.0):
    """Return the force of the wall on the column [N/m]: found, and by statics where its ends and centroid are."""
    stage = results.stages[0]
    contacts, there = stage.contacts, np.flatnonzero(np.hypot(*stage.contacts.force.T) > 1)
    point, force = (turned(of[there], -degrees) for of in (contacts.point, contacts.force))
    on = (contacts.block_a[there] == 2) | (contacts.block_b[there] == 2)
    (foot, top), size = (of[on][np.argsort(point[on, 1])] for of in (point, np.abs(force)))
    model = results.model
    middle = turned((model.blocks.moments.centroid + stage.displacement[:, :2])[2:], -degrees)[0]
    weight = float(np.hypot(*model.gravity_forces[2]))
    return size[-1, 0], weight * (middle[0] - foot[0]) / (top[1] - foot[1])


def beams(load, *, gap=0.02, young=1e9):
    """Return two cantilevers of 10 m x 1 m, one above the other, with a gap; a load [N/m] at the tip of the upper."""
    polygons = [rectangle(0, y, 10, y + 1) for y in (0, 1 + gap)]

    blocks = bsm.Blocks.from_polygons(polygons, rock="rock").with_boundary("held", lambda x, y: x < 1e-9)
    blocks = blocks.with_boundary("tip", lambda x, y: (x > 10 - 1e-9) & (y > 1 + gap / 2))
    zones = bsm.Zones(size=0.5, order=2, displacement="large")
    return bsm.Model(
        blocks=blocks,
        rocks=[bsm.Rock("rock", unit_weight=0.0, young=young, poisson=0.0, zones=zones)],
        joints=[bsm.Joint("J", 1e11, 1e11, law=bsm.MohrCoulomb(friction=0.0))],
        default_joint="J",
        supports=[bsm.Fixed(boundary="held")],
        loads=[bsm.EdgeTractions(boundary="tip", values=np.array([[(0.0, -load)] * 2]))],
    )


def beams_exact(load, *, gap=0.02, young=1e9):
    """Return the force between the beams [N/m]: both bend by F L^3 / (3 E I), and the gap is closed."""
    stiffness = 3 * young / 12 / 10**3
    return max(0.0, (load - gap * stiffness) / 2)


def force_between(results):
    """Return the force that contacts carry [N/m]."""
    return float(np.abs(results.stages[0].contacts.normal_force).sum())
