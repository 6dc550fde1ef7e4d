"""Semicircular arches around what limit analysis knows, and flat arches of two stones that snap through."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from benchmarks.campaign.families.draws import near, stiffness
from benchmarks.campaign.scene import Scene, box
from benchmarks.campaign.trial import Draft, Expected

THICKNESS = {  # least thickness over radius that stands without sliding, by the number of voussoirs (limit analysis)
    8: 0.09997, 10: 0.10701, 12: 0.10486, 16: 0.10708, 20: 0.10735, 30: 0.10741, 32: 0.10720, 50: 0.10744, 64: 0.10738,
}  # fmt: skip
STEEP = 80.0  # friction [degrees] at which nothing slides
SNAP = (
    0.005,
    0.1,
)  # of the limit; and per unit that shear springs are softer: at the crown one stone slides on the other
SOFTENING = 2e6, 2e-2  # a joint of this stiffness [Pa/m] in an arch of 1 m radius stands 2 % later


def draw_arch(generator: np.random.Generator) -> Draft:
    """Return an arch: half of them of steep friction and nearly their least thickness, half loaded or slippery."""
    count = int(generator.choice(list(THICKNESS)))
    radius = 10 ** generator.uniform(0, 1)
    kn, ks = stiffness(generator)
    is_plain = generator.random() < 0.5
    friction = STEEP if is_plain else generator.uniform(18, 60)
    ratio = near(generator, THICKNESS[count]) if is_plain else generator.uniform(0.09, 0.3)
    stones, springings = voussoirs(count, radius, ratio * radius)
    load, block = 0.0, int(generator.integers(count))
    if not is_plain and generator.random() < 0.5:
        load = 26e3 * np.pi * radius * ratio * radius * generator.uniform(0.01, 0.3)
    scene = Scene(
        polygons=[*stones, *springings],
        held=np.array([count, count + 1]),
        friction=friction,
        kn=kn,
        ks=ks,
        loads=((block, tuple(stones[block].mean(axis=0).tolist()), (0.0, -load)),) if load else (),
    )
    parameters = {
        "count": count, "radius": radius, "ratio": ratio, "friction": friction, "load": load, "block": block,
        "kn": kn, "ks": ks,
    }  # fmt: skip
    softening = SOFTENING[1] * SOFTENING[0] * radius**2 * 26 / 25 / kn  # closure over thickness grows with the radius
    expected = Expected(form="arch thickness", margin=ratio / THICKNESS[count] - 1, tolerance=max(5e-3, 50 * softening))
    return Draft(scene=scene, parameters=parameters, expected=expected if is_plain else None)


def draw_beam(generator: np.random.Generator) -> Draft:
    """Return two stones between walls that carry their weight as a flat arch, until their joints give way too far.

    With the angle b of the diagonal of a stone, each is in balance where its weight is ``W(b)``; the greatest of these
    is the limit. Half of the middle joint's closure and that of a wall's shorten the way of a thrust N by 1.5 N / k,
    the point in a corner having the stiffness ``k = kn h / 2``.
    """
    length, flatness = generator.uniform(1.0, 4.0), generator.uniform(0.04, 0.25)
    kn, ks = stiffness(generator)
    ratio = near(generator, 1.0)
    return _beam(length, flatness, kn, ks, ratio, STEEP, SNAP[0] + SNAP[1] * (1 - ks / kn))


def draw_stiff_beam(generator: np.random.Generator) -> Draft:
    """Return such stones with shear springs up to 10 000 times as stiff as normal ones, and less friction.

    The face between the stones turns, so that its shear spring carries a part of the thrust: in series with the normal
    one by the square of the turn.
    """
    length, flatness = generator.uniform(1.0, 4.0), generator.uniform(0.04, 0.25)
    kn, more = 10 ** generator.uniform(7, 9), 10 ** generator.uniform(0, 4)
    friction = float(generator.choice([40.0, 60.0, STEEP]))
    return _beam(length, flatness, kn, kn * more, near(generator, 1.0), friction, SNAP[0])


def _beam(
    length: float, flatness: float, kn: float, ks: float, ratio: float, friction: float, tolerance: float
) -> Draft:
    """Return two stones that weigh `ratio` of the most that they can carry."""
    height = flatness * length
    angle = np.linspace(0, np.arctan(flatness), 20_001)
    turned = angle[-1] - angle
    middle = np.cos(turned) ** 2 + np.sin(turned) ** 2 * kn / ks if ks > kn else 1.0
    diagonal = np.hypot(length, height)
    carried = 2 * kn * height / 2 / (1 + middle / 2) * np.tan(angle) * (diagonal * np.cos(angle) - length)
    unit_weight = float(ratio * carried.max() / (length * height))
    wall = max(length, height)
    scene = Scene(
        polygons=[
            box(-wall, -wall, 0.0, height + wall),
            box(2 * length, -wall, 2 * length + wall, height + wall),
            box(0.0, 0.0, length, height),
            box(length, 0.0, 2 * length, height),
        ],
        held=np.array([0, 1]),
        friction=friction,
        kn=kn,
        ks=ks,
        unit_weight=unit_weight,
    )
    parameters = {"length": length, "height": height, "ratio": ratio, "weight": unit_weight, "kn": kn, "ks": ks}
    if friction != STEEP:
        parameters["friction"] = friction
    expected = Expected(form="snap through", margin=1 - ratio, tolerance=tolerance)
    return Draft(scene=scene, parameters=parameters, expected=expected)


def voussoirs(count: int, radius: float, thickness: float) -> tuple[list[np.ndarray], list[np.ndarray]]:
    """Return the voussoirs from left to right, and the two springings."""
    angle = np.linspace(np.pi, 0, count + 1)
    ray = np.column_stack([np.cos(angle), np.sin(angle)])
    inner, outer = radius - thickness / 2, radius + thickness / 2
    stones = [np.array([inner * b, outer * b, outer * a, inner * a]) for a, b in pairwise(ray)]
    low = -0.2 * radius
    right = np.array([(inner, low), (outer, low), (outer, 0.0), (inner, 0.0)])
    left = np.array([(-outer, low), (-inner, low), (-inner, 0.0), (-outer, 0.0)])
    return stones, [left, right]
