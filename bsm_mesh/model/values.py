"""Rules for single values in the model, numbers, texts and things, each broken rule one sentence."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping
from dataclasses import fields
from numbers import Integral, Real
from typing import Any, SupportsFloat, TypeAlias

import numpy as np

from bsm_mesh.arrays import ReadOnlyMapping, read_only
from bsm_mesh.errors import as_given, nearest, one_line
from bsm_mesh.model.quantities import COORDINATE, quantities_of
from bsm_mesh.model.quantity import Quantity

Points: TypeAlias = tuple[tuple[float, float], ...]

STRANGE = (
    "holds a line break or a control character, as no name may; rename it (a group of a mesh is renamed by [groups])"
)


def is_number(value: object) -> bool:
    """Return whether `value` is a finite real number; truth values are none."""
    try:
        return isinstance(value, Real) and not isinstance(value, bool) and math.isfinite(value)
    except OverflowError:  # a whole number of more than 308 digits
        return False


def is_infinite(value: object) -> bool:
    """Return whether `value` is infinity, which represents no limit where a key says so."""
    return isinstance(value, float | np.floating) and value == math.inf


def parts_of(value: object) -> list[Any] | None:
    """Return the parts of a list, an array or the like; None of a text, and of an object without parts."""
    if isinstance(value, str | bytes) or not isinstance(value, Iterable):
        return None
    try:
        return list(value)
    except TypeError:  # an array of no dimension says that it can be iterated
        return None


def plain_numbers(owner: Any) -> None:
    """Replace the NumPy scalars in a frozen dataclass by Python's numbers: float32 would take sums down with it."""
    for field in fields(owner):
        value = getattr(owner, field.name)
        if isinstance(value, np.number):
            object.__setattr__(owner, field.name, value.item())


def is_plain(name: str) -> bool:
    r"""Return whether a name is one line of plain text, without control characters and marks of writing direction.

    Names go into files of other programs, where a line is a command, and onto terminals.

    Examples
    --------
    >>> is_plain("J1 (süd)"), is_plain("J1\nsystem"), is_plain("J\t1")
    (True, False, False)
    """
    return "\t" not in name and one_line(name) == name


