"""Charts of the bolts: their forces along them, and the support pressures (as Wang Figs. 8.13, 8.14)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from bsm_mesh.pictures.canvas import WIDTH
from bsm_mesh.pictures.figures import entitle, paper
from bsm_mesh.results.bolts import BoltForces, BoltStatus

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PRESSURE = "support pressure: force of a bolt over its spacing and its length of wall, half way to the adjacent bolts"
MOST_CHARTS = 12  # bolts with their own chart: the most utilised
COLOURS = {
    BoltStatus.SLACK: "#9e9e9e",
    BoltStatus.ELASTIC: "#1f4e79",
    BoltStatus.SLIPPING: "#e08214",
    BoltStatus.YIELDING: "#c62828",
}


def draw_bolt_forces(bolts: BoltForces, title: str, figure: Figure | None = None) -> Figure | None:
    """Return charts of axial and bond force along the most utilised bolts, and the support pressures; None: no bolt."""
    if not (bolts.status != BoltStatus.ABSENT).any():
        return None
    used = np.zeros(bolts.count)
    np.maximum.at(
        used, bolts.bolt, np.maximum(bolts.utilisation, bolts.axial_force / max(bolts.axial_force.max(), 1.0))
    )
    used[bolts.status == BoltStatus.ABSENT] = -1
    chosen = np.sort(np.argsort(-used, kind="stable")[:MOST_CHARTS])
    chosen = chosen[used[chosen] >= 0]
    rows = max(1, -(-len(chosen) // 3))
    figure = figure or paper((WIDTH / 100, 2.6 * (rows + 1)))
    axes = figure.subplots(rows + 1, 3)
    for place in axes[:rows].reshape(-1)[len(chosen) :]:
        place.axis("off")
    for place, bolt in zip(axes[:rows].reshape(-1), chosen.tolist(), strict=False):
        _draw_along(place, bolts, bolt)
    grid = axes[rows, 0].get_gridspec()
    for place in axes[rows]:
        place.remove()
    pressures = figure.add_subplot(grid[rows, :])
    _draw_pressures(pressures, bolts)
    if (there := int((used >= 0).sum())) > len(chosen):
        pressures.set_title(f"above: the {len(chosen)} most used of {there} bolts", fontsize=8, loc="left")
    entitle(figure, title)
    return figure


def _draw_along(axes: Any, bolts: BoltForces, bolt: int) -> None:
    """Draw the tension of a bolt's elements as steps, and the bond forces of its nodes as bars."""
    nodes = slice(bolts.node_start[bolt], bolts.node_start[bolt + 1])
    elements = slice(nodes.start - bolt, nodes.stop - bolt - 1)
    station = bolts.station[nodes]
    axial, bond = bolts.axial_force[elements] / 1e3, bolts.bond_force[nodes] / 1e3
    status = BoltStatus(int(bolts.status[bolt]))
    if len(axial):
        axes.stairs(axial, station, fill=True, color=COLOURS[status], alpha=0.35)
        axes.stairs(axial, station, color=COLOURS[status], linewidth=2, label="axial force")
    width = 0.02 * float(station[-1]) if len(station) > 1 else 0.1
    axes.bar(station, bond, width=width, color="#444444", label="bond force on the rock")
    axes.axhline(0.0, color="black", linewidth=0.8)
    axes.set_title(f"{bolts.names[bolt]} ({status.name.lower()})", fontsize=10, parse_math=False)
    axes.set_xlabel("distance from the head, m", fontsize=8)
    axes.set_ylabel("force of one bolt, kN", fontsize=8)
    axes.tick_params(labelsize=8)
    axes.legend(fontsize=7, frameon=False)


def _draw_pressures(axes: Any, bolts: BoltForces) -> None:
    """Draw every bolt's support pressure on the wall, "?" where it has no neighbour; head forces if none has one."""
    pressure = bolts.support_pressure / 1e3
    known = np.isfinite(pressure)
    values = pressure if known.any() else bolts.head_force / 1e3
    what = "support pressure on the wall, kPa" if known.any() else "force at the head, kN"
    number = np.arange(bolts.count)
    shown = np.isfinite(values)
    if known.any():  # both readings of Fig. 8.14
        axes.bar(number[shown] - 0.2, values[shown], color="#1f4e79", width=0.4, label="by the force at the head")
        mean = bolts.mean_pressure / 1e3
        axes.bar(number[shown] + 0.2, mean[shown], color="#e69f00", width=0.4, label="by the mean tension")
        axes.legend(fontsize=7, frameon=False, ncols=2)
        axes.set_xlabel(PRESSURE, fontsize=8)
    else:
        axes.bar(number[shown], values[shown], color="#1f4e79", width=0.7)
    axes.set_xlim(-0.6, bolts.count - 0.4)
    for place in number[~shown]:
        axes.annotate("?", (place, 0.02), xycoords=("data", "axes fraction"), ha="center", fontsize=10)
    if not shown.all():
        axes.set_title("?: no adjacent bolt determines how much of the wall it holds", fontsize=8, loc="right")
    axes.set_ylabel(what, fontsize=8)
    axes.tick_params(labelsize=8)
    if bolts.count <= 30:
        axes.set_xticks(number, bolts.names, fontsize=8, rotation=0 if bolts.count <= 12 else 60, parse_math=False)
    else:
        axes.set_xlabel(f"bolt; {PRESSURE}" if known.any() else "bolt", fontsize=8)
