"""Block systems of any size that benchmarks solve: a tilted wall of bricks, a slope with two joint sets."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import bsm_mesh as bsm

DENSITY, GRAVITY = 2500.0, 9.81  # kg/m3, m/s2
STIFFNESS = 1e10  # Pa/m, normal and shear
WALL_SIZES = {100: (10, 10), 1000: (25, 40), 10_000: (100, 100), 100_000: (250, 400)}  # courses, bricks
TILT = 5.0  # degrees
DIPS, SPACINGS = (60.0, -30.0), (2.0, 1.0)  # degrees from x, metres between joints of a set
FACE = 50.0  # degrees


@dataclass(frozen=True, eq=False, slots=True)
class Scene:
    """Convex quadrilaterals with one friction.

    Attributes
    ----------
    corners : (n, 4, 2) float64 [m]
        Corners of the blocks, counter-clockwise.
    held : (k,) int32
        Blocks that do not move.
    friction : float [degrees]
        Of every joint.
    gravity_direction : float [degrees]
        From the x axis.
    surface : sequence of (x, y) [m]
        The ground, from left to right, where the scene has one.
    """

    corners: np.ndarray
    held: np.ndarray
    friction: float
    gravity_direction: float
    surface: tuple[tuple[float, float], ...] = ()

    def model(self, k0: float | None = None) -> bsm.Model:
        """Return the model: rigid blocks, joints without cohesion; from zero stress, or with `k0` in situ."""
        law = bsm.MohrCoulomb(friction=self.friction)
        return bsm.Model(
            blocks=bsm.Blocks.from_polygons(list(self.corners), rock="rock"),
            rocks=[bsm.Rock("rock", unit_weight=DENSITY * GRAVITY)],
            joints=[bsm.Joint("joint", normal_stiffness=STIFFNESS, shear_stiffness=STIFFNESS, law=law)],
            default_joint="joint",
            supports=[bsm.Fixed(blocks=self.held)],
            gravity_direction=self.gravity_direction,
            in_situ=None if k0 is None else bsm.InSitu(surface=self.surface, k0=k0),
        )


def tilted_wall(n: int, friction: float = 35.0, tilt: float = TILT) -> Scene:
    """Return a half-bond wall of about n bricks of 1 x 0.5 m with flush ends on a fixed base, gravity turned."""
    courses, bricks = WALL_SIZES.get(n) or (max(1, round((n / 1.6) ** 0.5)), max(1, round((1.6 * n) ** 0.5)))
    left, course = [], []
    for j in range(courses):
        heads = np.arange(bricks) if j % 2 == 0 else np.concatenate([[0.0], np.arange(bricks) + 0.5])
        left.append(heads)
        course.append(np.full(len(heads), j))
    right = [np.append(heads[1:], bricks) for heads in left]
    x0, x1, j = np.concatenate(left), np.concatenate(right), np.concatenate(course)
    base = np.array([[(-1.0, -0.5), (bricks + 1.0, -0.5), (bricks + 1.0, 0.0), (-1.0, 0.0)]])
    return Scene(np.concatenate([base, boxes(x0, 0.5 * j, x1, 0.5 * (j + 1))]), np.array([0]), friction, tilt - 90)


def boxes(x0: np.ndarray, y0: np.ndarray, x1: np.ndarray, y1: np.ndarray) -> np.ndarray:
    """Return upright rectangles, (n, 4, 2)."""
    return np.stack([np.stack(c, axis=1) for c in ((x0, y0), (x1, y0), (x1, y1), (x0, y1))], axis=1)


def jointed_slope(n: int, friction: float = 35.0) -> Scene:
    """Return about n whole blocks between two joint sets behind a stepped face that falls to the right.

    The toe is the origin. Under the slope lies half its height of rock, beside it once its height; a ring of blocks
    around the bottom and the sides is held. The set at -30 degrees daylights in the face.
    """
    slope = np.tan(np.radians(FACE))
    area = 1.5 + 0.5 + 0.5 / slope * 2  # of a slope of height 1: behind the crest, before the toe, under the face
    height = (n * SPACINGS[0] * SPACINGS[1] / area) ** 0.5
    left, right, bottom = -height / slope - height, height, -height / 2
    first, second = (np.array([np.cos(a), np.sin(a)]) for a in np.radians(DIPS))
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
    return Scene(corners[kept], np.flatnonzero(~inside[kept]), friction, -90.0, surface)


SCENES = {"wall": tilted_wall, "slope": jointed_slope}
