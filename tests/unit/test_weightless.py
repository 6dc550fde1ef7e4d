"""Blocks without weight or load, moved by supports alone: they slip until nothing carries, and do not drift on."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from tests.scenes.models import model_of
from tests.scenes.shapes import rectangle

HEIGHT = 2.0


def on_a_crack(dip: float) -> list[np.ndarray]:
    """Return a block below a crack at a dip, and one above it."""
    rise = 2 * np.tan(np.radians(dip))
    low = np.array([(0, -3), (2, -3), (2, rise), (0, 0)])
    return [low, np.array([(0, 0), (2, rise), (2, HEIGHT + rise), (0, HEIGHT + rise)])]


@pytest.mark.parametrize("solver", ["auto", "superlu"])  # the second takes no zero pivot
@pytest.mark.parametrize("dip", [25.0, 35.0, 50.0])
def test_a_slipping_crack_without_load(dip, solver):
    """Pressed by v on a crack steeper than friction a block slips until the crack carries nothing: by v / tan(dip)."""
    model = model_of(on_a_crack(dip), gamma=0, friction=20.0, supports=[bsm.Fixed(blocks=[0])])
    top = HEIGHT + 2 * np.tan(np.radians(dip)) - 1e-9
    pressed = bsm.PrescribedDisplacement(boundary="top", direction=90, displacement=-1e-3)
    blocks = model.blocks.with_boundary("top", lambda x, y: y > top)
    options = bsm.Options(linear_solver=solver)
    stage = bsm.run(model.replace(blocks=blocks, supports=[*model.supports, pressed]), options).stages[-1]
    assert stage.status == "stable"
    assert len(stage.steps) <= 4
    assert_allclose(stage.displacement[1], [-1e-3 / np.tan(np.radians(dip)), -1e-3, 0], rtol=1e-3, atol=1e-9)


def squeezed(dip: float, friction: float, press: float) -> bsm.Model:
    """Return the block on the crack below a plate that is pressed on it."""
    low, block = on_a_crack(dip)
    top = block[:, 1].max()
    plate = [bsm.PrescribedDisplacement(blocks=[2], direction=d, displacement=u) for d, u in ((90, press), (0, 0.0))]
    polygons = [low, block, rectangle(0, top, 2, top + 2)]
    return model_of(polygons, gamma=0, friction=friction, supports=[bsm.Fixed(blocks=[0]), *plate])


@pytest.mark.parametrize(("dip", "friction", "press"), [(35.0, 10.0, -1e-3), (50.0, 20.0, -1e-3), (20.0, 10.0, -1e-3)])
def test_masses_of_blocks_without_weight(dip, friction, press):
    with warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)
        stage = bsm.run(squeezed(dip, friction, press)).stages[-1]
    assert stage.status == "stable"


def test_a_block_squeezed_out_does_not_drift():
    """No weight and no force would stop it: it ran until the steps were used up, with a residual of 0."""
    stage = bsm.run(squeezed(45.0, 30.0, -0.7313649)).stages[-1]
    assert stage.status == "stable"
    assert len(stage.steps) < 60
