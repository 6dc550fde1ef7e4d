"""Waves through joints, against closed forms.

An elastic joint: Schoenberg (1980), J. Acoust. Soc. Am. 68, 1516-1521: |T| = 1 / sqrt(1 + (omega Z / 2 k)^2). A joint
that slips at a constant strength and is rigid before: the velocity behind it is that of the incident wave, cut off at
strength / Z (Miller 1978, Bull. Seism. Soc. Am. 68, 1-20, as an approximation; here exactly, by quadrature).
"""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from tests.scenes.waves import ABOVE, BELOW, IMPEDANCE, column, in_time, velocities

SPEED_OF_BASE, FREQUENCY = 0.1, 30.0  # m/s, Hz


def rms(values):
    """Return the root of the mean square."""
    return np.sqrt((values**2).mean())


@pytest.mark.slow
def test_an_elastic_joint_lets_through_what_its_stiffness_says():
    """Of a wavelet the spectrum at 50 Hz, 39 blocks a wavelength, over that without the joint."""
    count, height, frequency = 160, 1.0, 50.0
    length = in_time(count, height)
    wavelet = bsm.Shaking(
        waveform="ricker", quantity="velocity", frequency=frequency, amplitude=SPEED_OF_BASE, duration=length,
        every=length / 200,
    )  # fmt: skip

    def spectrum(stiffness):
        time, velocity = velocities(bsm.run(column(wavelet, count, height, stiffness)), wavelet)
        assert np.abs(velocity[ABOVE][-1]) < 1e-6 * SPEED_OF_BASE  # it has gone by
        return abs((velocity[ABOVE] * np.exp(-2j * np.pi * frequency * time)).sum())

    stiffness = np.array([1e9, 5e9, 1e10])
    exact = 1 / np.sqrt(1 + (np.pi * frequency * IMPEDANCE / stiffness) ** 2)
    assert_allclose(exact, [0.78051, 0.98741, 0.99681], atol=1e-5)
    assert_allclose([spectrum(k) / spectrum(None) for k in stiffness], exact, rtol=3e-3)


@pytest.fixture(scope="module")
def passes():
    """Return a function that sends a sine through a joint of some strength, and what it returns of a strong one."""
    count, height = 200, 0.5
    length = in_time(count, height)
    sine = bsm.Shaking(
        waveform="sine", quantity="velocity", frequency=FREQUENCY, amplitude=SPEED_OF_BASE, cycles=10, duration=length,
        every=length / 400,
    )  # fmt: skip

    def run(strength):
        results = bsm.run(column(sine, count, height, 1e12, strength * IMPEDANCE * SPEED_OF_BASE))
        return (results, *velocities(results, sine))

    return run, run(10.0)


@pytest.mark.slow
@pytest.mark.parametrize("strength", [0.9, 0.7, 0.5, 0.3, 0.1])
def test_a_slipping_joint_cuts_off_the_velocity_of_a_wave(passes, strength):
    """What goes through, comes back and is lost in slip: roots of their parts of the energy of one period."""
    run, (_, time, whole) = passes
    results, _, velocity = run(strength)
    shaking = results.stages[-1].shaking
    end = shaking.time[-1] - 1e-3  # a wave's front is ahead of its time by a few blocks
    begin = end - 1 / FREQUENCY
    period = (time > begin) & (time <= end)
    wave = np.sin(np.linspace(0, 2 * np.pi, 100_001))
    cut = np.clip(wave, -strength, strength)

    through = rms(velocity[ABOVE][period]) / rms(whole[ABOVE][period])
    back = rms((velocity[BELOW] - whole[BELOW])[period]) / rms(whole[BELOW][period])
    slip = np.diff(np.interp([begin, end], shaking.time, shaking.energy[:, 5]))[0]
    lost = np.sqrt(slip * FREQUENCY / (IMPEDANCE * SPEED_OF_BASE**2 / 2))
    exact = rms(cut) / rms(wave), rms(wave - cut) / rms(wave), np.sqrt(2 * ((wave - cut) * cut).mean()) / rms(wave)
    assert_allclose((through, back, lost), exact, rtol=5e-3)
