"""Pictures along lines: extensions and displacements at the end of every stage, and the values compared with them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.model.kinds import in_space
from bsm_mesh.pictures.beside_marks import Looks, by_source, draw_beside, ends_of, looks_of, stages_that_count
from bsm_mesh.pictures.canvas import WIDTH, add_key, prefixed_unit
from bsm_mesh.pictures.figures import entitle, paper
from bsm_mesh.results.beside import line_movement
from bsm_mesh.results.histories import Recorded
from bsm_mesh.results.results import Results

Curves: TypeAlias = dict[int, dict[str, tuple[FloatArray, FloatArray]]]
"""Of a line by stage and quantity: values [m], and their distances from the first point [m]."""

if TYPE_CHECKING:
    from matplotlib.figure import Figure

HEIGHT = 2.9  # inches a chart
NOTHING = 1e-9  # of the greatest movement of all stages: less is rounding
PLACES = 240  # along a line
WORDS = {"towards": "towards the first point", "across": "across, to the left", "extension": "extension"}
FAINT = {"towards": 1.0, "across": 0.55, "extension": 1.0}  # where both are drawn


def draw_extensometers(results: Results, title: str, figure: Figure | None = None) -> Figure | None:
    """Return a chart of every line: its extensions over the distance, at the end of every stage; None: no line."""
    return _charts(results, ("extension",), title, figure)


def draw_profiles(results: Results, title: str, figure: Figure | None = None) -> Figure | None:
    """Return a chart of every line: displacements towards its first point and across it; None: no line, or in space.

    Where values are compared with it, only of the quantities that they have.
    """
    if in_space(results.blocks):
        return None
    return _charts(results, ("towards", "across"), title, figure)


def _charts(results: Results, quantities: Sequence[str], title: str, figure: Figure | None) -> Figure | None:
    lines = [one for one in results.recorded if one.kind == "line" and one.points]
    curves = {one.name: _curves(results, one, quantities) for one in lines}
    stages = _moving(curves)
    if not stages:
        return None
    columns = min(2, len(lines))
    rows = -(-len(lines) // columns)
    figure = figure or paper((WIDTH / 100, HEIGHT * rows + 0.9))
    axes = figure.subplots(rows, columns, squeeze=False).reshape(-1)
    for place in axes[len(lines) :]:
        place.axis("off")
    looks = looks_of(results, lines, stages)
    key: dict[str, Any] = {}
    for place, recorded in zip(axes, lines, strict=False):
        for drawn in _draw_line(place, results, recorded, curves[recorded.name], looks):
            key.setdefault(drawn.get_label(), drawn)
    entitle(figure, title)
    add_key(figure, list(key.values()))
    return figure


def _moving(curves: dict[str, Curves]) -> list[int]:
    """Return the stages at whose end any line moved."""
    stages = list(dict.fromkeys(stage for by_stage in curves.values() for stage in by_stage))
    size = {
        stage: max(
            float(np.abs(np.nan_to_num(values)).max(initial=0.0))
            for by_stage in curves.values()
            for values, _ in by_stage.get(stage, {}).values()
        )
        for stage in stages
    }
    return [stage for stage in stages if size[stage] > NOTHING * max(size.values())]


def _draw_line(axes: Any, results: Results, recorded: Recorded, curves: Curves, looks: Looks) -> list[Any]:
    """Draw the quantities of a line that are asked for; return the entries of the key."""
    curves = {stage: curve for stage, curve in curves.items() if stage in looks.stages}
    chosen = _chosen(recorded, list(next(iter(curves.values()))))
    beside = {
        quantity: {key: listed for key, listed in by_source(results, recorded, quantity).items() if key[1] in curves}
        for quantity in chosen
    }
    everything = [curve[quantity][0] for curve in curves.values() for quantity in chosen]
    everything.append(ends_of(listed for found in beside.values() for listed in found.values()))
    factor, unit = prefixed_unit(np.concatenate(everything), "m")
    drawn = []
    for quantity in chosen:
        more = f", {WORDS[quantity]}" if len(chosen) > 1 else ""
        look = {"alpha": FAINT[quantity] if more else 1.0, "linewidth": 1.6}
        for stage, curve in curves.items():
            values, distance = curve[quantity]
            if np.isfinite(values).any():
                marks = {"marker": "o", "markersize": 2.5} if quantity == "extension" else {}
                drawn += axes.plot(
                    distance, values / factor, color=looks.colour(stage), label=f"{looks.label(stage)}{more}",
                    zorder=4, **look, **marks,
                )  # fmt: skip
        for (_, stage), listed in beside[quantity].items():
            place = np.array([one.distance for one in listed], dtype=np.float64)
            mark = draw_beside(axes, place, listed, factor, looks, stage, joined=False)
            mark.set_alpha(look["alpha"])
            drawn.append(mark)
    _dress(axes, recorded, chosen, unit)
    return drawn


def _chosen(recorded: Recorded, quantities: Sequence[str]) -> list[str]:
    """Return which quantities are drawn: those that all sources have, or any of them, or all that are asked for."""
    given: dict[str, set[str]] = {}
    for one in recorded.measured:
        if one.quantity in quantities:
            given.setdefault(one.source, set()).add(one.quantity)
    common = set.intersection(*given.values()) if given else set()
    chosen = common or set().union(*given.values()) or set(quantities)
    return [quantity for quantity in quantities if quantity in chosen]


def _curves(results: Results, recorded: Recorded, quantities: Sequence[str]) -> Curves:
    """Return the computed values at the end of the stages that count.

    Extensions are those of the points that were recorded, displacements anywhere along the line.
    """
    anchors = np.concatenate([[0.0], recorded.distances])
    order = np.argsort(anchors, kind="stable")
    places = np.linspace(0.0, float(anchors.max()), PLACES)
    series = results.histories[recorded.name]
    curves: Curves = {}
    for stage in stages_that_count(results):
        if "extension" not in quantities:
            movement = line_movement(results, results.stages[stage], recorded.points, places)
            curves[stage] = {quantity: (movement[quantity], places) for quantity in quantities}
        elif len(rows := np.flatnonzero(series.stage == stage)):
            values = np.concatenate([[0.0], series.values[rows[-1]]])
            curves[stage] = {"extension": (values[order], anchors[order])}
    return curves


def _dress(axes: Any, recorded: Recorded, quantities: Sequence[str], unit: str) -> None:
    """Write the labels of the axes."""
    what = WORDS[quantities[0]] if len(quantities) == 1 else "displacement"
    axes.set_title(f"{recorded.name} (line)", fontsize=10, loc="left", parse_math=False)
    axes.set_xlabel("distance from the first point, m", fontsize=9)
    axes.set_ylabel(f"{what}, {unit}", fontsize=9)
    axes.axhline(0.0, color="#888888", linewidth=0.8)
    axes.tick_params(labelsize=8)
    axes.grid(visible=True, color="#dddddd", linewidth=0.6)
