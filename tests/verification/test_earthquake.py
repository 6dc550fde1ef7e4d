"""Pseudo-static earthquakes against statics: part of the weights pulls sideways, from the start or for a stage."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import bsm_mesh as bsm
from bsm_mesh.solve.limit.analysis import limit_tilt
from tests.scenes.models import GAMMA, LINEAR, framed, model_of
from tests.scenes.shapes import grid, rectangle, turned

CLOSE = 1e-3  # of the friction at the limit: the verdict must turn within it
EXACT = 1e-8


def tan(degrees):
    return np.tan(np.radians(degrees))


def on_incline(angle, slope, **given):
    """Return a block on a plane that falls to the left, with tan(friction) = slope."""
    polygons = [turned(p, angle) for p in (rectangle(-9, -2, 9, 0), rectangle(0, 0, 4, 0.5))]
    return model_of(polygons, friction=np.degrees(np.arctan(slope)), **given)


def least_slope(angle, down, up=0.0):
    """Return the friction that holds the block: forces along over forces across, of weights 1 - up and down."""
    a = np.radians(angle)
    weight = 1 - up
    return (weight * np.sin(a) + down * np.cos(a)) / (weight * np.cos(a) - down * np.sin(a))


@pytest.mark.heavy
@pytest.mark.parametrize(
    ("angle", "down", "up"), [(0, 0.2, 0), (20, 0.15, 0), (30, -0.1, 0), (30, 0.1, 0.3), (25, 0, 0.5)]
)
@pytest.mark.parametrize("in_a_stage", [False, True])
def test_a_block_on_an_incline(angle, down, up, in_a_stage):
    """It stands to tan(phi) = (sin a + k cos a) / (cos a - k sin a), k down the slope."""
    limit = least_slope(angle, down, up)
    for factor, verdict in ((1 - CLOSE, "unstable"), (1 + CLOSE, "stable")):
        if in_a_stage:
            given = {"stages": [bsm.Stage(name="shakes", gravity=(-down, up))]}
        else:
            given = {"gravity_horizontal": -down, "gravity_vertical": up}
        slope = max(factor * limit, 1.001 * tan(angle)) if in_a_stage else factor * limit
        if factor < 1 and slope > limit:
            continue  # it would not stand before
        model = on_incline(angle, slope, **given)
        results = bsm.run(model)
        assert results.status == verdict
        if not in_a_stage:
            assert bsm.limit_analysis(model).admissible == (verdict == "stable")
        if verdict == "stable":
            assert results.check().ok


@pytest.mark.heavy
@pytest.mark.parametrize("side", [1, -1])
def test_a_column_topples_at_its_breadth_over_its_height(side):
    breadth, height = 1.0, 4.0
    for factor, verdict in ((1 - CLOSE, "stable"), (1 + CLOSE, "unstable")):
        polygons = [rectangle(-9, -1, 9, 0), rectangle(0, 0, breadth, height)]
        k = side * factor * breadth / height
        model = model_of(polygons, friction=60, kn=1e11, gravity_horizontal=k)
        assert bsm.run(model, bsm.Options(displacement_limit=0.5)).status == verdict
        assert bsm.limit_analysis(model).admissible == (verdict == "stable")


@pytest.mark.heavy
def test_a_model_that_is_shaken_tilts_less():
    """What is added turns with gravity: the column topples where its resultant leaves the base."""
    model = model_of([rectangle(-9, -1, 9, 0), rectangle(0, 0, 1, 4)], friction=60, gravity_horizontal=0.1)
    falls_at = np.degrees(np.arctan(1 / 4))
    assert_allclose(limit_tilt(model), falls_at - np.degrees(np.arctan(0.1)), atol=1e-4)
    assert_allclose(limit_tilt(model, clockwise=True), falls_at + np.degrees(np.arctan(0.1)), atol=1e-4)


def beside_a_wall(stages, friction):
    """Return a flat block on the ground, a soft smooth wall on its right."""
    polygons = [rectangle(-9, -2, 10, 0), rectangle(0, 0, 8, 1), rectangle(8, 0, 9, 2)]
    blocks = bsm.Blocks.from_polygons(polygons, rock="rock").with_joint("wall", lambda x, y: np.abs(x - 8) < 1e-9)
    law = bsm.MohrCoulomb
    return bsm.Model(
        blocks=blocks,
        rocks=[bsm.Rock("rock", unit_weight=GAMMA)],
        joints=[
            bsm.Joint("ground", 1e10, 1e10, law=law(friction=friction)),
            bsm.Joint("wall", WALL, WALL, law=law(friction=0)),
        ],
        default_joint="ground",
        supports=[bsm.Fixed(blocks=[0, 2])],
        stages=stages,
    )


WALL, WEIGHT = 1e8, 8 * GAMMA  # Pa/m, N/m


def on_wall(stage):
    """Return the force on the wall, and the slip of the contacts on the ground."""
    contacts = stage.contacts
    at_wall = (contacts.joint == 1) & (np.abs(contacts.normal[:, 0]) > 0.5)
    return -contacts.normal_force[at_wall].sum(), contacts.slip[(contacts.joint == 0) & ~at_wall]


def test_a_stage_that_shakes_and_one_that_is_at_rest_again():
    """The block slips until the wall carries k W - W tan(phi); when it ends friction holds the wall's push."""
    k, slope = 0.4, 0.3
    stages = [bsm.Stage(name="shakes", gravity=(k, 0)), bsm.Stage(name="rests", gravity=(0, 0))]
    results = bsm.run(beside_a_wall(stages, np.degrees(np.arctan(slope))))
    assert [stage.status for stage in results.stages] == ["stable"] * 3
    assert results.check().ok
    force = [on_wall(stage)[0] for stage in results.stages]
    pushed = k * WEIGHT - slope * WEIGHT
    assert_allclose(force[:2], [0, pushed], atol=1e-6 * WEIGHT)
    stiffness = 8 * 1e10  # of the ground; the wall is much softer, and keeps all but that part of its push
    assert_allclose(force[2], pushed - k * WEIGHT * WALL / stiffness, rtol=1e-3)
    slid = pushed / WALL
    for stage in results.stages[1:]:
        assert_allclose(stage.displacement[1, 0], slid, rtol=1e-2)
        assert_allclose(np.abs(on_wall(stage)[1]).max(), slid, rtol=1e-2)
    total = [stage.loads[1] for stage in results.stages]
    assert_allclose([load[0] for load in total], [0, k * WEIGHT, 0], atol=1e-9 * WEIGHT)


