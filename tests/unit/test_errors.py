"""How numbers and places are written in messages."""

import pytest

from bsm_mesh.errors import listing, place


@pytest.mark.parametrize(
    ("point", "text"),
    [
        ((1.0, -0.5), "(1, -0.5)"),
        ((1 / 3, 2e-5 / 3), "(0.333333, 6.66667e-06)"),
        ((1234.5678, 0.0), "(1234.568, 0)"),
        ((500035.25, 5000010.0174), "(500035.25, 5000010.017)"),
        ((-500035.25, 1e7), "(-500035.25, 10000000)"),
        ((float("nan"), float("-inf")), "(nan, -inf)"),
        ((1e300, 0.5), "(1e+300, 0.5)"),
    ],
)
def test_places_are_given_to_six_digits_or_the_millimetre(point: tuple[float, float], text: str) -> None:
    assert place(point) == text


def test_a_long_listing_is_cut() -> None:
    assert listing(range(3)) == "0, 1, 2"
    assert listing(range(100), 2) == "0, 1, ... (100 in all)"
