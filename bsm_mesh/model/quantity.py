"""A kind of number: its unit, its range, and how a number of it is read: ``"6.89 GPa"``, ``"26 kN/m^3"``, 35.

A dataclass carries it at its field, ``young: Annotated[float, YOUNG]``. Pydantic reads the field of a model file by it.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from functools import cache
from typing import Any, TypeGuard

from bsm_mesh.named_units import STRESSES, UNIT_WEIGHTS

NUMBER = r"\s*(?P<number>[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?|[-+]?(?:nan|inf))\s*(?P<unit>[^\d\s,;+-][^,;+]*)?"


PREFIXES = {"": 1.0, "c": 1e-2, "m": 1e-3, "k": 1e3, "M": 1e6, "G": 1e9}


@dataclass(frozen=True, slots=True, kw_only=True)
class Quantity:
    """A kind of number.

    Attributes
    ----------
    unit : str
        As pint reads it; empty for a pure number.
    part_of : str
        Of a pure number that is a part of something: the words behind it.
    above, least, below, most : float
        The range: more than `above`, `least` or more, less than `below`, `most` or less.
    usual : pair of float, optional
        Usual values, both ends included; elsewhere a number is noted.
    usual_why : str
        Meaning of a value beyond the usual, for the note.
    example : str
        How it may be given in the model file.
    why : str
        Fault of a value beyond the range, or the meaning, for the message.
    whole : bool
        Whether it must be a whole number.
    doubtful : (float, float)
        A plain number of a model file from the first to below the second needs its unit: most likely it is in another.

    Examples
    --------
    >>> from bsm_mesh.model.quantities import FRICTION
    >>> FRICTION.holds(35), FRICTION.holds(90), FRICTION.rule
    (True, False, 'must be at least 0 and below 90 degrees')
    """

    unit: str = ""
    part_of: str = ""
    above: float = -math.inf
    least: float = -math.inf
    below: float = math.inf
    most: float = math.inf
    usual: tuple[float, float] | None = None
    usual_why: str = ""
    example: str
    why: str = ""
    whole: bool = False
    doubtful: tuple[float, float] = (0.0, 0.0)

    def holds(self, value: float) -> bool:
        """Return whether a number is in the range; NaN is in none."""
        return self.above < value < self.below and self.least <= value <= self.most

    def needs_unit(self, value: float) -> bool:
        """Return whether a plain number is so unusual that a model file must give its unit."""
        return self.doubtful[0] <= value < self.doubtful[1]

    def in_file(self, value: Any) -> Any:
        """Return a value as a model file takes it: a number that needs its unit as a text."""
        is_doubtful = isinstance(value, int | float) and self.needs_unit(value)
        return f"{value!r} {self.unit}" if is_doubtful else value

    @property
    def span(self) -> str:
        """The range in words, with its unit."""
        if self.above == -math.inf and self.below == math.inf:
            text = f"{shown(self.least)} to {shown(self.most)}"
        else:
            low = f"above {shown(self.above)}" if self.above > -math.inf else f"at least {shown(self.least)}"
            high = f"below {shown(self.below)}" if self.below < math.inf else f"at most {shown(self.most)}"
            text = f"{low} and {high}"
        return f"{text} {self.unit}".rstrip()

    @property
    def usual_span(self) -> str:
        """The usual range in words, with its unit; empty where anything is usual."""
        if self.usual is None:
            return ""
        return f"{shown(self.usual[0])} to {shown(self.usual[1])} {self.unit}".rstrip()

    @property
    def rule(self) -> str:
        """The rule of a number, and its reason."""
        return self._rule("")

    @property
    def rule_in_file(self) -> str:
        """The rule of a number of a model file, its form, and its reason."""
        return self._rule(f", for example {self.example}")

    def _rule(self, example: str) -> str:
        whole = "a whole number, " if self.whole else ""
        return f"must be {whole}{self.span}{example}" + (f"; {self.why}" if self.why else "")

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> Any:
        """Read a number of a model file, or a text with a unit, where a type carries this quantity."""
        from pydantic_core import core_schema

        return core_schema.no_info_plain_validator_function(
            lambda value: convert(value, self),
            serialization=core_schema.plain_serializer_function_ser_schema(self.in_file, when_used="json"),
        )

    def __get_pydantic_json_schema__(self, core: Any, handler: Any) -> Any:
        """Return the range, for editors."""
        return schema_of(self)


def shown(number: float) -> str:
    """Return a number as it is written by hand.

    Examples
    --------
    >>> shown(1e6), shown(0.0001), shown(5000)
    ('1e6', '1e-4', '5000')
    """
    if number == 0 or 1e-3 <= abs(number) < 1e6:
        return f"{number:g}"
    digits, power = f"{number:e}".split("e")
    return f"{float(digits):g}e{int(power)}"


@cache
def _registry() -> Any:
    import pint  # a fifth of a second: only where a unit is not the wanted one with a prefix

    registry = pint.UnitRegistry()
    for units, unit in ((STRESSES, "pascal"), (UNIT_WEIGHTS, "newton / meter ** 3")):
        for name, factor in units.items():
            if name.isalpha() and name not in registry:  # pounds per square foot, kips per cubic foot
                registry.define(f"{name} = {factor!r} * {unit}")
    return registry


def _prefixed(text: str, unit: str) -> float | None:
    """Return the factor of a unit that is `unit` with a prefix, as kN/m^3 for N/m^3; None if it is another one."""
    begins_plainly = re.match(r"[A-Za-z]+(?![A-Za-z^])", unit) is not None  # mm^2 is (mm)^2
    return PREFIXES.get(text.removesuffix(unit)) if begins_plainly and text.endswith(unit) else None


def convert(value: object, quantity: Quantity) -> float:
    """Return a number in the unit of a quantity, from a number (already in it) or a text with a unit.

    Parameters
    ----------
    value : float or str
        The input of the file.
    quantity : Quantity
        The quantity of the number. One without a unit, or a whole number, is given plainly.

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
    if not isinstance(value, str) and quantity.needs_unit(number):
        raise ValueError(
            f"a number without a unit is in {quantity.unit}, and {quantity.usual_span} is usual; write the unit, for "
            f'example {quantity.example}, or "{shown(number)} {quantity.unit}" if that is meant'
        )
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
        said = (
            f"is in {quantity.units:~P}{density}, which does not convert to {unit}{_as_a_force(spelled, unit)}; {cure}"
        )
        raise ValueError(said) from None


def _as_a_force(spelled: str, unit: str) -> str:
    """Return the unit meant where a force is written as a mass, for the message: lb/ft^3 for lbf/ft^3."""
    force = re.sub(r"\b(lb|kg|t)\b", r"\1f", spelled)
    meant = force != spelled and _registry().is_compatible_with(force, unit)
    return f"; of a force write {force}" if meant else ""


def _spelled_out(unit: str) -> str:
    """Return a unit as pint reads it: m3 and m³ are m^3."""
    if re.search(r"\^[^*/]*\^", unit.replace("**", "^")):  # towers of powers take pint for ever
        raise ValueError(unit)
    return re.sub(r"\b(m|cm|mm|ft|in)([23])\b", r"\1^\2", unit.replace("³", "^3").replace("²", "^2"))


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
