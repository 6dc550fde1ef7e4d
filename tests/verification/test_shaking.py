"""Blocks that are shaken, against closed forms.

A block that slides on a plane by a rectangular pulse: Newmark (1965), Geotechnique 15, 139-160. One that slides back
and forth under a harmonic acceleration: each half period is that of the last, a transcendental equation. A block that
rocks about its corners: Housner (1963), Bull. Seism. Soc. Am. 53, 403-417; its quarter period exactly.
"""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.model.base_motion import GRAVITY
from tests.scenes.shaken import (
    QUIET,
    block_on_plane,
    housners_quarter,
    housners_swings,
    quarter,
    rocking,
    slide_under_a_sine,
    swings,
    wall,
)

IMPLICIT = {"integrator": "implicit"}


@pytest.mark.parametrize(
    "given",
    [
        pytest.param({"duration": 1.0}, marks=pytest.mark.heavy),
        pytest.param({"duration": 0.9, "every": 0.01, **IMPLICIT, "time_step": 0.1}, marks=pytest.mark.slow),
    ],
    ids=["explicit", "implicit"],
)
def test_newmark_block_slides_as_far_as_after_a_pulse(given):
    """V = (a - mu g) t0 at the end of the pulse, then mu g stops it: (a - mu g) t0^2 / 2 (1 + (a - mu g) / (mu g))."""
    a, slows, t0 = 0.5 * GRAVITY, 0.2 * GRAVITY, 0.3
    exact = (a - slows) * t0**2 / 2 * a / slows
    pulse = bsm.Shaking(waveform="pulse", frequency=1, cycles=t0, amplitude=a, **given)
    results = bsm.run(block_on_plane(pulse, friction=0.2, kn=1e10))
    stage = results.stages[-1]
    assert results.status == "stable"
    assert_allclose(stage.stage_displacement[1, 0], -exact, rtol=3e-3)  # the base moves to +x, the block stays behind
    energy = stage.shaking.energy[-1]
    assert_allclose(energy[[0, 5]], 0.2 * 12.5e3 * exact, rtol=3e-3)  # all that is put in goes into slip
    assert stage.shaking.imbalance < 1e-4


@pytest.mark.slow
@pytest.mark.parametrize(
    ("last", "seen", "given"),
    [(20, slice(160, 400), {}), (12.5, slice(120, 250), {**IMPLICIT, "time_step": 0.04, "contact_damping": 0.5})],
    ids=["explicit", "implicit"],
)
def test_a_block_slides_to_and_fro_under_a_harmonic_acceleration(last, seen, given):
    """With the implicit integrator dashpots take the swinging of its spring, whose period of 2 ms no step resolves."""
    a, slows, times = 8.0, 0.8 * GRAVITY, np.linspace(0, last, int(1000 * last) + 1)
    swing, greatest = slide_under_a_sine(a, slows)
    record = bsm.Shaking(record=(times, -a * np.sin(times)), every=0.05, **given)
    watched = [bsm.History(name="b", block=1)]
    results = bsm.run(block_on_plane(record, friction=0.8, kn=1e7, gamma=GRAVITY / 0.5, histories=watched))
    assert_allclose(np.ptp(results.histories["b"]["u"][seen]), swing, rtol=2e-3)
    assert_allclose(results.stages[-1].shaking.peak_velocity[1], greatest, rtol=2e-3)


@pytest.mark.heavy
@pytest.mark.parametrize("tilt", [0.25, 0.5, 0.75])
def test_a_rocking_block_falls_back_in_a_quarter_of_housners_period(tilt):
    b, h = 0.25, 1.0
    begin = tilt * np.arctan2(b, h)
    exact = housners_quarter(b, h, begin)
    shaking = bsm.Shaking(**QUIET, cycles=1.1 * exact, every=2e-3)
    time, turn, loop = rocking(b, h, begin, shaking, kn=4e9)
    assert_allclose(quarter(time, turn), exact, atol=2e-4)
    assert loop.shaken.heaviest == pytest.approx(1.0, abs=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("b", "tilt", "kn"), [(0.25, 0.25, 4e9), (0.25, 0.5, 1e9), (0.5, 0.5, 1e9), (0.5, 0.5, 6.4e10)]
)
def test_with_the_dashpots_of_housner_a_rocking_block_loses_what_his_does(b, tilt, kn):
    """The rate of turn after an impact is r = 1 - 3/2 sin^2 a of that before.

    Critical dashpots let a block rebound by exp(-2) of its speed: the stocky block swings 2 % too far then, however
    stiff its joints are. On dashpots across the face alone it swings 14 % too far, then 39 %.
    """
    angle = np.arctan2(b, 1.0)
    shaking = bsm.Shaking(**QUIET, cycles=2.6, every=5e-3, contact_damping="housner")
    time, turn, _ = rocking(b, 1.0, tilt * angle, shaking, kn=kn)
    assert_allclose(swings(time, turn, 3), housners_swings(angle, tilt * angle, 3), rtol=0.02 if kn < 1e10 else 3e-3)


def test_mass_damping_takes_what_its_ratio_says():
    """A kicked column swings at its own frequency; its energy falls by exp(-4 pi ratio f t), whatever the mode."""
    kick = bsm.Shaking(waveform="pulse", frequency=1, amplitude=0.5, cycles=5e-3, duration=1.5, every=0.05)
    damped = replace(kick, mass_damping=(0.02, 5.0))
    energy = bsm.run(wall(damped, courses=4, bricks=1)).stages[-1].shaking.energy
    total = energy[:, 2] + energy[:, 3] - energy[:, 1]
    time = 0.05 * np.arange(len(total))
    # Movement and springs have half of the energy each over a period, and the drag takes its part of movement alone.
    rate = -np.polyfit(time[2:], np.log(total[2:]), 1)[0]
    assert_allclose(rate, damped.drag, rtol=0.05)
    assert_allclose(energy[-1, 7], energy[-1, 0] - total[-1], rtol=1e-2)


@pytest.mark.heavy
def test_free_vibration_neither_grows_nor_fades_in_30_000_cycles():
    kick = bsm.Shaking(waveform="pulse", frequency=1, amplitude=0.5, cycles=5e-3, duration=6.0, every=0.1)
    stage = bsm.run(wall(kick, courses=4, bricks=1)).stages[-1]
    energy = stage.shaking.energy
    assert stage.shaking.cycles > 30_000
    total = energy[1:, 2] + energy[1:, 3] - energy[1:, 1]  # kinetic, springs, weights
    assert energy[-1, 0] > 0
    assert_allclose(total, energy[-1, 0], rtol=1e-3)
