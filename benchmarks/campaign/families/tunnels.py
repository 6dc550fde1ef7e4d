"""Openings excavated in jointed rock under in-situ stress, at once or in parts."""

from __future__ import annotations

import numpy as np

from benchmarks.campaign.families.draws import blocks_wanted, stiffness
from benchmarks.campaign.families.slopes import SCATTER, SPREAD, polygons_of
from benchmarks.campaign.scene import Dig, FloatArray, Scene
from benchmarks.campaign.trial import Draft
from bsm_mesh.geometries import JointSet, Normal, Region, RockMass, Voronoi, circle, horseshoe, rectangle


def draw_tunnel(generator: np.random.Generator) -> Draft:
    """Return an opening in rock with two joint sets."""
    first = generator.uniform(0, 180)
    second = first + generator.uniform(50, 130)
    spacing = generator.uniform(0.7, 1.4, 2)
    n = blocks_wanted(generator, 60, 400)
    side = float((n * spacing[0] * spacing[1]) ** 0.5)
    joints = [
        JointSet(name=name, dip=dip, spacing=Normal(s, SPREAD * s), scatter=SCATTER)
        for name, dip, s in (("a", first, spacing[0]), ("b", second, spacing[1]))
    ]
    parameters = {"dip_1": first, "dip_2": second, "spacing_1": float(spacing[0]), "spacing_2": float(spacing[1])}
    return _draw(generator, side, joints, parameters)


def draw_cavern(generator: np.random.Generator) -> Draft:
    """Return an opening in blocky rock, Voronoi cells."""
    n, rounds = blocks_wanted(generator, 60, 400), int(generator.integers(0, 6))
    return _draw(generator, float(n**0.5), [Voronoi(name="cells", size=1.0, rounds=rounds)], {"rounds": rounds})


def _draw(
    generator: np.random.Generator, side: float, joints: list[JointSet] | list[Voronoi], parameters: dict
) -> Draft:
    half = side / 2
    mass = RockMass(
        regions=[Region(outline=rectangle(-half, -half, half, half), rock="rock")],
        joints=joints,
        seed=int(generator.integers(2**31)),
    )
    polygons = polygons_of(mass)
    outermost = np.array([np.abs(corners).max() for corners in polygons])
    held = np.flatnonzero(outermost > half * (1 - 1e-6))
    radius = side * generator.uniform(0.12, 0.22)
    is_circle = generator.random() < 0.5
    outline = circle(radius) if is_circle else horseshoe(2 * radius, 2 * radius, base=(0.0, -radius))
    opening = np.setdiff1d(_inside(polygons, outline), held)
    if not opening.size:
        opening = np.setdiff1d([_nearest(polygons)], held)
    depth = half + side * 10 ** generator.uniform(-1, 1)
    k0 = generator.uniform(0.3, 2.0)
    friction = generator.uniform(20, 50)
    cohesion = float(generator.choice([0.0, 0.0, 10 ** generator.uniform(4, 6.3)]))
    kn, ks = stiffness(generator)
    in_parts = generator.random() < 0.5
    relaxation = ((1.0,), (0.5, 1.0))[int(generator.random() < 0.4)]
    scene = Scene(
        polygons=polygons,
        held=held,
        friction=friction,
        cohesion=cohesion,
        kn=kn,
        ks=ks,
        surface=((-half, depth), (half, depth)),
        k0=k0,
        digs=tuple(Dig(blocks=part, relaxation=relaxation) for part in _parts(polygons, opening, in_parts)),
    )
    parameters |= {
        "side": side, "radius": radius, "shape": "circle" if is_circle else "horseshoe", "depth": depth, "k0": k0,
        "friction": friction, "cohesion": cohesion, "kn": kn, "ks": ks, "stages": len(scene.digs),
        "relaxation": len(relaxation),
    }  # fmt: skip
    return Draft(scene=scene, parameters=parameters)


def _inside(polygons: list[FloatArray], outline: FloatArray) -> np.ndarray:
    import shapely

    centres = np.array([polygon.mean(axis=0) for polygon in polygons])
    return np.flatnonzero(shapely.contains_xy(shapely.Polygon(outline), *centres.T))


def _nearest(polygons: list[FloatArray]) -> int:
    return int(np.argmin([np.hypot(*polygon.mean(axis=0)) for polygon in polygons]))


def _parts(polygons: list[FloatArray], opening: np.ndarray, in_parts: bool) -> list[np.ndarray]:
    """Return the opening, or its crown and then its bench."""
    level = np.array([polygons[block][:, 1].mean() for block in opening])
    crown = level >= np.median(level)
    return [opening[crown], opening[~crown]] if in_parts and crown.any() and not crown.all() else [opening]
