"""Statics judges the rests of blocks with zones by their deformed outlines."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import bsm_mesh as bsm
from benchmarks import zone_families
from benchmarks.campaign.families import FAMILIES
from benchmarks.campaign.oracles import LACK
from benchmarks.campaign.outcome import run
from benchmarks.campaign.scene import Scene, box, turn
from benchmarks.campaign.trial import trial_of

DIP = 25.0


@pytest.fixture(scope="module")
def rest():
    """Return a block that friction holds on an incline, and its results."""
    polygons = [turn(polygon, -DIP) for polygon in (box(-3, -1, 3, 0), box(-0.5, 0, 0.5, 1))]
    scene = Scene(polygons=polygons, held=np.array([0]), friction=DIP + 5, kn=1e9, ks=5e8)
    return scene, bsm.run(zone_families.zoned(scene))


def test_a_rest_that_friction_holds_is_not_refused(rest):
    scene, results = rest
    assert results.status == "stable"
    assert zone_families.lack_of(scene, results) < LACK


def test_a_rest_beyond_friction_is_refused(rest):
    """The same results, as if the joint had less friction than the dip."""
    scene, results = rest
    assert zone_families.lack_of(replace(scene, friction=DIP - 1), results) > LACK


def test_outlines_are_those_of_the_deformed_blocks(rest):
    scene, results = rest
    outlines = zone_families.outlines(results)
    assert len(outlines) == scene.count
    assert len(outlines[1]) >= len(scene.polygons[1])
    assert 0 < np.abs(outlines[1].mean(axis=0) - scene.polygons[1].mean(axis=0)).max() < 1e-3


@pytest.mark.heavy
def test_a_block_in_water_slides_to_a_rest_that_its_motion_reaches():
    """Friction grows linearly as it leaves the water: forces balance at one distance, and motion ends at twice that."""
    slides_twice_as_far_as_forces_balance(2)


@pytest.mark.heavy
def test_vibrations_of_the_rock_do_not_let_it_creep_on_without_end():
    """Friction is 50 degrees."""
    slides_twice_as_far_as_forces_balance(8)


def slides_twice_as_far_as_forces_balance(seed):
    scene = trial_of(FAMILIES["plane"], seed).scene
    zones, rigid = bsm.run(zone_families.zoned(scene)), run(scene)[0]
    assert zones.status == rigid.status == "stable"
    one, other = (np.hypot(*results.stages[-1].displacement[1, :2]) for results in (zones, rigid))
    assert other > 0.2
    assert one / other == pytest.approx(2.0, rel=0.1)  # 2.3 where motion begins undamped
