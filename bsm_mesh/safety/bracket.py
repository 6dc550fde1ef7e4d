"""The bracket of a limit: which value to try next, and between which values the limit lies.

A value is tried, and the trial is stable, unstable or undecided. The limit lies between the last stable value and the
first unstable one. An undecided trial counts as neither: it splits the bracket, whose parts are made smaller apart.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from enum import StrEnum
from itertools import accumulate, pairwise

FIRST_STEP, MORE = 0.03, 0.01  # towards stable values: 3 %, then more, for a bound is mostly near
GROWTH = 1.25, 1.6, 2.0, 2.5  # from a stable value on, where no bound is known


class Verdict(StrEnum):
    """Verdict of a trial on its value."""

    STABLE = "stable"
    UNSTABLE = "unstable"
    UNDECIDED = "undecided"


@dataclass(frozen=True, slots=True, kw_only=True)
class Judged:
    """A value that was tried."""

    value: float
    verdict: Verdict


@dataclass(frozen=True, slots=True, kw_only=True)
class Range:
    """Where a limit is looked for; models get worse from `good` to `bad`.

    Attributes
    ----------
    good, bad : float
        The ends: values beyond are not tried.
    first : float
        The first value tried.
    bound : float or None
        A value that is proved to be bad, and mostly near the limit.
    tolerance : float
        Width of the bracket that is small enough: over a factor's value, else over the range.
    is_factor : bool
        Whether the value is a factor: steps multiply it.
    """

    good: float
    bad: float
    first: float
    bound: float | None = None
    tolerance: float
    is_factor: bool

    def at(self, value: float) -> float:
        """Return the place of a value on a scale that grows from good to bad, on which widths are compared."""
        if self.is_factor:
            return math.log(value / self.good)
        return (value - self.good) / (self.bad - self.good)

    def value(self, place: float) -> float:
        """Return the value at a place."""
        if self.is_factor:
            return self.good * math.exp(place)
        return self.good + place * (self.bad - self.good)


@dataclass(frozen=True, slots=True)
class Bracket:
    """The bracket of the limit by trials.

    Attributes
    ----------
    stable, unstable : float or None
        The last stable value below the first unstable one, and that one; None: there is none.
    undecided : tuple of float
        Undecided values between them.
    stable_beyond : tuple of float
        Stable values beyond the first unstable one.
    """

    stable: float | None
    unstable: float | None
    undecided: tuple[float, ...] = ()
    stable_beyond: tuple[float, ...] = ()


def bracket_of(trials: Iterable[Judged], within: Range) -> Bracket:
    """Return the bracket of the limit."""
    rows = sorted((within.at(trial.value), trial) for trial in _different(trials))
    bad = [place for place, trial in rows if trial.verdict is Verdict.UNSTABLE]
    first = bad[0] if bad else math.inf
    good = [place for place, trial in rows if trial.verdict is Verdict.STABLE]
    last = max((place for place in good if place < first), default=-math.inf)
    values = {place: trial.value for place, trial in rows}
    between = [p for p, trial in rows if trial.verdict is Verdict.UNDECIDED and last < p < first]
    return Bracket(
        stable=values.get(last),
        unstable=values.get(first),
        undecided=tuple(values[place] for place in between),
        stable_beyond=tuple(values[place] for place in good if place > first),
    )


def _different(trials: Iterable[Judged]) -> list[Judged]:
    """Return one trial a value."""
    return list({trial.value: trial for trial in trials}.values())


def next_values(trials: Iterable[Judged], within: Range, count: int = 1) -> list[float]:
    """Return the values to be tried next, at most `count`; none where the bracket is closed or the range ends.

    Parameters
    ----------
    trials : iterable of Judged
        The trials.
    within : Range
        Where the limit is looked for.
    count : int
        How many trials continue at the same time.
    """
    tried = _different(trials)
    beyond = math.inf if within.bound is None else within.at(within.bound)
    if within.first != within.bound and all(within.at(trial.value) >= beyond for trial in tried):
        return [within.first]
    found = bracket_of(tried, within)
    if found.stable is None:
        return _towards_stable(tried, within)
    if found.unstable is None:
        return _towards_unstable(tried, within)
    return _inside(found, within, count)


def _towards_stable(tried: list[Judged], within: Range) -> list[float]:
    """Return a better value than all that were tried."""
    least = min(within.at(trial.value) for trial in tried)
    if least <= 0:
        return []
    if not within.is_factor:
        return [within.good]
    step = FIRST_STEP + MORE * len(tried)
    return [within.value(max(0.0, least + math.log1p(-min(step, 0.5))))]


def _towards_unstable(tried: list[Judged], within: Range) -> list[float]:
    """Return a worse value than all that were tried."""
    greatest = max(within.at(trial.value) for trial in tried)
    end = within.at(within.bad)
    if greatest >= end:
        return []
    if not within.is_factor:
        return [within.bad]
    growth = GROWTH[min(len(tried), len(GROWTH)) - 1]
    return [within.value(min(end, greatest + math.log(growth)))]


def _inside(found: Bracket, within: Range, count: int) -> list[float]:
    """Return values inside the bracket: near its bound while that is all that is known, else in its widest part."""
    assert found.stable is not None
    assert found.unstable is not None
    places = [within.at(value) for value in (found.stable, *found.undecided, found.unstable)]
    width, low, high = max((high - low, low, high) for low, high in pairwise(places))
    if width <= within.tolerance:
        return []
    chosen = [low + (high - low) * k / (count + 1) for k in range(1, count + 1)]
    if within.bound is not None:
        near = _from_bound(places[0], places[1], within, count)
        chosen = near or chosen
    return [within.value(place) for place in chosen]


def _from_bound(stable: float, nearest: float, within: Range, count: int) -> list[float]:
    """Return the next places from a bound towards the last stable one; none where halving is as good.

    `nearest` is the lowest place above `stable` that is not stable.
    """
    assert within.bound is not None
    steps = accumulate(FIRST_STEP * 2**k for k in range(8))
    first = 0.8 * within.tolerance  # closes the bracket: the bound is the limit, as often as not
    places = [within.at(within.bound) - step for step in (first, *steps)]
    worth = [p for p in places if (stable + nearest) / 2 < p < nearest - within.tolerance / 2]
    return worth[:count]
