"""Values that go wrong: numbers at the ends of what there is, texts of any kind, objects of another type."""

from __future__ import annotations

import copy
from random import Random
from typing import Any

import numpy as np

NUMBERS: list[Any] = [
    0,
    -0.0,
    1,
    -1,
    0.5,
    2,
    90,
    -90,
    360,
    1e-320,
    1e-30,
    1e-12,
    1e-6,
    1e-3,
    1e3,
    1e6,
    1e12,
    1e15,
    1e29,
    1e30,
    1e154,
    1e200,
    1.7e308,
    -1e29,
    -1e200,
    float("inf"),
    -float("inf"),
    float("nan"),
    2**31 - 1,
    2**31,
    2**53 + 1,
    2**63,
    2**64,
    10**18,
    -(2**63),
]
FACTORS = [0.0, -1.0, 1e-12, 1e-6, 1e-3, 0.1, 0.5, 0.9, 1.1, 2.0, 10.0, 1e3, 1e6, 1e12]
TEXTS = [
    "",
    " ",
    "a",
    "x" * 3000,
    "\x00",
    "a\x00b",
    "\x1b[31mred\x1b[0m",
    "\x07bell",
    "a\nb",
    "tab\there",
    "Größe",
    "岩盤",
    "\u202eright to left",
    "nan",
    "inf",
    "1",
    "1e400",
    "1,5",
    "-",
    "1e999 Pa",
    "..",
    "../x",
    "no/such/file",
    "%s",
    "{0}",
    "'",
    '"',
    "$(x)",
    "rock:",
    ":",
    "rock:a:b",
    "true",
    "None",
    "0x10",
    "1_000",
    "١٢",
]
UNITS = [
    "",
    "Pa",
    "kPa",
    "MPa",
    "GPa",
    "Kpa",
    "kN/m^3",
    "N/m",
    "kN",
    "mm",
    "m",
    "km",
    "Ym",
    "deg",
    "rad",
    "1/m",
    "GPa/m",
    "kg/m^3",
    "%",
    "s",
]


class Thing:
    """An object of a class that nobody knows."""

    def __repr__(self) -> str:
        return "Thing()"


def wrong_type(random: Random) -> Any:
    """Return a value of a type that is hardly ever right."""
    return random.choice(
        [
            lambda: None,
            lambda: True,
            lambda: Thing(),
            lambda: b"bytes",
            lambda: [],
            lambda: (),
            lambda: {},
            lambda: {"a": 1},
            lambda: {1, 2},
            lambda: [[]],
            lambda: [None],
            lambda: [[1, 2], [3]],
            lambda: 1j,
            lambda: range(3),
            lambda: np.array([]),
            lambda: np.zeros((2, 2, 2)),
            lambda: np.array(["a", "b"]),
            lambda: np.array([None, 1], dtype=object),
            lambda: np.array([1 + 1j]),
            lambda: np.float32(2.5),
            lambda: np.int8(-3),
            lambda: np.bool_(True),
            lambda: np.datetime64("2026-11-24"),
            lambda: float,
            lambda: iter([1, 2]),
            lambda: random.choice(TEXTS),
            lambda: random.choice(NUMBERS),
        ]
    )()


def number(random: Random, given: Any) -> Any:
    """Return another number in place of one."""
    kind = random.random()
    if kind < 0.4:
        return random.choice(NUMBERS)
    if kind < 0.8:
        try:
            changed = given * random.choice(FACTORS)
            return type(given)(changed)
        except (TypeError, ValueError, OverflowError):
            return given
    return random.choice(
        [
            str(given),
            f"{given} {random.choice(UNITS)}",
            [given],
            bool(given),
            random.gauss(0, 1) * 10 ** random.uniform(-9, 9),
        ]
    )


def text(random: Random, given: str) -> Any:
    """Return another text in place of one: another unit, a slip of the pen, a control character."""
    kind = random.random()
    parts = given.split(" ")
    if kind < 0.35 and len(parts) == 2:
        return random.choice(
            [
                f"{parts[0]} {random.choice(UNITS)}",
                f"{random.choice(NUMBERS)} {parts[1]}",
                parts[0],
                parts[1],
                "".join(parts),
            ]
        )
    if kind < 0.6:
        return random.choice(TEXTS)
    at = random.randrange(len(given) + 1)
    if kind < 0.85:  # a slip
        return random.choice(
            [
                given[:at] + given[at + 1 :],
                given[:at] + random.choice("aeinrst_0-. ") + given[at:],
                given.upper(),
                given + "s",
                given[::-1],
            ]
        )
    return given[:at] + random.choice(["\x00", "\x1b[2J", "\r", "\x7f", "\u2028", "é", "\ufeff"]) + given[at:]


def spoil(random: Random, given: Any, *, types: bool = True) -> Any:
    """Return a value in place of a good one: near it, of its type and extreme, or of another type.

    Parameters
    ----------
    random : Random
        Of this input.
    given : object
        The good value; it is left as it is.
    types : bool
        Whether values may come that no file can hold.
    """
    if types and random.random() < 0.2:
        return wrong_type(random)
    if isinstance(given, bool):
        return random.choice([not given, 1, "true", 0.5])
    if isinstance(given, int | float):
        return number(random, given)
    if isinstance(given, str):
        return text(random, given)
    if isinstance(given, np.ndarray):
        return _array(random, given)
    if isinstance(given, list | tuple):
        return _sequence(random, given, types)
    if isinstance(given, dict) and given:
        changed = dict(given)
        key = random.choice(list(changed))
        changed[key] = spoil(random, changed[key], types=types)
        return changed
    return wrong_type(random) if types else random.choice([0, "", [], {}, True])


def _sequence(random: Random, given: list[Any] | tuple[Any, ...], types: bool) -> Any:
    items = list(given)
    kind = random.random()
    if not items or kind < 0.08:
        return []
    at = random.randrange(len(items))
    if kind < 0.6:
        items[at] = spoil(random, items[at], types=types)
    elif kind < 0.7:
        del items[at]
    elif kind < 0.8:
        items.insert(at, copy.copy(items[random.randrange(len(items))]))
    elif kind < 0.86:
        random.shuffle(items)
    elif kind < 0.9:
        items = [items]
    elif kind < 0.94:
        items = items[::-1]
    elif types:
        try:
            return np.array(items)
        except (ValueError, TypeError):
            return items
    return tuple(items) if isinstance(given, tuple) and random.random() < 0.9 else items


def _array(random: Random, given: Any) -> Any:
    if random.random() < 0.4 and given.size:
        changed = given.copy()
        try:
            changed.flat[random.randrange(given.size)] = random.choice(NUMBERS)
        except (ValueError, OverflowError, TypeError):
            return changed.astype(object)
        return changed
    change = random.choice(
        [
            lambda: given[:-1],
            lambda: given[..., :1],
            lambda: given.ravel(),
            lambda: given[None],
            lambda: given.T,
            lambda: given.astype(object),
            lambda: given.astype(str),
            lambda: given.tolist(),
            lambda: given[:0],
            lambda: given.astype(np.float32),
            lambda: given * 1e200,
        ]
    )
    try:
        return change()
    except (ValueError, TypeError, IndexError):  # an array without axes, of objects
        return given.tolist()
