"""How numbers and places are written in messages."""

import pytest

from bsm_mesh.errors import InputError, listing, place


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


def test_faults_that_differ_in_numbers_are_one_line_with_a_count() -> None:
    short = [f"block {k}: edge {k + 1} has length 1e-0{k} m; merge" for k in range(1, 9)]
    message = str(InputError(["rock a: no weight", *short]))
    assert message == (
        "9 faults:\n  - rock a: no weight\n"
        "  - block 1: edge 2 has length 1e-01 m; merge [7 more of this kind: block 2, block 3, block 4, ...]"
    )


def test_two_faults_of_a_kind_are_both_shown() -> None:
    both = ["joint 'J1': friction = 95 is too large", "joint 'J2': friction = 99 is too large"]
    assert str(InputError(both)) == "2 faults:\n  - " + "\n  - ".join(both)


def test_many_kinds_are_cut_short() -> None:
    kinds = [f"{'x' * k}: wrong" for k in range(1, 21)]
    assert str(InputError(kinds)).endswith("and 8 more")
