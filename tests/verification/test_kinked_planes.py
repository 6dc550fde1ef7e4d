"""Blocks that slide from one block of ground onto another, at an angle: the next one's corner is no obstacle."""

from dataclasses import replace

import numpy as np
import pytest

import bsm_mesh as bsm
from tests.scenes.kinked_plane import KinkedPlane

STEEP = {"friction": 15.0, "upper": 40.0, "lower": 25.0}


@pytest.mark.parametrize("bare", [False, True])
@pytest.mark.parametrize("loose", [False, True])
def test_a_slab_slides_over_a_kink_where_both_planes_are_steeper_than_its_friction(loose, bare):
    """Its corner has the joint of its lower face, and its front face does not catch on the ground."""
    results = bsm.run(KinkedPlane(**STEEP, loose=loose, bare=bare).model())
    assert results.unstable_blocks.tolist() == [3 if loose else 2]


@pytest.mark.parametrize(
    "seen",
    [{}, pytest.param({"width": 0.5, "aside": 0.1, "direction": 130.0}, marks=pytest.mark.heavy)],
    ids=["as wide as the ground", "narrower, turned"],
)
@pytest.mark.parametrize(("loose", "bare"), [(False, True), pytest.param(True, False, marks=pytest.mark.heavy)])
def test_so_it_does_in_space(loose, bare, seen):
    results = bsm.run(KinkedPlane(**STEEP, loose=loose, bare=bare, gap=0.05).in_space(**seen))
    assert results.unstable_blocks.tolist() == [3 if loose else 2]


@pytest.mark.parametrize("space", [False, True])
def test_a_slab_stops_behind_a_kink_where_the_plane_below_is_flatter_than_its_friction(space):
    """Its foot passes the kink. In the plane it lies flat below at last; in space friction holds it on both planes."""
    scene = KinkedPlane(friction=25.0, upper=35.0, lower=10.0, gap=1.0, length=0.6, height=0.3)
    results = bsm.run(scene.in_space() if space else scene.model())
    assert results.status.value == "stable"
    moved = results.stages[-1].displacement[2]
    assert np.hypot(moved[0], moved[2 if space else 1]) > scene.gap + 0.05
    if not space:
        assert np.degrees(moved[2]) == pytest.approx(scene.lower - scene.upper, abs=0.01)


@pytest.mark.slow
def test_a_slab_of_zones_slides_over_the_kink_of_held_ground():
    model = KinkedPlane(**STEEP, bare=True, gap=0.05).model()
    zones = bsm.Zones(size=2.0, displacement="large")
    results = bsm.run(model.replace(rocks=[replace(model.rocks[0], zones=zones)]))
    assert results.unstable_blocks.tolist() == [2]


def test_a_face_stops_at_a_corner_above_the_plane_by_a_fiftieth_of_a_block():
    base, step = [(0, -1), (4, -1), (4, 0), (0, 0)], [(4, -1), (5, -1), (5, 0.5), (4, 0.02)]
    block = [(2.5, 0), (3.5, 0), (3.5, 1), (2.5, 1)]
    model = bsm.Model(
        blocks=bsm.Blocks.from_polygons([base, step, block], rock="rock"),
        rocks=[bsm.Rock("rock", unit_weight=26e3)],
        joints=[bsm.Joint("J", 1e10, 5e9, law=bsm.MohrCoulomb(friction=10.0))],
        default_joint="J",
        supports=[bsm.Fixed(blocks=[0, 1])],
        gravity_horizontal=0.25,
    )
    results = bsm.run(model)
    assert results.status.value == "stable"
    assert results.stages[-1].displacement[2, 0] == pytest.approx(0.5, abs=0.01)
