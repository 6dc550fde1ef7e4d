"""Sampling: moments, bounds, strata, correlations, grids and lists, and what is refused."""

from __future__ import annotations

import math

import numpy as np
import pytest

from bsm_mesh.errors import ModelError
from bsm_mesh.studies.distributions import NEEDS, Distribution
from bsm_mesh.studies.sampling import Correlation, Plan, Seeds, Values, make_plan

NORMAL = Distribution(family="normal", mean=35.0, deviation=2.0)
EVEN = (np.arange(400_000) + 0.5) / 400_000  # probabilities whose mean over a quantile function is its integral


def column(plan: Plan, key: str) -> np.ndarray:
    return np.array(plan.values[key], dtype=np.float64)


@pytest.mark.parametrize("family", ["normal", "lognormal", "gamma", "weibull", "gumbel"])
def test_moments_are_those_that_are_given(family: str) -> None:
    values = Distribution(family=family, mean=35.0, deviation=7.0).at(EVEN)
    assert values.mean() == pytest.approx(35, rel=1e-4)
    assert values.std() == pytest.approx(7, rel=2e-3)  # the tails beyond the last probability are not there


def test_moments_of_families_with_bounds_of_their_own() -> None:
    beta = Distribution(family="beta", mean=3.0, deviation=1.0, lower=0.0, upper=10.0).at(EVEN)
    assert (beta.mean(), beta.std()) == pytest.approx((3, 1), rel=1e-4)
    uniform = Distribution(family="uniform", lower=2.0, upper=6.0).at(EVEN)
    assert (uniform.mean(), uniform.std()) == pytest.approx((4, 4 / math.sqrt(12)), rel=1e-4)
    triangular = Distribution(family="triangular", lower=0.0, mode=1.0, upper=5.0).at(EVEN)
    assert triangular.mean() == pytest.approx((0 + 1 + 5) / 3, rel=1e-4)
    assert Distribution(family="exponential", mean=4.0).at(EVEN).mean() == pytest.approx(4, rel=1e-3)


def test_bounds_cut_a_distribution_off() -> None:
    """Within one deviation of its mean a normal distribution has this variance: 1 - 2 p(1) / (2 P(1) - 1)."""
    values = Distribution(family="normal", mean=35.0, deviation=2.0, lower=33.0, upper=37.0).at(EVEN)
    density, inside = math.exp(-0.5) / math.sqrt(2 * math.pi), math.erf(1 / math.sqrt(2))
    assert values.min() >= 33
    assert values.max() <= 37
    assert values.std() == pytest.approx(2 * math.sqrt(1 - 2 * density / inside), rel=1e-4)


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ({"family": "norml", "mean": 1.0}, "did you mean 'normal'"),
        ({"family": "normal", "mean": 1.0}, "needs the key 'deviation'"),
        ({"family": "normal", "mean": 1.0, "deviation": 1.0, "mode": 2.0}, "has no 'mode'"),
        ({"family": "normal", "mean": 1.0, "deviation": 0.0}, "must be above 0"),
        ({"family": "normal", "mean": 1.0, "deviation": 1.0, "lower": 3.0, "upper": 2.0}, "lower = 3 must be less"),
        ({"family": "normal", "mean": 0.0, "deviation": 1.0, "lower": 9.0, "upper": 10.0}, "leave nothing"),
        ({"family": "lognormal", "mean": -1.0, "deviation": 1.0}, "mean = -1 must be above 0"),
        ({"family": "triangular", "lower": 0.0, "mode": 7.0, "upper": 5.0}, "mode = 7 must lie between"),
        ({"family": "beta", "mean": 1.0, "deviation": 1.0, "lower": 0.0, "upper": 2.0}, "deviation = 1 is too much"),
        ({"family": "uniform", "lower": 0.0}, "needs the key 'upper'"),
    ],
)
def test_bad_distributions(given: dict[str, object], says: str) -> None:
    with pytest.raises(ModelError, match=says):
        Distribution(**given)  # type: ignore[arg-type]


def test_every_family_has_finite_values_at_the_very_ends() -> None:
    numbers = {"mean": 3.0, "deviation": 1.0, "mode": 2.0, "lower": 0.0, "upper": 10.0}
    for family, needed in NEEDS.items():
        made = Distribution(family=family, **{name: numbers[name] for name in needed})  # type: ignore[arg-type]
        assert np.isfinite(made.at(np.array([1e-300, 1 - 1e-16]))).all(), family


def test_monte_carlo_draws_the_same_and_first_runs_whatever_their_number() -> None:
    one, two = (make_plan({"a": NORMAL, "b": NORMAL}, "monte_carlo", runs=n, seed=3) for n in (100, 200))
    assert one.values["a"] == two.values["a"][:100]
    assert one.values["a"] != one.values["b"]
    assert make_plan({"a": NORMAL, "b": NORMAL}, "monte_carlo", runs=100, seed=4).values["a"] != one.values["a"]
    assert column(two, "a").mean() == pytest.approx(35, abs=3 * 2 / math.sqrt(200))


