"""Water on blocks and in joints against closed forms: Wang Eqs. 6.1-6.7, plane failure, infinite slope, gravity dam."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from tests.scenes.models import LINEAR
from tests.scenes.shapes import turned

EXACT = 1e-12
STATICS = 1e-10
WATER = 9810.0
TOE, CREST, TOP, CRACK = np.array([(0, 0), (6.928, 12), (10.928, 12), (10.928, 7.652)])
ROCK_BELOW = np.array([(0, 0), CRACK, (CRACK[0], -8.0), (0.0, -8.0)])
GAMMA, COHESION, PHI = 26e3, 25e3, 37.0
JOINT = bsm.Joint("J", normal_stiffness=1e10, shear_stiffness=1e9)


def area(corners):
    x, y = np.asarray(corners, dtype=float).T
    return (x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2


def on_rock(block, rock_below, water, unit_weight=GAMMA, **more):
    """Return the linear stage of a block on fixed rock, and the sums of effective normal and shear force between."""
    model = bsm.Model(
        blocks=bsm.Blocks.from_polygons([rock_below, block], rock="rock"),
        rocks=[bsm.Rock("rock", unit_weight=unit_weight)],
        joints=[JOINT],
        default_joint="J",
        supports=[bsm.Fixed(blocks=[0])],
        water=water,
        **more,
    )
    results = bsm.run(model, LINEAR)
    assert results.check().ok
    contacts = results.stages[-1].contacts
    return results.stages[-1], -contacts.normal_force.sum(), contacts.shear_force.sum()


SHAPES = [
    np.array([(0, 0), (1, 0), (1, 1), (0, 1)]),
    turned(np.array([(0, 0), (3, 0.5), (2.5, 2), (0.5, 1.5)]), 37, (4, -2)),
    np.array([(0, 0), (2, 0), (2, 2), (1, 0.5), (0, 2)]),  # concave
]


@pytest.mark.parametrize("shape", SHAPES)
def test_a_submerged_block_loses_the_weight_of_the_water(shape):
    blocks = bsm.Blocks.from_polygons([shape], rock="rock")
    model = bsm.Model(
        blocks=blocks,
        rocks=[bsm.Rock("rock", unit_weight=26e3)],
        supports=[bsm.Fixed(blocks=[0])],
        water=bsm.Water(table=[(0, 10)]),
    )
    stage = bsm.run(model, LINEAR).stages[0]
    uplift = WATER * area(shape)
    assert_allclose(stage.water, [[0, uplift, 0]], rtol=EXACT, atol=EXACT * 10 * WATER)
    assert_allclose(stage.reactions[0, 1], 26e3 * area(shape) - uplift, rtol=EXACT)


def submerged(shape, surface, depth=None):
    """Return force and moment of the water on a polygon under a piecewise linear surface, by fine summation."""
    total = np.zeros(3)
    centroid = bsm.Blocks.from_polygons([shape], rock="r").moments.centroid[0]
    t = (np.arange(200_000) + 0.5) / 200_000
    for start, end in zip(shape, np.roll(shape, -1, axis=0), strict=True):
        x = start + t[:, None] * (end - start)
        pressure = WATER * np.maximum(surface(x[:, 0]) - x[:, 1], 0)
        inward = np.array([-(end - start)[1], (end - start)[0]])
        force = pressure[:, None] * inward / len(t)
        arm = x - centroid
        total += [*force.sum(axis=0), (arm[:, 0] * force[:, 1] - arm[:, 1] * force[:, 0]).sum()]
    return total


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize(
    "table",
    [
        [(0, 0.7)],
        [(-1, 0.2), (9, 2.1)],
        [(0.4, 0.3), (0.6, 1.2), (1.1, 0.4), (5, -1.5), (6, 0.5)],  # bends between corners, dry and wet alternately
    ],
)
def test_partly_submerged_faces(shape, table):
    """Eqs. 6.3-6.5, and beyond them faces under a table that bends between their corners."""
    blocks = bsm.Blocks.from_polygons([shape], rock="rock")
    model = bsm.Model(
        blocks=blocks,
        rocks=[bsm.Rock("rock", unit_weight=0)],
        supports=[bsm.Fixed(blocks=[0])],
        water=bsm.Water(table=table),
    )
    x, y = np.array(table, dtype=float).T
    expected = submerged(np.asarray(shape, dtype=float), lambda at: np.interp(at, x, y))
    assert_allclose(bsm.run(model, LINEAR).stages[0].water[0], expected, atol=1e-8 * WATER)


def test_the_two_forces_of_a_face():
    """A vertical face wet over l' of l: R = q2 l' / 2, (1 - l'/(3 l)) R below and l'/(3 l) R above (Eqs. 6.3-6.5)."""
    from bsm_mesh.model.water_pressure import WaterLoad

    square = np.array([(0, 0), (1, 0), (1, 3), (0, 3)])
    blocks = bsm.Blocks.from_polygons([square], rock="rock")
    water = bsm.Water(table=[(0, 1.2)])
    model = bsm.Model(
        blocks=blocks, rocks=[bsm.Rock("rock", unit_weight=0)], supports=[bsm.Fixed(blocks=[0])], water=water
    )
    wet, length = 1.2, 3.0
    resultant = wet * WATER * wet / 2
    ends = WaterLoad(model).on_faces(blocks.vertices, blocks.vertices[blocks.following])
    share = wet / (3 * length)
    assert_allclose(ends[1], [(1 - share) * resultant, share * resultant], rtol=EXACT)  # the right face, going up
    assert_allclose(ends[0], WATER * wet * np.array([0.5, 0.5]), rtol=EXACT)  # the bottom: Eq. 6.2
    assert_allclose(ends[2], 0)


@pytest.mark.parametrize("zw", [3.0, 4.348, 0.0])
@pytest.mark.parametrize("cohesion", [COHESION, 0.0])
def test_plane_failure_with_a_tension_crack(zw, cohesion):
    """Hoek and Bray; water triangular in the crack, falling linearly to zero at the toe."""
    block = np.array([TOE, CRACK, TOP, CREST])
    p = np.arctan2(CRACK[1] - TOE[1], CRACK[0] - TOE[0])
    base = np.hypot(*(CRACK - TOE))
    water = bsm.Water(table=[(0, 0), (CRACK[0], CRACK[1] + zw)]) if zw else None
    _, normal, shear = on_rock(block, ROCK_BELOW, water)
    W, V, U = GAMMA * area(block), WATER * zw**2 / 2, WATER * zw * base / 2
    tan_phi = np.tan(np.radians(PHI))
    expected = (cohesion * base + (W * np.cos(p) - U - V * np.sin(p)) * tan_phi) / (W * np.sin(p) + V * np.cos(p))
    assert_allclose((cohesion * base + normal * tan_phi) / abs(shear), expected, rtol=STATICS)


@pytest.mark.parametrize("depth", [0.0, 2.5, 5.0])
@pytest.mark.parametrize("head", ["vertical", "parallel"])
def test_infinite_slope(depth, head):
    b, z, gamma, length = np.radians(30), 5.0, 26e3, 8.0
    slope = np.tan(b)
    block = np.array([(0, 0), (length, slope * length), (length, slope * length + z), (0, z)])
    below = np.array([(0, -20.0), (length, -20.0), (length, slope * length), (0, 0)])
    table = np.column_stack([[-50.0, 50.0], slope * np.array([-50.0, 50.0]) + depth])
    water = bsm.Water(table=table, head=head) if depth else None
    _, normal, shear = on_rock(block, below, water, unit_weight=gamma)
    factor = np.cos(b) ** 2 if head == "parallel" else 1.0
    tan_phi = np.tan(np.radians(35))
    effective = gamma * z * np.cos(b) ** 2 - WATER * depth * factor
    assert_allclose(
        normal * tan_phi / abs(shear), effective * tan_phi / (gamma * z * np.sin(b) * np.cos(b)), rtol=STATICS
    )


@pytest.mark.parametrize("wide", [False, True])
@pytest.mark.parametrize(("uplift", "cohesion"), [(True, 0.0), (False, 0.0), (True, 200e3)])
def test_gravity_dam(uplift, cohesion, wide):
    """A triangular dam, the reservoir to its crest, uplift from the full head at the heel to zero at the toe."""
    H, B, gamma = 50.0, 40.0, 24e3
    dam = np.array([(0, 0), (B, 0), (0, H)])
    rock = (
        np.array([(-60, -10), (100, -10), (100, 0), (-60, 0)])
        if wide
        else np.array([(0, -10), (B, -10), (B, 0), (0, 0)])
    )
    dry_base = {"J": 0.0} if not uplift else {}
    water = bsm.Water(table=[(-50, H), (0, H), (B, 0)], joint_pressure=dry_base)
    stage, normal, shear = on_rock(dam, rock, water, unit_weight=gamma)
    W, T, U = gamma * H * B / 2, WATER * H**2 / 2, WATER * H * B / 2 if uplift else 0.0
    assert_allclose((normal + cohesion * B) / abs(shear), (W - U + cohesion * B) / T, rtol=STATICS)
    heel_moment = W * B / 3 + T * H / 3 - U * B / 3  # about the heel, clockwise
    toe = heel_moment / B
    by_x = dict(zip(stage.contacts.point[:, 0], -stage.contacts.normal_force, strict=True))
    assert_allclose([by_x[B], by_x[0.0]], [toe, W - U - toe], rtol=STATICS)
    assert_allclose(
        dict(zip(stage.contacts.point[:, 0], stage.contacts.water_pressure, strict=True))[0.0], WATER * H * uplift
    )


def test_effective_and_total_stress():
    """A column under water: total stress by the column's weight and the water above, effective less its pressure."""
    h, head, n = 1.0, 12.0, 10
    blocks = bsm.Blocks.from_polygons(
        [np.array([(0, k * h), (1, k * h), (1, (k + 1) * h), (0, (k + 1) * h)]) for k in range(n)], rock="rock"
    )
    blocks = blocks.with_boundary("bottom", lambda x, y: y < 1e-9)
    model = bsm.Model(
        blocks=blocks,
        rocks=[bsm.Rock("rock", unit_weight=26e3)],
        joints=[JOINT],
        default_joint="J",
        supports=[bsm.Fixed(boundary="bottom")],
        water=bsm.Water(table=[(0, head)]),
    )
    stage = bsm.run(model, LINEAR).stages[0]
    y = (np.arange(n) + 0.5) * h
    pore = WATER * (head - y)
    total = 26e3 * (n * h - y) + WATER * (head - n * h)
    assert_allclose(stage.stress[:, 1, 1], -total, rtol=STATICS)
    assert_allclose(stage.stress_effective[:, 1, 1], -(total - pore), rtol=STATICS, atol=1e-6)
    assert_allclose(stage.stress[:, 0, 0], -pore, rtol=STATICS)
    assert_allclose(stage.contacts.water_pressure, WATER * (head - stage.contacts.point[:, 1]), rtol=EXACT)


def test_water_falls_from_stage_to_stage():
    model = bsm.Model(
        blocks=bsm.Blocks.from_polygons([SHAPES[0]], rock="rock"),
        rocks=[bsm.Rock("rock", unit_weight=26e3)],
        supports=[bsm.Fixed(blocks=[0])],
        water=bsm.Water(table=[(0, 1.0)]),
        stages=[
            bsm.Stage(name="half", water=bsm.Water(table=[(0, 0.5)])),
            bsm.Stage(name="as before"),
            bsm.Stage(name="drained", water=bsm.Water()),
        ],
    )
    for options in (LINEAR, bsm.Options(scheme="continuation")):
        lift = [stage.water[0, 1] for stage in bsm.run(model, options).stages]
        assert_allclose(lift, WATER * np.array([1.0, 0.5, 0.5, 0.0]), rtol=EXACT, atol=1e-9)
