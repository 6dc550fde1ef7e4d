"""Shaking as it is given: faults, lengths, the movement of the base."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.model.base_motion import BaseMotion
from tests.scenes.models import model_of
from tests.scenes.shapes import square

SINE = {"waveform": "sine", "frequency": 2.0, "amplitude": 3.0}


@pytest.mark.parametrize(
    ("given", "fault"),
    [
        ({}, "needs a record or a waveform"),
        ({**SINE, "record": ([0, 1], [0, 1])}, "not both"),
        ({"waveform": "sine"}, r"needs frequency(.|\n)*needs amplitude"),
        ({**SINE, "waveform": "cosine"}, "waveform = 'cosine' is unknown"),
        ({**SINE, "waveform": "ricker", "cycles": 2}, "no cycles"),
        ({**SINE, "frequency": -1}, "frequency = -1 Hz must be"),
        ({**SINE, "every": 3.0}, "longer than the 0.5 s"),
        ({"record": 7}, "must be a pair"),
        ({"record": ([0, 1], [0, float("nan")])}, r"values\[1\] = nan is not a finite number"),
        ({"record": ([0, 1, 1], [0, 1, 2])}, "times must rise"),
        ({"record": ([0, 1], [0, 1, 2])}, "2 times and 3 values"),
        ({**SINE, "mass_scaling": 0.5}, "mass_scaling = 0.5"),
        ({**SINE, "contact_damping": 1.5}, "contact_damping = 1.5 must be"),
        ({**SINE, "contact_damping": "houzner"}, "contact_damping = 'houzner'"),
        ({**SINE, "mass_damping": 0.02}, r"must be a pair \(ratio, frequency\)"),
        ({**SINE, "mass_damping": (0.02, -1)}, "mass_damping: frequency = -1 Hz"),
        ({**SINE, "quantity": "force"}, "quantity = 'force' is unknown"),
        ({**SINE, "quantity": "stress"}, "quantity = 'stress' needs the boundary on which it acts"),
        ({**SINE, "quantity": "velocity", "quiet": ["a"], "boundary": "b"}, "boundary = 'b' is not quiet"),
        ({**SINE, "quiet": ["a", "a"]}, "names a boundary twice"),
        ({**SINE, "quiet": [3]}, "quiet"),
        ({**SINE, "waveform": np.zeros(2)}, "waveform = array.* is unknown"),
        ({**SINE, "integrator": np.zeros(2)}, "integrator = array.* is unknown"),
        ({**SINE, "contact_damping": np.zeros(2)}, "contact_damping = array.* is not a finite number"),
    ],
)
def test_faults_are_said(given, fault):
    with pytest.raises(bsm.ModelError, match=fault):
        bsm.Shaking(**given)


def test_a_stage_that_is_shaken_changes_nothing_else():
    with pytest.raises(bsm.ModelError, match="goes without excavate, gravity"):
        bsm.Stage(name="s", shaking=bsm.Shaking(**SINE), excavate=[1], gravity=(0.1, 0.0))


def test_what_cannot_be_shaken_is_said():
    stages = [bsm.Stage(name="s", shaking=bsm.Shaking(**SINE))]
    with pytest.raises(bsm.ModelError, match="stage 's': shaking: rock 'rock' has unit_weight 0"):
        model_of([square(0, 0), square(0, 1)], gamma=0.0, stages=stages)
    model = model_of([square(0, 0), square(0, 1)], stages=stages)
    for scheme in ("linear", "wang"):
        with pytest.raises(bsm.ModelError, match=f"'s' is shaken, which scheme = '{scheme}' cannot do"):
            bsm.run(model, bsm.Options(scheme=scheme))


def test_quiet_boundaries_that_cannot_be_are_said():
    quiet = bsm.Shaking(**SINE, quiet=["left", "lower", "right"])
    blocks = bsm.Blocks.from_polygons([square(0, 0), square(0, 1)], rock="rock")
    for name, x in (("left", 0.0), ("right", 1.0)):
        blocks = blocks.with_boundary(name, lambda at, _, x=x: np.abs(at - x) < 1e-6)
    model = model_of([square(0, 0), square(0, 1)])
    with pytest.raises(bsm.ModelError) as raised:
        model.replace(
            blocks=blocks,
            supports=[bsm.NormalRoller(boundary="left"), bsm.Fixed(blocks=[0])],
            stages=[bsm.Stage(name="s", shaking=quiet)],
        )
    assert "stage 's': shaking: quiet: there is no boundary 'lower'" in str(raised.value)
    assert "quiet: boundary 'right' has no support" in str(raised.value)
    assert "boundary 'left'" not in str(raised.value)
    with pytest.raises(bsm.ModelError, match="quiet: other supports fix all blocks at boundary 'left', so no wave"):
        model.replace(
            blocks=blocks,
            supports=[bsm.NormalRoller(boundary="left"), bsm.Fixed(blocks=[0]), bsm.Fixed(boundary="right")],
            stages=[bsm.Stage(name="s", shaking=bsm.Shaking(**SINE, quiet=["left"]))],
        )


def test_digests_of_models_that_are_not_shaken_stay():
    plain, shaking = bsm.Stage(name="s"), bsm.Stage(name="s", shaking=bsm.Shaking(**SINE))
    digest = model_of([square(0, 0), square(0, 1)], stages=[plain]).digest
    assert digest == "33ffc8967257167cc2d3959c9e524f0b81abcd1ad81e784ba7d239e6ac19893a"
    assert model_of([square(0, 0), square(0, 1)], stages=[shaking]).digest != digest


@pytest.mark.parametrize("quantity", ["acceleration", "velocity"])
@pytest.mark.parametrize("waveform", ["sine", "ricker", "pulse"])
def test_the_base_gains_what_its_acceleration_adds_up_to(quantity, waveform):
    base = BaseMotion(bsm.Shaking(waveform=waveform, frequency=2.0, amplitude=3.0, scale=-2.0, quantity=quantity))
    step, time = 1e-3, 1e-3 * np.arange(2000)
    gained = np.cumsum(base.acceleration_at(time, step)) * step
    assert_allclose(gained, base.velocity_at(time + step / 2), atol=1e-12)
    assert base.velocity_at(np.array([0.0, -1.0])).tolist() == [0.0, 0.0]


def test_a_record_is_integrated_exactly_between_its_values():
    times, values = np.array([0.5, 1.0, 2.0]), np.array([0.0, 4.0, 2.0])
    base = BaseMotion(bsm.Shaking(record=(times, values), duration=5.0))
    exact = [0.0, 0.25, 1.0, 1.0 + (4 + 3.5) / 2 / 4, 1.0 + 3.0, 4.0]
    assert_allclose(base.velocity_at(np.array([0.4, 0.75, 1.0, 1.25, 2.0, 4.0])), exact, rtol=1e-12)
    assert_allclose(base.at_end[0], 4.0)


def test_housners_damping_is_twice_the_critical_one():
    assert bsm.Shaking(**SINE, contact_damping="housner").dashpots == 2.0
    assert bsm.Shaking(**SINE, contact_damping=0.2).dashpots == 0.2


def test_a_direction_turns_the_base():
    base = BaseMotion(bsm.Shaking(**SINE, direction=90.0))
    assert base.axis.tolist() == [0.0, 1.0]
