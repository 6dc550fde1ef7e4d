"""Numbers with units in the model file: ``"6.89 GPa"``, ``"26 kN/m^3"``, ``"69 kPa"``, each held to its range."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from functools import cache
from typing import Annotated, Any, TypeGuard

from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler, PlainValidator, WithJsonSchema
from pydantic_core import core_schema

from bsm_mesh.model.quantities import BLOCK, COORDINATE, FORCE, STRESS, STRESS_GRADIENT, Quantity

NUMBER = r"\s*(?P<number>[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?|[-+]?(?:nan|inf))\s*(?P<unit>[^\d\s,;+-][^,;+]*)?"


PREFIXES = {"": 1.0, "c": 1e-2, "m": 1e-3, "k": 1e3, "M": 1e6, "G": 1e9}


@cache
def _registry() -> Any:
    import pint  # a fifth of a second: only where a unit is not the wanted one with a prefix

    return pint.UnitRegistry()


def _prefixed(text: str, unit: str) -> float | None:
    """Return the factor of a unit that is `unit` with a prefix, as kN/m^3 for N/m^3; None if it is another one."""
    begins_plainly = re.match(r"[A-Za-z]+(?![A-Za-z^])", unit) is not None  # mm^2 is (mm)^2
    return PREFIXES.get(text.removesuffix(unit)) if begins_plainly and text.endswith(unit) else None


def convert(value: object, quantity: Quantity) -> float:
    """Return a number in the unit of a quantity, from a number (already in it) or a text with a unit.

    Parameters
    ----------
    value : float or str
        What the file says.
    quantity : Quantity
        What it is a number of. One without a unit, or a whole number, is given plainly.

    Raises
    ------
    ValueError
        If the text cannot be read or has another dimension, or the number is not in the quantity's range.

    Examples
    --------
    >>> from bsm_mesh.model.quantities import FRICTION, YOUNG
    >>> convert("6.89 GPa", YOUNG)
    6890000000.0
    >>> convert(35, FRICTION)
    35.0
    """
    if not quantity.unit and (isinstance(value, str) or not _is_number(value)):
        raise ValueError(f"must be a {'whole' if quantity.whole else 'plain'} number, without quotes")
    if isinstance(value, str):
        number: float = _from_text(value, quantity.unit, f"give {quantity.unit}, for example {quantity.example}")
    elif _is_number(value):
        number = value
    else:
        raise ValueError(f"needs a number [{quantity.unit}] or a text with a unit such as {quantity.example}")
    if isinstance(number, float) and not math.isfinite(number):
        raise ValueError(f"is no finite number; it {quantity.rule_in_file}")
    if not quantity.holds(number) or (quantity.whole and not isinstance(number, int)):
        raise ValueError(quantity.rule_in_file)
    return number if quantity.whole else float(number)


def in_unit(value: float | str, quantity: Quantity) -> float:
    """Return a number in the unit of a quantity, whatever its range: a deviation, or a bound.

    Raises
    ------
    ValueError
        If a text cannot be read, or has another dimension.
    """
    if not isinstance(value, str):
        return float(value)
    if not quantity.unit:
        raise ValueError("must be a plain number, without quotes")
    return _from_text(value, quantity.unit, f"give {quantity.unit}, for example {quantity.example}")


def number_of(value: float | str, quantity: Quantity | None) -> float:
    """Return a number that a key takes, in the key's unit, whatever its range; of keys of no one kind a plain number.

    Raises
    ------
    ValueError
        If a text cannot be read or has another dimension, or the number is not finite.
    """
    if quantity is None and isinstance(value, str):
        raise ValueError("needs a plain number here, without quotes, in SI units")
    number = float(value) if quantity is None else in_unit(value, quantity)
    if not math.isfinite(number):
        raise ValueError("is no finite number")
    return number


def typed(word: str) -> float | str:
    """Return a word of a command line as a file would hold it: a number, or a text such as ``20 kPa``."""
    try:
        return float(word)
    except ValueError:
        return word


def _is_number(value: object) -> TypeGuard[int | float]:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _from_text(text: str, unit: str, cure: str) -> float:
    parts = re.fullmatch(NUMBER, text)
    if parts is None:
        comma = " (a comma is no decimal point)" if "," in text else ""
        raise ValueError(f"not a number with a unit{comma}; {cure}")
    if not parts["unit"]:
        raise ValueError(f"a text without a unit; write a plain number (in {unit}) or {cure}")
    number = float(parts["number"])
    try:
        spelled = _spelled_out(parts["unit"].strip())
    except ValueError:
        raise ValueError(f"not a number with a unit; {cure}") from None
    factor = _prefixed(spelled, unit)
    if factor is None:
        return _by_pint(number, spelled, unit, cure)
    return float(f"{number * factor:.15g}")


def _by_pint(number: float, spelled: str, unit: str, cure: str) -> float:
    import pint

    try:
        quantity = _registry().Quantity(number, spelled)
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


@dataclass(frozen=True, slots=True)
class In:
    """The pydantic type of a number of a quantity: ``Annotated[float, In(YOUNG)]``."""

    quantity: Quantity

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> core_schema.CoreSchema:
        """Read a number, or a text with a unit."""
        return core_schema.no_info_plain_validator_function(lambda value: convert(value, self.quantity))

    def __get_pydantic_json_schema__(self, core: core_schema.CoreSchema, handler: GetJsonSchemaHandler) -> Any:
        """Return the range, for editors."""
        return schema_of(self.quantity)


def schema_of(quantity: Quantity) -> dict[str, Any]:
    """Return the JSON Schema of a number with its range; where it has a unit it may be a text as well."""
    bounds = {
        "minimum": quantity.least,
        "exclusiveMinimum": quantity.above,
        "maximum": quantity.most,
        "exclusiveMaximum": quantity.below,
    }
    given = {key: bound for key, bound in bounds.items() if math.isfinite(bound)}
    number = {"type": "integer" if quantity.whole else "number", **given}
    if not quantity.unit:
        return number
    return {
        "anyOf": [number, {"type": "string"}],
        "description": f"{quantity.span}, or a text with its unit",
        "examples": [quantity.example.strip('"')],
    }


@dataclass(frozen=True, slots=True)
class Each:
    """What every entry of a list is a number of."""

    quantity: Quantity


def pair(quantity: Quantity) -> Any:
    """Return the pydantic type of a pair such as a point [x, y]."""

    def read(value: object) -> tuple[float, float]:
        if not isinstance(value, list | tuple) or len(value) != 2:
            raise ValueError(f"needs two numbers [x, y] in {quantity.unit}")
        return convert(value[0], quantity), convert(value[1], quantity)

    return Annotated[
        Any,
        PlainValidator(read),
        WithJsonSchema({"type": "array", "items": schema_of(quantity), "minItems": 2, "maxItems": 2}),
        Each(quantity),
    ]


def _linear_stress(value: object) -> tuple[float, float, float]:
    if not isinstance(value, list | tuple):
        return convert(value, STRESS), 0.0, 0.0
    if len(value) != 3:
        raise ValueError("needs one stress, or three values [c, a_x, a_y] for c + a_x x + a_y y")
    return convert(value[0], STRESS), convert(value[1], STRESS_GRADIENT), convert(value[2], STRESS_GRADIENT)


def _linear_stress_pair(value: object) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
    if not isinstance(value, list | tuple) or len(value) != 2:
        raise ValueError("needs two components [t_x, t_y], each a stress or [c, a_x, a_y]")
    return _linear_stress(value[0]), _linear_stress(value[1])


def _linear_schema() -> dict[str, Any]:
    gradient = schema_of(STRESS_GRADIENT)
    three = {"type": "array", "prefixItems": [schema_of(STRESS), gradient, gradient], "minItems": 3, "maxItems": 3}
    return {"anyOf": [*schema_of(STRESS)["anyOf"], three], "description": "Pa, or [c, a_x, a_y]"}


LinearStress = Annotated[Any, PlainValidator(_linear_stress), WithJsonSchema(_linear_schema()), STRESS]
LinearStressPair = Annotated[
    Any,
    PlainValidator(_linear_stress_pair),
    WithJsonSchema({"type": "array", "items": _linear_schema(), "minItems": 2, "maxItems": 2}),
    Each(STRESS),
]


def _line(value: object) -> Any:
    if not isinstance(value, list | tuple) or not value:
        raise ValueError("needs points [[x, y], ...] in m")
    read = []
    for point in value:
        if not isinstance(point, list | tuple) or len(point) != 2:
            raise ValueError("needs points [[x, y], ...] in m")
        read.append((convert(point[0], COORDINATE), convert(point[1], COORDINATE)))
    return tuple(read)


def lines_of(value: object) -> Any:
    """Return one line or several as several."""
    if not isinstance(value, list | tuple):
        raise ValueError("needs points [[x, y], ...] in m, or several such lists")
    if not value:
        return ()
    first = value[0]
    several = isinstance(first, list | tuple) and len(first) > 0 and isinstance(first[0], list | tuple)
    return tuple(_line(line) for line in (value if several else [value]))


def _level(value: object) -> Any:
    return _line(value) if isinstance(value, list | tuple) else convert(value, COORDINATE)


_POINTS = {"type": "array", "items": {"type": "array", "items": schema_of(COORDINATE), "minItems": 2, "maxItems": 2}}
LINES_SCHEMA: dict[str, Any] = {"anyOf": [_POINTS, {"type": "array", "items": _POINTS}]}
Lines = Annotated[Any, PlainValidator(lines_of), WithJsonSchema(LINES_SCHEMA)]
Level = Annotated[Any, PlainValidator(_level), WithJsonSchema({"anyOf": [*schema_of(COORDINATE)["anyOf"], _POINTS]})]


def _region(value: object) -> Any:
    if isinstance(value, str):
        return value
    if isinstance(value, int) and not isinstance(value, bool):
        return convert(value, BLOCK)
    try:
        points = _line(value)
    except ValueError:
        points = ()
    if len(points) < 3:
        raise ValueError("must be the name of an excavation group, a block's number, or a polygon [[x, y], ...] in m")
    return points


Region = Annotated[
    Any, PlainValidator(_region), WithJsonSchema({"anyOf": [{"type": "string"}, schema_of(BLOCK), _POINTS]})
]


Point = pair(COORDINATE)
Force = pair(FORCE)
