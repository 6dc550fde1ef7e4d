"""Large scenes drawn at random: walls, slopes, layers, jointed and Voronoi rock of 5000 to 11 000 blocks.

All start from zero stress, gravity switched on, so that rules of the first step can be judged by them.
"""

from __future__ import annotations

from functools import partial

import numpy as np

from bsm_mesh import geometries as g
from tests.scenes import large

SCENES, SEED = 30, 62
FEWEST, MOST = 5000, 10_000  # blocks
ROCK_HEIGHT = 40.0  # of the slopes in rock [m]


def random_scene(number: int) -> tuple[str, partial[large.Scene]]:
    """Return the name of a scene, with its friction [degrees], and what builds it."""
    kind, friction, _, _ = _drawn(number)
    return f"{number} {kind} {friction:g}", partial(_built, number)


def _built(number: int) -> large.Scene:
    kind, friction, blocks, generator = _drawn(number)
    return _SCENES[kind](number, blocks, friction, generator)


def _drawn(number: int) -> tuple[str, float, int, np.random.Generator]:
    """Return kind, friction [degrees] and number of blocks of a scene, and what draws the rest."""
    generator = np.random.default_rng([number, SEED])
    friction, blocks = round(float(generator.uniform(25, 45)), 1), int(generator.integers(FEWEST, MOST))
    return KINDS[number % len(KINDS)], friction, blocks, generator


def _wall(number: int, blocks: int, friction: float, generator: np.random.Generator) -> large.Scene:
    bricks = round((blocks / generator.uniform(0.3, 2.0)) ** 0.5)
    return large.tilted_courses(round(blocks / bricks), bricks, friction, tilt=generator.uniform(0, 12))


def _slope(number: int, blocks: int, friction: float, generator: np.random.Generator) -> large.Scene:
    return large.jointed_slope(blocks, friction, dips=(generator.uniform(45, 80), -generator.uniform(15, 40)))


def _leaning(number: int, blocks: int, friction: float, generator: np.random.Generator) -> large.Scene:
    return large.jointed_slope(blocks, friction, dips=(-generator.uniform(45, 80), generator.uniform(15, 40)))


def _layers(number: int, blocks: int, friction: float, generator: np.random.Generator) -> large.Scene:
    return large.sliding_layers(blocks, friction)


def _jointed(number: int, blocks: int, friction: float, generator: np.random.Generator) -> large.Scene:
    spacing = g.Lognormal(0.92 * _side(blocks), 0.3 * _side(blocks))  # lines at random make fewer
    first, second = generator.uniform(-80, -20), generator.uniform(10, 70)
    sets = [
        g.JointSet(name="J1", dip=first, spacing=spacing, scatter=2.0),
        g.JointSet(name="J2", dip=second, spacing=spacing, scatter=2.0),
    ]
    return _rock(number, friction, sets)


def _voronoi(number: int, blocks: int, friction: float, generator: np.random.Generator) -> large.Scene:
    return _rock(number, friction, [g.Voronoi(name="joint", size=_side(blocks), rounds=3)])


def _side(blocks: int) -> float:
    """Return the side [m] of one of so many blocks, by the area of the outline of `_rock`."""
    return float((3 * ROCK_HEIGHT**2 / blocks) ** 0.5)


def _rock(number: int, friction: float, joints: list[g.JointSet | g.Voronoi]) -> large.Scene:
    """Return a slope of 45 degrees in rock that joints cut; what touches its bottom and sides is held."""
    h = ROCK_HEIGHT
    outline = ((-2 * h, -h / 2), (h, -h / 2), (h, 0.0), (0.0, 0.0), (-h, h), (-2 * h, h))
    cut = g.cut_blocks(g.RockMass(regions=[g.Region(outline=outline, rock="rock")], joints=joints, seed=number))
    polygons = np.split(cut.points[cut.corners], cut.rings[1:-1])
    near = 1e-6 * h
    x, y = cut.points[cut.corners].T
    at_end = (x < -2 * h + near) | (x > h - near) | (y < -h / 2 + near)
    held = np.flatnonzero(np.logical_or.reduceat(at_end, cut.rings[:-1]))
    return large.Scene(polygons=polygons, held=held, friction=friction)


_SCENES = {
    "wall": _wall,
    "slope": _slope,
    "jointed rock": _jointed,
    "leaning": _leaning,
    "Voronoi rock": _voronoi,
    "layers": _layers,
}
KINDS = tuple(_SCENES)
