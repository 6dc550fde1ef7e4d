"""Pictures of flow in the joints: heads with what enters and leaves, and discharges."""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import BoolArray
from bsm_mesh.pictures.canvas import FAINT, WATER, Sheet, add_outline, add_paper, limits
from bsm_mesh.pictures.figures import TEXT
from bsm_mesh.pictures.marks import add_gone, add_gravity, add_name
from bsm_mesh.results.flow import FlowResult
from bsm_mesh.text.flow_text import discharge_text, in_litres

STILL = 1e-9  # of the greatest discharge: what is less is still water
TRICKLES = "#c58b00"
WIDEST, NARROWEST = 4.5, 0.6  # points: joints of the greatest and of the least discharge
MOST_ARROWS = 90
ENTERS, LEAVES = "#0a4f7a", "#a33b00"
MOST_NAMED = 8  # places where most enters or leaves
OF_NAMES = ((34, 20), (34, -20), (34, 46), (34, -46), (34, 72), (34, -72))  # points from a place, the first tried first


def draw_head(sheet: Sheet) -> str | None:
    """Draw the joints by the head of the water in them, the dry ones thin, and what enters and leaves where."""
    flow = sheet.scene.stage.flow
    if flow is None:
        return None
    add_paper(sheet)
    lines, (wet, trickles) = flow.lines, _states(flow)
    dry = ~(wet | trickles)
    sheet.lines(lines[dry], colors=FAINT, linewidths=0.8)
    sheet.lines(lines[trickles], colors=TRICKLES, linewidths=1.0, linestyles=(0, (2, 2)))
    head = (flow.head[flow.first] + flow.head[flow.last]) / 2
    parts = lines[:, :1] + flow.wet[:, :, None] * np.diff(lines, axis=1)
    (low, high), remark = limits(head[wet])
    drawn = sheet.lines(parts[wet], array=head[wet], cmap="viridis", linewidths=2.2, capstyle="round", zorder=2.5)
    drawn.set_clim(low, high if high > low else low + 1.0)
    sheet.scale(drawn, "head (level of the water), m")
    sheet.lines(flow.shore, colors=WATER, linewidths=4.0, zorder=2.4)
    add_outline(sheet)
    _add_places(sheet, flow)
    add_gravity(sheet)
    told = add_gone(sheet)
    for found, label, style in (
        (dry, "dry", {"color": FAINT, "linewidth": 1.0}),
        (trickles, "water trickles, without pressure", {"color": TRICKLES, "linestyle": (0, (2, 2))}),
    ):
        if found.any():
            sheet.explain(label, **style)
    if len(flow.shore):
        sheet.explain("boundary under water", color=WATER, linewidth=4.0)
    return f"head of the water in the joints; {discharge_text(flow.through)} flows through them{remark}{told}"


def draw_discharge(sheet: Sheet) -> str | None:
    """Draw the joints by their discharge, with arrows where it goes."""
    scene, flow = sheet.scene, sheet.scene.stage.flow
    if flow is None:
        return None
    size = np.abs(flow.discharge)
    greatest = float(size.max(initial=0.0))
    if greatest <= 0:
        return None
    add_paper(sheet)
    flows = size > STILL * greatest
    lines = np.where((flow.discharge >= 0)[:, None, None], flow.lines, flow.lines[:, ::-1])
    sheet.lines(lines[~flows], colors=FAINT, linewidths=0.8)
    factor, unit = in_litres(greatest)
    order = np.flatnonzero(flows)[np.argsort(size[flows], kind="stable")]  # the greatest on top
    width = np.clip(WIDEST * np.sqrt(size[order] / greatest), NARROWEST, WIDEST)
    drawn = sheet.lines(
        lines[order], array=factor * size[order], cmap="viridis_r", linewidths=width, capstyle="round", zorder=2.5
    )
    drawn.set_clim(0, factor * greatest)
    sheet.scale(drawn, f"discharge, {unit} per m")
    middle = lines.mean(axis=1)
    strong = np.flatnonzero(size > 0.02 * greatest)
    chosen = strong[scene.spread(middle[strong], MOST_ARROWS)]
    along = lines[chosen, 1] - lines[chosen, 0]
    unit_vectors = along / np.hypot(*along.T)[:, None]
    sheet.axes.quiver(
        *middle[chosen].T,
        *unit_vectors.T,
        color=TEXT,
        pivot="mid",
        width=0.0016,
        scale=75,
        headwidth=5,
        zorder=3,
    )
    add_outline(sheet)
    add_gravity(sheet)
    told = add_gone(sheet)
    return (
        f"discharge of the joints, greatest {discharge_text(greatest)}; width by its root, arrows where it goes if "
        f"it is more than a fiftieth of that{told}"
    )


def _states(flow: FlowResult) -> tuple[BoolArray, BoolArray]:
    """Return which pieces are under pressure, and in which of the others water trickles, (m,) each."""
    wet: BoolArray = np.asarray((flow.wet_pressure > 0).any(axis=1))
    greatest = float(np.abs(flow.discharge).max(initial=0.0))
    flows: BoolArray = np.abs(flow.discharge) > STILL * greatest
    return wet, ~wet & flows


def _add_places(sheet: Sheet, flow: FlowResult) -> None:
    """Draw where water enters and leaves, and name the places with how much."""
    greatest = float(np.abs(flow.outflow).max(initial=0.0))
    if greatest <= 0:
        return
    for sign, colour, marker, label in ((-1, ENTERS, "v", "water enters"), (1, LEAVES, "o", "water leaves")):
        nodes = np.flatnonzero(sign * flow.outflow > STILL * greatest)
        if nodes.size:
            area = 10 + 60 * np.abs(flow.outflow[nodes]) / greatest
            sheet.axes.scatter(
                *flow.point[nodes].T, s=area, color=colour, marker=marker, zorder=4, linewidths=0.4, edgecolors="white"
            )
            sheet.explain(label, color=colour, marker=marker, linestyle="none")
    leaving = flow.leaving
    named = [k for k in np.argsort(-np.abs(leaving))[:MOST_NAMED].tolist() if abs(leaving[k]) > STILL * greatest]
    for k in named:
        at = np.flatnonzero((flow.place == k) & (flow.outflow * leaving[k] > 0))
        weight = np.abs(flow.outflow[at])
        middle = at[int(np.searchsorted(np.cumsum(weight), weight.sum() / 2))]
        word, told = "out" if leaving[k] > 0 else "in", discharge_text(abs(float(leaving[k])), beside=flow.through)
        colour = LEAVES if leaving[k] > 0 else ENTERS
        text = f"{flow.places[k]}: {told} {word}"
        add_name(sheet, flow.point[middle], text, colour, OF_NAMES, leftwards=0.5)
