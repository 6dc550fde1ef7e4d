"""Checks of a geometry's parameters: every fault is collected, then raised as one error."""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from numbers import Integral, Real

from bsm_mesh.errors import as_given, nearest, one_line
from bsm_mesh.geometries.errors import GeometryError


class Checks:
    """Collects the faults of the values of one thing.

    Parameters
    ----------
    thing : str
        Owner of the values; the first word of each fault.

    Attributes
    ----------
    faults : list of str
        The sentences collected so far.
    """

    def __init__(self, thing: str) -> None:
        self.thing = thing
        self.faults: list[str] = []

    @classmethod
    def of_named(cls, kind: str, name: object) -> Checks:
        """Return checks of a thing that names a group, of its name first."""
        checks = cls(f"{kind} '{name}'" if isinstance(name, str) else kind)
        checks.group_part(name=name)
        return checks

    def add(self, fault: str) -> None:
        """Add the sentence `fault`, with the name of the thing before it."""
        self.faults.append(f"{self.thing}: {fault}")

    def number(self, unit: str, /, **values: object) -> bool:
        """Return whether all `values` are finite numbers; add a fault for each that is not."""
        bad = {name: value for name, value in values.items() if not math.isfinite(_number(value))}
        for name, value in bad.items():
            self.add(f"{name} = {as_given(value)} is not a finite number; give {name} in {unit}")
        return not bad

    def points(self, least: int = 1, /, **values: object) -> bool:
        """Return whether all `values` are lines of at least `least` points; add a fault for each that is not."""
        bad = {name: value for name, value in values.items() if not _is_line(value, least)}
        for name, value in bad.items():
            self.add(f"{name} = {as_given(value)} is no line of points; give [(x, y), ...] in m, {least} or more")
        return not bad

    def vector(self, axes: str = "xyz", /, **values: object) -> bool:
        """Return whether all `values` are a finite number for each of the axes; add a fault for each that is not."""
        bad = {name: value for name, value in values.items() if not _is_vector(value, len(axes))}
        count = {2: "two", 3: "three"}[len(axes)]
        for name, value in bad.items():
            self.add(f"{name} = {as_given(value)} must be {count} numbers ({', '.join(axes)}) in m")
        return not bad

    def positive(self, unit: str = "m", /, **values: object) -> bool:
        """Return whether all `values` are positive finite numbers; add a fault for each that is not."""
        bad = {name: value for name, value in values.items() if not 0.0 < _number(value) < math.inf}
        for name, value in bad.items():
            self.add(f"{name} = {as_given(value)} is not a positive number; give {name} in {unit}, greater than 0")
        return not bad

    def positive_or_none(self, unit: str = "m", /, **values: object) -> bool:
        """Return whether all `values` are positive or None: where not given another value represents them."""
        return self.positive(unit, **{name: value for name, value in values.items() if value is not None})

    def count(self, least: int = 1, /, **values: object) -> bool:
        """Return whether all `values` are whole numbers of at least `least`; add a fault for each that is not."""
        bad = {name: value for name, value in values.items() if not _is_count(value, least)}
        for name, value in bad.items():
            self.add(f"{name} = {as_given(value)} is not a whole number of at least {least}; give one")
        return not bad

    def within(self, low: float, high: float, unit: str, **values: object) -> bool:
        """Return whether all `values` lie from `low` to less than `high`; add a fault for each that does not."""
        bad = {name: value for name, value in values.items() if not low <= _number(value) < high}
        for name, value in bad.items():
            self.add(
                f"{name} = {as_given(value)} does not lie from {low:g} to less than {high:g} {unit}; give one that does"
            )
        return not bad

    def one_of(self, allowed: Collection[object], **values: object) -> bool:
        """Return whether all `values` are among `allowed`; add a fault for each that is not."""
        bad = {name: value for name, value in values.items() if not _is_one_of(value, allowed)}
        choices = ", ".join(repr(known) for known in allowed)
        for name, value in bad.items():
            texts = [known for known in allowed if isinstance(known, str)]
            hint = nearest(value, texts).partition(" (")[0] if isinstance(value, str) else ""
            self.add(f"{name} = {as_given(value)} is not known{hint}; give one of {choices}")
        return not bad

    def true_or_false(self, **values: object) -> bool:
        """Return whether all `values` are True or False; add a fault for each that is not."""
        return self.one_of((True, False), **values)

    def group_part(self, **values: object) -> bool:
        """Return whether all `values` can name a group; add a fault for each that cannot."""
        bad = {n: v for n, v in values.items() if not isinstance(v, str) or not v.strip() or v != one_line(v).strip()}
        for name, value in bad.items():
            self.add(
                f"{name} = {as_given(value)} cannot name a group; give one line of text without spaces at its ends"
            )
        return not bad

    def group_part_or_none(self, **values: object) -> bool:
        """Return whether all `values` can name a group or are None: not given."""
        return self.group_part(**{name: value for name, value in values.items() if value is not None})

    def a_thing(self, kind: type, **values: object) -> bool:
        """Return whether all `values` are of a class; add a fault for each that is not."""
        bad = {name: value for name, value in values.items() if not isinstance(value, kind)}
        for name, value in bad.items():
            package = kind.__module__.split(".geometries.")[-1].startswith("three_d")
            self.add(
                f"{name} = {as_given(value)} must be a {kind.__name__} of geometries{'.three_d' if package else ''}"
            )
        return not bad

    def things(self, fits: Callable[[object], bool], wanted: str, **values: object) -> bool:
        """Return whether all `values` are lists of things that fit; add a fault for each that is not.

        Parameters
        ----------
        fits : callable
            Says whether a thing is one of those that are wanted.
        wanted : str
            How a user writes one.
        **values : object
            The lists, by their names.
        """
        bad = {name: value for name, value in values.items() if not _is_list(value, fits)}
        for name, value in bad.items():
            self.add(f"{name} = {as_given(value)} must be a list, in brackets, of {wanted}")
        return not bad

    def raise_faults(self) -> None:
        """Raise one `GeometryError` for all faults; do nothing if there are none."""
        if self.faults:
            raise GeometryError(self.faults)


