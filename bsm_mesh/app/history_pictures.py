"""Pictures of the histories: over the steps, with the ends of the stages; and along extensometers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from bsm_mesh.app.canvas import WIDTH, scaled
from bsm_mesh.app.figures import entitle, paper
from bsm_mesh.arrays import FloatArray
from bsm_mesh.results.histories import HistorySeries
from bsm_mesh.results.results import Results

Draw = Callable[[Any, HistorySeries, list[str]], None]  # into axes, a series, with the names of the stages

if TYPE_CHECKING:
    from matplotlib.figure import Figure

COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00")  # Okabe and Ito: told apart by all eyes
HEIGHT = 2.6  # inches a chart
MOVEMENTS = ("point", "line", "block")  # histories of displacements
ROOM = 0.14  # of the height of the curves, above them for the names of stages
MOST_NAMED = 8  # stages; the names of more would touch
WORDS = {"u": "to the right", "v": "upwards", "slipping_share": "share at strength", "open_share": "share open"}


def draw_histories(results: Results, title: str, figure: Figure | None = None) -> Figure | None:
    """Return a chart of every history over the steps of the run; None where there is none."""
    return _charts(results, list(results.histories.values()), _draw_one, title, figure)


def draw_extensometers(results: Results, title: str, figure: Figure | None = None) -> Figure | None:
    """Return a chart of every line: its extensions over the distance, at the end of every stage; None: no line."""
    lines = [series for series in results.histories.values() if series.recorded.kind == "line"]
    return _charts(results, lines, _draw_line, title, figure)


def _charts(
    results: Results, series: list[HistorySeries], draw: Draw, title: str, figure: Figure | None
) -> Figure | None:
    """Return a chart of each series, or None where there is none."""
    if not series:
        return None
    series = [_counted(results, one) for one in series]
    columns = min(2, len(series))
    rows = -(-len(series) // columns)
    figure = figure or paper((WIDTH / 100, HEIGHT * rows + 0.6))
    axes = figure.subplots(rows, columns, squeeze=False)
    for place in axes.reshape(-1)[len(series) :]:
        place.axis("off")
    names = [stage.name for stage in results.stages]
    for place, one in zip(axes.reshape(-1), series, strict=False):
        draw(place, one, names)
    entitle(figure, title)
    return figure


def _counted(results: Results, series: HistorySeries) -> HistorySeries:
    """Return a series from where its displacements count: after an in-situ state that moved the blocks.

    During it they are those since the blocks were given, and would stand beside the others as a jump.
    """
    if series.recorded.kind not in MOVEMENTS or not any(stage.origin.any() for stage in results.stages):
        return series
    counts = series.stage > 0
    return replace(series, stage=series.stage[counts], step=series.step[counts], values=series.values[counts])


def _draw_line(axes: Any, series: HistorySeries, stage_names: list[str]) -> None:
    """Draw by how much the distances along a line have grown at the end of every stage (as Wang Fig. 8.10)."""
    recorded = series.recorded
    distance = np.concatenate([[0.0], recorded.distances])
    values, unit = _shown(series.values, "m")
    order = np.argsort(distance, kind="stable")
    for number, stage in enumerate(np.unique(series.stage).tolist()):
        last = np.flatnonzero(series.stage == stage)[-1]
        along = np.concatenate([[0.0], values[last]])[order]
        if np.isfinite(along[1:]).any():
            axes.plot(distance[order], along, color=COLOURS[number % len(COLOURS)], marker="o", markersize=2.5,
                      linewidth=1.3, label=stage_names[stage].replace("$", r"\$"))  # fmt: skip
    axes.set_title(f"{recorded.name} (line)", fontsize=10, loc="left", parse_math=False)
    axes.set_xlabel("distance from the first point, m", fontsize=9)
    axes.set_ylabel(f"extension, {unit}", fontsize=9)
    axes.tick_params(labelsize=8)
    axes.grid(visible=True, color="#dddddd", linewidth=0.6)
    axes.legend(fontsize=8, frameon=False, title="end of stage", title_fontsize=8)


def _draw_one(axes: Any, series: HistorySeries, stage_names: list[str]) -> None:
    """Draw a history: the quantities of its first unit to the left axis, of another one to the right."""
    recorded = series.recorded
    units = list(dict.fromkeys(recorded.units))
    colours = iter(COLOURS * len(recorded.quantities))
    number = np.arange(1, len(series.step) + 1)
    lines = []
    for unit, side in zip(units, (axes, axes.twinx() if len(units) > 1 else axes), strict=False):
        chosen = [k for k, other in enumerate(recorded.units) if other == unit]
        values, shown = _shown(series.values[:, chosen], unit)
        for k, column in zip(chosen, values.T, strict=True):
            label = WORDS.get(recorded.quantities[k], recorded.quantities[k].replace("_", " "))
            if recorded.distances:
                label = f"over {recorded.distances[k]:.3g} m"
            (line,) = side.plot(
                number,
                column,
                color=next(colours),
                marker="o",
                markersize=2.5,
                linewidth=1.3,
                linestyle="-" if side is axes else ":",
            )
            lines.append((line, f"{label}, {shown}" if shown else label))
        side.set_ylabel({"": "share of the length"}.get(unit, shown), fontsize=9)
        side.tick_params(labelsize=8)
        if not unit:
            side.set_ylim(-0.03, 1.03)
    _mark_stages(axes, series, stage_names)
    axes.set_title(f"{recorded.name} ({recorded.kind})", fontsize=10, loc="left", parse_math=False)
    begins = "step" if not series.stage.size or series.stage[0] == 0 else "step after the in-situ state"
    axes.set_xlabel(begins, fontsize=9, loc="right")
    axes.xaxis.get_major_locator().set_params(integer=True)
    axes.grid(visible=True, color="#dddddd", linewidth=0.6)
    handles, labels = zip(*lines, strict=True)
    axes.legend(handles, labels, fontsize=8, frameon=False, ncols=min(4, len(lines)), loc="upper left",
                bbox_to_anchor=(0.0, -0.16))  # fmt: skip


def _shown(values: FloatArray, unit: str) -> tuple[FloatArray, str]:
    """Return values in a unit that suits them."""
    if unit not in ("m", "N"):
        return values, unit
    prefixed, unit = scaled(np.nan_to_num(values), unit)
    return np.where(np.isnan(values), np.nan, prefixed), unit


def _mark_stages(axes: Any, series: HistorySeries, names: list[str]) -> None:
    """Draw a line where a stage begins, and above the curves the names of the stages as far as there is room."""
    begins = np.flatnonzero(np.diff(series.stage)) + 1
    if not len(begins):
        return
    low, high = axes.get_ylim()
    axes.set_ylim(low, high + ROOM * (high - low))
    for first in [0, *begins.tolist()]:
        if first:
            axes.axvline(first + 0.5, color="#888888", linewidth=0.8, linestyle="--")
        if len(begins) < MOST_NAMED:
            axes.text(first + 0.5, 0.97, f" {names[series.stage[first]]}", fontsize=7, va="top", color="#555555",
                      transform=axes.get_xaxis_transform(), clip_on=True, parse_math=False)  # fmt: skip
