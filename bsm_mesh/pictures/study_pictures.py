"""The pictures of a study: histogram of the answer, every key against it, and the tornado of which key decides.

A grid and a list are no sample of chance: they have the answer over the values of every key instead of a histogram.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray
from bsm_mesh.model.model import Model
from bsm_mesh.pictures.canvas import WIDTH
from bsm_mesh.pictures.figures import entitle, paper, save
from bsm_mesh.studies.statistics import answers_of, effects_on, fails, main_answer, stands
from bsm_mesh.studies.table import StudyTable
from bsm_mesh.text.headings import PICTURES_FOLDER
from bsm_mesh.text.study_tables import NAMES, failure_in_words

STANDS, FAILS = "#1f4e79", "#c62828"
MOST_PANELS = 12  # keys; more cannot be read
WIDE = 100.0  # of greatest over least: a logarithmic axis
CLASSES = 15  # of a key, in which the share that fails is drawn


def draw_study(table: StudyTable, model: Model, title: str, folder: Path, *, drawn: bool = True) -> list[Path]:
    """Draw the model and the answers of a study into ``pictures/`` and return their paths; `drawn`: by chance."""
    from bsm_mesh.pictures.plotting import plot_model

    pictures = [save(plot_model(model, None, None), folder / PICTURES_FOLDER / "model.png")]
    answer = main_answer(table)
    if answer is None:
        return pictures
    for name, draw in _drawers(table, answer, drawn=drawn).items():
        figure = paper((WIDTH / 140, 5.5))
        draw(figure, table, answer)
        entitle(figure, f"{title}: {failure_in_words(table)}")
        pictures.append(save(figure, folder / PICTURES_FOLDER / f"{name}.png"))
    return pictures


def _drawers(table: StudyTable, answer: str, *, drawn: bool) -> dict[str, Callable[[Any, StudyTable, str], None]]:
    """Return which pictures there are: a tornado compares the effects of keys."""
    drawers: dict[str, Callable[[Any, StudyTable, str], None]] = {
        "histogram": _draw_histogram,
        "scatter": _draw_scatter,
    }
    if not drawn:
        drawers = {"values": _draw_values} if any(map(table.is_number, table.keys)) else {}
    if any(effect.width for effect in effects_on(table, answer)) and (drawn or len(table.keys) > 1):
        drawers["tornado"] = _draw_tornado
    return drawers


def _label(answer: str) -> str:
    return f"{NAMES[answer]} of stable runs, m" if answer == "max_displacement" else NAMES[answer]


def _draw_histogram(figure: Any, table: StudyTable, answer: str) -> None:
    """Draw how often which value of the answer comes; of a verdict alone the movement of stable runs."""
    axes, answers = figure.add_subplot(), answers_of(table)
    shown = answer if answer != "failure" or "max_displacement" not in answers else "max_displacement"
    values = answers[shown]
    values = values[np.isfinite(values)]
    log = _is_wide(values)
    low, high = float(values.min()), float(values.max())
    count = min(40, max(5, math.ceil(math.sqrt(len(values)))))
    if high - low <= 1e-9 * max(abs(high), 1e-300):
        low, high, log = low - 0.5 * abs(low) - 1e-12, high + 0.5 * abs(high) + 1e-12, False
    edges = np.geomspace(low, high, count + 1) if log else np.linspace(low, high, count + 1)
    axes.hist(values, bins=edges, color=STANDS, alpha=0.85, edgecolor="white", linewidth=0.5)
    if log:
        axes.set_xscale("log")
    if shown == "factor":
        axes.axvline(1.0, color=FAILS, linewidth=1.5)
    mean = float(values.mean())
    axes.axvline(mean, color="black", linestyle="--", linewidth=1, label=f"mean {mean:.4g}")
    axes.set_xlabel(_label(shown))
    axes.set_ylabel(f"runs, of {len(values)}")
    axes.legend(frameon=False, fontsize=9)


def _panels(figure: Any, table: StudyTable) -> Iterator[tuple[str, Any]]:
    """Yield the keys that are numbers, each with axes of its own."""
    keys = [key for key in table.keys if table.is_number(key)][:MOST_PANELS]
    columns = min(3, max(1, len(keys)))
    rows = -(-max(1, len(keys)) // columns)
    figure.set_size_inches(max(7.0, 4.7 * columns), 3.8 * rows + 0.5)
    for number, key in enumerate(keys):
        axes = figure.add_subplot(rows, columns, number + 1)
        yield key, axes
        axes.set_xlabel(", ".join(filter(None, (key, table.unit(key)))), fontsize=9, parse_math=False)
        axes.tick_params(labelsize=8)


def _draw_values(figure: Any, table: StudyTable, answer: str) -> None:
    """Draw the answer over the values of every key, a point a run; runs without a value are above the frame.

    Of verdicts alone all are, inside it. Lines join the runs in which all other keys are the same.
    """
    answers = answers_of(table)
    shown = answer if answer != "failure" or "max_displacement" not in answers else "max_displacement"
    values = np.full(table.count, np.nan) if shown == "failure" else answers[shown]
    standing, failing = stands(table), fails(table)
    marks = (
        (standing, "o", STANDS, "stable"),
        (failing, "x", FAILS, "unstable, or moved too far"),
        (~(standing | failing), "s", "grey", "without verdict"),
    )
    for key, axes in _panels(figure, table):
        given = table.numbers(key)
        others = [
            tuple(table.columns[other][run] for other in table.keys if other != key) for run in range(table.count)
        ]
        for same in dict.fromkeys(others):
            runs = [run for run in np.argsort(given, kind="stable") if others[run] == same]
            axes.plot(given[runs], values[runs], "-", color="grey", linewidth=0.8, alpha=0.6)
        top, height = axes.get_xaxis_transform(), 0.97 if shown == "failure" else 1.04
        for chosen, mark, colour, told in marks:
            known, unknown = chosen & np.isfinite(values), chosen & ~np.isfinite(values)
            axes.plot(given[known], values[known], mark, color=colour, ms=5)
            if unknown.any():  # an empty line that is not clipped has a place in the layout
                at_top = np.full(int(unknown.sum()), height)
                axes.plot(given[unknown], at_top, mark, color=colour, ms=6, transform=top, clip_on=False)
            if number_of_them := int(chosen.sum()):
                above = unknown.any() and shown != "failure"
                without = f" ({unknown.sum()} above the frame: no value)" if above else ""
                axes.plot([], [], mark, color=colour, label=f"{told}: {number_of_them}{without}")
        axes.margins(y=0.15)
        if shown == "failure":
            axes.set_yticks([])
        else:
            axes.set_ylabel(_label(shown), fontsize=9)
        if len(figure.axes) == 1:
            figure.legend(loc="outside lower center", ncols=3, frameon=False, fontsize=8)


def _draw_scatter(figure: Any, table: StudyTable, answer: str) -> None:
    """Draw every key against the answer, a point a run; of a verdict the share that fails along the key."""
    standing, failing = stands(table), fails(table)
    values = answers_of(table)[answer]
    for key, axes in _panels(figure, table):
        given = table.numbers(key)
        if answer == "failure":
            _draw_verdicts(axes, given, standing, failing)
        else:
            others = ~(standing | failing)
            for chosen, colour in ((standing, STANDS), (failing, FAILS), (others, "grey")):
                axes.plot(given[chosen], values[chosen], ".", color=colour, ms=5, alpha=0.6, mew=0)
            if _is_wide(values):
                axes.set_yscale("log")
        axes.set_ylabel(_label(answer), fontsize=9)


def _draw_verdicts(axes: Any, given: FloatArray, standing: BoolArray, failing: BoolArray) -> None:
    """Draw the share of runs that fail in classes of a key of as many runs each, and the runs as ticks at the edges."""
    known = standing | failing
    order = np.argsort(given[known], kind="stable")
    x, fail = given[known][order], failing[known][order].astype(np.float64)
    parts = [part for part in np.array_split(np.arange(len(x)), min(CLASSES, max(1, len(x) // 5))) if len(part)]
    middle = [float(x[part].mean()) for part in parts]
    axes.plot(middle, [float(fail[part].mean()) for part in parts], "o-", color="black", ms=4, linewidth=1)
    axes.plot(given[standing], np.full(int(standing.sum()), -0.04), "|", color=STANDS, alpha=0.5)
    axes.plot(given[failing], np.full(int(failing.sum()), 1.04), "|", color=FAILS, alpha=0.5)
    axes.set_ylim(-0.1, 1.1)


def _draw_tornado(figure: Any, table: StudyTable, answer: str) -> None:
    """Draw the mean of the answer in the quarters of the runs with the least and the greatest values of each key."""
    effects = [effect for effect in effects_on(table, answer) if effect.low is not None and effect.high is not None]
    effects = sorted(effects, key=lambda effect: effect.width)[-MOST_PANELS:]
    figure.set_size_inches(WIDTH / 140, 1.8 + 0.55 * len(effects))
    axes, mean = figure.add_subplot(), float(np.nanmean(answers_of(table)[answer]))
    for number, effect in enumerate(effects):
        assert effect.low is not None
        assert effect.high is not None
        for end, colour in ((effect.low, "#e08214"), (effect.high, STANDS)):
            axes.barh(number, end - mean, left=mean, height=0.6, color=colour)
    axes.axvline(mean, color="black", linewidth=1)
    axes.set_yticks(range(len(effects)), [effect.key for effect in effects], fontsize=9, parse_math=False)
    axes.set_xlabel(f"mean of: {_label(answer)}")
    from matplotlib.patches import Patch

    handles = [
        Patch(color="#e08214", label="quarter with the least values"),
        Patch(color=STANDS, label="quarter with the greatest"),
        Patch(color="black", label=f"all runs: {mean:.4g}"),
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=3, frameon=False, fontsize=8)


def _is_wide(values: FloatArray) -> bool:
    known = values[np.isfinite(values)]
    return len(known) > 0 and bool(known.min() > 0) and bool(known.max() > WIDE * known.min())
