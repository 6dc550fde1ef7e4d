"""Numbers with units in the model file: ``"6.89 GPa"``, ``"26 kN/m^3"``, ``"69 kPa"``."""

from __future__ import annotations

import re
from functools import cache
from typing import Annotated, Any

from pydantic import BeforeValidator, PlainValidator, WithJsonSchema

EXAMPLES = {
    "Pa": "69 kPa",
    "Pa/m": "5 GPa/m",
    "N/m^3": "26 kN/m^3",
    "m": "25 mm",
    "N/m": "120 kN/m",
    "N": "100 kN",
    "degree": "35 deg",
}
GREATEST = 1e30  # in SI units; nothing in rock is greater, and products of such numbers are still finite
NUMBER = r"\s*(?P<number>[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?|[-+]?(?:nan|inf))\s*(?P<unit>[^\d\s,;+-][^,;+]*)?"


@cache
def _registry() -> Any:
    import pint  # half a second: only where a file bears a unit

    return pint.UnitRegistry()


def convert(value: object, unit: str) -> float:
    """Return a number in `unit`, from a number (already in it) or a text with a unit.

    Parameters
    ----------
    value : float or str
        What the file says.
    unit : str
        An SI unit as in `EXAMPLES`.

    Raises
    ------
    ValueError
        If the text cannot be read or has another dimension, or the number is not finite.

    Examples
    --------
    >>> convert("6.89 GPa", "Pa")
    6890000000.0
    >>> convert(35, "degree")
    35.0
    """
    example = f'"{EXAMPLES.get(unit, "1 " + unit)}"'
    if isinstance(value, bool) or not isinstance(value, str | int | float):
        raise ValueError(f"needs a number [{unit}] or a text with a unit such as {example}")
    number = _from_text(value, unit, f"give {unit}, for example {example}") if isinstance(value, str) else value
    if not abs(number) < GREATEST:
        raise ValueError(f"is no finite number below {GREATEST:g} [{unit}]")
    return float(number)


def _from_text(text: str, unit: str, cure: str) -> float:
    import pint

    parts = re.fullmatch(NUMBER, text)
    if parts is None:
        comma = " (a comma is no decimal point)" if "," in text else ""
        raise ValueError(f"not a number with a unit{comma}; {cure}")
    if not parts["unit"]:
        raise ValueError(f"a text without a unit; write a plain number (in {unit}) or {cure}")
    try:
        quantity = _registry().Quantity(float(parts["number"]), _spelled_out(parts["unit"]))
    except pint.UndefinedUnitError as error:
        raise ValueError(f"the unit {error.unit_names[0]} is unknown; {cure}") from None
    except Exception:  # pint lets through whatever its tokenizer raises
        raise ValueError(f"not a number with a unit; {cure}") from None
    try:
        if quantity.unitless:  # a percentage is no angle
            raise pint.DimensionalityError(quantity.units, unit)
        return float(f"{quantity.to(unit).magnitude:.15g}")  # 26 kN is 26000, not 26000.000000000004
    except pint.DimensionalityError:
        density = " (a density: its unit weight is g = 9.81 m/s^2 times it)" if quantity.check("[density]") else ""
        raise ValueError(f"is in {quantity.units:~P}{density}, which does not convert to {unit}; {cure}") from None


def _spelled_out(unit: str) -> str:
    """Return a unit as pint reads it: m3 and m³ are m^3."""
    if re.search(r"\^[^*/]*\^", unit.replace("**", "^")):  # towers of powers take pint for ever
        raise ValueError(unit)
    return re.sub(r"\b(m|cm|mm|ft|in)([23])\b", r"\1^\2", unit.replace("³", "^3").replace("²", "^2"))


def quantity(unit: str) -> Any:
    """Return the pydantic type of a number in `unit` that may be given as a text with a unit."""
    return Annotated[
        float,
        BeforeValidator(lambda value: convert(value, unit)),
        WithJsonSchema(_schema(unit)),
    ]


def _schema(unit: str) -> dict[str, Any]:
    return {
        "anyOf": [{"type": "number"}, {"type": "string"}],
        "description": f"in {unit}, or a text with its unit",
        "examples": [EXAMPLES.get(unit, f"1 {unit}")],
    }


