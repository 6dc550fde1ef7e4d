"""Larger models: the scenes of ``docs/performance.md`` and others of their kind, chosen by ``--size``."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from benchmarks.campaign.families import FAMILIES
from benchmarks.campaign.random_scenes import MOST, SCENES, random_scene
from benchmarks.campaign.scene import Dig, Scene
from benchmarks.campaign.trial import Draft, Family
from tests.scenes import large

Build = Callable[[int], large.Scene]


@dataclass(frozen=True, kw_only=True)
class Named:
    """A scene of the benchmark suite, from zero stress or with a ratio of in-situ stresses."""

    name: str
    build: Build
    k0: float | None = None


def _slopes(kind: str, build: Callable[..., large.Scene], *starts: tuple[float, float | None]) -> list[Named]:
    return [
        Named(
            name=f"{kind} {friction:g}, {'gravity' if k0 is None else f'in situ {k0:g}'}",
            build=partial(build, friction=friction),
            k0=k0,
        )
        for friction, k0 in starts
    ]


def _rock(friction: float, k0: float) -> Named:
    return Named(name=f"rock {friction:g}, in situ {k0:g}", build=partial(large.blocky_rock, friction=friction), k0=k0)


def _random(number: int) -> Named:
    name, build = random_scene(number)
    return Named(name=name, build=lambda n: build())


WALL = Named(name="wall", build=large.tilted_wall)
SIZES: dict[str, tuple[int, list[Named]]] = {
    "1e4": (
        10_000,
        [
            WALL,
            Named(name="wall 30", build=partial(large.tilted_wall, friction=30.0)),
            *_slopes("slope", large.jointed_slope, (35, 1.0), (35, None), (40, 1.0), (40, None), (30, 1.0), (30, None)),
            *_slopes("leaning", large.leaning_slope, (35, 1.0), (35, None), (35, 0.5), (30, 1.0), (30, None)),
            _rock(35, 1.0),
            _rock(30, 1.0),
            _rock(35, 2.0),
            _rock(35, 0.5),
            Named(name="layers", build=large.sliding_layers),
            Named(name="bolts, passive", build=large.bolted_wall),
            Named(name="bolts, pretension", build=partial(large.bolted_wall, pretension=20e3)),
        ],
    ),
    "1e5": (
        100_000,
        [
            WALL,
            _rock(35, 1.0),
            *_slopes("leaning", large.leaning_slope, (35, None), (35, 1.0)),
            *_slopes("slope", large.jointed_slope, (35, None), (35, 1.0)),
        ],
    ),
    "1e6": (1_000_000, [WALL]),
    "random": (MOST, [_random(number) for number in range(SCENES)]),
}
LIMITS = {"random": 150.0, "1e4": 300.0, "1e5": 1800.0, "1e6": 7200.0}  # processor seconds


def scene_of(named: Named, n: int) -> Scene:
    """Return a scene of the benchmark suite, of about n blocks, as one of the campaign's."""
    made = named.build(n)
    polygons = [np.asarray(polygon, dtype=np.float64) for polygon in made.polygons]
    digs = []
    for stage in made.stages:
        import shapely

        centres = np.array([polygon.mean(axis=0) for polygon in polygons])
        inside = [shapely.contains_xy(shapely.Polygon(outline), *centres.T) for outline in stage.excavate]
        digs.append(Dig(blocks=np.flatnonzero(np.any(inside, axis=0))))
    return Scene(
        polygons=polygons,
        held=np.asarray(made.held, dtype=np.int64),
        friction=made.friction,
        cohesion=made.cohesion,
        kn=large.STIFFNESS,
        ks=large.STIFFNESS,
        unit_weight=large.DENSITY * large.GRAVITY,
        gravity=made.gravity_direction,
        surface=made.surface if named.k0 is not None else (),
        k0=named.k0,
        bolts=tuple(made.bolts),
        digs=tuple(digs),
    )


def _draw(size: str, number: int) -> Draft:
    n, chosen = SIZES[size]
    return Draft(scene=scene_of(chosen[number], n), parameters={"scene": chosen[number].name})


def families_of(size: str) -> dict[str, Family]:
    """Return the scenes of a size, a family each, of one model."""
    _, chosen = SIZES[size]
    return {
        f"{size} {named.name}": Family(
            name=f"{size} {named.name}",
            title=named.name,
            draw=lambda generator, number=number: _draw(size, number),
            models=1,
        )
        for number, named in enumerate(chosen)
    }


def every_family() -> dict[str, Family]:
    """Return the random families and the scenes of every size."""
    found = dict(FAMILIES)
    for size in SIZES:
        found |= families_of(size)
    return found
