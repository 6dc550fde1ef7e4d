"""Water on blocks with zones that displace by much: it presses where their faces are."""

from __future__ import annotations

import dataclasses
import subprocess
import sys

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.certificate import verify_certificate
from tests.scenes import meeting_zones as meeting
from tests.scenes.large_zones import bolted

UNIT = 9810.0  # N/m3


def level(y):
    """Return water whose table is level."""
    return bsm.Water(table=[(-9.0, y), (9.0, y)])


@pytest.mark.heavy
@pytest.mark.parametrize("order", [1, 2])
def test_a_block_that_falls_into_water_is_lighter_by_it(order):
    """Archimedes: above the table it has its weight, and on the floor less that of the water beside it."""
    results = bsm.run(meeting.dropped(young=1e11, size=1.0, order=order, gap=0.05, water=level(0.04)))
    assert results.status == "stable", results.stages[0].reason
    assert results.check().ok
    stage = results.stages[0]
    deep = 0.04 - 0.05 - stage.displacement[1, 1]
    assert deep > 0.03
    assert_allclose(meeting.force_between(results), meeting.WEIGHT - UNIT * deep, rtol=1e-6)
    assert_allclose(stage.water[1, 1], UNIT * deep, rtol=1e-5)


def test_rock_deep_in_water_has_the_stress_of_its_buoyant_weight():
    """That is its effective stress; the total one has the water's pressure as well."""
    results = bsm.run(meeting.dropped(young=1e9, size=0.5, water=level(5.0)))
    stage = results.stages[0]
    carried = meeting.WEIGHT - UNIT
    assert_allclose(meeting.force_between(results), carried, rtol=1e-5)  # its volume changes by 2e-5
    assert_allclose(stage.stress_effective[1, 1, 1], -carried / 2, rtol=1e-4)  # half of it at mid-height
    middle = 5.0 - 0.5 - 0.02 - stage.displacement[1, 1]
    assert_allclose(stage.stress[1, 1, 1] - stage.stress_effective[1, 1, 1], -UNIT * middle, rtol=1e-4)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [2, 4])
def test_stiff_blocks_that_meet_in_water_rest_as_rigid_ones(seed, tmp_path):
    """Under an inclined table that crosses them; the certificate finds its water on their outlines."""
    model = meeting.row(seed, smooth=True).replace(water=bsm.Water(table=[(-5.0, 0.4), (8.0, 1.4)]))
    zones, rigid = bsm.run(model), bsm.run(meeting.rigid(model))
    assert zones.status == rigid.status == "stable"
    one, other = (results.stages[0] for results in (zones, rigid))
    assert_allclose(one.displacement, other.displacement, atol=1e-4 * np.abs(other.displacement).max())
    assert_allclose(one.water, other.water, atol=1e-4 * np.abs(other.water).max())
    verify = [sys.executable, "-m", verify_certificate.__name__, zones.save(tmp_path / "out")]
    done = subprocess.run(verify, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout


@pytest.mark.slow
def test_a_bolted_block_slides_in_water_as_a_rigid_one():
    """By a third of its length, through the table."""
    model = bolted().replace(water=level(0.3))
    rigid = model.replace(rocks=[dataclasses.replace(model.rocks[0], zones=None, young=None, poisson=None)])
    one, other = (bsm.run(each).stages[0] for each in (model, rigid))
    assert one.status.value == other.status.value == "stable"
    assert_allclose(one.displacement[1, :2], other.displacement[1, :2], rtol=1e-5)
    assert_allclose(one.bolts.axial_force, other.bolts.axial_force, rtol=1e-5)


def test_a_table_that_rises_acts_in_its_stage():
    """From dry to wet and back: the block is where it was."""
    stages = [bsm.Stage(name="wet", water=level(5.0)), bsm.Stage(name="dry", water=level(-5.0))]
    results = bsm.run(meeting.dropped(young=1e9, size=1.0, stages=stages))
    assert results.status == "stable"
    pressed = [np.abs(stage.contacts.normal_force).sum() for stage in results.stages]
    assert_allclose(pressed, [meeting.WEIGHT, meeting.WEIGHT - UNIT, meeting.WEIGHT], rtol=1e-5)
    first, _, last = (stage.displacement for stage in results.stages)
    assert_allclose(last, first, atol=1e-4 * np.abs(first).max())
