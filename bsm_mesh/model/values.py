"""Rules for single numbers in the model, each broken rule one sentence."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import fields
from numbers import Real
from typing import Any, SupportsFloat

import numpy as np


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

    def number(
        self,
        name: str,
        value: object,
        unit: str,
        *,
        optional: bool = False,
        above: float = -math.inf,
        least: float = -math.inf,
        below: float = math.inf,
        most: float = math.inf,
    ) -> None:
        """Demand a finite number (of Python or NumPy) in a range; None (not given) passes where `optional`."""
        if value is None and optional:
            return
        if not is_number(value):
            shown = f"{self.thing}: {name} = {value!r} is not a finite number"
            self.faults.append(f"{shown} [{unit}]" if unit else shown)
            return
        assert isinstance(value, SupportsFloat)
        value = float(value)
        for holds, rule in (
            (value > above, f"be above {above:g}"),
            (value >= least, f"be {least:g} or more"),
            (value < below, f"be below {below:g}"),
            (value <= most, f"be {most:g} or less"),
        ):
            if not holds:
                self.faults.append(f"{self.thing}: {name} = {value:g} {unit}".rstrip() + f" must {rule}")

    def point(self, name: str, value: object, unit: str) -> tuple[float, float]:
        """Demand two finite numbers, and return them; zeros where the rule is broken."""
        parts = list(value) if isinstance(value, Iterable) and not isinstance(value, str) else []
        if len(parts) != 2:
            self.faults.append(f"{self.thing}: {name} = {value!r} must be two numbers (x, y) [{unit}]")
            return 0.0, 0.0
        before = len(self.faults)
        for axis, part in zip("xy", parts, strict=True):
            self.number(f"{name} {axis}", part, unit)
        return (float(parts[0]), float(parts[1])) if len(self.faults) == before else (0.0, 0.0)

    def name(self, value: object) -> None:
        """Demand a non-empty text as the thing's name."""
        if not isinstance(value, str) or not value.strip():
            self.faults.append(f"{self.thing}: the name must be a non-empty text")
