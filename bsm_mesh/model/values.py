"""Rules for single numbers in the model, each broken rule one sentence."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable
from dataclasses import fields
from numbers import Integral, Real
from typing import Any, SupportsFloat

import numpy as np

from bsm_mesh.model.quantities import COORDINATE, Quantity, quantities_of


def is_number(value: object) -> bool:
    """Return whether `value` is a finite real number; truth values are none."""
    return isinstance(value, Real) and not isinstance(value, bool) and math.isfinite(value)


def plain_numbers(owner: Any) -> None:
    """Replace the NumPy scalars in a frozen dataclass by Python's numbers: float32 would take sums down with it."""
    for field in fields(owner):
        value = getattr(owner, field.name)
        if isinstance(value, np.number):
            object.__setattr__(owner, field.name, value.item())


class Rules:
    """Collects what is wrong with the values of one named thing.

    Parameters
    ----------
    thing : str
        What the values belong to, for example ``"rock 'gneiss'"``.
    """

    def __init__(self, thing: str) -> None:
        self.thing = thing
        self.faults: list[str] = []

    def numbers(self, owner: Any, *, without: Collection[str] = ()) -> None:
        """Hold every field of a dataclass that bears a `Quantity` to its range."""
        owner_type: type = type(owner)
        for name, (quantity, optional) in quantities_of(owner_type).items():
            if name not in without:
                self.number(name, getattr(owner, name), quantity, optional=optional)

    def number(self, name: str, value: object, quantity: Quantity, *, optional: bool = False) -> None:
        """Demand a finite number (of Python or NumPy) in its range; None (not given) passes where `optional`."""
        if value is None and optional:
            return
        if not is_number(value):
            unit = f" [{quantity.unit}]" if quantity.unit else ""
            self.faults.append(f"{self.thing}: {name} = {value!r} is not a finite number{unit}")
            return
        assert isinstance(value, SupportsFloat)
        if (quantity.whole and not isinstance(value, Integral)) or not quantity.holds(float(value)):
            shown = f"{value!r}" if quantity.whole else f"{float(value):g} {quantity.unit}".rstrip()
            self.faults.append(f"{self.thing}: {name} = {shown} {quantity.rule}")

    def point(self, name: str, value: object, quantity: Quantity = COORDINATE) -> tuple[float, float]:
        """Demand two numbers in their range, and return them; zeros where the rule is broken."""
        parts = list(value) if isinstance(value, Iterable) and not isinstance(value, str) else []
        if len(parts) != 2:
            self.faults.append(f"{self.thing}: {name} = {value!r} must be two numbers (x, y) [{quantity.unit}]")
            return 0.0, 0.0
        before = len(self.faults)
        for axis, part in zip("xy", parts, strict=True):
            self.number(f"{name} {axis}", part, quantity)
        return (float(parts[0]), float(parts[1])) if len(self.faults) == before else (0.0, 0.0)

    def name(self, value: object) -> None:
        """Demand a non-empty text as the thing's name."""
        if not isinstance(value, str) or not value.strip():
            self.faults.append(f"{self.thing}: the name must be a non-empty text")
