"""What a case is, and how far an answer is from the exact one."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

ROUNDING = 1e-8  # smaller errors differ from machine to machine and are reported as smaller than this


@dataclass(frozen=True)
class Between:
    """A limit that was found from both sides, as by verdicts or by a factor of safety.

    Attributes
    ----------
    low, high : float
        The last value on one side, the first on the other.
    """

    low: float
    high: float


Value: TypeAlias = "float | str | NDArray[np.float64]"
Answer: TypeAlias = "tuple[Value, Value | Between]"


@dataclass(frozen=True, kw_only=True)
class Case:
    """One comparison with an answer from elsewhere.

    Attributes
    ----------
    name : str
        Short, in lower case: the test carries it.
    what : str
        What is checked, in words.
    source : str
        Where the exact answer comes from: a key of `verification.sources.SOURCES`.
    quantity : str
        What is compared, with its unit.
    compute : callable
        Runs the program and returns the exact answer and ours: numbers, arrays (m,), words, or ours as `Between`.
    tolerance : float
        Greatest error that is accepted, see `error_of`.
    equations : tuple of str
        Numbers of the thesis's equations that it proves.
    page : str
        Page and heading where the numbers stand already; the manual then leads there instead of repeating them.
    is_slow : bool
        Whether it is left out of the quick ones.
    """

    name: str
    what: str
    source: str
    quantity: str
    compute: Callable[[], Answer]
    tolerance: float
    equations: tuple[str, ...] = ()
    page: str = ""
    is_slow: bool = False

    @cached_property
    def answer(self) -> Answer:
        """The exact answer and ours; it is computed once."""
        return self.compute()

    @property
    def is_told_in_words(self) -> bool:
        """Whether the exact answer is words, as a verdict is."""
        return isinstance(self.answer[0], str)

    @property
    def error(self) -> float:
        """Our error, see `error_of`."""
        return error_of(*self.answer)


def error_of(exact: Value, found: Value | Between) -> float:
    """Return the greatest difference over the greatest exact number; of `Between` that of its further side.

    Words are right or not: 0 or infinite. Where all exact numbers are 0 the difference itself is returned.
    """
    if isinstance(exact, str) or isinstance(found, str):
        return 0.0 if exact == found else math.inf
    numbers = np.array([found.low, found.high]) if isinstance(found, Between) else np.asarray(found, dtype=float)
    wanted = np.asarray(exact, dtype=float)
    if not np.isfinite(numbers).all():
        return math.inf
    largest = float(np.abs(wanted).max())
    return float(np.abs(numbers - wanted).max()) / (largest or 1.0)


def limit_between(passes: Callable[[float], bool], low: float, high: float) -> Between:
    """Return the two values as a bracket of a limit: `passes` must be true at the first and false at the second.

    Where it is not so the bracket is infinite, and with it the error.
    """
    if passes(low) and not passes(high):
        return Between(low, high)
    return Between(-math.inf, math.inf)


def in_words(error: float) -> str:
    """Return an error as the manual tells it: those of rounding by what they are below."""
    if error == math.inf:
        return "wrong"
    for bound in (ROUNDING, 1e-6, 1e-4):
        if error < bound:
            return f"below {bound:.0e}".replace("e-0", "e-")
    return f"{100 * error:.2f} %"


def value_in_words(value: Value | Between) -> str:
    """Return a value as the manual tells it: up to four numbers, of more the count and the greatest; rounding as 0."""
    if isinstance(value, str):
        return value
    if isinstance(value, Between):
        return f"{value.low:.5g} to {value.high:.5g}"
    numbers = np.atleast_1d(np.asarray(value, dtype=float)).ravel()
    numbers = np.where(np.abs(numbers) > max(ROUNDING * np.abs(numbers).max(), 1e-12), numbers, 0.0)
    if numbers.size > 4:
        return f"{numbers.size} numbers up to {np.abs(numbers).max():.4g}"
    return ", ".join(f"{number:.5g}" for number in numbers)
