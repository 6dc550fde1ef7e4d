"""The picture of the water: its pressure along every face, as a band as wide as the pressure is great."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.pictures.canvas import Sheet, add_outline, add_paper, scaled
from bsm_mesh.pictures.marks import add_bolts, add_gone, add_gravity, add_supports, add_water_table
from bsm_mesh.pictures.scene import Scene
from bsm_mesh.results.water_faces import wet_parts
from bsm_mesh.text.tables import engineering

OF_A_BLOCK = 0.3  # of a block's size: width of the band of the greatest pressure, but ...
LEAST, WIDEST = 0.006, 0.03  # ... within these parts of the visible part
SHADES = 12  # colours along a face on which the pressure rises from nothing to the greatest
TRUE = 1.0  # faces are drawn where the blocks are, to scale


def draw_water(sheet: Sheet) -> str | None:
    """Draw the pressure of the water along the faces: in joints to both sides of them, on outer faces outside."""
    scene = sheet.scene
    inner = _wet(scene, scene.face_lines, scene.faces.joint)
    outer = _wet(scene, scene.outline, np.full(len(scene.outline()), -1))
    ends, pressure = (np.concatenate(both) for both in zip(inner, outer, strict=True))
    x0, y0, x1, y1 = scene.view
    low, high = ends.min(axis=1, initial=np.inf), ends.max(axis=1, initial=-np.inf)
    seen = ((high > (x0, y0)) & (low < (x1, y1))).all(axis=1)
    seen &= (low < high).any(axis=1)  # a table through a corner leaves parts without length
    greatest = float(pressure[seen].max(initial=0.0))
    if greatest <= 0:
        return None
    add_paper(sheet, TRUE)
    block = float(np.sqrt(np.median(scene.results.blocks.moments.area[scene.shown])))
    widest = float(np.clip(OF_A_BLOCK * block, LEAST * scene.size, WIDEST * scene.size))
    is_outer = np.arange(len(ends)) >= len(inner[0])
    bands, mean = _bands(ends[seen], pressure[seen] / greatest, is_outer[seen], widest)
    values, unit = scaled(mean * greatest, "Pa")
    drawn = sheet.polygons(list(bands), array=values, cmap="Blues", edgecolors="face", linewidths=0.2, zorder=2.5)
    drawn.set_gid("water")
    drawn.set_clim(0, float(values.max()) / float(mean.max()))  # up to the greatest
    sheet.scale(drawn, f"water pressure along the faces, {unit}")
    sheet.lines(ends[seen], colors="#333333", linewidths=0.6, zorder=2.6)
    add_outline(sheet, TRUE)
    add_supports(sheet)
    add_water_table(sheet)
    add_bolts(sheet)
    add_gravity(sheet)
    told = add_gone(sheet, TRUE)
    return (
        f"water pressure along the faces, greatest {engineering(greatest, 'Pa')}; the width of a band shows "
        f"the pressure{told}"
    )


def _wet(scene: Scene, lines: Callable[[float], FloatArray], joint: IntArray) -> tuple[FloatArray, FloatArray]:
    """Return ends (p, 2, 2) and pressures (p, 2) of the wet parts of faces, or of the outline (blocks on its left)."""
    there = lines(0.0 if scene.results.has_small_displacements else TRUE)  # where the water meets the blocks
    parts = wet_parts(scene.stage, there[:, 0], there[:, 1], joint, lines(0.0))
    return parts.at(*lines(TRUE).transpose(1, 0, 2)), parts.pressure


def _bands(ends: FloatArray, pressure: FloatArray, is_outer: BoolArray, widest: float) -> tuple[FloatArray, FloatArray]:
    """Return the corners (k, 4, 2) of pieces of bands along lines, and the mean pressure of each, (k,).

    Parameters
    ----------
    ends : (p, 2, 2) float64 [m]
        Of the lines.
    pressure : (p, 2) float64
        At the ends, over the greatest.
    is_outer : (p,) bool
        Whether the band lies to the right of the line only, else to both sides.
    widest : float [m]
        Width where the pressure is the greatest.
    """
    count = np.maximum(np.ceil(SHADES * np.abs(np.diff(pressure, axis=1)[:, 0])), 1).astype(int)
    line = np.repeat(np.arange(len(count)), count)
    first = np.arange(len(line)) - np.repeat(np.cumsum(count) - count, count)
    along = (ends[:, 1] - ends[:, 0])[line]
    right = np.stack([along[:, 1], -along[:, 0]], axis=1) / np.hypot(*along.T)[:, None]
    sides = np.where(is_outer[line, None], [1.0, 0.0], [0.5, -0.5])
    corners, found = [], []
    for k, order in ((0, (0, 1)), (1, (1, 0))):  # both ends, round the piece
        t = (first + k) / count[line]
        value = pressure[line, 0] + t * (pressure[line, 1] - pressure[line, 0])
        at = ends[line, 0] + t[:, None] * along
        corners += [at + (widest * value * sides[:, side])[:, None] * right for side in order]
        found.append(value)
    return np.stack(corners, axis=1), np.mean(found, axis=0)
