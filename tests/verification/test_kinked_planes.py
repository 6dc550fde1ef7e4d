"""Blocks that slide from one block of ground onto another, at an angle: the next one's corner is no obstacle."""

from dataclasses import replace

import numpy as np
import pytest

import bsm_mesh as bsm
from tests.scenes.kinked_plane import KinkedPlane
from tests.scenes.models import model_of

STEEP = {"friction": 15.0, "upper": 40.0, "lower": 25.0}


@pytest.mark.parametrize("bare", [False, pytest.param(True, marks=pytest.mark.heavy)])
def test_a_slab_slides_over_a_kink_where_both_planes_are_steeper_than_its_friction(bare):
    """Its corner has the joint of its lower face, and its front face does not catch on the ground."""
    assert bsm.run(KinkedPlane(**STEEP, bare=bare).model()).unstable_blocks.tolist() == [2]


@pytest.mark.parametrize("bare", [pytest.param(False, marks=pytest.mark.heavy), True])
def test_so_it_does_where_the_ground_rests_on_a_block(bare):
    assert bsm.run(KinkedPlane(**STEEP, loose=True, bare=bare).model()).unstable_blocks.tolist() == [3]


@pytest.mark.heavy
@pytest.mark.parametrize(("loose", "bare"), [(False, True), (True, False)])
def test_so_it_does_in_space(loose, bare):
    """The slab is as wide as the ground."""
    results = bsm.run(KinkedPlane(**STEEP, loose=loose, bare=bare, gap=0.05).in_space())
    assert results.unstable_blocks.tolist() == [3 if loose else 2]


@pytest.mark.heavy
@pytest.mark.parametrize(("loose", "bare"), [(False, True), (True, False)])
def test_so_does_a_narrower_one_turned(loose, bare):
    scene = KinkedPlane(**STEEP, loose=loose, bare=bare, gap=0.05)
    results = bsm.run(scene.in_space(width=0.5, aside=0.1, direction=130.0))
    assert results.unstable_blocks.tolist() == [3 if loose else 2]


FLAT_BELOW = KinkedPlane(friction=25.0, upper=35.0, lower=10.0, gap=1.0, length=0.6, height=0.3)


@pytest.mark.heavy
def test_a_slab_stops_behind_a_kink_where_the_plane_below_is_flatter_than_its_friction():
    """Its foot passes the kink, and it lies flat below at last."""
    results = bsm.run(FLAT_BELOW.model())
    assert results.status.value == "stable"
    moved = results.stages[-1].displacement[2]
    assert np.hypot(*moved[:2]) > FLAT_BELOW.gap + 0.05
    assert np.degrees(moved[2]) == pytest.approx(FLAT_BELOW.lower - FLAT_BELOW.upper, abs=0.01)


@pytest.mark.heavy
def test_so_it_stops_in_space():
    """Friction holds it on both planes."""
    results = bsm.run(FLAT_BELOW.in_space())
    assert results.status.value == "stable"
    moved = results.stages[-1].displacement[2]
    assert np.hypot(moved[0], moved[2]) > FLAT_BELOW.gap + 0.05


@pytest.mark.slow
def test_a_slab_of_zones_slides_over_the_kink_of_held_ground():
    model = KinkedPlane(**STEEP, bare=True, gap=0.05).model()
    zones = bsm.Zones(size=2.0, displacement="large")
    results = bsm.run(model.replace(rocks=[replace(model.rocks[0], zones=zones)]))
    assert results.unstable_blocks.tolist() == [2]


def test_a_face_stops_at_a_corner_above_the_plane_by_a_fiftieth_of_a_block():
    base, step = [(0, -1), (4, -1), (4, 0), (0, 0)], [(4, -1), (5, -1), (5, 0.5), (4, 0.02)]
    block = [(2.5, 0), (3.5, 0), (3.5, 1), (2.5, 1)]
    model = model_of(
        [base, step, block], gamma=26e3, friction=10.0, kn=1e10, ks=5e9, fixed=(0, 1), gravity_horizontal=0.25
    )
    results = bsm.run(model)
    assert results.status.value == "stable"
    assert results.stages[-1].displacement[2, 0] == pytest.approx(0.5, abs=0.01)
