"""Stages of blocks with zones against statics: reactions of a stack that is dug in parts, water in its joints."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from tests.scenes.models import model_of
from tests.scenes.shapes import rectangle

WEIGHT, KN = 26e3, 1e9  # N/m of a block of 1 m2; Pa/m
STACK = [rectangle(-3, -1, 3, 0), *(rectangle(0, y, 1, y + 1) for y in range(3))]  # a base of 6 m2, and three on it
BASE = 6 * WEIGHT
ZONES = {"rigid": None, "small": bsm.Zones(), "large": bsm.Zones(displacement="large")}


def stack(zones, **given):
    """Return the stack on joints, of rock that hardly deforms; the base is fixed."""
    rock = bsm.Rock("rock", unit_weight=WEIGHT, young=1e13, poisson=0.0, zones=ZONES[zones])
    joint = bsm.Joint("J", normal_stiffness=KN, shear_stiffness=KN, law=bsm.MohrCoulomb(friction=35))
    return model_of(STACK, rocks=[rock], joint=joint, **given)


@pytest.mark.parametrize("zones", ZONES)
def test_reactions_while_a_part_of_the_excavation_is_held_back(zones):
    """Of the top block's weight four tenths still press on the rest, then none."""
    stages = [bsm.Stage("part", excavate=[3], relaxation=[0.3, 0.6]), bsm.Stage("all")]
    results = bsm.run(stack(zones, in_situ=bsm.InSitu(surface=3.0), stages=stages))
    expected = BASE + np.array([3.0, 2.4, 2.0]) * WEIGHT
    assert_allclose([stage.reactions[:, 1].sum() for stage in results.stages], expected, rtol=1e-6)
    assert_allclose([stage.reactions[0, 1] + stage.loads[:, 1].sum() for stage in results.stages], 0, atol=1e-2)
    assert_allclose(results.stages[1].displacement[1:3, 1], np.array([0.6, 1.2]) * WEIGHT / KN, rtol=1e-4)
    assert results.check().ok


@pytest.mark.parametrize("zones", ["rigid", "small"])
@pytest.mark.parametrize("at_once", [True, False])
def test_a_joint_that_is_laid_bare_is_dry(zones, at_once):
    """Its own pressure acts between blocks: the upper of two that stay is lifted by it, and nothing presses on top."""
    pressure = 5e3
    water = bsm.Water(table=[], joint_pressure={"J": pressure})
    dug = bsm.Stage("dug", excavate=[3], water=water if at_once else None)
    stages = [dug] if at_once else [dug, bsm.Stage("water", water=water)]
    results = bsm.run(stack(zones, stages=stages))
    last = results.stages[-1]
    assert_allclose(last.water[:3, 1], [-pressure, 0, pressure], atol=1e-3)
    assert_allclose(last.reactions[:, 1].sum(), BASE + 2 * WEIGHT, rtol=1e-6)
    lower = -(2 * WEIGHT - pressure) / KN
    assert_allclose(last.displacement[1:3, 1], [lower, lower - (WEIGHT - pressure) / KN], rtol=1e-4)
    assert results.check().ok
