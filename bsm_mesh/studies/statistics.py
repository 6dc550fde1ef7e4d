"""Answers of a study: the probability of failure, how the answers scatter, and which key decides."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray
from bsm_mesh.studies.table import FAILED, StudyTable

CONFIDENCE = 0.95
QUANTILES = (0.05, 0.25, 0.5, 0.75, 0.95)
SAME = 1e-6  # answers nearer than this part of them are one: runs of equal models differ by rounding
FEWEST = 8  # runs for a correlation and for quarters of them
STABLE, UNSTABLE, UNDECIDED = ("stable", "stable_after_falls"), ("unstable",), ("not_converged", "no_verdict")
UNIT = {"max_displacement": "m"}
MOVEMENT_LIMIT = "movement_limit"  # in a table's metadata: runs that reach rest further away fail [m]


@dataclass(frozen=True, slots=True, kw_only=True)
class Failure:
    """How often it fails.

    Attributes
    ----------
    runs, stable, moved_far, unstable, undecided, failed : int
        Numbers of runs: all, stable, at rest beyond the limit of movement, unstable, without a verdict, and with a
        fault.
    gave_way : int
        Stable runs in which blocks fell, or moved by more than a tenth of their size before they reached rest; 0 with
        a limit of movement, which then decides.
    share : float or None
        Runs that moved too far or are unstable, over those with a verdict; None where there are none.
    interval : pair of float or None
        Clopper and Pearson's interval of it, of the confidence `confidence`: for runs that were drawn.
    bounds : pair of float
        The share if no run without a verdict failed, and if all did.
    confidence : float
        Of the interval.
    """

    runs: int
    stable: int
    moved_far: int
    unstable: int
    undecided: int
    failed: int
    gave_way: int
    share: float | None
    interval: tuple[float, float] | None
    bounds: tuple[float, float]
    confidence: float = CONFIDENCE


@dataclass(frozen=True, slots=True, kw_only=True)
class Spread:
    """How an answer scatters over the runs that have it.

    Attributes
    ----------
    answer : str
        Its column.
    runs : int
        How many have it.
    mean, deviation : float
        Of these; the deviation with n - 1.
    quantiles : mapping of str to float
        By ``5 %`` and so on.
    """

    answer: str
    runs: int
    mean: float
    deviation: float
    quantiles: Mapping[str, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class Extremes:
    """Least and greatest value of an answer over chosen runs, which are no sample: a grid or a list.

    Attributes
    ----------
    answer : str
        Its column.
    runs : int
        How many have it.
    least, greatest : float
        Of these.
    least_at, greatest_at : mapping of str to str
        Values of the keys there, with their units: of the first run with the answer.
    least_runs, greatest_runs : int
        How many runs have it.
    """

    answer: str
    runs: int
    least: float
    least_at: Mapping[str, str]
    greatest: float
    greatest_at: Mapping[str, str]
    least_runs: int
    greatest_runs: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Effect:
    """How an answer belongs to a key.

    Attributes
    ----------
    key, answer : str
        Columns.
    correlation, p_value : float or None
        Spearman's rank correlation, and how likely one as great is by chance; None where either does not vary.
    low, high : float or None
        Mean of the answer in the quarter of the runs with the least values of the key; the same with the greatest.
    """

    key: str
    answer: str
    correlation: float | None
    p_value: float | None
    low: float | None
    high: float | None

    @property
    def width(self) -> float:
        """Difference of both quarters; 0 where there are none."""
        return 0.0 if self.low is None or self.high is None else abs(self.high - self.low)


def stands(table: StudyTable) -> BoolArray:
    """Return which runs are stable within the limit of movement, where there is one, (n,)."""
    stable: BoolArray = table.has_status(*STABLE) & ~_moved_far(table)
    return stable


def fails(table: StudyTable) -> BoolArray:
    """Return which runs are unstable, or reached rest beyond the limit of movement, (n,)."""
    failing: BoolArray = table.has_status(*UNSTABLE) | _moved_far(table)
    return failing


def _moved_far(table: StudyTable) -> BoolArray:
    limit = float(table.metadata.get(MOVEMENT_LIMIT, math.inf))
    far: BoolArray = table.has_status(*STABLE) & (table.numbers("max_displacement") > limit)
    return far


def _gave_way(table: StudyTable) -> int:
    if MOVEMENT_LIMIT in table.metadata or "moved_blocks" not in table.columns:
        return 0
    return int((table.has_status(*STABLE) & (table.numbers("moved_blocks") > 0)).sum())


def failure_of(table: StudyTable, *, drawn: bool) -> Failure:
    """Return how often the runs of a study fail; `drawn` says whether they are a sample of chance."""
    stable, failing, n = int(stands(table).sum()), int(fails(table).sum()), table.count
    moved_far, failed = int(_moved_far(table).sum()), int(table.has_status(FAILED).sum())
    decided = stable + failing
    return Failure(
        runs=n,
        stable=stable,
        moved_far=moved_far,
        unstable=failing - moved_far,
        undecided=n - decided - failed,
        failed=failed,
        gave_way=_gave_way(table),
        share=failing / decided if decided else None,
        interval=_interval(failing, decided) if drawn and decided else None,
        bounds=(failing / n, (n - stable) / n),
    )


def _interval(successes: int, trials: int) -> tuple[float, float]:
    """Return Clopper and Pearson's interval of a probability."""
    from scipy.stats import binomtest

    found = binomtest(successes, trials).proportion_ci(confidence_level=CONFIDENCE, method="exact")
    return float(found.low), float(found.high)


