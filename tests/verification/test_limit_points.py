"""Flat arches that snap through: at rest below the exact limit, on the right branch, and unstable above it."""

import numpy as np
import pytest
from scipy.optimize import brentq

import bsm_mesh as bsm
from tests.scenes.flat_arch import is_right, snapped
from tests.scenes.shapes import rectangle

FRACTIONS = (0.5, 0.9, 0.97, 0.99, 1.01, 1.03)


@pytest.mark.parametrize("fraction", FRACTIONS)
@pytest.mark.parametrize(
    ("flatness", "kn", "given"),
    [
        (0.05, 1e9, {"half": True}),
        pytest.param(0.1, 1e13, {"half": False, "stages": 20}, marks=pytest.mark.heavy),
        (0.2, 1e10, {"half": False}),
        pytest.param(0.3, 1e8, {"half": True, "stages": 20}, marks=pytest.mark.heavy),
        (0.3, 1e11, {"half": False, "weight": True}),
        (0.5, 1e12, {"half": True, "weight": True}),
    ],
)
def test_flat_arches_snap_through_at_their_limit_and_not_before(flatness, kn, given, fraction):
    stage, exact = snapped(flatness, fraction, kn, **given)
    assert stage.status == ("stable" if fraction < 1 else "unstable")
    assert is_right(stage, exact)


@pytest.mark.heavy
@pytest.mark.parametrize("fraction", [0.6, 0.99, 1.01])
@pytest.mark.parametrize(
    ("flatness", "shear", "friction", "given"),
    [
        (0.3, 10.0, 40.0, {}),
        (0.1, 1e2, 60.0, {"weight": True}),
        (0.2, 1e3, 40.0, {"weight": True}),
        (0.1, 1e4, 80.0, {"weight": True}),
        (0.3, 1e4, 60.0, {"stages": 5}),
    ],
)
def test_the_limit_does_not_hang_on_the_stiffness_in_shear(flatness, shear, friction, given, fraction):
    stage, exact = snapped(flatness, fraction, 1e7, half=True, shear=shear, friction=friction, **given)
    assert stage.status == ("stable" if fraction < 1 else "unstable")
    assert is_right(stage, exact)


@pytest.mark.parametrize("friction", [40.0, 80.0])
@pytest.mark.parametrize("load", [0.0, 50e3])
@pytest.mark.parametrize("shear", [1.0, 1e2, 1e3, 1e4])
def test_a_beam_of_two_stones_stands_with_stiff_shear_springs(shear, load, friction):
    """Stones of 5 x 1 m and 26 kN/m3: they thrust ten times what they weigh against friction they hardly use."""
    held = [rectangle(-1, -1, 0, 2), rectangle(10, -1, 11, 2)]
    model = bsm.Model(
        blocks=bsm.Blocks.from_polygons([*held, rectangle(0, 0, 5, 1), rectangle(5, 0, 10, 1)], rock="rock"),
        rocks=[bsm.Rock("rock", unit_weight=26e3)],
        joints=[bsm.Joint("joint", 1e9, shear * 1e9, law=bsm.MohrCoulomb(friction=friction))],
        default_joint="joint",
        supports=[bsm.Fixed(blocks=[0, 1])],
        loads=[bsm.PointLoad(block=b, point=(5.0, 1.0), force=(0.0, -load)) for b in (2, 3)] if load else [],
    )
    stage = bsm.run(model).stages[-1]
    assert stage.status == "stable"
    flat, spring, borne = np.arctan(0.2), 1e9 / 2 / 1.5, load + 26e3 * 5 / 2
    turned = brentq(lambda a: spring * np.tan(flat - a) * (np.hypot(5, 1) * np.cos(flat - a) - 5) - borne, 0, flat / 4)
    assert np.abs(stage.displacement[2:, 2]).mean() == pytest.approx(turned, rel=2e-3)
