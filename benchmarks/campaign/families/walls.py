"""Walls in bond, tilted, and piles of convex blocks."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from benchmarks.campaign.families.draws import blocks_wanted, stiffness
from benchmarks.campaign.scene import FloatArray, Scene, box, turn
from benchmarks.campaign.trial import Draft


def draw_wall(generator: np.random.Generator) -> Draft:
    """Return a wall of bricks with flush ends on a base; all of it is tilted."""
    n = blocks_wanted(generator, 20, 400)
    slenderness = 10 ** generator.uniform(-0.6, 0.5)  # courses over bricks
    courses = max(2, round((n * slenderness) ** 0.5))
    bricks = max(2, round(n / courses))
    length, bond = generator.uniform(0.6, 3.0), generator.uniform(0.2, 0.5)
    tilt = generator.uniform(0, 35)
    friction = generator.uniform(20, 50)
    kn, ks = stiffness(generator)
    cells = [box(-length, -0.5, (bricks + 1) * length, 0.0)]
    for course in range(courses):
        heads = np.arange(bricks + 1.0) if course % 2 == 0 else np.array([0, *(np.arange(bricks) + bond), bricks])
        cells += [box(a, 0.5 * course, b, 0.5 * (course + 1)) for a, b in pairwise(length * heads)]
    scene = Scene(polygons=[turn(cell, -tilt) for cell in cells], held=np.array([0]), friction=friction, kn=kn, ks=ks)
    parameters = {
        "courses": courses, "bricks": bricks, "length": length, "bond": bond, "tilt": tilt, "friction": friction,
        "kn": kn, "ks": ks,
    }  # fmt: skip
    return Draft(scene=scene, parameters=parameters)


def draw_pile(generator: np.random.Generator) -> Draft:
    """Return convex blocks that lie on each other as they were dropped, each on the highest point below it."""
    n = blocks_wanted(generator, 3, 30)
    half = 2.0 + 0.2 * n
    friction = generator.uniform(15, 50)
    kn, ks = stiffness(generator)
    drop = float(generator.choice([0.0, 0.0, 0.05]))
    polygons = [box(-half - 4, -1.0, half + 4, 0.0)]
    for _ in range(n):
        block = _convex(generator) + np.array([generator.uniform(-half, half) / 2, 0.0])
        polygons.append(block + np.array([0.0, _height_above(block, polygons) + drop]))
    scene = Scene(polygons=polygons, held=np.array([0]), friction=friction, kn=kn, ks=ks)
    return Draft(scene=scene, parameters={"blocks": n, "drop": drop, "friction": friction, "kn": kn, "ks": ks})


def _convex(generator: np.random.Generator) -> FloatArray:
    """Return a convex block: corners on an ellipse."""
    sides = int(generator.integers(3, 8))
    angle = np.sort((np.arange(sides) + generator.uniform(0.1, 0.9, sides)) * 2 * np.pi / sides)
    corners = np.column_stack([np.cos(angle), np.sin(angle)]) * generator.uniform(0.3, 0.9, 2)
    return turn(corners, generator.uniform(0, 360))


def _height_above(block: FloatArray, polygons: list[FloatArray]) -> float:
    """Return how far to raise a convex block so that it just lies on convex others."""
    least = -block[:, 1].min()
    for other in polygons:
        x = np.concatenate([block[:, 0], other[:, 0]])
        low, high = max(block[:, 0].min(), other[:, 0].min()), min(block[:, 0].max(), other[:, 0].max())
        if low < high:
            x = np.concatenate([[low, high], x[(x >= low) & (x <= high)]])
            least = max(least, float((_side(other, x, np.fmax) - _side(block, x, np.fmin)).max()))
    return least


def _side(polygon: FloatArray, x: FloatArray, best: np.ufunc) -> FloatArray:
    """Return the top (``np.fmax``) or the bottom (``np.fmin``) of a convex polygon at x within its width."""
    found = np.full(len(x), np.nan)
    for (x0, y0), (x1, y1) in zip(polygon, np.roll(polygon, -1, axis=0), strict=True):
        if x0 == x1:
            at = np.isclose(x, x0, rtol=0, atol=1e-12)
            found[at] = best(best(found[at], y0), y1)
        else:
            at = (x >= min(x0, x1) - 1e-12) & (x <= max(x0, x1) + 1e-12)
            found[at] = best(found[at], y0 + (x[at] - x0) / (x1 - x0) * (y1 - y0))
    return found
