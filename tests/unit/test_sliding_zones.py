"""Blocks with zones that slide over the sides of other zones: statics, no jump of a force, and ends of faces."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from tests.scenes.large_zones import FRICTION, forces_below, pushed
from tests.scenes.meeting_zones import meeting
from tests.scenes.shapes import rectangle
from tests.unit.test_large_zones import BENDS
from tests.unit.test_zones import JOINT, RIGID, wall

WEIGHT = 25e3  # N/m, of the block that is pushed
SLIDES = np.array([-np.tan(np.radians(FRICTION)), 1.0]) * WEIGHT
FAR = [0.5, *(pytest.param(each, marks=pytest.mark.heavy) for each in (1.0, 1.5))]


def forces(by, degrees=0.0, **given):
    """Return the forces below the block that is pushed, and how it moved, as in the frame of the base."""
    results = bsm.run(pushed(by, degrees=degrees, **given))
    assert results.status == "stable", results.stages[0].reason
    assert results.check().ok
    return forces_below(results, degrees)


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("at", [5e-4, *FAR])
def test_no_force_jumps_where_points_get_other_places_or_pass_nodes(at, order):
    """Points get other places beyond a thousandth of a zone's side, and pass nodes at every half metre."""
    before, after = (forces(at + small, order=order) for small in (-1e-4, 1e-4))
    assert_allclose(before.sum(axis=0), SLIDES, rtol=1e-4)
    assert_allclose(after, before, atol=1e-3 * WEIGHT / len(before))


@pytest.mark.parametrize("order", [1, pytest.param(2, marks=pytest.mark.heavy)])
def test_zones_that_do_not_match_carry_the_weight(order):
    """Zones of .3 m come to lie over others of .5 m; the base may be numbered first or last."""
    first, last = (forces(0.63, order=order, size=0.3, number=number) for number in (0, 1))
    assert_allclose(first.sum(axis=0), SLIDES, rtol=1e-4)
    assert_allclose(first, last, atol=1e-7 * WEIGHT)


@pytest.mark.parametrize("order", [1, pytest.param(2, marks=pytest.mark.heavy)])
def test_a_model_that_is_turned_slides_alike(order):
    given = forces(0.63, order=order)
    assert_allclose(forces(0.63, 37.0, order=order), given, atol=1e-9 * WEIGHT)


def test_a_block_slides_on_over_the_neighbour():
    """Whose face lies in one plane with that of the first, across a joint between the two."""
    there = forces(0.8, base=(0.0, 2.3, 4.0))
    assert_allclose(there.sum(axis=0), SLIDES, rtol=1e-4)
    assert (there[:, 1] > 0).all()


@pytest.mark.parametrize(
    ("ramp", "order"),
    [(0.01, 1), (1.0, 1), (10.0, 1), (0.01, 2), (1.0, 2), pytest.param(10.0, 2, marks=pytest.mark.heavy)],
)
def test_a_block_is_pushed_up_a_ramp(ramp, order):
    """It does not turn, so that its front corner carries all: W tan(friction + ramp)."""
    there = forces(0.6, ramp=ramp, order=order)
    exact = SLIDES[1] * np.tan(np.radians(FRICTION + ramp))
    assert_allclose(there.sum(axis=0), (-exact, SLIDES[1]), rtol=1e-3)
    assert ramp < 0.5 or np.count_nonzero(there[:, 1]) == 1


def test_a_block_slides_beyond_an_edge_that_falls():
    """Its front leaves the base there: three of its four points carry."""
    there = forces(0.6, ramp=-10.0)
    assert_allclose(there.sum(axis=0), SLIDES, rtol=1e-3)
    assert np.count_nonzero(there[:, 1]) == 3


