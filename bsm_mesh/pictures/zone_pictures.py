"""Pictures of zones: stresses within blocks."""

from __future__ import annotations

import numpy as np

from bsm_mesh.pictures.canvas import Sheet, add_joints, add_outline, add_paper, limits, scaled
from bsm_mesh.pictures.marks import add_gone
from bsm_mesh.results.stress import principal_stresses
from bsm_mesh.text.tables import engineering


def draw_zone_sigma_1(sheet: Sheet) -> str | None:
    """Draw the zones by their most compressive principal stress."""
    return _draw(sheet, 0, "sigma_1", "most compressive principal stress")


def draw_zone_sigma_3(sheet: Sheet) -> str | None:
    """Draw the zones by their least compressive principal stress."""
    return _draw(sheet, 1, "sigma_3", "least compressive principal stress")


def _draw(sheet: Sheet, which: int, name: str, words: str) -> str | None:
    scene = sheet.scene
    zones = scene.stage.zones
    if zones is None or not zones.stress.any():
        return None
    sigma = principal_stresses(zones.stress)[which]
    add_paper(sheet)
    chosen = np.flatnonzero(np.isin(zones.block, scene.shown))
    values, unit = scaled(sigma[chosen], "Pa")
    (low, high), remark = limits(values)
    drawn = sheet.polygons(
        list(zones.points[zones.cells[chosen, :3]]), array=values, cmap="cividis", edgecolors="face", linewidths=0.1
    )
    drawn.set_clim(low, high)
    sheet.scale(drawn, f"{name}, {unit} (compression negative)")
    add_joints(sheet)
    add_outline(sheet)
    span = f"{engineering(float(sigma[chosen].min()), 'Pa')} to {engineering(float(sigma[chosen].max()), 'Pa')}"
    return f"{words} in {len(chosen)} zones, {span}{remark}{add_gone(sheet)}"
