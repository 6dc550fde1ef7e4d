"""The random slopes behind plastic collapse: one of them, beyond its limit and below."""

import numpy as np
import pytest

from benchmarks.plastic_slopes import Count, ask_below, ask_beyond, drawn, limit


@pytest.mark.slow
def test_a_slope_collapses_beyond_its_limit_and_not_below():
    model = drawn(np.random.default_rng(3))
    low, high = limit(model)
    assert low < high <= 1.02 * low
    beyond, below = Count(), Count()
    ask_beyond(model, high, beyond)
    ask_below(model, low, below)
    assert (beyond.asked, beyond.called) == (1, 1)
    assert below.asked > 2
    assert below.called == 0
    assert 0 < below.nearest < 1
