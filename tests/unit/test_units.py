"""Numbers with units in the model file."""

from __future__ import annotations

import random

import pytest

from bsm_mesh.model import quantities
from bsm_mesh.model.quantities import BOLT_COUNT, FRICTION, POISSON, UNIT_WEIGHT
from bsm_mesh.model.quantity import PREFIXES, Quantity, _by_pint, _prefixed, convert


def wide(unit: str) -> Quantity:
    return Quantity(unit=unit, least=-1e12, most=1e12, example=f'"1 {unit}"')


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("6.89 GPa", "Pa", 6.89e9),
        ("69 kPa", "Pa", 69e3),
        ("69kPa", "Pa", 69e3),
        ("-.5 MPa", "Pa", -0.5e6),
        ("1.e3 kPa", "Pa", 1e6),
        ("5 N m^-2", "Pa", 5.0),
        ("5 N/mm2", "Pa", 5e6),
        ("1 psi", "Pa", 4.4482216152605 / 0.0254**2),
        ("1.5 ksf", "Pa", 1500 * 4.4482216152605 / 0.3048**2),
        ("165 pcf", "N/m^3", 165 * 4.4482216152605 / 0.3048**3),
        ("26 kN/m^3", "N/m^3", 26e3),
        ("26 kN/m3", "N/m^3", 26e3),
        ("26 kN/m³", "N/m^3", 26e3),
        ("26 kN*m**-3", "N/m^3", 26e3),
        ("5 GPa/m", "Pa/m", 5e9),
        ("5 MPa/mm", "Pa/m", 5e9),
        ("0.2 inch", "m", 0.2 * 0.0254),
        ("35°", "degree", 35.0),
        ("100 gon", "degree", 90.0),
        ("120 kN/m", "N/m", 120e3),
        (35, "degree", 35.0),
        (2.5, "m", 2.5),
    ],
)
def test_conversions(text: object, unit: str, value: float) -> None:
    assert convert(text, wide(unit)) == pytest.approx(value, rel=1e-14)


def test_rounding_of_factors_is_taken_out() -> None:
    """26 * 1000.0000000000001 would make a model in kN differ from the same in N."""
    assert convert("26 kN/m^3", UNIT_WEIGHT) == 26000
    assert convert("0.3 mm", wide("m")) == 0.0003


UNITS = sorted({one.unit for one in vars(quantities).values() if isinstance(one, Quantity)} - {"", "1/m"})


@pytest.mark.parametrize("unit", UNITS)
@pytest.mark.parametrize("prefix", PREFIXES)
def test_prefixes_that_need_no_library_mean_what_they_mean_in_it(prefix: str, unit: str) -> None:
    rng, any_size = random.Random(7), Quantity(unit=unit, least=-1e40, most=1e40, example="1")
    for digits in range(1, 16):
        number = float(f"{rng.uniform(-1, 1) * 10 ** rng.randint(-8, 8):.{digits}g}")
        assert convert(f"{number} {prefix}{unit}", any_size) == _by_pint(number, prefix + unit, unit, "")


@pytest.mark.parametrize(("text", "unit"), [("mm^2/s", "m^2/s"), ("psi", "Pa"), ("MPa/mm", "Pa/m"), ("k1/m", "1/m")])
def test_other_units_are_read_by_the_library(text: str, unit: str) -> None:
    assert _prefixed(text, unit) is None


@pytest.mark.parametrize(
    ("text", "unit", "words"),
    [
        ("10,5 GPa", "Pa", "comma"),  # pint reads 105 GPa
        ("GPa", "Pa", "not a number"),  # pint reads 1 GPa
        ("35", "degree", "without a unit"),  # pint reads radians
        ("35 %", "degree", "does not convert"),
        ("160 lb/ft^3", "N/m^3", r"of a force write lbf/ft\^3"),
        ("10 t/m2", "Pa", r"of a force write tf/m\^2"),
        ("10 GPa + 1 Pa", "Pa", "not a number"),
        ("1 000 kPa", "Pa", "not a number"),
        ("9**9**9**9**9 Pa", "Pa", "not a number"),  # pint computes it, for ever
        ("1 m^9^9^9^9^9", "m", "not a number"),
        ("1 Pa**9**9**9**9", "Pa", "not a number"),
        ("__import__('os')", "Pa", "not a number"),
        ("", "Pa", "not a number"),
        ("10 degC", "Pa", "does not convert"),
        ("2700 kg/m^3", "N/m^3", "density"),
        ("nan Pa", "Pa", "no finite number"),
        (float("inf"), "Pa", "no finite number"),
        (10**400, "Pa", "must be -1e12 to 1e12 Pa"),
        (True, "Pa", "needs a number"),
        (None, "Pa", "needs a number"),
    ],
)
def test_what_is_refused(text: object, unit: str, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        convert(text, wide(unit))


@pytest.mark.parametrize(
    ("value", "quantity", "words"),
    [
        ("26e6 MN/m^3", UNIT_WEIGHT, 'must be 0 to 1e12 N/m.3, for example "26 kN/m.3"'),
        (-1, UNIT_WEIGHT, "must be 0 to"),
        (90, FRICTION, "must be at least 0 and below 90 degrees"),
        ("0.25", POISSON, "must be a plain number, without quotes"),
        (0, BOLT_COUNT, "must be a whole number, 1 to 10000"),
        (3.0, BOLT_COUNT, "must be a whole number"),
        ("3", BOLT_COUNT, "must be a whole number, without quotes"),
        (True, BOLT_COUNT, "must be a whole number"),
        (10**400, BOLT_COUNT, "must be a whole number"),
    ],
)
def test_numbers_beyond_their_range(value: object, quantity: Quantity, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        convert(value, quantity)


def test_the_ends_of_a_range_belong_to_it() -> None:
    assert (convert(0, UNIT_WEIGHT), convert("1 MN/m^3", UNIT_WEIGHT), convert(10_000, BOLT_COUNT)) == (0, 1e6, 10_000)