def test_gravity_stays_until_a_stage_changes_it():
    stages = [
        bsm.Stage(name="shakes", gravity=(0.1, -0.05)),
        bsm.Stage(name="continues"),
        bsm.Stage(name="up", gravity=(0, 0.2)),
    ]
    for scheme in ("linear", "continuation"):
        results = bsm.run(on_incline(0, 0.5, stages=stages, gravity_horizontal=0.02), bsm.Options(scheme=scheme))
        loads = np.array([stage.loads[1, :2] for stage in results.stages]) / (2 * GAMMA)
        assert_allclose(loads, [(0.02, -1), (0.1, -1.05), (0.1, -1.05), (0, -0.8)], rtol=EXACT)
        assert results.check().ok


def test_the_linear_scheme_bears_it():
    k, v = 0.3, 0.1
    model = on_incline(20, 1.0, gravity_horizontal=k, gravity_vertical=v)
    stage = bsm.run(model, LINEAR).stages[0]
    force = stage.contacts.force
    on_block = np.where((stage.contacts.block_b == 1)[:, None], force, -force).sum(axis=0)
    assert_allclose(on_block, 2 * GAMMA * np.array([-k, 1 - v]), rtol=EXACT)


GROUND = bsm.InSitu(surface=4.0, k0=0.5)


def ground(**given):
    return bsm.Model(
        blocks=framed(bsm.Blocks.from_polygons(grid(6, 4), rock="rock"), 6, 4),
        rocks=[bsm.Rock("rock", unit_weight=GAMMA, young=1e9, poisson=0.2)],
        joints=[bsm.Joint("J", 1e9, 1e9, law=bsm.MohrCoulomb(friction=35))],
        default_joint="J",
        supports=[bsm.NormalRoller(boundary="left"), bsm.NormalRoller(boundary="right"), bsm.Fixed(boundary="bottom")],
        in_situ=GROUND,
        **given,
    )


@pytest.mark.parametrize("scheme", ["linear", "continuation"])
def test_the_ground_is_at_rest_before_a_stage_shakes_it(scheme):
    stages = [bsm.Stage(name="shakes", gravity=(0.1, 0.0))]
    results = bsm.run(ground(stages=stages), bsm.Options(scheme=scheme))
    initial, shakes = results.stages
    assert_allclose(initial.displacement, 0, atol=1e-12)
    assert shakes.displacement[:, 0].max() > 1e-6
    assert_allclose(shakes.total_load, 24 * GAMMA * np.array([0.1, -1]), rtol=EXACT)
    assert_allclose(shakes.total_load + shakes.total_reaction, 0, atol=1e-5 * 24 * GAMMA)


@pytest.mark.parametrize("scheme", ["linear", "continuation"])
def test_what_shakes_from_the_start_acts_on_ground_that_was_at_rest(scheme):
    """The field is that of level ground; with it the initial stage is one that shakes."""
    staged = bsm.run(ground(stages=[bsm.Stage(name="shakes", gravity=(0.1, 0.0))]), bsm.Options(scheme=scheme))
    at_once = bsm.run(ground(gravity_horizontal=0.1), bsm.Options(scheme=scheme)).stages[0]
    assert_allclose(at_once.displacement, staged.stages[1].displacement, rtol=1e-4, atol=1e-9)
    assert at_once.start_residual > 0.05


def test_other_routes_lead_to_the_same():
    results = bsm.spread(bsm.run(on_incline(20, 1.01 * least_slope(20, 0.15), gravity_horizontal=-0.15)))
    assert {end.status for end in results.spread} == {"stable"}
    assert max(end.difference for end in results.spread) < 1e-3 * results.stages[0].max_displacement


def test_the_forces_of_a_part_of_the_blocks_are_those_of_the_whole():
    from bsm_mesh.model.loads import point_forces_of
    from bsm_mesh.model.submodel import submodel_of
    from bsm_mesh.model.supports import bars_of

    model = ground(gravity_horizontal=0.1, gravity_vertical=-0.3)
    present = np.arange(24) % 3 > 0
    part = submodel_of(model, present, bars_of(model.supports, model.blocks), point_forces_of((), model.blocks), None)
    assert_array_equal(part.model.gravity_forces, model.gravity_forces[present])
    assert_allclose(model.gravity_forces, GAMMA * np.array([(0.1, -1.3)] * 24))
