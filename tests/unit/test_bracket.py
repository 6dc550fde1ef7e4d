"""The search for a limit: brackets contain it, close, and count undecided values as neither."""

import math
from itertools import pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bsm_mesh.safety.bracket import Bracket, Judged, Range, Verdict, bracket_of, next_values

TOLERANCE = 0.005


def factors(bound=None, first=1.0):
    return Range(good=0.05, bad=20.0, first=first, bound=bound, tolerance=TOLERANCE, is_factor=True)


def search(within, verdict_of, count=1, most=80):
    """Return the bracket that the search ends with, and how many values it tried."""
    tried = [] if within.bound is None else [Judged(value=within.bound, verdict=Verdict.UNSTABLE)]
    number = 0
    while number < most and (values := next_values(tried, within, count)):
        number += len(values)
        tried += [Judged(value=value, verdict=verdict_of(value)) for value in values]
    return bracket_of(tried, within), number


def fails_from(limit):
    return lambda value: Verdict.STABLE if value < limit else Verdict.UNSTABLE


@given(limit=st.floats(0.06, 19.0), above=st.floats(1.0, 1.6), count=st.integers(1, 4), knows=st.booleans())
@settings(deadline=None, max_examples=200)
def test_brackets_contain_the_limit(limit, above, count, knows):
    bound = limit * above * (1 + 1e-6) if knows and limit * above < 19 else None
    first = 1.0 if bound is None or bound > 1 else bound * (1 - 0.8 * TOLERANCE)
    found, number = search(factors(bound, first), fails_from(limit), count)
    assert found.stable < limit <= found.unstable * (1 + 1e-12)
    assert math.log(found.unstable / found.stable) <= TOLERANCE * (1 + 1e-9)
    assert number <= 40 * count


def test_a_bound_that_is_the_limit_takes_two_trials():
    assert search(factors(1.4535), fails_from(1.4534))[1] == 2


def test_undecided_values_are_neither():
    """They stay in the bracket, and its parts on both sides are made as narrow as asked."""

    def verdict_of(value):
        return Verdict.UNDECIDED if 1.29 < value < 1.31 else fails_from(1.3)(value)

    found, _ = search(factors(), verdict_of)
    assert found.undecided
    ends = [found.stable, *found.undecided, found.unstable]
    assert found.stable <= 1.29 * (1 + TOLERANCE)
    assert found.unstable >= 1.31 * (1 - TOLERANCE)
    assert all(math.log(b / a) <= TOLERANCE * (1 + 1e-9) for a, b in pairwise(ends))


def test_where_nothing_fails_or_nothing_stands():
    assert search(factors(), lambda value: Verdict.STABLE)[0] == Bracket(stable=pytest.approx(20.0), unstable=None)
    found, number = search(factors(), lambda value: Verdict.UNSTABLE)
    assert (found.stable, found.unstable) == (None, pytest.approx(0.05))
    assert number < 40


def test_the_first_failure_counts_where_stable_values_follow():
    values = [(1.0, "stable"), (1.2, "unstable"), (1.4, "stable"), (1.6, "unstable"), (1.1, "undecided")]
    found = bracket_of([Judged(value=v, verdict=Verdict(text)) for v, text in values], factors())
    assert found == Bracket(stable=1.0, unstable=1.2, undecided=(1.1,), stable_beyond=(1.4,))


@pytest.mark.parametrize(("good", "bad"), [(40.0, 10.0), (0.0, 0.5), (-3.0, 2.0)])
def test_ranges_run_either_way(good, bad):
    """Friction fails downwards, an earthquake upwards; the ends are tried first."""
    within = Range(good=good, bad=bad, first=good, tolerance=TOLERANCE, is_factor=False)
    limit = good + 0.37 * (bad - good)

    def verdict_of(value):
        return Verdict.STABLE if abs(value - good) < abs(limit - good) else Verdict.UNSTABLE

    found, number = search(within, verdict_of)
    assert abs(found.stable - good) < abs(limit - good) <= abs(found.unstable - good)
    assert abs(found.unstable - found.stable) <= TOLERANCE * abs(bad - good)
    assert number == 10


def test_a_range_whose_good_end_fails():
    within = Range(good=40.0, bad=10.0, first=40.0, tolerance=TOLERANCE, is_factor=False)
    assert search(within, lambda value: Verdict.UNSTABLE) == (Bracket(stable=None, unstable=40.0), 1)
