"""Models whose exact limit is known: a block on an incline, columns, towers, plane failure with water and a bolt."""

from __future__ import annotations

import numpy as np

import bsm_mesh as bsm
from benchmarks.campaign.families.draws import near, stiffness
from benchmarks.campaign.scene import Scene, box, polygon_area, polygon_centre, turn
from benchmarks.campaign.trial import Draft, Expected

SLIDING = 2e-5  # a limit angle is held to 1e-3 degrees
TIPPING = 2e-3  # corners are let in over a thousandth of a block
PLAIN, BOLTED = 2e-3, 2e-2  # of plane failure: a bolt yields only after the block moved, and turned the bolt
GAMMA, WATER = 26e3, 9810.0  # N/m3


def draw_incline(generator: np.random.Generator) -> Draft:
    """Return a block b x h on a plane of angle psi: it slides above phi and topples above atan(b / h)."""
    b, h = 10 ** generator.uniform(-0.5, 1, 2)
    friction = generator.uniform(15, 55)
    kn, ks = stiffness(generator)
    tipping = np.degrees(np.arctan(b / h))
    limit = tipping if generator.random() < 0.5 else friction
    angle = min(near(generator, limit), 80.0)
    size = float(np.hypot(b, h))
    scene = Scene(
        polygons=[turn(box(-6 * size, -size, 6 * size, 0), angle), turn(box(-b / 2, 0, b / 2, h), angle)],
        held=np.array([0]),
        friction=friction,
        kn=kn,
        ks=ks,
    )
    lean = GAMMA * h / kn / (b / 2)  # of the base on its springs, over an angle of tipping
    parameters = {"b": b, "h": h, "angle": angle, "friction": friction, "kn": kn, "ks": ks}
    return Draft(scene=scene, parameters=parameters, expected=_slide_or_tip(angle, friction, tipping, lean))


def draw_column(generator: np.random.Generator) -> Draft:
    """Return n blocks b x h on each other, tilted: they slide above phi and topple above atan(b / (n h))."""
    n = int(generator.integers(2, 25))
    b, h = 10 ** generator.uniform(-0.3, 0.3, 2)
    h = h if n < 6 else h / 2
    friction = generator.uniform(15, 60)
    kn, ks = stiffness(generator)
    tipping = np.degrees(np.arctan(b / (n * h)))
    limit = friction if generator.random() < 0.25 else min(tipping, friction)
    angle = min(near(generator, limit), 80.0)
    base = box(-3 * n * h - b, -h, 3 * n * h + b, 0)
    cells = [base, *(box(-b / 2, k * h, b / 2, (k + 1) * h) for k in range(n))]
    scene = Scene(polygons=[turn(cell, -angle) for cell in cells], held=np.array([0]), friction=friction, kn=kn, ks=ks)
    lean = 2 * GAMMA * n * h / kn / b * n * n * h / b  # every joint turns what is above it
    parameters = {"n": n, "b": b, "h": h, "angle": angle, "friction": friction, "kn": kn, "ks": ks}
    return Draft(scene=scene, parameters=parameters, expected=_slide_or_tip(angle, friction, tipping, lean))


def _slide_or_tip(angle: float, friction: float, tipping: float, lean: float) -> Expected:
    if friction < tipping:
        return Expected(form="sliding", margin=1 - angle / friction, tolerance=SLIDING + lean * angle / tipping / 10)
    return Expected(form="toppling", margin=1 - angle / tipping, tolerance=TIPPING + 3 * lean)


def draw_tower(generator: np.random.Generator) -> Draft:
    """Return blocks of any length on each other, overhanging: a joint opens where what is above it weighs outside."""
    n = int(generator.integers(2, 13))
    length, height = generator.uniform(0.5, 2.0, n), generator.uniform(0.3, 0.8, n)
    kn, ks = stiffness(generator)
    weight = length * height
    centre, reach = np.zeros(n), near(generator, 1.0)
    for k in range(n - 2, -1, -1):  # from above, each block is put under the weight of those on it
        above = (weight[k + 1 :] @ centre[k + 1 :]) / weight[k + 1 :].sum()
        inward = float(generator.uniform(0.1, 0.6)) if k else reach
        centre[k] = above - generator.choice([-1.0, 1.0]) * inward * length[k] / 2
    centre -= centre[0]
    level = np.concatenate([[0], np.cumsum(height)])
    cells = [box(-25, -1, 25, 0)]
    cells += [box(c - a / 2, y, c + a / 2, z) for c, a, y, z in zip(centre, length, level, level[1:], strict=False)]
    scene = Scene(polygons=cells, held=np.array([0]), friction=45.0, kn=kn, ks=ks)
    lean = GAMMA * level[-1] / kn / length.min() * n * level[-1] / length.min()
    margin = min(_overhangs(centre, length, weight))
    parameters = {"n": n, "reach": reach, "kn": kn, "ks": ks}
    expected = Expected(form="overhang", margin=margin, tolerance=2 * TIPPING + 4 * lean)
    return Draft(scene=scene, parameters=parameters, expected=expected)


