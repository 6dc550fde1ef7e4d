"""Pictures of a shaken stage: peak acceleration, permanent displacement; histories and energy over time."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.model.base_motion import GRAVITY
from bsm_mesh.pictures.canvas import SETS, WIDTH, Sheet, add_blocks, add_outline, add_paper, prefixed_unit
from bsm_mesh.pictures.figures import entitle, paper
from bsm_mesh.pictures.history_pictures import HEIGHT, WORDS
from bsm_mesh.pictures.marks import add_excluded
from bsm_mesh.results.histories import HistorySeries
from bsm_mesh.results.results import Results
from bsm_mesh.results.shaking import ENERGIES, ShakingResult
from bsm_mesh.text.tables import engineering

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NAMES = {name: name.replace("_", " ") for name in ENERGIES} | {"kinetic": "movement", "error": "left over"}
GIVEN = 2  # the first energies are put in


def draw_peak_acceleration(sheet: Sheet) -> str | None:
    """Draw the blocks by their greatest acceleration, that of the base included."""
    shaking, scene = sheet.scene.stage.shaking, sheet.scene
    if shaking is None or not shaking.peak_acceleration.any():
        return None
    values = shaking.peak_acceleration / GRAVITY
    add_paper(sheet)  # supported blocks move with the base
    remark = add_blocks(sheet, values, "greatest acceleration, g", "viridis", values > 0)
    add_outline(sheet)
    greatest = float(values[scene.shown].max(initial=0.0))
    base = float(np.abs(shaking.base_acceleration).max()) / GRAVITY
    return (
        f"greatest acceleration of the blocks, up to {greatest:.3g} g (base: {base:.3g} g); "
        f"impacts of blocks on each other make short peaks{remark}"
    )


def draw_permanent(sheet: Sheet) -> str | None:
    """Draw the blocks by the displacement that the shaken stage leaves, relative to the base."""
    scene = sheet.scene
    if scene.stage.shaking is None:
        return None
    size = np.hypot(*scene.stage.stage_displacement[:, :2].T)
    stays = np.where(scene.down, 0.0, size)  # blocks at rest after a long way are the answer here
    greatest = float(stays[scene.shown].max(initial=0.0))
    if greatest == 0:
        return None
    factor, unit = prefixed_unit(stays[scene.shown], "m")
    remark = add_blocks(sheet, stays / factor, f"permanent displacement, {unit}", "viridis", ~scene.down)
    add_outline(sheet)
    return f"displacement that the shaking leaves, up to {engineering(greatest, 'm')}{remark}{add_excluded(sheet)}"


def draw_time_histories(results: Results, number: int, title: str, figure: Figure | None = None) -> Figure | None:
    """Return charts over the time of a shaken stage: acceleration of the base, and every history; None for others."""
    shaking = results.stages[number].shaking
    if shaking is None:
        return None
    timed = [step.time for step in results.stages[number].steps if step.time is not None]
    series = list(results.histories.values())
    figure = figure or paper((WIDTH / 100, HEIGHT * (1 + len(series)) + 0.6))
    places = np.atleast_1d(figure.subplots(1 + len(series), 1, sharex=True))
    places[0].plot(shaking.time, shaking.base_acceleration / GRAVITY, color="#444444", linewidth=0.9)
    places[0].set_ylabel("base, g", fontsize=9)
    for axes, one in zip(places[1:], series, strict=True):
        _draw_series(axes, one, number, np.array(timed))
    _finish(places, figure, title)
    return figure


def _draw_series(axes: Any, series: HistorySeries, number: int, time: FloatArray) -> None:
    """Draw a history over the times of a stage, the quantities of its first unit to the left axis."""
    values = series.values[series.stage == number][: len(time)]
    units = list(dict.fromkeys(series.recorded.units))
    sides = dict(zip(units, (axes, axes.twinx() if len(units) > 1 else axes), strict=False))
    lines = []
    for k, (name, unit) in enumerate(zip(series.recorded.quantities, series.recorded.units, strict=True)):
        if unit not in sides:
            continue
        mine = [i for i, other in enumerate(series.recorded.units) if other == unit]
        factor, shown = prefixed_unit(values[:, mine], unit) if unit in ("m", "N") else (1.0, unit)
        label = f"{WORDS.get(name, name.replace('_', ' '))}, {shown}".rstrip(", ")
        style = "-" if sides[unit] is axes else ":"
        lines += sides[unit].plot(time, values[:, k] / factor, style, color=SETS[k % len(SETS)], label=label)
        sides[unit].set_ylabel(shown or "share of the length", fontsize=9)
    axes.set_title(f"{series.recorded.name} ({series.recorded.kind})", fontsize=10, loc="left", parse_math=False)
    axes.legend(handles=lines, fontsize=8, frameon=False, ncols=4, loc="best")


def draw_energy(results: Results, number: int, title: str, figure: Figure | None = None) -> Figure | None:
    """Return the chart of energies over the time of a shaken stage; None for others."""
    shaking = results.stages[number].shaking
    if shaking is None or not shaking.energy.any():
        return None
    figure = figure or paper((WIDTH / 100, 2 * HEIGHT + 0.6))
    axes = figure.add_subplot()
    _draw_energies(axes, shaking)
    _finish(np.array([axes]), figure, title)
    return figure


def _draw_energies(axes: Any, shaking: ShakingResult) -> None:
    """Draw the changes of energies since the start: of springs and bolts they may be below 0."""
    energy = shaking.energy - shaking.energy[0]
    factor, unit = prefixed_unit(energy, "J")
    shown = [k for k in range(GIVEN, len(ENERGIES) - 1) if energy[:, k].any()]
    for k in shown:
        axes.plot(shaking.time, energy[:, k] / factor, color=SETS[(k - GIVEN) % len(SETS)], label=NAMES[ENERGIES[k]])
    given = energy[:, :GIVEN].sum(axis=1) / factor
    axes.plot(shaking.time, given, "--", color="black", label="put in by base, weights and water")
    axes.plot(shaking.time, energy[:, -1] / factor, ":", color="#c62828", label=NAMES["error"])
    axes.set_ylabel(f"energy per metre of thickness, {unit}", fontsize=9)
    axes.set_title(
        f"error of the balance: at most {100 * shaking.imbalance:.2g} % of the greatest energy",
        fontsize=10, loc="left",
    )  # fmt: skip
    axes.legend(fontsize=8, frameon=False)


def _finish(places: Any, figure: Figure, title: str) -> None:
    for axes in places:
        axes.grid(visible=True, color="#dddddd", linewidth=0.6)
        axes.tick_params(labelsize=8)
    places[-1].set_xlabel("time, s", fontsize=9, loc="right")
    entitle(figure, title)
