"""The picture of the histories: over the steps, with the ends of the stages and the values compared with them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.model.beside import Beside
from bsm_mesh.model.kinds import in_space
from bsm_mesh.pictures.beside_marks import COLOURS, Looks, by_source, draw_range, ends_of, looks_of, stages_that_count
from bsm_mesh.pictures.canvas import WIDTH, prefixed_unit
from bsm_mesh.pictures.figures import entitle, paper
from bsm_mesh.results.histories import HistorySeries
from bsm_mesh.results.results import Results

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SAME_PLACE = 1e-3  # of the distance: a value beside an extension is of the same anchor
HEIGHT = 2.6  # inches a chart
MOVEMENTS = ("point", "line", "block")  # histories of displacements
ROOM = 0.14  # of the height of the curves, above them for a row of names of stages
ROW = 0.08  # of the height of the chart: from row to row of the names
LETTER = 0.06  # inches: a letter of these names
PLOTTED = 0.9  # of the width of a chart: without its labels
MOST_NAMED = 8  # stages; the names of more would touch
WORDS = {"u": "to the right", "v": "upwards", "slipping_share": "share at strength", "open_share": "share open"}
WORDS_IN_SPACE = {**WORDS, "u": "to the east", "v": "to the north", "w": "upwards"}


def draw_histories(results: Results, title: str, figure: Figure | None = None) -> Figure | None:
    """Return a chart of every history over the steps of the run; None where there is none."""
    series = [_counted(results, one) for one in results.histories.values()]
    if not series:
        return None
    columns = min(2, len(series))
    rows = -(-len(series) // columns)
    figure = figure or paper((WIDTH / 100, HEIGHT * rows + 0.6))
    axes = figure.subplots(rows, columns, squeeze=False)
    for place in axes.reshape(-1)[len(series) :]:
        place.axis("off")
    for place, one in zip(axes.reshape(-1), series, strict=False):
        _draw_one(place, results, one)
    entitle(figure, title)
    return figure


def _counted(results: Results, series: HistorySeries) -> HistorySeries:
    """Return a series from where its displacements count."""
    if series.recorded.kind not in MOVEMENTS:
        return series
    counts = np.isin(series.stage, stages_that_count(results))
    return replace(series, stage=series.stage[counts], step=series.step[counts], values=series.values[counts])


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class _Curve:
    """A quantity over the steps: label, unit, values (k,), and the values compared with it by source and stage."""

    label: str
    unit: str
    values: FloatArray
    beside: dict[tuple[str, int], list[Beside]]


def _curves(results: Results, series: HistorySeries) -> Iterator[_Curve]:
    """Return the quantities of a history; of a point also its displacement where values of that are given."""
    recorded = series.recorded
    words = WORDS_IN_SPACE if "w" in recorded.quantities else WORDS
    for k, (name, unit) in enumerate(zip(recorded.quantities, recorded.units, strict=True)):
        beside = by_source(results, recorded, "extension" if recorded.distances else name)
        label = words.get(name, name.replace("_", " "))
        if recorded.distances:
            at = recorded.distances[k]
            label = f"over {at:.3g} m"
            beside = {
                key: [one for one in listed if math.isclose(one.distance or 0.0, at, rel_tol=SAME_PLACE)]
                for key, listed in beside.items()
            }
        yield _Curve(label=label, unit=unit, values=series.values[:, k], beside=beside)
    if lengths := by_source(results, recorded, "displacement"):
        yield _Curve(label="in all", unit="m", values=series.length, beside=lengths)


def _draw_one(axes: Any, results: Results, series: HistorySeries) -> None:
    """Draw a history: the quantities of its first unit to the left axis, of another one to the right."""
    recorded, curves = series.recorded, list(_curves(results, series))
    units = list(dict.fromkeys(curve.unit for curve in curves))
    colours = iter(COLOURS * len(curves))
    looks = looks_of(results, [recorded], stages_that_count(results))
    number = np.arange(1, len(series.step) + 1)
    key: dict[str, Any] = {}
    for unit, side in zip(units, (axes, axes.twinx() if len(units) > 1 else axes), strict=False):
        mine = [curve for curve in curves if curve.unit == unit]
        factor, shown = _scale(mine, unit)
        for curve, colour in zip(mine, colours, strict=False):
            look = {"marker": "o", "markersize": 2.5, "linewidth": 1.3, "linestyle": "-" if side is axes else ":"}
            (line,) = side.plot(number, curve.values / factor, color=colour, **look)
            key[f"{curve.label}, {shown}" if shown else curve.label] = line
            _draw_ends(side, series, curve, factor, looks, colour)
        side.set_ylabel(
            shown if unit else f"share of the {'area' if in_space(results.blocks) else 'length'}", fontsize=9
        )
        side.tick_params(labelsize=8)
        if not unit:
            side.set_ylim(-0.03, 1.03)
    key |= {source.replace("$", r"\$"): _grey(axes, looks.mark(source)) for source in looks.sources}
    _mark_stages(axes, series, [stage.name for stage in results.stages])
    axes.set_title(f"{recorded.name} ({recorded.kind})", fontsize=10, loc="left", parse_math=False)
    begins = "step" if not series.stage.size or series.stage[0] == 0 else "step after the in-situ state"
    axes.set_xlabel(begins, fontsize=9, loc="right")
    axes.xaxis.get_major_locator().set_params(integer=True)
    axes.grid(visible=True, color="#dddddd", linewidth=0.6)
    axes.legend(list(key.values()), list(key), fontsize=8, frameon=False, ncols=min(4, len(key)), loc="upper left",
                bbox_to_anchor=(0.0, -0.16))  # fmt: skip


def _scale(curves: list[_Curve], unit: str) -> tuple[float, str]:
    """Return the divisor of the values of curves of a unit, and the unit that then suits them."""
    if unit not in ("m", "N"):
        return 1.0, unit
    beside = ends_of(listed for curve in curves for listed in curve.beside.values())
    return prefixed_unit(np.concatenate([*(curve.values for curve in curves), beside]), unit)


def _draw_ends(axes: Any, series: HistorySeries, curve: _Curve, factor: float, looks: Looks, colour: str) -> None:
    """Draw the values compared with a curve, where the stages end at which it holds; ranges as bars."""
    for (source, stage), listed in curve.beside.items():
        rows = np.flatnonzero(series.stage == stage)
        if not len(rows):
            continue
        at = float(rows[-1]) + 1
        for one in listed:
            style = {"color": colour, "marker": looks.mark(source), "markersize": 7, "markerfacecolor": "white"}
            axes.plot([at], [one.middle / factor], linestyle="none", clip_on=False, zorder=5, **style)
            draw_range(axes, at, one, factor, colour)


def _grey(axes: Any, mark: Any) -> Any:
    """Return what represents a source in the key."""
    return axes.plot([], [], linestyle="none", marker=mark, color="#555555", markersize=6, markerfacecolor="white")[0]


def _mark_stages(axes: Any, series: HistorySeries, names: list[str]) -> None:
    """Draw a line where a stage begins, and above the curves the names of the stages as far as there is room."""
    begins = np.flatnonzero(np.diff(series.stage)) + 1
    if not len(begins):
        return
    for first in begins.tolist():
        axes.axvline(first + 0.5, color="#888888", linewidth=0.8, linestyle="--")
    low, high = axes.get_ylim()
    start, end = axes.get_xlim()
    firsts = [0, *begins.tolist()] if len(begins) < MOST_NAMED else []
    at = [max(start, first + 0.5) for first in firsts]
    shown = [f" {names[series.stage[first]]}" for first in firsts]
    grid = axes.get_subplotspec().get_gridspec()
    letter = LETTER * (end - start) * grid.ncols / (PLOTTED * axes.figure.get_figwidth())
    rows = rows_of_names(at, [len(name) * letter for name in shown])
    axes.set_ylim(low, high + ROOM * (1 + max(rows, default=0)) * (high - low))
    style = {"fontsize": 7, "va": "top", "color": "#555555", "clip_on": True, "parse_math": False}
    for x, name, row in zip(at, shown, rows, strict=True):
        axes.text(x, 0.97 - ROW * row, name, transform=axes.get_xaxis_transform(), **style)


def rows_of_names(at: Sequence[float], widths: Sequence[float]) -> list[int]:
    """Return the row of each name, from above, in which it begins behind the end of those before it.

    Examples
    --------
    >>> rows_of_names([0, 1, 2, 9], [1.5, 8, 1, 1])
    [0, 1, 0, 0]
    """
    ends: list[float] = []
    rows = []
    for x, width in zip(at, widths, strict=True):
        row = next((k for k, end in enumerate(ends) if end <= x), len(ends))
        ends[row : row + 1] = [x + width]
        rows.append(row)
    return rows
