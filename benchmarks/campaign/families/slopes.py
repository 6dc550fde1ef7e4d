"""Jointed slopes: two joint sets behind a face that falls to the right, from an in-situ start or from zero stress."""

from __future__ import annotations

import numpy as np

from benchmarks.campaign.families.draws import blocks_wanted, start_of, stiffness
from benchmarks.campaign.scene import FloatArray, Line, Scene
from benchmarks.campaign.trial import Draft
from bsm_mesh.geometries import JointSet, Normal, Region, RockMass, cut_blocks

SPREAD = 0.25  # of random spacings, over their mean
SCATTER = 2.0  # of the dips of joints that are cut [degrees]


def draw_slope(generator: np.random.Generator) -> Draft:
    """Return a slope whose flat set daylights in the face and whose columns lean out over it."""
    return _draw(generator, (generator.uniform(45, 85), -generator.uniform(12, 45)))


def draw_leaning(generator: np.random.Generator) -> Draft:
    """Return a slope whose columns lean into it; nothing daylights in the face."""
    return _draw(generator, (-generator.uniform(45, 85), generator.uniform(12, 45)))


def _draw(generator: np.random.Generator, dips: tuple[float, float]) -> Draft:
    n = blocks_wanted(generator, 60, 600)
    face = generator.uniform(40, 75)
    spacings = generator.uniform(0.8, 2.5), generator.uniform(0.8, 2.5)
    friction = generator.uniform(20, 50)
    kn, ks = stiffness(generator)
    is_cut = generator.random() < 0.3
    ground = Ground(n * spacings[0] * spacings[1] / np.sin(np.radians(abs(dips[0] - dips[1]))), face)
    polygons = (_cut if is_cut else _stepped)(generator, ground, dips, spacings)
    held = ground.holds(polygons)
    k0 = start_of(generator)
    scene = Scene(
        polygons=polygons,
        held=held,
        friction=friction,
        kn=kn,
        ks=ks,
        surface=ground.surface,
        k0=k0,
    )
    parameters = {
        "face": face, "dip_1": dips[0], "dip_2": dips[1], "spacing_1": spacings[0], "spacing_2": spacings[1],
        "friction": friction, "kn": kn, "ks": ks, "start": "gravity" if k0 is None else "in situ",
        "k0": -1.0 if k0 is None else k0, "surface": "cut" if is_cut else "stepped",
    }  # fmt: skip
    return Draft(scene=scene, parameters=parameters)


class Ground:
    """The outline of a slope whose toe is the origin: half its height of rock below, once its height beside it."""

    def __init__(self, area: float, face: float) -> None:
        self.run = 1 / np.tan(np.radians(face))
        self.height = float(np.sqrt(area / (2.0 + self.run)))
        self.left, self.right = -self.height * (1 + self.run), self.height
        self.bottom = -self.height / 2

    @property
    def surface(self) -> Line:
        """The ground from left to right."""
        crest = -self.height * self.run
        return (self.left, self.height), (crest, self.height), (0.0, 0.0), (self.right, 0.0)

    def top(self, x: FloatArray) -> FloatArray:
        """Return the level of the ground."""
        return np.where(x > 0, 0.0, np.minimum(self.height, -x / self.run))

    def holds(self, polygons: list[FloatArray]) -> np.ndarray:
        """Return the blocks that reach the bottom or the sides."""
        off = 1e-6 * self.height
        low = np.array([polygon.min(axis=0) for polygon in polygons])
        high = np.array([polygon.max(axis=0) for polygon in polygons])
        reach = (low[:, 0] < self.left + off) | (high[:, 0] > self.right - off) | (low[:, 1] < self.bottom + off)
        return np.flatnonzero(reach)


def _stepped(
    generator: np.random.Generator, ground: Ground, dips: tuple[float, float], spacings: tuple[float, float]
) -> list[FloatArray]:
    """Return whole blocks between the joints whose centres lie under the ground: a face in steps."""
    along = [np.array([np.cos(a), np.sin(a)]) for a in np.radians(dips)]
    across = np.array([(-y, x) for x, y in along])
    ring = 1.5 * max(spacings)
    reach = 2 * (ground.right - ground.left)
    offsets = []
    for spacing in spacings:
        steps = generator.normal(spacing, SPREAD * spacing, int(2 * reach / spacing) + 4).clip(0.4 * spacing)
        lines = np.cumsum(steps)
        offsets.append(lines - lines.mean())
    points = np.stack(np.meshgrid(*offsets, indexing="ij"), axis=-1) @ np.linalg.inv(across).T
    cells = np.stack([points[:-1, :-1], points[1:, :-1], points[1:, 1:], points[:-1, 1:]], axis=2).reshape(-1, 4, 2)
    if np.linalg.det(across) < 0:
        cells = cells[:, ::-1]
    x, y = cells.mean(axis=1).T
    kept = (y < ground.top(x)) & (x > ground.left - ring) & (x < ground.right + ring) & (y > ground.bottom - ring)
    return list(cells[kept])


def _cut(
    generator: np.random.Generator, ground: Ground, dips: tuple[float, float], spacings: tuple[float, float]
) -> list[FloatArray]:
    """Return the blocks of a plane face, cut by joints of scattered dip."""
    outline = [(ground.left, ground.bottom), (ground.right, ground.bottom), *reversed(ground.surface)]
    sets = [
        JointSet(name=name, dip=dip, spacing=Normal(spacing, SPREAD * spacing), scatter=SCATTER)
        for name, dip, spacing in zip("ab", dips, spacings, strict=True)
    ]
    mass = RockMass(regions=[Region(outline=outline, rock="rock")], joints=sets, seed=int(generator.integers(2**31)))
    return polygons_of(mass)


def polygons_of(mass: RockMass) -> list[FloatArray]:
    """Return the blocks of a rock mass."""
    cut = cut_blocks(mass)
    return np.split(cut.points[cut.corners], cut.rings[1:-1])
