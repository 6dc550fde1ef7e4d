"""Pictures of the bolts in the model: their axial force, and how much of their strength is used along them."""

from __future__ import annotations

from typing import Any

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.pictures.canvas import Sheet, add_joints, add_outline, add_paper, scaled
from bsm_mesh.pictures.figures import TEXT
from bsm_mesh.pictures.marks import add_gone, add_gravity, add_heads, bolt_lines
from bsm_mesh.text.tables import engineering

WIDTH = 5.0  # points
MOST_NAMED = 40  # bolts


def draw_bolts(sheet: Sheet) -> str | None:
    """Draw the bolts by their axial force."""
    bolts = sheet.scene.stage.bolts
    force = bolts.axial_force
    values, unit = scaled(force, "N")
    greatest = float(force.max(initial=0.0))
    told = _by_value(sheet, values, f"axial force of a bolt, {unit}", "plasma_r", float(values.max(initial=0.0)))
    return None if told is None else f"axial force in the bolts, greatest {engineering(greatest, 'N')}{told}"


def draw_bolt_utilisation(sheet: Sheet) -> str | None:
    """Draw how much of the strength of steel, bond and grout is used along every bolt."""
    used = np.minimum(sheet.scene.stage.bolts.utilisation, 1.0)
    if not used.any():
        return None
    told = _by_value(sheet, used, "utilisation: force over strength", "viridis_r", 1.0)
    return None if told is None else f"utilisation along the bolts, greatest {used.max():.3g}{told}"


def _by_value(sheet: Sheet, values: FloatArray, title: str, colours: str, greatest: float) -> str | None:
    lines, element = bolt_lines(sheet.scene)
    if not len(lines):
        return None
    add_paper(sheet)
    add_joints(sheet)
    sheet.lines(lines, colors="black", linewidths=WIDTH + 1.6, zorder=4)
    drawn: Any = sheet.lines(lines, array=values[element], cmap=colours, linewidths=WIDTH, zorder=4.1)
    drawn.set_clim(0.0, greatest or 1.0)
    sheet.scale(drawn, title)
    add_heads(sheet)
    add_outline(sheet)
    add_gravity(sheet)
    _add_names(sheet)
    sheet.explain("head", linestyle="none", marker="o", markersize=4, color=TEXT)
    return add_gone(sheet)


def _add_names(sheet: Sheet) -> None:
    """Write the names of the bolts at their tips, where they are not too many."""
    bolts = sheet.scene.stage.bolts
    if bolts.count > MOST_NAMED:
        return
    from matplotlib.patheffects import withStroke

    x0, y0, x1, y1 = sheet.scene.view
    rim = [withStroke(linewidth=2.0, foreground="white")]  # a name may lie over another bolt
    seen = sheet.scene.flat(bolts.original)
    tips, heads = seen[bolts.node_start[1:] - 1], seen[bolts.node_start[:-1]]
    for name, (x, y), side in zip(bolts.names, tips.tolist(), np.sign(tips[:, 0] - heads[:, 0]).tolist(), strict=True):
        if x0 < x < x1 and y0 < y < y1:
            sheet.axes.annotate(
                name, (x, y), xytext=(4 * side, 2), textcoords="offset points", fontsize=7, zorder=6,
                ha="right" if side < 0 else "left", va="bottom", parse_math=False, path_effects=rim,
            )  # fmt: skip
