"""Quiet boundaries: waves that reach them leave, and waves that are put in there enter as they are given."""

import numpy as np

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
