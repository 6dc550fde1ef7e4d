"""Block systems of any size, from numbers alone: no file, no randomness without a seed. Benchmarks solve them too."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

import bsm_mesh as bsm

DENSITY, GRAVITY = 2500.0, 9.81  # kg/m3, m/s2
STIFFNESS = 1e10  # Pa/m, normal and shear
FRICTION = 35.0  # degrees
WALL_SIZES = {100: (10, 10), 1000: (25, 40), 10_000: (100, 100), 100_000: (250, 400)}  # courses, bricks
WALL_SIZES |= {1_000_000: (800, 1250)}
TILT = 5.0  # degrees
DIPS, SPACINGS = (60.0, -30.0), (2.0, 1.0)  # degrees from x, metres between joints of a set
FACE = 50.0  # degrees
ROCK_SIDE, TUNNEL, DEPTH = 100.0, 10.0, 200.0  # of the square, radius, of the centre [m]
ROCK_COHESION = 0.5e6  # Pa
LAYER, DIP, GAP, SLIDING_FRICTION = (
    (2.0, 1.0),
    40.0,
    1.0,
    25.0,
)  # length and thickness of a block [m], degrees, m, degrees
BOLT_LENGTH, BOLT_AWAY = 2.5, 1.6  # of a bolt, less in low walls [m]; of the heads from the sides, in bolt lengths


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Scene:
    """Blocks with one joint, ready for this program and for others.

    Attributes
    ----------
    polygons : sequence of (k, 2) float64 [m]
        Corners of the blocks, counter-clockwise.
    held : (k,) int32
        Blocks that do not move.
    friction, cohesion : float [degrees, Pa]
        Of every joint.
    gravity_direction : float [degrees]
        From the x axis.
    surface : sequence of (x, y) [m]
        The ground, from left to right, where the scene has one.
    stages, bolts : sequence
        As `bsm_mesh.Model` takes them.
    """

    polygons: np.ndarray | list[np.ndarray]
    held: np.ndarray
    friction: float = FRICTION
    cohesion: float = 0.0
    gravity_direction: float = -90.0
    surface: tuple[tuple[float, float], ...] = ()
    stages: tuple[bsm.Stage, ...] = ()
    bolts: list[bsm.Bolt] = field(default_factory=list)

    def model(self, k0: float | None = None) -> bsm.Model:
        """Return the model: rigid blocks; from zero stress, or with `k0` in situ."""
        law = bsm.MohrCoulomb(friction=self.friction, cohesion=self.cohesion)
        return bsm.Model(
            blocks=bsm.Blocks.from_polygons(list(self.polygons), rock="rock"),
            rocks=[bsm.Rock("rock", unit_weight=DENSITY * GRAVITY)],
            joints=[bsm.Joint("joint", normal_stiffness=STIFFNESS, shear_stiffness=STIFFNESS, law=law)],
            default_joint="joint",
            supports=[bsm.Fixed(blocks=self.held)],
            gravity_direction=self.gravity_direction,
            in_situ=None if k0 is None else bsm.InSitu(surface=self.surface, k0=k0),
            stages=self.stages,
            bolts=self.bolts,
        )


def tilted_wall(n: int, friction: float = FRICTION, tilt: float = TILT) -> Scene:
    """Return a half-bond wall of about n bricks of 1 x 0.5 m with flush ends on a fixed base, gravity turned."""
    courses, bricks = WALL_SIZES.get(n) or (max(1, round((n / 1.6) ** 0.5)), max(1, round((1.6 * n) ** 0.5)))
    return tilted_courses(courses, bricks, friction, tilt)


def tilted_courses(courses: int, bricks: int, friction: float = FRICTION, tilt: float = TILT) -> Scene:
    """Return such a wall of so many courses, of so many bricks in every second one."""
    left, course = [], []
    for j in range(courses):
        heads = np.arange(bricks) if j % 2 == 0 else np.concatenate([[0.0], np.arange(bricks) + 0.5])
        left.append(heads)
        course.append(np.full(len(heads), j))
    right = [np.append(heads[1:], bricks) for heads in left]
    x0, x1, j = np.concatenate(left), np.concatenate(right), np.concatenate(course)
    base = np.array([[(-1.0, -0.5), (bricks + 1.0, -0.5), (bricks + 1.0, 0.0), (-1.0, 0.0)]])
    return Scene(
        polygons=np.concatenate([base, boxes(x0, 0.5 * j, x1, 0.5 * (j + 1))]),
        held=np.array([0]),
        friction=friction,
        gravity_direction=tilt - 90,
    )


def boxes(x0: np.ndarray, y0: np.ndarray, x1: np.ndarray, y1: np.ndarray) -> np.ndarray:
    """Return upright rectangles, (n, 4, 2)."""
    return np.stack([np.stack(c, axis=1) for c in ((x0, y0), (x1, y0), (x1, y1), (x0, y1))], axis=1)


def bolted_wall(n: int, friction: float = FRICTION, **keys: float) -> Scene:
    """Return the tilted wall with a grouted bolt for every ten bricks, in random directions."""
    wall = tilted_wall(n, friction)
    rng, count = np.random.default_rng(0), max(1, n // 10)
    corners = np.concatenate(list(wall.polygons))
    length = min(BOLT_LENGTH, 0.25 * np.ptp(corners, axis=0).min())
    low, high = corners.min(axis=0) + BOLT_AWAY * length, corners.max(axis=0) - BOLT_AWAY * length
    head = rng.uniform(low, high, (count, 2))
    angle = rng.uniform(0, 2 * np.pi, count)
    tip = head + length * np.column_stack([np.cos(angle), np.sin(angle)])
    keys = {"diameter": 0.025, "yield_strength": 500e6, "bond_strength": 150e3, "spacing": 1.5, **keys}
    ends = zip(head.tolist(), tip.tolist(), strict=True)
    bolts = [bsm.Bolt(start=tuple(h), end=tuple(t), **keys) for h, t in ends]
    return Scene(
        polygons=wall.polygons,
        held=wall.held,
        friction=friction,
        gravity_direction=wall.gravity_direction,
        bolts=bolts,
    )


def jointed_slope(n: int, friction: float = FRICTION, dips: tuple[float, float] = DIPS) -> Scene:
    """Return about n whole blocks between two joint sets behind a stepped face that falls to the right.

    The toe is the origin. Under the slope lies half its height of rock, beside it once its height; a ring of blocks
    around the bottom and the sides is held. The set at -30 degrees daylights in the face, and columns along the other
    lean out over it.
    """
    slope = np.tan(np.radians(FACE))
    area = 1.5 + 0.5 + 0.5 / slope * 2  # of a slope of height 1: behind the crest, before the toe, under the face
    height = (n * SPACINGS[0] * SPACINGS[1] / area) ** 0.5
    left, right, bottom = -height / slope - height, height, -height / 2
    first, second = (np.array([np.cos(a), np.sin(a)]) for a in np.radians(dips))
    reach = int(3 * height / min(SPACINGS)) + 4
    along, across = np.meshgrid(np.arange(-reach, reach), np.arange(-reach, reach), indexing="ij")
    corner = np.array([(0, 0), (1, 0), (1, 1), (0, 1)])  # counter-clockwise: the first set is a right angle ahead
    place = np.stack([along.ravel(), across.ravel()], axis=1)[:, None] + corner
    corners = place[..., :1] * SPACINGS[0] * second + place[..., 1:] * SPACINGS[1] * first
    x, y = corners.mean(axis=1).T
    ring = 1.5 * max(SPACINGS)
    ground = np.where(x > 0, 0.0, np.minimum(height, -slope * x))
    kept = (y < ground) & (x > left - ring) & (x < right + ring) & (y > bottom - ring)
    inside = (x > left) & (x < right) & (y > bottom)
    surface = ((left, height), (-height / slope, height), (0.0, 0.0), (right, 0.0))
    return Scene(polygons=corners[kept], held=np.flatnonzero(~inside[kept]), friction=friction, surface=surface)


def leaning_slope(n: int, friction: float = FRICTION) -> Scene:
    """Return the slope with its joint sets mirrored: its columns lean into it, and nothing daylights in the face."""
    return jointed_slope(n, friction, dips=(-DIPS[0], -DIPS[1]))


def blocky_rock(n: int, friction: float = FRICTION) -> Scene:
    """Return about n Voronoi cells of deep rock, of which a stage excavates a circle: finer blocks, same opening."""
    from bsm_mesh.geometries import Region, RockMass, Voronoi, cut_blocks, rectangle

    half = ROCK_SIDE / 2
    cut = cut_blocks(
        RockMass(
            regions=[Region(outline=rectangle(-half, -half, half, half), rock="rock")],
            joints=[Voronoi(name="joint", size=ROCK_SIDE / n**0.5, rounds=5)],
            seed=1,
        )
    )
    polygons = np.split(cut.points[cut.corners], cut.rings[1:-1])
    outermost = np.array([np.abs(corners).max() for corners in polygons])
    turn = np.linspace(0, 2 * np.pi, 64, endpoint=False)
    circle = tuple(map(tuple, (TUNNEL * np.column_stack([np.cos(turn), np.sin(turn)])).tolist()))
    return Scene(
        polygons=polygons,
        held=np.flatnonzero(outermost > half - 1e-6),
        friction=friction,
        cohesion=ROCK_COHESION,
        surface=((-half, DEPTH), (half, DEPTH)),
        stages=(bsm.Stage(name="tunnel", excavate=(circle,)),),
    )


def sliding_layers(n: int, friction: float = SLIDING_FRICTION) -> Scene:
    """Return about n blocks in layers steeper than their friction, a metre above a toe: they slide to it and stop.

    In kind Wang's Example 3, with four times as many blocks along a layer as there are layers.
    """
    layers = max(1, round(n**0.5 / 2))
    length, thickness = LAYER
    along, layer = (a.ravel() for a in np.meshgrid(np.arange(-(n // layers), 0), np.arange(layers)))
    blocks = boxes(length * along, thickness * layer, length * (along + 1), thickness * (layer + 1))
    top = thickness * layers
    crest, end = length * along.min(), GAP + 2 * top
    fixed = boxes(*(np.array(side) for side in ([crest - length, GAP], [-length, 0.0], [end, end], [0.0, top])))
    a = np.radians(-DIP)
    turn = np.array([(np.cos(a), np.sin(a)), (-np.sin(a), np.cos(a))])
    return Scene(polygons=np.concatenate([fixed, blocks]) @ turn, held=np.array([0, 1]), friction=friction)
