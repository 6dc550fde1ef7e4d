"""Factors of safety against closed forms and published ones: the bracket, .2 % wide, contains them.

Hoek & Bray (1981); Hoek, Practical Rock Engineering, chapter 8; Goodman & Bray (1976); limit analysis of arches; the
tutorial slope of UDEC's manual.
"""

import pytest

from bsm_mesh.safety.factor import factor_of_safety
from tests.scenes.known_factors import LEAST_FRICTION, TOPPLING, arch, goodman_and_bray, incline, tan, tutorial_slope
from tests.scenes.plane_failure import hoek_and_bray, sau_mau_ping

WIDTH = 0.002


def contains(found, exact, within=WIDTH):
    """Assert that a bracket is closed and contains the exact factor, to what elastic contacts do to it."""
    assert found.is_closed, str(found)
    assert found.unstable / found.stable - 1 <= WIDTH * 1.01
    assert found.stable * (1 - within) <= exact <= found.unstable * (1 + within), f"{found}, exact {exact}"


@pytest.mark.parametrize(("friction", "dip"), [(40.0, 30.0), (20.0, 30.0)])
def test_incline(friction, dip):
    found = factor_of_safety(incline(friction, dip), tolerance=WIDTH)
    contains(found, tan(friction) / tan(dip), 2e-4)
    assert found.limit.factor == pytest.approx(tan(friction) / tan(dip), rel=1e-4)
    assert found.mechanism.blocks.tolist() == [1]


@pytest.mark.parametrize("slope", [hoek_and_bray, sau_mau_ping])
@pytest.mark.parametrize(
    "given", [{"zw": 3.0}, {"cohesion": 0.0}, {"zw": 3.0, "cohesion": 0.0}, {}, {"zw": 3.0, "horizontal": 0.1}]
)
def test_plane_failure(slope, given):
    case = slope(**given)
    found = factor_of_safety(case.model(), joints=["J"], tolerance=WIDTH)
    contains(found, case.factor, 5e-4)


@pytest.mark.parametrize(("ratio", "n"), LEAST_FRICTION)
def test_least_friction_of_an_arch(ratio, n):
    found = factor_of_safety(arch(ratio, n, 35.0), tolerance=WIDTH)
    contains(found, tan(35.0) / LEAST_FRICTION[ratio, n], 3e-3)


@pytest.mark.parametrize(("friction", "exact"), [(20.0, 0.90993), (11.0, 0.48595)])
def test_tutorial_slope_the_top_block_slides_first(friction, exact):
    assert exact == pytest.approx(tan(friction) / 0.4, abs=1e-5)
    found = factor_of_safety(tutorial_slope(friction), tolerance=WIDTH)
    contains(found, exact, 5e-4)
    assert found.mechanism.blocks.tolist() == [3]


def test_tutorial_slope_the_lower_block_without_the_top_one():
    assert tan(20.0) / 0.3 == pytest.approx(1.21323, abs=1e-5)
    contains(factor_of_safety(tutorial_slope(20.0, excavate=(1, 3)), tolerance=WIDTH), tan(20.0) / 0.3, 5e-4)


def test_toppling():
    """Limiting friction 38.15 degrees, printed; its authors let blocks touch at their upper corners only."""
    contains(factor_of_safety(goodman_and_bray(42.0), tolerance=WIDTH), tan(42.0) / TOPPLING, 5e-3)
