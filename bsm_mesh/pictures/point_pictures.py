"""The picture of the points: how far each moved at the end of every stage, and the values compared with (Fig. 8.19)."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from bsm_mesh.model.beside import Beside
from bsm_mesh.pictures.beside_marks import Looks, by_source, draw_beside, ends_of, looks_of, stages_that_count
from bsm_mesh.pictures.canvas import WIDTH, add_key, prefixed_unit
from bsm_mesh.pictures.figures import entitle, paper
from bsm_mesh.results.beside import at_the_end
from bsm_mesh.results.histories import Recorded
from bsm_mesh.results.results import Results

if TYPE_CHECKING:
    from matplotlib.figure import Figure

HEIGHT = 5.4  # inches
FEWEST = 2  # points: one is better seen over the steps
MOST_LEVEL = 10  # names that are written level
QUANTITY = "displacement"


def draw_points(results: Results, title: str, figure: Figure | None = None) -> Figure | None:
    """Return a chart of the displacements of all points and blocks of histories; None: fewer than two."""
    points = [one for one in results.recorded if one.kind in ("point", "block")]
    stages = stages_that_count(results)
    if len(points) < FEWEST or not stages:
        return None
    looks = looks_of(results, points, stages)
    curves = {
        stage: np.array([at_the_end(results.histories[one.name], QUANTITY, stage) for one in points])
        for stage in stages
    }
    beside = _beside(results, points)
    everything = [*curves.values(), ends_of(listed.values() for listed in beside.values())]
    factor, unit = prefixed_unit(np.concatenate(everything), "m")
    figure = figure or paper((WIDTH / 100, HEIGHT))
    axes = figure.subplots()
    place = np.arange(len(points))
    key = []
    for stage, curve in curves.items():
        if np.isfinite(curve).any():
            key += axes.plot(place, curve / factor, "o-", color=looks.colour(stage), linewidth=1.6,
                             markersize=4, zorder=4, label=looks.label(stage))  # fmt: skip
    key += _draw_beside(axes, beside, factor, looks, len(points))
    axes.set_xticks(place, [one.name for one in points], fontsize=8, parse_math=False,
                    rotation=0 if len(points) <= MOST_LEVEL else 60)  # fmt: skip
    axes.set_ylabel(f"displacement, {unit}", fontsize=9)
    axes.set_ylim(bottom=0.0)
    axes.tick_params(labelsize=8)
    axes.grid(visible=True, color="#dddddd", linewidth=0.6)
    entitle(figure, title)
    add_key(figure, key)
    return figure


def _beside(results: Results, points: list[Recorded]) -> dict[tuple[str, int], dict[int, Beside]]:
    """Return displacements to compare with those of the points, by source and stage, then by the number of the point.

    Of a point of which u and v are known, and no displacement, their length.
    """
    found: dict[tuple[str, int], dict[int, Beside]] = {}
    for number, recorded in enumerate(points):
        known = {quantity: by_source(results, recorded, quantity) for quantity in ("u", "v", QUANTITY)}
        for key, listed in known[QUANTITY].items():
            found.setdefault(key, {})[number] = listed[0]
        for key, listed in known["u"].items():
            if key in known["v"] and number not in found.get(key, {}):
                length = math.hypot(listed[0].middle, known["v"][key][0].middle)
                one = Beside(quantity=QUANTITY, value=length, stage=listed[0].stage, source=listed[0].source)
                found.setdefault(key, {})[number] = one
    return found


def _draw_beside(
    axes: Any, beside: dict[tuple[str, int], dict[int, Beside]], factor: float, looks: Looks, count: int
) -> list[Any]:
    """Draw the values compared with; a source that knows all points has a line."""
    return [
        draw_beside(
            axes, np.array(list(listed), dtype=np.float64), list(listed.values()), factor, looks, stage,
            joined=len(listed) == count,
        )
        for (_, stage), listed in beside.items()
    ]  # fmt: skip
