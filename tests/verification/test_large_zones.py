"""Zones in large displacement against closed forms: the elastica, and columns that buckle."""

from __future__ import annotations

import pytest
from numpy.testing import assert_allclose

from tests.scenes.large_zones import elastica, elastica_exact, pressed

SLENDER = 3e-3  # of the strip's length: shear adds .6 (H / L)^2 of the deflection, and the page of a beam is 20 by 1
BUCKLES = 0.01  # of the critical load


@pytest.mark.parametrize(("alpha", "pieces"), [pytest.param(1.0, 1, marks=pytest.mark.heavy), (4.0, 10)])
def test_a_cantilever_bends_as_the_elastica(alpha, pieces):
    """Bisshopp & Drucker (1945): deflection and shortening of the tip, up to two thirds of the length."""
    results, found = elastica(alpha, pieces=pieces, size=1.0)
    assert results.status == "stable", results.stages[0].reason
    assert results.check().block_residual < 1e-8
    assert_allclose(found, elastica_exact(alpha), atol=SLENDER)


@pytest.mark.parametrize("pieces", [pytest.param(1, marks=pytest.mark.heavy), 10])
def test_a_column_buckles_at_the_euler_load(pieces):
    """Stable straight below it, and unstable above."""
    assert pressed(1 - BUCKLES, pieces=pieces).status == "stable"
    above = pressed(1 + BUCKLES, pieces=pieces)
    assert above.status == "not_converged"
    assert "is unstable" in above.stages[0].reason
