"""Blocks that are shaken, by the implicit integrator: closed forms, and agreement with the explicit one.

Blocks that slide, by either integrator: `test_shaking`, which has the source of the closed form here, too.
"""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.model.base_motion import GRAVITY
from tests.scenes.shaken import (
    QUIET,
    housners_quarter,
    quake,
    quarter,
    rocking,
    wall,
)


@pytest.mark.heavy
@pytest.mark.parametrize("tilt", [0.25, 0.5, 0.75])
def test_a_rocking_block_falls_back_in_a_quarter_of_housners_period(tilt):
    b, h = 0.25, 1.0
    begin = tilt * np.arctan2(b, h)
    exact = housners_quarter(b, h, begin)
    shaking = bsm.Shaking(**QUIET, cycles=1.05 * exact, every=4e-3, time_step=0.5, integrator="implicit")
    time, turn, _ = rocking(b, h, begin, shaking, kn=4e9)
    assert_allclose(quarter(time, turn), exact, atol=2e-4)


@pytest.mark.heavy
def test_free_vibration_keeps_its_energy():
    """Up and down springs are linear: the trapezoidal rule keeps their energy, whatever the time step."""
    kick = bsm.Shaking(waveform="pulse", frequency=1, amplitude=0.2, cycles=4e-3, duration=0.8, direction=90.0)
    shaking = replace(kick, every=0.002, time_step=1.0, integrator="implicit")
    found = bsm.run(wall(shaking, courses=4, bricks=1)).stages[-1].shaking
    total = found.energy[5:, 2] + found.energy[5:, 3] - found.energy[5:, 1]  # kinetic, springs, weights
    assert found.cycles == 400
    assert total.min() > 0
    assert np.ptp(total) < 1e-6 * total.mean()


@pytest.mark.slow
@pytest.mark.parametrize("damping", [0.0, 0.2])
def test_both_integrators_agree_on_a_wall(damping):
    record = bsm.Shaking(record=quake(0.4 * GRAVITY, 2.5), every=0.05, contact_damping=damping)
    moved = []
    for given in ({}, {"integrator": "implicit", "time_step": 0.05}):
        stage = bsm.run(wall(replace(record, **given), courses=4, bricks=4, kn=1e8)).stages[-1]
        assert stage.status == "stable"
        moved.append(np.sqrt((stage.stage_displacement[1:, :2] ** 2).sum(axis=1).mean()))
    assert_allclose(moved[1], moved[0], rtol=0.03)