def test_a_latin_hypercube_has_one_value_in_every_stratum() -> None:
    plan = make_plan(
        {"a": NORMAL, "b": Distribution(family="uniform", lower=0.0, upper=1.0)},
        "latin_hypercube",
        runs=50,
        correlations=[Correlation(between=("a", "b"), coefficient=0.7)],
    )
    assert np.sort(np.floor(column(plan, "b") * 50)).tolist() == list(range(50))
    assert len(set(plan.values["a"])) == 50


@pytest.mark.parametrize("method", ["monte_carlo", "latin_hypercube"])
def test_correlations_of_a_gaussian_copula(method: str) -> None:
    """Normal scores of correlation r have Spearman's correlation 6 / pi asin(r / 2)."""
    from scipy.stats import spearmanr

    plan = make_plan(
        {"a": NORMAL, "b": Distribution(family="lognormal", mean=9.0, deviation=9.0), "c": NORMAL},
        method,  # type: ignore[arg-type]
        runs=4000,
        correlations=[
            Correlation(between=("a", "b"), coefficient=-0.5),
            Correlation(between=("c", "b"), coefficient=0.8),
        ],
    )
    found = spearmanr(np.column_stack([column(plan, key) for key in "abc"])).statistic
    expected = 6 / math.pi * np.arcsin(np.array([-0.5, 0.8, 0.0]) / 2)
    assert [found[0, 1], found[1, 2], found[0, 2]] == pytest.approx(expected, abs=3 / math.sqrt(4000))


def test_contradicting_correlations_are_refused() -> None:
    pairs = [(("a", "b"), 0.9), (("b", "c"), 0.9), (("a", "c"), -0.9)]
    given = [Correlation(between=pair, coefficient=r) for pair, r in pairs]
    with pytest.raises(ModelError, match=r"between a, b, c contradict each other .*not positive definite.*nearer to 0"):
        make_plan(dict.fromkeys("abc", NORMAL), "monte_carlo", runs=5, correlations=given)


@pytest.mark.parametrize(
    ("pair", "coefficient", "says"),
    [
        (("a", "x"), 0.5, "'x' is not drawn"),
        (("a", "a"), 0.5, "give two keys"),
        (("a", "b"), 1.0, "above -1 and below 1"),
        (("a", "s"), 0.5, "'s' is not drawn"),
    ],
)
def test_bad_correlations(pair: tuple[str, str], coefficient: float, says: str) -> None:
    given = [Correlation(between=pair, coefficient=coefficient)]
    with pytest.raises(ModelError, match=says):
        make_plan({"a": NORMAL, "b": NORMAL, "s": Seeds()}, "monte_carlo", runs=5, correlations=given)


def test_a_grid_has_every_combination() -> None:
    plan = make_plan({"a": Values((1, 2)), "s": Seeds(), "b": Values((10.0, 20.0, 30.0))}, "grid", seed=7)
    assert [plan.of(run) for run in (0, 1, 5)] == [
        {"a": 1, "s": 7, "b": 10.0},
        {"a": 1, "s": 8, "b": 20.0},
        {"a": 2, "s": 12, "b": 30.0},
    ]
    assert plan.count == 6


def test_a_list_takes_the_values_in_order() -> None:
    plan = make_plan({"a": Values((1, 2)), "b": Values(("x", "y"))}, "list")
    assert [plan.of(run) for run in range(plan.count)] == [{"a": 1, "b": "x"}, {"a": 2, "b": "y"}]


def test_values_that_are_drawn_are_equally_likely() -> None:
    plan = make_plan({"a": Values(("x", "y")), "s": Seeds()}, "latin_hypercube", runs=100, seed=5)
    assert plan.values["a"].count("x") == 50
    assert plan.values["s"] == list(range(5, 105))


@pytest.mark.parametrize(
    ("sources", "method", "runs", "says"),
    [
        ({"a": NORMAL}, "monte_carlo", None, "needs the key 'runs'"),
        ({"a": Values((1, 2))}, "monte_carlo", None, "every combination of the values: sampling = 'grid'"),
        ({"a": NORMAL}, "grid", None, "not a distribution"),
        ({"a": Values((1, 2))}, "grid", 5, "has as many runs as its values say"),
        ({"a": Values((1, 2)), "b": Values((1,))}, "list", None, "as many values of every key"),
        ({"a": Seeds()}, "grid", None, "whose values are listed"),
        ({"a": Values(tuple(range(2000))), "b": Values(tuple(range(2000)))}, "grid", None, "4000000 runs"),
    ],
)
def test_bad_plans(sources: dict[str, object], method: str, runs: int | None, says: str) -> None:
    with pytest.raises(ModelError, match=says):
        make_plan(sources, method, runs=runs)  # type: ignore[arg-type]