class ParameterChecks(Checks):
    """Collects the faults of the parameters of one case: first those that it does not have.

    Parameters
    ----------
    build : callable
        The case's ``build``; its module's name is the first word of each fault.
    unknown : mapping of str to object
        Given names that are not its parameters; for each there is a fault, with the nearest one that it has.
    """

    def __init__(self, build: Callable[..., object], unknown: Mapping[str, object]) -> None:
        super().__init__(build.__module__.rpartition(".")[2])
        takes = inspect.signature(build).parameters.values()
        known = [parameter.name for parameter in takes if parameter.kind is parameter.KEYWORD_ONLY]
        for name in unknown:
            self.add(f"there is no parameter '{name}'{nearest(name, known, most=len(known))}")


def _number(value: object) -> float:
    """Return a number as a float; NaN for any other value and for a truth value."""
    if isinstance(value, bool) or not isinstance(value, Real | Integral):
        return math.nan
    try:
        return float(value)
    except OverflowError:  # a whole number of more than 308 digits
        return math.inf


def _is_line(value: object, least: int) -> bool:
    import numpy as np  # not before it is needed: a case's parameters are read without it

    try:
        points = np.asarray(value)
    except ValueError:  # lines of unequal lengths
        return False
    return (
        points.dtype.kind in "iuf"
        and points.ndim == 2
        and points.shape[1] == 2
        and len(points) >= least
        and bool(np.isfinite(points).all())
    )


def _is_list(value: object, fits: Callable[[object], bool]) -> bool:
    if isinstance(value, str | Mapping) or not isinstance(value, Sequence):
        return False
    return all(fits(each) for each in value)


def _is_vector(value: object, count: int) -> bool:
    parts = list(value) if isinstance(value, Iterable) and not isinstance(value, str) else []
    return len(parts) == count and all(math.isfinite(_number(part)) for part in parts)


def _is_count(value: object, least: int) -> bool:
    return isinstance(value, Integral) and not isinstance(value, bool) and int(value) >= least


def _is_one_of(value: object, allowed: Collection[object]) -> bool:
    # True == 1 in Python, yet an order of True is a slip.
    return any(
        isinstance(value, type(known)) and value == known and isinstance(value, bool) == isinstance(known, bool)
        for known in allowed
    )
