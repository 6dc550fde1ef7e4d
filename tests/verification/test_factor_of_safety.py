"""Factors of safety against closed forms and published ones: the bracket, .2 % wide, contains them.

Hoek & Bray (1981); Hoek, Practical Rock Engineering, chapter 8; Goodman & Bray (1976); limit analysis of arches; the
tutorial slope of UDEC's manual; Bray's roof prism (Brady & Brown, Rock Mechanics for Underground Mining, section 9.5).
"""

from dataclasses import replace

import numpy as np
import pytest

from bsm_mesh.safety.factor import factor_of_safety
from tests.scenes.known_factors import (
    LEAST_FRICTION,
    TOPPLING,
    RoofPrism,
    arch,
    goodman_and_bray,
    incline,
    tan,
    tutorial_slope,
)
from tests.scenes.plane_failure import hoek_and_bray, sau_mau_ping

WIDTH = 0.002


def contains(found, exact, within=WIDTH):
    """Assert that a bracket is closed and contains the exact factor, to what elastic contacts do to it."""
    assert found.is_closed, str(found)
    assert found.unstable / found.stable - 1 <= WIDTH * 1.01
    assert found.stable * (1 - within) <= exact <= found.unstable * (1 + within), f"{found}, exact {exact}"


@pytest.mark.heavy
@pytest.mark.parametrize(("friction", "dip"), [(40.0, 30.0), (20.0, 30.0)])
def test_incline(friction, dip):
    found = factor_of_safety(incline(friction, dip), tolerance=WIDTH)
    contains(found, tan(friction) / tan(dip), 2e-4)
    assert found.limit.factor == pytest.approx(tan(friction) / tan(dip), rel=1e-4)
    assert found.mechanism.blocks.tolist() == [1]


@pytest.mark.heavy
@pytest.mark.parametrize("slope", [hoek_and_bray, sau_mau_ping])
@pytest.mark.parametrize(
    "given", [{"zw": 3.0}, {"cohesion": 0.0}, {"zw": 3.0, "cohesion": 0.0}, {}, {"zw": 3.0, "horizontal": 0.1}]
)
def test_plane_failure(slope, given):
    case = slope(**given)
    found = factor_of_safety(case.model(), joints=["J"], tolerance=WIDTH)
    contains(found, case.factor, 5e-4)


@pytest.mark.heavy
@pytest.mark.parametrize(("ratio", "n"), LEAST_FRICTION)
def test_least_friction_of_an_arch(ratio, n):
    found = factor_of_safety(arch(ratio, n, 35.0), tolerance=WIDTH)
    contains(found, tan(35.0) / LEAST_FRICTION[ratio, n], 3e-3)


@pytest.mark.parametrize(("friction", "exact"), [pytest.param(20.0, 0.90993, marks=pytest.mark.heavy), (11.0, 0.48595)])
def test_tutorial_slope_the_top_block_slides_first(friction, exact):
    assert exact == pytest.approx(tan(friction) / 0.4, abs=1e-5)
    found = factor_of_safety(tutorial_slope(friction), tolerance=WIDTH)
    contains(found, exact, 5e-4)
    assert found.mechanism.blocks.tolist() == [3]


def test_tutorial_slope_the_lower_block_without_the_top_one():
    assert tan(20.0) / 0.3 == pytest.approx(1.21323, abs=1e-5)
    contains(factor_of_safety(tutorial_slope(20.0, excavate=(1, 3)), tolerance=WIDTH), tan(20.0) / 0.3, 5e-4)


@pytest.mark.heavy
@pytest.mark.parametrize(
    ("apex", "ratio", "share"), [(10, 1, 1.3), (20, 100, 3), (30, 10, 10), (30, 1, 2), (40, 10, 3)]
)
def test_roof_prism(apex, ratio, share):
    """The stress is so many times that which just holds the prism at its whole friction."""
    case = prism(apex, ratio, share)
    found = factor_of_safety(case.model(), tolerance=WIDTH)
    contains(found, case.factor, 0.0)
    assert found.limit.factor == pytest.approx(tan(case.friction) / tan(apex), rel=1e-4)


@pytest.mark.heavy
@pytest.mark.parametrize("start", ["stage", "after", "throughout"])
def test_roof_prism_that_an_excavation_undercuts(start):
    """Nothing slips before the limit, so that no start matters."""
    case = prism(30.0, 10.0, 3.0)
    contains(factor_of_safety(case.model(dug=True), tolerance=WIDTH, start=start), case.factor, 0.0)


@pytest.mark.slow
@pytest.mark.parametrize(("share", "holds"), [(0.99, False), (1.2, True)])
def test_roof_prism_that_no_strength_holds(share, holds):
    """Where its joints open before they slip: W = 2 H (ks cos(a)^2 + kn sin(a)^2) / (kn tan(a)); statics holds it."""
    case = RoofPrism(apex=30.0, stress=1.0, kn=1e10, ks=1e9)
    a = np.radians(case.apex)
    weight, relaxed = case.gamma * case.height**2 * np.tan(a), case.ks * np.cos(a) ** 2 + case.kn * np.sin(a) ** 2
    least = weight * case.kn * np.tan(a) / (2 * case.height * relaxed)
    found = factor_of_safety(replace(case, stress=share * least).model())
    assert found.limit.factor == pytest.approx(tan(case.friction) / tan(case.apex), rel=1e-4)
    assert (found.stable is not None) == holds
    assert any("open joints carry no shear" in note for note in found.notes) != holds


def prism(apex, ratio, share):
    """Return a prism under so many times the stress at which its weight is the greatest, by equation 9.28."""
    case = RoofPrism(apex=apex, stress=1.0, kn=1e10, ks=1e10 / ratio)
    a, phi = np.radians([apex, case.friction])
    d = case.ks * np.cos(a) * np.cos(phi) + case.kn * np.sin(a) * np.sin(phi)
    borne = 2 * case.height / d * (case.ks * np.cos(a) ** 2 + case.kn * np.sin(a) ** 2) * np.sin(phi - a)
    weight = case.gamma * case.height**2 * np.tan(a)
    at_limit = replace(case, stress=weight / borne)
    assert at_limit.factor == pytest.approx(1.0, rel=1e-9)
    return replace(case, stress=share * at_limit.stress)


@pytest.mark.slow
def test_toppling():
    """Limiting friction 38.15 degrees, printed; its authors let blocks touch at their upper corners only."""
    contains(factor_of_safety(goodman_and_bray(42.0), tolerance=WIDTH), tan(42.0) / TOPPLING, 5e-3)
