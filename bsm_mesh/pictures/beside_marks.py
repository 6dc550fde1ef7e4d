"""How values compared with a run's histories look in charts: a mark and a dash a source, the colour of their stage."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.model.beside import Beside, number_of
from bsm_mesh.results.histories import Recorded
from bsm_mesh.results.results import Results

COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00")  # Okabe and Ito: distinguished by all eyes
MARKS = ("s", "^", "D", "v", "*", "P", "X", "p")
DASHES = ("--", ":", "-.", (0, (6, 1, 1, 1, 1, 1)), (0, (1, 3)))
CURVE = 13  # values along a line: so many and more are a curve, and no marks
RANGE = 5.0  # points: width of the bar of a range


@dataclass(frozen=True, kw_only=True)
class Looks:
    """Which colours, marks and dashes stages and sources have in all charts of a picture.

    Attributes
    ----------
    stages : tuple of int
        The stages of the run that are drawn.
    sources : tuple of str
        Where values come from.
    names : tuple of str
        Of all stages.
    """

    stages: tuple[int, ...]
    sources: tuple[str, ...]
    names: tuple[str, ...]

    def colour(self, stage: int, source: str | None = None) -> str:
        """Return the colour of a stage; where only one is drawn every source has its own."""
        if source is not None and len(self.stages) == 1:
            return COLOURS[1 + self.sources.index(source) % (len(COLOURS) - 1)]  # never that of the run
        number = self.stages.index(stage) if stage in self.stages else len(self.stages)
        return COLOURS[number % len(COLOURS)]

    def mark(self, source: str) -> Any:
        """Return the mark of a source."""
        return MARKS[self.sources.index(source) % len(MARKS)]

    def dash(self, source: str) -> Any:
        """Return the dash of a source: another one where the colours begin anew, for curves have no marks."""
        number = self.sources.index(source)
        return DASHES[(number + number // (len(COLOURS) - 1)) % len(DASHES)]

    def label(self, stage: int, source: str | None = None) -> str:
        """Return the key's entry for a stage of the run or values of a source, with the stage if there are several."""
        stage_name = self.names[stage] if len(self.names) > 1 else "computed"
        told = stage_name if source is None else source if len(self.stages) == 1 else f"{source}, {stage_name}"
        return told.replace("$", r"\$")


def looks_of(results: Results, recorded: Iterable[Recorded], stages: Sequence[int]) -> Looks:
    """Return how the stages of a run and the sources of values compared with some histories look."""
    sources = dict.fromkeys(one.source for each in recorded for one in each.measured)
    names = tuple(stage.name for stage in results.stages)
    return Looks(stages=tuple(stages), sources=tuple(sources), names=names)


def stages_that_count(results: Results) -> list[int]:
    """Return the stages whose displacements are drawn: an in-situ state that moved blocks is none of them.

    During it displacements are those since the blocks were given, and would be compared with the others as a jump.
    """
    # fill has an origin too, from the third stage on
    first = 1 if any(stage.origin.any() for stage in results.stages[:2]) else 0
    return list(range(first, len(results.stages)))


def by_source(results: Results, recorded: Recorded, quantity: str) -> dict[tuple[str, int], list[Beside]]:
    """Return values compared with a history, by source and number of the stage, in order of distance."""
    names = [stage.name for stage in results.stages]
    found: dict[tuple[str, int], list[Beside]] = {}
    for one in recorded.measured:
        number = number_of(one.stage, names)
        if one.quantity == quantity and number is not None:
            found.setdefault((one.source, number), []).append(one)
    return {key: sorted(listed, key=lambda one: one.distance or 0.0) for key, listed in found.items()}


def ends_of(beside: Iterable[Iterable[Beside]]) -> FloatArray:
    """Return values, and the other ends of those that are ranges, (k,)."""
    return np.array([end for listed in beside for one in listed for end in (one.value, one.until) if end is not None])


def draw_range(axes: Any, at: float, one: Beside, factor: float, colour: str) -> None:
    """Draw the bar of a value that is a range."""
    if one.until is not None:
        ends = [one.value / factor, one.until / factor]
        axes.plot([at, at], ends, color=colour, linewidth=RANGE, alpha=0.4, solid_capstyle="butt", zorder=2.5)


def draw_beside(
    axes: Any, place: FloatArray, values: Sequence[Beside], factor: float, looks: Looks, stage: int, *, joined: bool
) -> Any:
    """Draw values of a source and stage at places along the axis, and return what represents them in the key.

    Many values, and those that are `joined`, have a line; ranges have bars.
    """
    source = values[0].source
    colour = looks.colour(stage, source)
    curve = len(values) >= CURVE
    height = np.array([one.middle for one in values]) / factor
    for at, one in zip(place.tolist(), values, strict=True):
        draw_range(axes, at, one, factor, colour)
    style = {"linestyle": looks.dash(source) if curve or joined else "none", "linewidth": 1.3 if curve else 0.9}
    marked = {} if curve else {"marker": looks.mark(source), "markersize": 6, "markerfacecolor": "white"}
    (drawn,) = axes.plot(place, height, color=colour, zorder=3, label=looks.label(stage, source), **style, **marked)
    return drawn
