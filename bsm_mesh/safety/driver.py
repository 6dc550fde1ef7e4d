"""Trials one after the other, or several at a time, until the bracket of the limit is closed."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from bsm_mesh.arrays import BoolArray, IntArray
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.movements import distances
from bsm_mesh.results.movement import moved_beyond
from bsm_mesh.results.records import Status
from bsm_mesh.results.results import Results
from bsm_mesh.safety.bracket import Bracket, Judged, Range, Verdict, bracket_of, next_values
from bsm_mesh.safety.criterion import Criterion, Ended, Judgement, movement, of_size
from bsm_mesh.safety.pool import RunAll, Trials, pool_of

STRONGER, MOST_STRONGER = 0.8, 5  # of the factor of a state in which blocks moved far; how often


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Trial:
    """A value that was tried, and its verdict.

    Attributes
    ----------
    value : float
        The value of the trial.
    verdict : Verdict
        Stable, unstable or undecided.
    reason : str
        Why, in words.
    status : Status
        The verdict of the run.
    moved : float
        Greatest movement of a block from where it is in the reference state, over its size.
    blocks : (k,) int32
        Blocks that fail.
    seconds : float
        Processor time.
    """

    value: float
    verdict: Verdict
    reason: str
    status: Status
    moved: float
    blocks: IntArray
    seconds: float


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Found:
    """Result of a search.

    Attributes
    ----------
    bracket : Bracket
        Between which values the limit lies.
    trials : tuple of Trial
        The trials, by value.
    reference : float or None
        Value of the reference state.
    reference_moved : float
        Greatest movement of a block up to the reference state, over its size.
    states : dict
        Results at the ends of the bracket that were run, by value.
    is_closed : bool
        Whether the bracket is as narrow as asked, without undecided values in it.
    """

    bracket: Bracket
    trials: tuple[Trial, ...]
    reference: float | None
    reference_moved: float
    states: dict[float, Results]
    is_closed: bool


class Allowance(NamedTuple):
    """The displacement at which a trial ends [m], and its parts in words."""

    limit: float
    words: str


class Search:
    """The search for a limit.

    Parameters
    ----------
    trials : Trials
        What runs the model.
    within : Range
        Where it is looked for.
    criterion : Criterion
        The criterion that separates good values from bad ones.
    blocks : Blocks
        The model's blocks.
    counts : (n,) bool
        Those whose movement counts: supports do not hold them fast, and they are not too small.
    report : callable
        Called after every trial.
    known : iterable of Ended
        Former trials.
    states : bool
        Whether the states at both ends of the bracket are wanted; not wanted, the proof or known is not run.
    """

    def __init__(
        self,
        trials: Trials,
        within: Range,
        criterion: Criterion,
        blocks: Blocks,
        counts: BoolArray,
        report: Callable[[str], None],
        known: Iterable[Ended] = (),
        *,
        states: bool = True,
    ) -> None:
        self._trials, self._within, self._criterion, self._blocks = trials, within, criterion, blocks
        self._report = report
        self._counts, self._wants_states = counts, states
        self._ended: dict[float, Ended] = {each.value: each for each in known}
        self._reference: Ended | None = None
        self._allowed: dict[float, Allowance | None] = {}

    def run(self, most: int, processes: int = 1) -> Found:
        """Return what at most so many trials find, as many at a time as there are processes."""
        with pool_of(self._trials, processes) as run_all:
            self._find_reference(run_all)
            while len(self._ended) < most:
                values = next_values(self._judged(), self._within, processes) or self._unseen()
                if not values:
                    break
                self._try(values, run_all)
                self._find_reference(run_all)
                self._forget()
        return self._found()

    def _find_reference(self, run_all: RunAll) -> None:
        if self._reference is None and (first := self._first_stable()) is not None:
            self._set_reference(first, run_all)

    def _unseen(self) -> list[float]:
        """Return the ends of the bracket whose states are not there: proved and not run, or forgotten."""
        return [value for value in self._ends if self._wants_states and self._state(value) is None]

    @property
    def _ends(self) -> list[float]:
        bracket = self._bracket
        return [value for value in (bracket.stable, bracket.unstable) if value is not None]

    def _state(self, value: float) -> Results | None:
        return self._ended[value].results if value in self._ended else None

    def _try(self, values: Sequence[float], run_all: RunAll) -> None:
        allowed = {value: self._allowance(value) for value in values}
        self._allowed |= allowed
        for each in run_all([(value, None if (most := allowed[value]) is None else most.limit) for value in values]):
            self._ended[each.value] = each
            said = self._judge(each)
            self._report(f"trial at {each.value:.5g}: {said.verdict} ({said.reason})")

    def _forget(self) -> None:
        """Forget the results of all runs but those at the ends of the bracket: of large models they are large."""
        ends = self._ends
        for value, each in self._ended.items():
            if value not in ends:
                self._ended[value] = replace(each, results=None)

    def _allowance(self, value: float) -> Allowance | None:
        """Return the movement that is a failure for certain, so that no run continues beyond it.

        That is more than any block moves in the reference state by a mean size, or, where failure is proved, by the
        part of it that counts as failure.
        """
        part = self._criterion.movement
        if self._reference is None or not math.isfinite(part) or not self._counts.any():
            return None
        size = self._blocks.moments.size[self._counts]
        mean, greatest = float(size.mean()), part * float(size.max())
        if self._is_proved(value):
            beyond, words = part * mean, f"{100 * part:g} % of the mean block size"
        elif greatest > mean:
            beyond, words = greatest, f"{100 * part:g} % of the greatest block size"
        else:
            beyond, words = mean, "the mean block size"
        moved, at = float(distances(self._reference.displacement).max()), f"{self._reference.value:.4g}"
        return Allowance(
            limit=moved + beyond,
            words=f"{words} ({beyond:.3g} m) beyond the displacement at {at} ({moved:.3g} m)",
        )

    def _is_proved(self, value: float) -> bool:
        """Return whether failure is proved at a value."""
        bound = self._within.bound
        return bound is not None and self._within.at(value) >= self._within.at(bound)

    def _first_stable(self) -> Ended | None:
        """Return the best value at which blocks stay at rest; beyond the bound they are at rest elsewhere."""
        stable = [each for each in self._ended.values() if each.status.is_stable and not self._is_proved(each.value)]
        return min(stable, key=lambda each: self._within.at(each.value), default=None)

    def _set_reference(self, first: Ended, run_all: RunAll) -> None:
        """Take the state from which movement counts: the first, or a stronger one where blocks moved far in it.

        A state that blocks reached by giving way is none to count from. Where they move as far at more strength they
        have not given way: joints are soft.
        """
        self._reference, farther = first, first.value
        for _ in range(MOST_STRONGER):
            farther *= STRONGER
            if not self._has_moved(self._reference) or not self._within.is_factor or farther < self._within.good:
                return
            self._try([farther], run_all)
            former, stronger = self._reference, self._ended[farther]
            if not stronger.status.is_stable:  # on the way down to where blocks reached rest
                continue
            self._reference = stronger
            if movement(former, stronger, self._blocks, self._counts).max() <= self._criterion.movement:
                return

    def _has_moved(self, ended: Ended) -> bool:
        return self._movement_of(ended) > self._criterion.movement

    def _movement_of(self, ended: Ended) -> float:
        """Return the greatest movement of a block in a run, over its size."""
        moved = distances(ended.displacement) / self._blocks.moments.size
        return float(moved[self._counts].max(initial=0.0))

    def _judge(self, each: Ended) -> Judgement:
        said = self._criterion.judge(each, self._reference, self._blocks, self._counts)
        allowed = self._allowed.get(each.value)
        if allowed is not None and said.reason == moved_beyond(allowed.limit):
            said = replace(said, reason=f"{said.reason}: {allowed.words}")
        if not self._is_proved(each.value) or said.verdict is Verdict.UNSTABLE:
            return said
        moved = movement(each, self._reference, self._blocks, self._counts)
        ended = "reached rest" if each.status.is_stable else f"ended {each.status}"
        reason = (
            "limit analysis proves that no equilibrium exists in the initial geometry; in the run blocks moved by "
            f"{of_size(moved.max())}, and it {ended}"
        )
        return Judgement(Verdict.UNSTABLE, reason, np.flatnonzero(moved > moved.max() / 2).astype(np.int32))

    def _judged(self) -> list[Judged]:
        judged = [Judged(value=each.value, verdict=self._judge(each).verdict) for each in self._ended.values()]
        bound = self._within.bound
        if bound is not None and bound not in self._ended:
            judged.append(Judged(value=bound, verdict=Verdict.UNSTABLE))
        return judged

    @property
    def _bracket(self) -> Bracket:
        return bracket_of(self._judged(), self._within)

    @property
    def ended(self) -> tuple[Ended, ...]:
        """The run."""
        return tuple(self._ended.values())

    def _found(self) -> Found:
        bracket = self._bracket
        ends = self._ends
        closed = len(ends) == 2 and not bracket.undecided and not next_values(self._judged(), self._within)
        return Found(
            bracket=bracket,
            trials=tuple(sorted((self._trial(each) for each in self._ended.values()), key=self._place)),
            reference=None if self._reference is None else self._reference.value,
            reference_moved=0.0 if self._reference is None else self._movement_of(self._reference),
            states={value: state for value in ends if (state := self._state(value)) is not None},
            is_closed=closed,
        )

    def _place(self, trial: Trial) -> float:
        return self._within.at(trial.value)

    def _trial(self, each: Ended) -> Trial:
        said = self._judge(each)
        moved = movement(each, self._reference, self._blocks, self._counts)
        return Trial(
            value=each.value,
            verdict=said.verdict,
            reason=said.reason,
            status=each.status,
            moved=float(moved.max(initial=0.0)),
            blocks=said.blocks,
            seconds=each.seconds,
        )