class Rules:
    """Collects the fault with the values of one named thing.

    Parameters
    ----------
    thing : str
        Owner of the values, for example ``"rock"``.
    name : object, optional
        Its name, which is behind if it is a text.
    """

    def __init__(self, thing: str, name: object = "") -> None:
        self.thing = f"{thing} '{one_line(name)}'" if isinstance(name, str) and name else thing
        self.faults: list[str] = []

    def numbers(self, owner: Any, *, without: Collection[str] = ()) -> None:
        """Hold every field of a dataclass that carries a `Quantity` to its range."""
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
            cure = "; only a model file takes texts with units" if isinstance(value, str) else ""
            self.faults.append(f"{self.thing}: {name} = {as_given(value)} is not a finite number{unit}{cure}")
            return
        assert isinstance(value, SupportsFloat)
        if (quantity.whole and not isinstance(value, Integral)) or not quantity.holds(float(value)):
            shown = as_given(value) if quantity.whole else f"{float(value):g} {quantity.unit}".rstrip()
            self.faults.append(f"{self.thing}: {name} = {shown} {quantity.rule}")

    def point(self, name: str, value: object, quantity: Quantity = COORDINATE) -> tuple[float, float]:
        """Demand two numbers in their range, and return them; zeros where the rule is broken."""
        x, y = self._numbers(name, value, quantity, (2,), "two numbers (x, y)")
        return x, y

    def place(self, name: str, value: object, quantity: Quantity = COORDINATE) -> tuple[float, ...]:
        """Demand two numbers, or three of a point in space, and return them; zeros where the rule is broken."""
        return self._numbers(name, value, quantity, (2, 3), "two numbers (x, y), or in space three (x, y, z)")

    def _numbers(
        self, name: str, value: object, quantity: Quantity, sizes: tuple[int, ...], asked: str
    ) -> tuple[float, ...]:
        """Demand so many numbers, one of `sizes`; zeros of the first size where the rule is broken."""
        parts, none = parts_of(value) or [], (0.0,) * sizes[0]
        if len(parts) not in sizes:
            unit = f" [{quantity.unit}]" if quantity.unit else ""
            self.faults.append(f"{self.thing}: {name} = {as_given(value)} must be {asked}{unit}")
            return none
        before = len(self.faults)
        for axis, part in zip("xyz", parts, strict=False):
            self.number(f"{name} {axis}", part, quantity)
        return tuple(float(part) for part in parts) if len(self.faults) == before else none

    def text(self, name: str, value: object, *, optional: bool = False, free: bool = False) -> None:
        """Demand a name, or any text where it is `free`; None (not given) passes where `optional`."""
        if not (isinstance(value, str) or (optional and value is None)):
            self.faults.append(f"{self.thing}: {name} = {as_given(value)} must be a text, in quotes")
        elif not free:
            self._plain(name, [value])

    def texts(self, name: str, value: object) -> tuple[str, ...]:
        """Demand a list of names, and return it; empty where the rule is broken."""
        parts = parts_of(value)
        if parts is None or not all(isinstance(part, str) for part in parts):
            self.faults.append(f"{self.thing}: {name} = {as_given(value)} must be a list of texts, in brackets")
            return ()
        self._plain(name, parts)
        return tuple(parts)

    def _plain(self, name: str, values: Iterable[str | None]) -> None:
        """Demand names that are one line of plain text."""
        self.faults.extend(
            f"{self.thing}: {name}: {as_given(value)} {STRANGE}"
            for value in values
            if value is not None and not is_plain(value)
        )

    def truth(self, name: str, value: object) -> None:
        """Demand True or False."""
        if not isinstance(value, bool | np.bool_):
            self.faults.append(f"{self.thing}: {name} = {as_given(value)} must be True or False")

    def choice(self, name: str, value: object, known: Collection[str]) -> None:
        """Demand one of a few texts."""
        if isinstance(value, str) and value in known:
            return
        hint = nearest(value if isinstance(value, str) else "", known)
        self.faults.append(f"{self.thing}: {name} = {as_given(value)} is unknown{hint}")

    def mapping(self, name: str, value: object) -> Mapping[str, Any]:
        """Demand a mapping by names, and return it; empty where the rule is broken."""
        if isinstance(value, Mapping) and all(isinstance(key, str) for key in value):
            self._plain(name, value)
            return value
        self.faults.append(f'{self.thing}: {name} = {as_given(value)} must be a mapping by names: {{"a name": ...}}')
        return {}

    def own_names(self, owner: Any, *, groups: Collection[str], texts: Collection[str]) -> None:
        """Make fields of a frozen dataclass its own: groups of numbers by name, and tuples of texts."""
        title = type(owner).__name__
        for name in groups:
            given = self.mapping(name, getattr(owner, name))
            own = {key: read_only(ids, np.int32, (None,), f"{title}.{name}['{key}']") for key, ids in given.items()}
            object.__setattr__(owner, name, ReadOnlyMapping(own))
        for name in texts:
            object.__setattr__(owner, name, self.texts(name, getattr(owner, name)))

    def a_thing(self, name: str, value: object, *kinds: type, optional: bool = False) -> None:
        """Demand a thing of one of some public classes; None (not given) passes where `optional`."""
        if not (isinstance(value, kinds) or (optional and value is None)):
            none = ", or None" if optional else ""
            self.faults.append(f"{self.thing}: {name} = {as_given(value)} must be {_named(kinds)}{none}")

    def things(self, name: str, value: object, *kinds: type, derived: tuple[type, ...] = ()) -> tuple[Any, ...]:
        """Demand a list of things of some public classes, and return it; empty where the rule is broken.

        Parameters
        ----------
        name : str
            Of the list.
        value : object
            The input.
        *kinds : type
            The classes.
        derived : tuple of type
            Classes of the program's own values; no message names them.
        """
        parts = parts_of(value)
        if parts is None:
            cure = "; put it in brackets" if isinstance(value, kinds) else ""
            self.faults.append(f"{self.thing}: {name} = {as_given(value)} must be a list of {_named(kinds)}{cure}")
            return ()
        bad = [(k, part) for k, part in enumerate(parts) if not isinstance(part, (*kinds, *derived))]
        self.faults.extend(
            f"{self.thing}: {name}: number {k + 1} is {as_given(part)}; it must be {_named(kinds)}" for k, part in bad
        )
        return () if bad else tuple(parts)

    def name(self, value: object) -> None:
        """Demand a non-empty text as the thing's name."""
        if not isinstance(value, str) or not value.strip():
            self.faults.append(f"{self.thing}: the name must be a non-empty text")
        elif not is_plain(value):
            self.faults.append(f"{self.thing}: the name {STRANGE}")


def line(value: Any, name: str, rules: Rules) -> Points:
    """Return the points of a line that runs from left to right; note the fault with it."""
    points = parts_of(value)
    if not points:
        rules.faults.append(
            f"{rules.thing}: {name} = {as_given(value)} must be points [[x, y], ...] from left to right [m]"
        )
        return ((0.0, 0.0),)
    before = len(rules.faults)
    found = tuple(rules.point(f"{name} point {k + 1}", point) for k, point in enumerate(points))
    if len(rules.faults) == before:
        for k in range(1, len(found)):
            if found[k][0] <= found[k - 1][0]:
                rules.faults.append(
                    f"{rules.thing}: {name} goes from x = {found[k - 1][0]:g} m to x = {found[k][0]:g} m at point "
                    f"{k + 1}; points go from left to right; for a step give two points a little apart"
                )
                break
    return found


def _named(kinds: tuple[type, ...]) -> str:
    """Return how a user writes classes: ``"bsm.Rock(...)"``."""
    return " or ".join(f"bsm.{kind.__name__}(...)" for kind in kinds)
