"""Quiet boundaries: waves that reach them leave, and waves that are put in there enter as they are given."""

import numpy as np
import pytest

import bsm_mesh as bsm
from tests.scenes.quiet import DENSITY, column, reflected, velocities

WAVE, BACK = 3e-3, 1e-3  # of the wave: error of its height, what may come back


@pytest.mark.slow
@pytest.mark.parametrize(("direction", "quantity", "amplitude"), [(0, "velocity", 0.01), (90, "stress", 1e5)])
def test_a_wave_enters_as_it_is_given_and_leaves_at_both_ends(direction, quantity, amplitude):
    """At 40 blocks a wavelength less than a thousandth comes back, of shear waves and of pressure waves.

    A stress on the boundary is twice that of the wave, which is density times speed times its velocity.
    """
    model, speed = column(direction, quantity=quantity, amplitude=amplitude)
    height = amplitude if quantity == "velocity" else amplitude / (2 * DENSITY * speed)
    results = bsm.run(model)
    time, velocity = velocities(results, "u" if direction == 0 else "v")
    assert velocity.max() == pytest.approx(height, rel=WAVE)
    assert np.abs(velocity[time > 175 / speed]).max() < BACK * height
    stage = results.stages[-1]
    assert stage.status.is_stable
    assert stage.shaking.imbalance < 3e-3
    assert not stage.shaking.base_acceleration.any()


@pytest.mark.slow
def test_a_boundary_that_is_not_quiet_sends_a_wave_back():
    """The base that holds: the same wave comes back whole, turned over."""
    model, speed = column(0, 40, quiet=("bottom",), wavelength=16.0, length=3.5)
    model = model.replace(supports=[*model.supports, bsm.Fixed(boundary="top")])
    time, velocity = velocities(bsm.run(model), "u")
    assert velocity[time > 80 / speed].min() == pytest.approx(-0.01, rel=0.05)


@pytest.mark.parametrize("angle", [0.0, 20.0, 40.0, 60.0, 80.0])
@pytest.mark.parametrize("kind", ["p", "s"])
def test_the_closed_form_at_an_angle(kind, angle):
    """Without dashpots a free surface sends all energy back; with them none along the normal, and never more."""
    assert reflected(angle, kind, dashpots=0.0)[1].sum() == pytest.approx(1.0)
    energy = reflected(angle, kind)[1].sum()
    assert energy == pytest.approx(0.0, abs=1e-12) if angle == 0 else 0 < energy < 1


def test_a_free_surface_changes_waves_wholly():
    """With a Poisson's ratio of 1/4 a pressure wave at 60 degrees comes back as shear, and the other way.

    The shear wave is at 30 degrees. There ``sin 2a sin 2b = 3 cos^2 2b`` holds for the angles a of pressure waves and b
    of shear waves, with ``sin a = 3^.5 sin b``.
    """
    for angle, kind, amplitudes in ((60.0, "p", (0.0, 1.0)), (30.0, "s", (1.0, 0.0))):
        assert np.abs(reflected(angle, kind, dashpots=0.0)[0]) == pytest.approx(amplitudes, abs=1e-9)