def answers_of(table: StudyTable) -> dict[str, FloatArray]:
    """Return the answers that are numbers, by their names, (n,) each; NaN where a run has none.

    ``failure`` is 1 where a run fails and 0 where it is stable. The greatest displacement is that of stable runs:
    where an unstable one was left has no meaning.
    """
    found = {"failure": np.where(fails(table), 1.0, np.where(stands(table), 0.0, np.nan))}
    if "factor" in table.columns:
        found["factor"] = table.numbers("factor")
    found["max_displacement"] = np.where(table.has_status(*STABLE), table.numbers("max_displacement"), np.nan)
    return {name: values for name, values in found.items() if np.isfinite(values).any()}


def main_answer(table: StudyTable) -> str | None:
    """Return the answer that pictures show: the factor, else whether it fails where both happen, else the movement."""
    answers = answers_of(table)
    if "factor" in answers:
        return "factor"
    known = answers.get("failure", np.empty(0))
    if np.nanmin(known, initial=1.0) < np.nanmax(known, initial=0.0):
        return "failure"
    return "max_displacement" if "max_displacement" in answers else None


def spread_of(table: StudyTable, answer: str) -> Spread:
    """Return how an answer scatters."""
    values = answers_of(table)[answer]
    values = values[np.isfinite(values)]
    quantiles = {f"{100 * part:g} %": float(np.quantile(values, part)) for part in QUANTILES}
    deviation = float(values.std(ddof=1)) if len(values) > 1 else 0.0
    return Spread(answer=answer, runs=len(values), mean=float(values.mean()), deviation=deviation, quantiles=quantiles)


def extremes_of(table: StudyTable, answer: str) -> Extremes:
    """Return the least and the greatest value of an answer, and the values of the keys that give them."""
    values = answers_of(table)[answer]
    least, greatest = float(np.nanmin(values)), float(np.nanmax(values))
    lows, highs = (np.flatnonzero(np.isclose(values, end, rtol=SAME, atol=0)) for end in (least, greatest))
    return Extremes(
        answer=answer,
        runs=int(np.isfinite(values).sum()),
        least=least,
        least_at=table.given_to(int(lows[0])),
        greatest=greatest,
        greatest_at=table.given_to(int(highs[0])),
        least_runs=lows.size,
        greatest_runs=highs.size,
    )


def effects_on(table: StudyTable, answer: str) -> list[Effect]:
    """Return how an answer belongs to every key that holds numbers, the most decisive first."""
    values = answers_of(table)[answer]
    found = [_effect(key, table.numbers(key), answer, values) for key in table.keys if table.is_number(key)]
    return sorted(found, key=lambda effect: (-abs(effect.correlation or 0.0), effect.key))


def _effect(key: str, given: FloatArray, answer: str, values: FloatArray) -> Effect:
    from scipy.stats import spearmanr

    known: BoolArray = np.isfinite(given) & np.isfinite(values)
    given, values = given[known], values[known]
    if len(given) < FEWEST or np.ptp(given) == 0 or np.ptp(values) == 0:
        return Effect(key=key, answer=answer, correlation=None, p_value=None, low=None, high=None)
    rank = spearmanr(given, values)
    low, high = np.quantile(given, (0.25, 0.75))
    return Effect(
        key=key,
        answer=answer,
        correlation=float(rank.statistic),
        p_value=float(rank.pvalue),
        low=float(values[given <= low].mean()),
        high=float(values[given >= high].mean()),
    )


def summary_of(table: StudyTable, *, drawn: bool) -> dict[str, Any]:
    """Return all of it, of plain values; `drawn` says whether the runs are a sample of chance."""
    answers = answers_of(table)
    of_answer: Callable[[StudyTable, str], Spread | Extremes] = spread_of if drawn else extremes_of
    return {
        "failure": asdict(failure_of(table, drawn=drawn)),
        "answers": [asdict(of_answer(table, name)) for name in answers if name != "failure"],
        "effects": [asdict(effect) for name in answers for effect in effects_on(table, name)],
        "seconds": math.fsum(table.numbers("seconds")[np.isfinite(table.numbers("seconds"))]),
    }
