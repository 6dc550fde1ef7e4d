"""Checks of the parameters of a case: every fault is collected, then raised as one error."""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Collection, Mapping
from numbers import Integral, Real

from bsm_mesh.geometries.errors import GeometryError, nearest_name


class ParameterChecks:
    """Collects the faults of the parameters of one case: first those that it does not have.

    Parameters
    ----------
    build : callable
        The case's ``build``; its module's name is the first word of each fault.
    unknown : mapping of str to object
        What it was given beside its own parameters; for each there is a fault, with the nearest one that it has.

    Attributes
    ----------
    faults : list of str
        The sentences collected so far.
    """

    def __init__(self, build: Callable[..., object], unknown: Mapping[str, object]) -> None:
        self.case = build.__module__.rpartition(".")[2]
        self.faults: list[str] = []
        takes = inspect.signature(build).parameters.values()
        known = [parameter.name for parameter in takes if parameter.kind is parameter.KEYWORD_ONLY]
        for name in unknown:
            self.add(f"there is no parameter '{name}'{nearest_name(name, known)}")

    def add(self, fault: str) -> None:
        """Add the sentence `fault`, with the name of the case before it."""
        self.faults.append(f"{self.case}: {fault}")

    def positive(self, unit: str = "m", /, **values: object) -> bool:
        """Return whether all `values` are positive finite numbers; add a fault for each that is not."""
        bad = {name: value for name, value in values.items() if not _is_positive(value)}
        for name, value in bad.items():
            self.add(f"{name} = {value!r} is not a positive number; give {name} in {unit}, greater than 0")
        return not bad

    def positive_or_none(self, unit: str = "m", /, **values: object) -> bool:
        """Return whether all `values` are positive or None: where not given another value stands for them."""
        return self.positive(unit, **{name: value for name, value in values.items() if value is not None})

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