def test_no_point_carries_in_the_air_beyond_the_end_of_a_long_side():
    """Before the block lie three metres of its base without a node; its front is 0.2 m beyond their end."""
    model = pushed(3.24, block=(0.5, 1.0), size=8.0)
    coarse = [dataclasses.replace(rock, zones=dataclasses.replace(rock.zones, size=8.0)) for rock in model.rocks]
    results = bsm.run(model.replace(rocks=coarse))
    assert results.status == "stable", results.stages[0].reason
    contacts = results.stages[0].contacts
    carries = contacts.normal_force < -1.0
    assert_allclose(contacts.point[carries, 0].max(), 4.0, atol=1e-3)
    assert_allclose(contacts.normal_force.sum(), -WEIGHT / 2, rtol=1e-3)


@pytest.mark.slow
def test_a_block_that_slid_off_is_unstable():
    """Points over the end of a face carry nothing; the others and the edge of the base do until none is left."""
    given = {"base": (0.0, 2.0)}
    part = forces(0.7, **given)
    assert_allclose(part.sum(axis=0), SLIDES, rtol=1e-3)
    assert sorted(part[:, 1] > 0) == [False, False, False, True, True]  # its rear, and the corner of the base
    results = bsm.run(pushed(1.2, **given))
    assert results.status == "unstable"
    assert list(results.stages[0].unstable_blocks) == [1]
    assert results.stages[0].displacement[1, 1] < -1.0  # shown where it falls


@pytest.mark.slow
def test_a_block_that_slides_slowly_is_unstable():
    """A hundredth of its weight drives it by three times its size, and its stiff rock takes many time steps."""
    model = meeting([rectangle(-1, -1, 14, 0), rectangle(0, 0, 2, 0.5)], young=1e10, friction=20.0, degrees=-20.8)
    results = bsm.run(model.replace(gravity_direction=-90.0))
    assert results.status == "unstable", results.stages[0].reason
    assert "move on" in results.stages[0].reason


@pytest.mark.parametrize("order", [1, pytest.param(2, marks=pytest.mark.heavy)])
def test_a_face_that_touched_nothing_gets_points(order):
    """A block that overhangs is pushed inwards, also where everything is turned."""
    given = forces(0.3, block=(-0.5, 0.5), order=order)
    assert_allclose(given.sum(axis=0), SLIDES, rtol=1e-3)
    assert np.count_nonzero(given[:, 1]) > len(forces(0.001, block=(-0.5, 0.5), order=order))
    assert_allclose(forces(0.3, 37.0, block=(-0.5, 0.5), order=order), given, atol=1e-9 * WEIGHT)


def test_courses_in_bond_slide_over_the_joints_below():
    """Shear springs so soft that both blocks of a course slide by .078 m: the springs hold what gravity pulls."""
    soft = dataclasses.replace(JOINT, shear_stiffness=1e5)
    given = {"joints": [soft], "supports": [bsm.Fixed(boundary="bottom")], "loads": [], "gravity_horizontal": 0.3}
    results = bsm.run(wall(rocks=[BENDS, RIGID], **given))
    assert results.status == "stable", results.stages[0].reason
    assert results.check().ok
    stage = results.stages[0]
    assert_allclose(stage.displacement[2:, 0], 0.3 * 26e3 * 3 / (3 * 1e5), rtol=0.01)  # over shear stiffness
    level = np.abs(stage.contacts.normal[:, 1]) > 0.9
    assert_allclose(np.abs(stage.contacts.shear_force[level]).sum(), 0.3 * 26e3 * 3, rtol=1e-3)


def test_whole_rock_below_carries_the_block_that_slid() -> None:
    """The block lies on one of two blocks without a joint between them; the other one is held."""
    model = pushed(0.2, base=(0.0, 2.3, 4.0))
    blocks = model.blocks.with_joint("J", lambda x, y: np.abs(y) < 1e-9)
    blocks = blocks.with_boundary("low", lambda x, y: (y < -0.5) & (x > 2.2))
    results = bsm.run(model.replace(blocks=blocks, default_joint=None))
    assert results.status == "stable", results.stages[0].reason
    contacts = results.stages[0].contacts
    hangs = contacts.force[contacts.joint < 0].sum(axis=0)
    assert_allclose(hangs - (0, 2.3 * WEIGHT), forces_below(results).sum(axis=0), atol=1e-6 * WEIGHT)