def _overhangs(centre: np.ndarray, length: np.ndarray, weight: np.ndarray) -> list[float]:
    """Return how far inside each joint the weight above it acts, over half the length of the block below."""
    found = []
    for k in range(len(centre) - 1):
        above = (weight[k + 1 :] @ centre[k + 1 :]) / weight[k + 1 :].sum()
        low = max(centre[k] - length[k] / 2, centre[k + 1] - length[k + 1] / 2)
        high = min(centre[k] + length[k] / 2, centre[k + 1] + length[k + 1] / 2)
        found.append(float(min(above - low, high - above) / (length[k] / 2)))
    return found


def draw_plane(generator: np.random.Generator) -> Draft:
    """Return the block of a plane failure with a tension crack, water in both and a bolt at its yield."""
    height, face, plane = generator.uniform(6, 20), generator.uniform(50, 75), generator.uniform(25, 40)
    crest = height / np.tan(np.radians(face))
    behind = crest + generator.uniform(0.1, 0.4) * (height / np.tan(np.radians(plane)) - crest)
    crack = np.array([behind, behind * np.tan(np.radians(plane))])
    block = np.array([(0, 0), crack, (behind, height), (crest, height)])
    depth = height - crack[1]
    water = float(generator.choice([0.0, generator.uniform(0.1, 0.95)])) * depth
    p = np.radians(plane)
    area = abs(polygon_area(block))
    weight, along = GAMMA * area, float(np.hypot(*crack))
    thrust, uplift = WATER * water**2 / 2, WATER * water * along / 2
    is_bolted = generator.random() < 0.4
    plunge = np.radians(generator.uniform(0, 60))
    force = weight * float(generator.uniform(0.05, 0.3)) if is_bolted else 0.0
    normal = weight * np.cos(p) - uplift - thrust * np.sin(p) + force * np.sin(plunge + p)
    driving = weight * np.sin(p) + thrust * np.cos(p) - force * np.cos(plunge + p)
    factor = near(generator, 1.0)
    friction = float(np.degrees(np.arctan2(factor * driving, normal)))
    kn, ks = stiffness(generator)
    head = np.array([crest, height]) * 0.5 + (0.05, 0.0)
    tip = head + 3 * along * np.array([np.cos(plunge), -np.sin(plunge)])
    steel = force / (np.pi * 0.05**2 / 4)
    ends = (float(head[0]), float(head[1])), (float(tip[0]), float(tip[1]))
    bolts = (bsm.Bolt(start=ends[0], end=ends[1], diameter=0.05, yield_strength=steel),) if is_bolted else ()
    reach, low = behind + 4 * along, -4 * along
    rock = np.array([(0, low), (reach, low), (reach, height), (behind, height), crack, (0, 0)])  # free below the toe
    scene = Scene(
        polygons=[rock, block],
        held=np.array([0]),
        friction=float(np.clip(friction, 1, 75)),
        kn=kn,
        ks=ks,
        table=((0.0, 0.0), (behind, crack[1] + water)) if water else (),
        bolts=bolts,
    )
    parameters = {
        "height": height, "face": face, "plane": plane, "behind": behind, "water": water, "force": force,
        "plunge": float(np.degrees(plunge)), "friction": friction, "factor": factor, "kn": kn, "ks": ks,
    }  # fmt: skip
    moment = _moment_about_toe(block, weight, thrust, crack[1] + water / 3, uplift, along, force, head, plunge)
    stays_flat = normal > 0 and 0.02 * along < moment / normal < 0.98 * along and 1 < friction < 75
    expected = Expected(form="plane failure", margin=factor - 1, tolerance=BOLTED if is_bolted else PLAIN)
    return Draft(scene=scene, parameters=parameters, expected=expected if stays_flat else None)


def _moment_about_toe(
    block: np.ndarray,
    weight: float,
    thrust: float,
    at: float,
    uplift: float,
    along: float,
    force: float,
    head: np.ndarray,
    plunge: float,
) -> float:
    """Return the moment of all loads about the toe, clockwise: over the normal force it is where that acts."""
    from_uplift = uplift * 2 * along / 3
    from_bolt = force * (head[0] * np.sin(plunge) + head[1] * np.cos(plunge))
    return float(weight * polygon_centre(block)[0] - thrust * at - from_uplift + from_bolt)
