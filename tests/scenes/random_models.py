"""Random piles and jointed banks of convex blocks, for hypothesis."""

from __future__ import annotations

import numpy as np
from hypothesis import strategies as st

from tests.scenes import models
from tests.scenes.shapes import rectangle, turned


def convex(rng, sides):
    """Return a convex polygon on an ellipse, about its middle."""
    angle = np.sort((np.arange(sides) + rng.uniform(0.1, 0.9, sides)) * 2 * np.pi / sides)
    return turned(np.column_stack([np.cos(angle), np.sin(angle)]) * rng.uniform(0.3, 0.8, 2), rng.uniform(0, 360))


@st.composite
def piles(draw):
    """Return a model of blocks stacked at random, each lowered to just above the highest point below it."""
    rng = np.random.default_rng(draw(st.integers(0, 10_000)))
    polygons, top = [rectangle(-4, -1, 4, 0)], np.zeros(81)
    lines = np.linspace(-4, 4, 81)
    for _ in range(draw(st.integers(1, 6))):
        block = convex(rng, int(rng.integers(3, 7)))
        block += np.array([rng.uniform(-2, 2), 0.0])
        low, high = block[:, 0].min() - 0.1, block[:, 0].max() + 0.1
        under = (lines >= low) & (lines <= high)
        block += np.array([0.0, top[under].max() - block[:, 1].min() + draw(st.sampled_from([0.0, 0.05]))])
        top[under] = block[:, 1].max()
        polygons.append(block)
    return model_of(draw, polygons)


def model_of(draw, polygons):
    """Return the polygons as a model, the first one fixed."""
    friction, gravity = draw(st.sampled_from([10.0, 35.0, 60.0])), draw(st.sampled_from([-90.0, -100.0]))
    return models.model_of(polygons, friction=friction, ks=5e8, gravity_direction=gravity)


def parts(polygon, point, direction):
    """Return the two parts of a convex polygon beside a line, or the polygon where the line misses it."""
    side = (polygon - point) @ np.array([-direction[1], direction[0]])
    found = []
    for sign in (1, -1):
        corners = []
        for p, q, a, b in zip(polygon, np.roll(polygon, -1, 0), sign * side, sign * np.roll(side, -1), strict=True):
            if a > 0:
                corners.append(p)
            if a * b < 0:
                corners.append(p + a / (a - b) * (q - p))
        if len(corners) > 2:
            found.append(np.array(corners))
    return found


def area(polygon):
    x, y = polygon.T
    return 0.5 * (x * np.roll(y, -1) - y * np.roll(x, -1)).sum()


@st.composite
def jointed_banks(draw):
    """Return a bank of rock on a base, cut into convex blocks by random joints, some blocks taken out."""
    rng = np.random.default_rng(draw(st.integers(0, 10_000)))
    polygons = [rectangle(0, 0, 3, 2)]
    for _ in range(draw(st.integers(1, 4))):
        angle = rng.uniform(0, np.pi)
        point, direction = rng.uniform((0.3, 0.3), (2.7, 1.7)), (np.cos(angle), np.sin(angle))
        cut = [parts(p, point, direction) for p in polygons]
        polygons = [
            q for p, found in zip(polygons, cut, strict=True) for q in (found if min(map(area, found)) > 0.02 else [p])
        ]
    kept = rng.random(len(polygons)) < 0.85
    kept[0] = True
    return model_of(draw, [rectangle(-3, -1, 6, 0), *(p for p, k in zip(polygons, kept, strict=True) if k)])
