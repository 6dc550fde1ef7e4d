"""Flat arches that snap through: at rest below the exact limit, on the right branch, and unstable above it."""

import pytest

from tests.scenes.flat_arch import is_right, snapped

FRACTIONS = (0.5, 0.9, 0.97, 0.99, 1.01, 1.03)


@pytest.mark.parametrize("fraction", FRACTIONS)
@pytest.mark.parametrize(
    ("flatness", "kn", "given"),
    [
        (0.05, 1e9, {"half": True}),
        (0.1, 1e13, {"half": False, "stages": 20}),
        (0.2, 1e10, {"half": False}),
        (0.3, 1e8, {"half": True, "stages": 20}),
        (0.3, 1e11, {"half": False, "weight": True}),
        (0.5, 1e12, {"half": True, "weight": True}),
    ],
)
def test_flat_arches_snap_through_at_their_limit_and_not_before(flatness, kn, given, fraction):
    stage, exact = snapped(flatness, fraction, kn, **given)
    assert stage.status == ("stable" if fraction < 1 else "unstable")
    assert is_right(stage, exact)
