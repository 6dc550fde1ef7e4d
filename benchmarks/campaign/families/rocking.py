"""Columns, dams and stacks with water behind them: they leave their heel, and rest at a tilt where it presses less."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from scipy.optimize import brentq

from benchmarks.campaign.families.draws import near, stiffness
from benchmarks.campaign.scene import FloatArray, Line, Scene, box, polygon_area, polygon_centre, turn
from benchmarks.campaign.trial import Draft, Expected

GAMMA, WATER = 25e3, 9810.0  # N/m3
STEEP = 78.0  # friction [degrees] at which nothing slides
SLIDING = 0.7  # of the friction: steeper thrusts on the toe are not judged
FARTHEST = 0.15  # of a block's size: larger tilts are not looked for
SPRINGS = 20.0  # times the closure of the toe over the base: what springs make of a level
APART = 1e-3  # of both levels: where they are nearer, none between them is sought
TRIES = 50  # for a shape that has a level


def draw_rocking(generator: np.random.Generator) -> Draft:
    """Return a body on a base, its toe at the origin, with a level between, or around, its two limits."""
    shape = str(generator.choice(["column", "dam", "stack"]))
    for _ in range(TRIES):
        polygons = _body(generator, shape)
        tail = float(generator.choice([0.0, generator.uniform(0, 0.4)])) * polygons[-1][:, 1].max()
        limits = level_limits(polygons, tail)
        if limits is not None:
            break
    else:
        raise RuntimeError("no shape has a level")
    leaves, falls = limits
    level = near(generator, float(generator.choice(limits)))
    if falls > (1 + APART) * leaves and generator.random() < 0.6:  # at rest at a tilt
        level = float(generator.uniform(leaves, falls))
    kn, ks = stiffness(generator)
    kn, ks = 10 * kn, 10 * ks
    width = -polygons[0][:, 0].min()
    base = box(-6 * width - 4, -2.0, 6 * width + 4, 0)
    scene = Scene(
        polygons=[base, *polygons],
        held=np.array([0]),
        friction=STEEP,
        kn=kn,
        ks=ks,
        unit_weight=GAMMA,
        water_weight=WATER,
        table=table_of(level, tail, width),
    )
    tilt = tilt_at_rest(polygons, level, tail)
    at_toe = forces_at_toe(polygons, tilt or 0.0, scene.table)
    closure = float(at_toe[1] / (kn * width / 2) / width * max(1.0, kn / ks * at_toe[0] / at_toe[1]))
    parameters = {
        "shape": shape, "blocks": len(polygons), "width": width, "height": float(polygons[-1][:, 1].max()),
        "level": level, "tail": tail, "leaves": leaves, "falls": falls, "tilt": tilt or 0.0, "kn": kn, "ks": ks,
    }  # fmt: skip
    expected = Expected(
        form="rocking on water",
        margin=1 - level / falls,
        tolerance=2e-4 + SPRINGS * closure,
        moved=None if tilt is None else float(movement(polygons, tilt) / scene.size),
        moved_within=SPRINGS * closure + 2e-3,
    )
    slides = abs(at_toe[0]) > SLIDING * np.tan(np.radians(STEEP)) * at_toe[1]
    return Draft(scene=scene, parameters=parameters, expected=None if slides else expected)


def _body(generator: np.random.Generator, shape: str) -> list[FloatArray]:
    """Return the blocks of a body from below, its toe at the origin and its heel to the left."""
    width = float(10 ** generator.uniform(-0.3, 1))
    if shape == "dam":
        height, crest, batter = width * generator.uniform(1.5, 3.5), *(width * generator.uniform(0.1, 0.3, 2))
        return [np.array([(-width, 0), (0, 0), (batter + crest - width, height), (batter - width, height)])]
    height = width * float(generator.uniform(1.5, 5))
    count = int(generator.integers(2, 6)) if shape == "stack" else 1
    return [box(-width, a, 0, b) for a, b in pairwise(np.linspace(0, height, count + 1))]


def table_of(level: float, tail: float, width: float) -> Line:
    """Return the table: level behind the heel, straight through the body to the tailwater at its toe."""
    return ((-6 * width - 4, level), (-width, level), (0.0, tail), (6 * width + 4, tail))


def forces_at_toe(polygons: list[FloatArray], tilt: float, table: Line) -> FloatArray:
    """Return what weight and water of a rigid body, tilted over its toe [rad], press on the toe with.

    Push to the right and down [N/m], and the moment that rights the body [N]. Pressures are integrated between all
    bends of the table and where a face leaves the water, by Gauss's points.
    """
    total = np.zeros(3)
    knots = np.array(table)
    for polygon in polygons:
        corners = turn(polygon, -np.degrees(tilt))
        weight = GAMMA * abs(polygon_area(polygon))
        total += (0.0, weight, -weight * polygon_centre(corners)[0])
        for start, end in pairwise([*corners, corners[0]]):
            total += _thrust(start, end, knots)
    return total


def _thrust(start: FloatArray, end: FloatArray, knots: FloatArray) -> FloatArray:
    """Return the water's push to the right and down on a face, and its moment about the origin."""
    along = end - start

    def head(t: FloatArray) -> FloatArray:
        return np.asarray(np.interp(start[0] + t * along[0], *knots.T) - start[1] - t * along[1])

    bends = (knots[:, 0] - start[0]) / along[0] if along[0] else np.zeros(0)
    t = np.unique(np.concatenate([[0.0, 1.0], bends[(bends > 0) & (bends < 1)]]))
    h = head(t)
    dry = t[:-1] + np.diff(t) * h[:-1] / np.where(h[:-1] == h[1:], 1.0, h[:-1] - h[1:])
    t = np.unique(np.concatenate([t, dry[h[:-1] * h[1:] < 0]]))
    middle, half = (t[1:] + t[:-1]) / 2, np.diff(t) / 2
    offset = half / np.sqrt(3)
    at = np.concatenate([middle - offset, middle + offset])
    pressure = WATER * np.maximum(head(at), 0.0) * np.tile(half, 2)
    arm = (start[:, None] + along[:, None] * at).T @ along
    return np.array([-along[1] * pressure.sum(), -along[0] * pressure.sum(), arm @ pressure])