def pair(unit: str) -> Any:
    """Return the pydantic type of a pair such as a point [x, y]."""

    def read(value: object) -> tuple[float, float]:
        if not isinstance(value, list | tuple) or len(value) != 2:
            raise ValueError(f"needs two numbers [x, y] in {unit}")
        return convert(value[0], unit), convert(value[1], unit)

    number = _schema(unit)
    return Annotated[
        Any,
        PlainValidator(read),
        WithJsonSchema({"type": "array", "items": number, "minItems": 2, "maxItems": 2}),
    ]


def _linear_stress(value: object) -> tuple[float, float, float]:
    if not isinstance(value, list | tuple):
        return convert(value, "Pa"), 0.0, 0.0
    if len(value) != 3:
        raise ValueError("needs one stress, or three values [c, a_x, a_y] for c + a_x x + a_y y")
    return convert(value[0], "Pa"), convert(value[1], "Pa/m"), convert(value[2], "Pa/m")


def _linear_stress_pair(value: object) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
    if not isinstance(value, list | tuple) or len(value) != 2:
        raise ValueError("needs two components [t_x, t_y], each a stress or [c, a_x, a_y]")
    return _linear_stress(value[0]), _linear_stress(value[1])


def _linear_schema() -> dict[str, Any]:
    three = {"type": "array", "items": {"type": ["number", "string"]}, "minItems": 3, "maxItems": 3}
    return {"anyOf": [{"type": "number"}, {"type": "string"}, three], "description": "Pa, or [c, a_x, a_y]"}


LinearStress = Annotated[Any, PlainValidator(_linear_stress), WithJsonSchema(_linear_schema())]
LinearStressPair = Annotated[
    Any,
    PlainValidator(_linear_stress_pair),
    WithJsonSchema({"type": "array", "items": _linear_schema(), "minItems": 2, "maxItems": 2}),
]


def _line(value: object) -> Any:
    if not isinstance(value, list | tuple) or not value:
        raise ValueError("needs points [[x, y], ...] in m")
    read = []
    for point in value:
        if not isinstance(point, list | tuple) or len(point) != 2:
            raise ValueError("needs points [[x, y], ...] in m")
        read.append((convert(point[0], "m"), convert(point[1], "m")))
    return tuple(read)


def _lines(value: object) -> Any:
    """Return one line or several as several."""
    if not isinstance(value, list | tuple):
        raise ValueError("needs points [[x, y], ...] in m, or several such lists")
    if not value:
        return ()
    first = value[0]
    several = isinstance(first, list | tuple) and len(first) > 0 and isinstance(first[0], list | tuple)
    return tuple(_line(line) for line in (value if several else [value]))


def _level(value: object) -> Any:
    return _line(value) if isinstance(value, list | tuple) else convert(value, "m")


_POINTS = {"type": "array", "items": {"type": "array", "items": _schema("m"), "minItems": 2, "maxItems": 2}}
Lines = Annotated[
    Any, PlainValidator(_lines), WithJsonSchema({"anyOf": [_POINTS, {"type": "array", "items": _POINTS}]})
]
Level = Annotated[Any, PlainValidator(_level), WithJsonSchema({"anyOf": [*_schema("m")["anyOf"], _POINTS]})]


def _region(value: object) -> Any:
    if isinstance(value, str) or (isinstance(value, int) and not isinstance(value, bool)):
        return value
    try:
        points = _line(value)
    except ValueError:
        points = ()
    if len(points) < 3:
        raise ValueError("must be the name of an excavation group, a block's number, or a polygon [[x, y], ...] in m")
    return points


Region = Annotated[
    Any, PlainValidator(_region), WithJsonSchema({"anyOf": [{"type": "string"}, {"type": "integer"}, _POINTS]})
]


def _plain(value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) < GREATEST:
        raise ValueError("must be a plain finite number, without quotes")
    return float(value)


Number = Annotated[float, PlainValidator(_plain), WithJsonSchema({"type": "number"})]
Point = pair("m")
Force = pair("N/m")
Stress = quantity("Pa")
Stiffness = quantity("Pa/m")
UnitWeight = quantity("N/m^3")
Length = quantity("m")
Angle = quantity("degree")
ForceOfOne = quantity("N")
ForcePerLength = quantity("N/m")
