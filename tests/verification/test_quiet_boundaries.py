"""Quiet boundaries: waves that reach them leave, and waves that are put in there enter as they are given."""

import dataclasses

import numpy as np
import pytest

import bsm_mesh as bsm
from bsm_mesh.model.base_motion import GRAVITY
from tests.scenes.shapes import rectangle

YOUNG, POISSON, DENSITY = 25e9, 0.25, 2600.0
SHEAR = YOUNG / 2 / (1 + POISSON)
PRESSURE = SHEAR * 2 * (1 - POISSON) / (1 - 2 * POISSON)
MODULI = {0: SHEAR, 90: PRESSURE}  # of waves that move blocks along x and along y


def column(direction, count=100, height=1.0, *, amplitude=0.01, quantity="velocity", top=False, wavelength=40, **given):
    """Return a column of rigid blocks that carries one kind of wave, and its speed; the wave enters below."""
    modulus = MODULI[direction]
    speed = np.sqrt(modulus / DENSITY)
    blocks = bsm.Blocks.from_polygons(
        [rectangle(0, height * k, 1, height * (k + 1)) for k in range(count)], rock="rock"
    )
    blocks = blocks.with_boundary("sides", lambda x, y: np.minimum(x, 1 - x) < 1e-6)
    blocks = blocks.with_boundary("bottom", lambda x, y: y < 1e-6)
    blocks = blocks.with_boundary("top", lambda x, y: y > height * count - 1e-6)
    quiet = ["bottom", "top"] if top else ["bottom"]
    shaking = bsm.Shaking(
        waveform="ricker", frequency=speed / (wavelength * height), amplitude=amplitude, quantity=quantity,
        direction=direction, quiet=quiet, boundary="bottom", **given,
    )  # fmt: skip
    sides = bsm.Roller(boundary="sides", direction=90 - direction)
    model = bsm.Model(
        blocks=blocks,
        rocks=[bsm.Rock("rock", unit_weight=DENSITY * GRAVITY, young=YOUNG, poisson=POISSON, stiffness="rigid")],
        joints=[bsm.Joint("J", normal_stiffness=modulus / height, shear_stiffness=modulus / height)],
        default_joint="J",
        supports=[bsm.Fixed(boundary="bottom"), *([bsm.Fixed(boundary="top")] if top else []), sides],
        in_situ=bsm.InSitu(stress={"xx": -1e6, "yy": -1e6}),
        gravity_vertical=1.0,  # no weights
        stages=[bsm.Stage(name="wave", shaking=shaking)],
        histories=[bsm.History(name="middle", block=count // 2)],
    )
    return model, speed


@pytest.mark.heavy
@pytest.mark.parametrize("direction", [0, 90])
def test_a_wave_enters_as_it_is_given_and_leaves_at_both_ends(direction):
    """At 40 blocks a wavelength less than a thousandth comes back, of shear waves and of pressure waves."""
    model, speed = column(direction, top=True)
    length = 390 / speed
    stage, shaking = model.stages[0], model.stages[0].shaking
    model = model.replace(
        stages=[dataclasses.replace(stage, shaking=dataclasses.replace(shaking, duration=length, every=length / 780))]
    )
    results = bsm.run(model)
    steps = [step for each in results.stages for step in each.steps]
    shaken = np.array([step.time is not None for step in steps])
    time = np.append(0.0, [step.time for step in steps if step.time is not None])
    moved = np.append(0.0, np.asarray(results.histories["middle"]["u" if direction == 0 else "v"])[shaken])
    velocity, middle = np.diff(moved) / np.diff(time), (time[1:] + time[:-1]) / 2
    assert velocity.max() == pytest.approx(0.01, rel=3e-3)
    assert np.abs(velocity[middle > 175 / speed]).max() < 1e-3 * 0.01
    assert results.stages[-1].status.is_stable
    assert results.stages[-1].shaking.imbalance < 3e-3