def movement(polygons: list[FloatArray], tilt: float) -> float:
    """Return how far a centroid, or a block's half size by its rotation, moves at most by a tilt [m]."""
    size = np.sqrt(np.mean([abs(polygon_area(polygon)) for polygon in polygons]))
    arm = max(float(np.hypot(*polygon_centre(polygon))) for polygon in polygons)
    return max(2 * arm * np.sin(tilt / 2), float(size) / 2 * tilt)


def _tilts(polygons: list[FloatArray]) -> FloatArray:
    size = np.sqrt(np.mean([abs(polygon_area(polygon)) for polygon in polygons]))
    return np.linspace(0, FARTHEST * float(size) / movement(polygons, 1e-3) * 1e-3, 41)


def tilt_at_rest(polygons: list[FloatArray], level: float, tail: float) -> float | None:
    """Return the least tilt at which weight and water right the body [rad]; None where there is none."""
    table = table_of(level, tail, -polygons[0][:, 0].min())

    def righting(tilt: float) -> float:
        return float(forces_at_toe(polygons, tilt, table)[2])

    tilts = _tilts(polygons)
    rights = np.array([righting(tilt) for tilt in tilts]) >= 0
    if not rights.any():
        return None
    first = int(rights.argmax())
    return 0.0 if first == 0 else float(brentq(righting, tilts[first - 1], tilts[first]))


def level_limits(polygons: list[FloatArray], tail: float) -> tuple[float, float] | None:
    """Return the level at which a body leaves its heel, and that above which no tilt rights it; None: there is none."""
    width, height = -polygons[0][:, 0].min(), polygons[-1][:, 1].max()

    def most(level: float, tilts: FloatArray) -> float:
        table = table_of(level, tail, width)
        return max(float(forces_at_toe(polygons, tilt, table)[2]) for tilt in tilts)

    low, high = tail + 1e-3 * height, height
    still, tilted = np.zeros(1), _tilts(polygons)
    if most(low, still) <= 0 or most(high, tilted) >= 0:
        return None
    leaves = float(brentq(most, low, high, args=(still,)))
    return leaves, float(brentq(most, leaves, high, args=(tilted,), xtol=1e-9)) if most(leaves, tilted) > 0 else leaves
