"""Where a run records histories, drawn over blocks: points and lines with their names; vectors compared with."""

from __future__ import annotations

from typing import Any

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.model.locate import blocks_at
from bsm_mesh.pictures.beside_marks import COLOURS, by_source
from bsm_mesh.pictures.canvas import Sheet
from bsm_mesh.pictures.figures import TEXT
from bsm_mesh.pictures.marks import arrows
from bsm_mesh.results.movement import displacement_at

MOST_NAMED = 30  # points and lines; the names of more would touch
PLACES = "#8a1c6c"


def add_monitoring(sheet: Sheet) -> None:
    """Draw the points and lines of the histories with their names."""
    x0, y0, x1, y1 = sheet.scene.view
    placed = [one for one in sheet.scene.results.recorded if one.points]
    for recorded in placed:
        points = sheet.scene.flat(np.array(recorded.points))
        line = recorded.kind == "line"
        style: dict[str, Any] = {
            "linestyle": ":" if line else "none",
            "linewidth": 1.6,
            "marker": "o",
            "markersize": 3 if line else 4,
        }
        sheet.axes.plot(*points.T, color=PLACES, zorder=5, **style)
        at = points[(len(points) - 1) // 2 :][:2].mean(axis=0)  # of a line between two of its points
        if len(placed) <= MOST_NAMED and x0 < at[0] < x1 and y0 < at[1] < y1:
            sheet.axes.annotate(
                recorded.name, tuple(at), xytext=(5, 3), textcoords="offset points", fontsize=8, color=PLACES,
                zorder=6, parse_math=False,
            )  # fmt: skip
    for kind, dash in (("point", "none"), ("line", ":")):
        if any(recorded.kind == kind for recorded in placed):
            sheet.explain(
                f"{kind}s of histories", color=PLACES, marker="o", markersize=4, linestyle=dash, linewidth=1.6
            )


def vectors_beside(sheet: Sheet) -> dict[str, tuple[FloatArray, FloatArray]]:
    """Return by source the points with a given displacement of both components, and it, (k, 2) [m] each.

    At the same points the run's own displacements, under the name "".
    """
    scene = sheet.scene
    found: dict[str, list[tuple[Any, Any]]] = {}
    for recorded in scene.results.recorded:
        if recorded.kind != "point":
            continue
        u, v = (by_source(scene.results, recorded, name) for name in "uv")
        for source, number in u:
            if number == scene.number and (source, number) in v:
                vector = (u[source, number][0].middle, v[source, number][0].middle)
                found.setdefault(source, []).append((recorded.points[0], vector))
    vectors = {source: (np.array(listed)[:, 0], np.array(listed)[:, 1]) for source, listed in found.items()}
    if vectors:
        points = np.unique(np.concatenate([points for points, _ in vectors.values()]), axis=0)
        block = np.array([blocks_at(scene.results.blocks, (x, y))[0] for x, y in points])
        vectors[""] = points, displacement_at(scene.results.blocks, scene.stage, block, points)
    return vectors


def add_vectors(sheet: Sheet, vectors: dict[str, tuple[FloatArray, FloatArray]], factor: float) -> None:
    """Draw displacements with the run's own at the points of histories, so many times as long."""
    sources = [source for source in vectors if source]
    for source, (points, vector) in vectors.items():
        colour = COLOURS[(1 + sources.index(source)) % len(COLOURS)] if source else TEXT
        arrows(sheet, points, factor * vector, colour, width=0.004, zorder=6)
        sheet.explain(source or "computed at the same points", color=colour, marker=">", linewidth=2.0)
