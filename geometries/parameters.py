"""Checks of the parameters of a case: every fault is collected, then raised as one error."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from numbers import Integral, Real

from geometries.errors import GeometryError, nearest_name


class ParameterChecks:
    """Collects the faults of the parameters of one case.

    Parameters
    ----------
    case : str
        Name of the case, the first word of each fault.

    Attributes
    ----------
    faults : list of str
        The sentences collected so far.
    """

    def __init__(self, case: str) -> None:
        self.case = case
        self.faults: list[str] = []

    def add(self, fault: str) -> None:
        """Add the sentence `fault`, with the name of the case before it."""
        self.faults.append(f"{self.case}: {fault}")

    def refuse_unknown(self, unknown: Mapping[str, object], known: Collection[str]) -> None:
        """Add a fault for each parameter that the case does not have, with the nearest one that it has."""
        for name in unknown:
            self.add(f"there is no parameter '{name}'{nearest_name(name, known)}")

    def positive(self, unit: str = "m", /, **values: object) -> bool:
        """Return whether all `values` are positive finite numbers; add a fault for each that is not."""
        bad = {name: value for name, value in values.items() if not _is_positive(value)}
        for name, value in bad.items():
            self.add(f"{name} = {value!r} is not a positive number; give {name} in {unit}, greater than 0")
        return not bad

    def count(self, least: int = 1, /, **values: object) -> bool:
        """Return whether all `values` are whole numbers of at least `least`; add a fault for each that is not."""
        bad = {name: value for name, value in values.items() if not _is_count(value, least)}
        for name, value in bad.items():
            self.add(f"{name} = {value!r} is not a whole number of at least {least}; give one")
        return not bad

    def within(self, low: float, high: float, unit: str, **values: object) -> bool:
        """Return whether all `values` lie from `low` to less than `high`; add a fault for each that does not."""
        bad = {name: value for name, value in values.items() if not _is_within(value, low, high)}
        for name, value in bad.items():
            self.add(f"{name} = {value!r} does not lie from {low:g} to less than {high:g} {unit}; give one that does")
        return not bad

    def one_of(self, allowed: Collection[object], **values: object) -> bool:
        """Return whether all `values` are among `allowed`; add a fault for each that is not."""
        bad = {name: value for name, value in values.items() if not _is_one_of(value, allowed)}
        choices = ", ".join(repr(known) for known in allowed)
        for name, value in bad.items():
            texts = [known for known in allowed if isinstance(known, str)]
            hint = nearest_name(value, texts).partition(" (")[0] if isinstance(value, str) else ""
            self.add(f"{name} = {value!r} is not known{hint}; give one of {choices}")
        return not bad

    def true_or_false(self, **values: object) -> bool:
        """Return whether all `values` are True or False; add a fault for each that is not."""
        return self.one_of((True, False), **values)

    def group_part(self, **values: object) -> bool:
        """Return whether all `values` can name a group; add a fault for each that cannot."""
        bad = {n: v for n, v in values.items() if not isinstance(v, str) or not v.strip() or v != v.strip()}
        for name, value in bad.items():
            self.add(f"{name} = {value!r} cannot name a group; give a text without spaces at its ends")
        return not bad

    def raise_faults(self) -> None:
        """Raise one `GeometryError` for all faults; do nothing if there are none."""
        if self.faults:
            raise GeometryError(self.faults)


def _is_positive(value: object) -> bool:
    if isinstance(value, bool) or not isinstance(value, Real | Integral):
        return False
    number = float(value)
    return math.isfinite(number) and number > 0.0


def _is_count(value: object, least: int) -> bool:
    return isinstance(value, Integral) and not isinstance(value, bool) and int(value) >= least


def _is_within(value: object, low: float, high: float) -> bool:
    return isinstance(value, Real | Integral) and not isinstance(value, bool) and low <= float(value) < high


def _is_one_of(value: object, allowed: Collection[object]) -> bool:
    # True == 1 in Python, yet an order of True is a slip.
    return any(value == known and isinstance(value, bool) == isinstance(known, bool) for known in allowed)
