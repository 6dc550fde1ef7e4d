"""Pictures of the blocks: the model, displacement, stress, deformation, and where the blocks are at the end.

Each draws on a sheet and returns its caption, or None where there is nothing to show.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.errors import counted
from bsm_mesh.movements import distances
from bsm_mesh.pictures.canvas import (
    GIVEN,
    MOVED,
    OUTLINE,
    Sheet,
    add_blocks,
    add_joints,
    add_outline,
    add_paper,
    middle,
    scaled,
)
from bsm_mesh.pictures.marks import (
    add_bolts,
    add_excluded,
    add_gone,
    add_gravity,
    add_loads,
    add_numbers,
    add_supports,
    add_water_table,
    arrows,
    told_count,
)
from bsm_mesh.pictures.monitoring import add_monitoring, add_vectors, vectors_beside
from bsm_mesh.pictures.zone_pictures import draw_deformed_zones
from bsm_mesh.results.stress import principal_stresses
from bsm_mesh.text.tables import engineering

MOST_GLYPHS = 700  # arrows or crosses, were they spread over all that is seen; more cannot be distinguished
LONGEST = 0.4  # of the visible part's shorter side: the greatest arrow of few blocks, which else leaves the frame
NOTHING = 1e-12  # of the model's size: less is no movement
COMPRESSION, TENSION = "#1f3b73", "#d55e00"


def draw_model(sheet: Sheet) -> str | None:
    """Draw the model: rocks, joint sets, supports, loads, bolts, water, places of histories, numbers of blocks."""
    add_paper(sheet, rocks=True)
    add_joints(sheet, sets=True)
    add_supports(sheet)
    add_loads(sheet)
    add_water_table(sheet)
    add_bolts(sheet)
    add_monitoring(sheet)
    add_gravity(sheet)
    told = add_gone(sheet)
    numbers = ", numbered where space allows" if add_numbers(sheet) else ""
    return f"{told_count(sheet)} in the initial position{numbers}{told}"


def draw_displacement(sheet: Sheet) -> str | None:
    """Draw the blocks by the magnitude of their displacement."""
    scene = sheet.scene
    size = distances(scene.stage.displacement)
    greatest = _greatest(sheet, size)
    if greatest <= NOTHING * scene.size:
        return None
    stays = np.where(scene.apart, 0.0, np.minimum(size, greatest))
    values, unit = scaled(stays[scene.shown], "m")
    shown = np.zeros(len(size))
    shown[scene.shown] = values
    remark = add_blocks(sheet, shown, f"displacement, {unit}", "viridis")
    _over(sheet)
    of = "displacement" if scene.stage.zones is None else "mean displacement"
    return f"{of} of the blocks, greatest {engineering(greatest, 'm')}{remark}{add_excluded(sheet)}"


def draw_sigma_1(sheet: Sheet) -> str | None:
    """Draw the blocks by their most compressive principal stress."""
    scene = sheet.scene
    sigma, _ = principal_stresses(scene.stage.stress)
    stays = scene.shown[scene.stressed[scene.shown]]
    if not len(stays) or not sigma[stays].any():
        return None
    add_paper(sheet)
    values, unit = scaled(sigma[stays], "Pa")
    shown = np.zeros(len(sigma))
    shown[stays] = values
    remark = add_blocks(sheet, shown, f"sigma_1, {unit} (compression negative)", "cividis", scene.stressed)
    _over(sheet)
    least = engineering(float(sigma[stays].min()), "Pa")
    return f"most compressive stress (sigma_1), {least} at most{_unknown(sheet)}{remark}{add_excluded(sheet)}"


def draw_arrows(sheet: Sheet) -> str | None:
    """Draw displacements as arrows on the outlines of the blocks, and those that are compared with at points."""
    scene = sheet.scene
    vectors = scene.stage.displacement[:, :2]
    size = np.hypot(*vectors.T)
    greatest = _greatest(sheet, size)
    beside = vectors_beside(sheet)
    longest_beside = max((float(np.hypot(*vector.T).max()) for _, vector in beside.values()), default=0.0)
    if max(greatest, longest_beside) <= NOTHING * scene.size:
        return None
    add_paper(sheet)
    add_joints(sheet)
    stays = scene.shown[~scene.apart[scene.shown]]
    chosen = stays[scene.spread(middle(scene, stays), MOST_GLYPHS)]
    values, unit = scaled(np.minimum(size[chosen], greatest), "m")
    x0, y0, x1, y1 = scene.view
    longest = min(1.6 * scene.spacing(min(MOST_GLYPHS, len(stays))), LONGEST * min(x1 - x0, y1 - y0))
    factor = longest / max(greatest, longest_beside)
    drawn = arrows(sheet, middle(scene, chosen), vectors[chosen] * factor, values, cmap="plasma")
    drawn.set_clim(0, float(values.max(initial=0.0)) or 1.0)
    sheet.scale(drawn, f"displacement, {unit}")
    add_vectors(sheet, beside, factor)
    _over(sheet)
    count = f"{len(chosen)} of {counted(len(stays), 'block')}"
    return f"displacement, greatest {engineering(greatest, 'm')}, {count}{add_excluded(sheet)}"


def draw_principal_stresses(sheet: Sheet) -> str | None:
    """Draw crosses of the principal stresses (as Wang Fig. 3.18)."""
    scene = sheet.scene
    stays = scene.shown[scene.stressed[scene.shown]]
    chosen = stays[scene.spread(middle(scene, stays), MOST_GLYPHS)]
    if not len(chosen) or not scene.stage.stress[chosen].any():
        return None
    add_paper(sheet)
    add_joints(sheet)
    xx, yy, xy = (scene.stage.stress[chosen, i, j] for i, j in ((0, 0), (1, 1), (0, 1)))
    angle = np.arctan2(2 * xy, xx - yy) / 2  # direction of the greatest (least compressive) stress
    mean, radius = (xx + yy) / 2, np.hypot((xx - yy) / 2, xy)
    greatest = float(max(np.abs(mean + radius).max(), np.abs(mean - radius).max()))
    size = float(np.sqrt(np.median(scene.results.blocks.moments.area[chosen])))
    half = min(
        0.8 * scene.spacing(min(MOST_GLYPHS, len(stays))), 0.6 * size * np.sqrt(max(1, len(stays) / MOST_GLYPHS))
    )
    for colour, sign, name in ((COMPRESSION, -1.0, "compression"), (TENSION, 1.0, "tension")):
        bars = [
            _bars(middle(scene, chosen), angle + turn, value * (half / greatest))[value * sign > 0.002 * greatest]
            for value, turn in ((mean + radius, 0.0), (mean - radius, np.pi / 2))
        ]
        sheet.lines(np.concatenate(bars), colors=colour, linewidths=1.4, zorder=3)
        sheet.explain(name, color=colour, linewidth=1.4)
    _over(sheet)
    return f"principal stresses, longest bar {engineering(greatest, 'Pa')}{_unknown(sheet)}{add_gone(sheet)}"


def draw_deformation(sheet: Sheet) -> str | None:
    """Draw the deformed blocks, exaggerated, over their outline (as Wang Fig. 6.10)."""
    scene = sheet.scene
    if _greatest(sheet, distances(scene.stage.displacement)) <= NOTHING * scene.size:
        return None
    if scene.stage.zones is None:
        factor = scene.exaggeration
        add_paper(sheet, factor)
        add_joints(sheet, factor)
    else:
        factor = draw_deformed_zones(sheet)
    sheet.outline(colors="#0072b2", linewidths=1.2, linestyles="--", zorder=3)
    sheet.explain("initial outline", color="#0072b2", linewidth=1.2, linestyle="--")
    told = add_gone(sheet, note="drawn in the initial position")
    how = f"exaggerated {factor:g} times" if factor > 1 else "true to scale"
    return f"deformation, {how}{told}"


def draw_final_position(sheet: Sheet) -> str | None:
    """Draw the blocks where they are at the end, true to scale (as Wang Fig. 4.19)."""
    scene = sheet.scene
    faint: dict[str, Any] = {"facecolors": "none", "edgecolors": GIVEN, "linewidths": 0.7}
    sheet.blocks(scene.here, **faint)
    stays = scene.here[~scene.apart[scene.here]]
    edges = {"edgecolors": OUTLINE if scene.outlines_seen else "face", "linewidths": 0.5}
    sheet.blocks(stays, 1.0, facecolors=MOVED, **edges)
    sheet.explain_patch("initial position", facecolor="white", edgecolor=GIVEN)
    sheet.explain_patch("final position", facecolor=MOVED, edgecolor=OUTLINE)
    told = add_gone(sheet, 1.0)
    add_water_table(sheet)
    add_bolts(sheet)
    return f"final position, true to scale{told}"


def _over(sheet: Sheet) -> None:
    """Draw what most pictures show over the blocks."""
    add_joints(sheet)
    add_outline(sheet)
    add_water_table(sheet)
    add_bolts(sheet)
    add_gravity(sheet)


def _greatest(sheet: Sheet, size: FloatArray) -> float:
    """Return the greatest value of the blocks that stay, are seen, and are not too small to count."""
    scene = sheet.scene
    counts = scene.stage.counts & ~scene.apart
    return float(size[scene.shown[counts[scene.shown]]].max(initial=0.0))


def _unknown(sheet: Sheet) -> str:
    """Return what to say of blocks whose mean stress is not known, as ``run`` says it."""
    scene = sheet.scene
    left_out = int((~scene.stressed & ~scene.apart)[scene.shown].sum())
    return f"; {counted(left_out, 'block')} excluded: supported, or slivers" if left_out else ""


def _bars(centre: FloatArray, angle: FloatArray, half: FloatArray) -> FloatArray:
    """Return lines (k, 2, 2) about centres, at angles, of half lengths of either sign."""
    along = np.column_stack([np.cos(angle), np.sin(angle)]) * half[:, None]
    return np.stack([centre - along, centre + along], axis=1)
