"""Pictures of zones: stresses and yielding within blocks."""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.movements import lengths
from bsm_mesh.pictures.canvas import ROCKS, Sheet, add_joints, add_outline, add_paper, limits, scaled
from bsm_mesh.pictures.marks import add_excluded
from bsm_mesh.results.stress import principal_stresses
from bsm_mesh.results.zones import ZoneResult
from bsm_mesh.text.exaggeration import exaggeration
from bsm_mesh.text.tables import engineering


def draw_zone_displacement(sheet: Sheet) -> str | None:
    """Draw the zones by the magnitude of the mean displacement of their corners."""
    zones = sheet.scene.stage.zones
    if zones is None or not zones.displacement.any():
        return None
    chosen = np.flatnonzero(np.isin(zones.block, sheet.scene.shown))
    size = lengths(zones.displacement[zones.cells[chosen, :3]].mean(axis=1))
    values, unit = scaled(size, "m")
    remark, gone = _draw(sheet, zones, chosen, values, f"displacement, {unit}")
    greatest = engineering(float(lengths(zones.displacement[zones.cells[chosen]].reshape(-1, 2)).max(initial=0.0)), "m")
    return f"displacement in {len(chosen)} zones, of a node up to {greatest}{remark}{gone}"


def draw_zone_sigma_1(sheet: Sheet) -> str | None:
    """Draw the zones by their most compressive principal stress."""
    return _draw_stress(sheet, 0, "sigma_1", "most compressive stress (sigma_1)")


def draw_zone_sigma_3(sheet: Sheet) -> str | None:
    """Draw the zones by their least compressive principal stress."""
    return _draw_stress(sheet, 1, "sigma_3", "most tensile stress (sigma_3)")


def draw_zone_yielding(sheet: Sheet) -> str | None:
    """Draw the zones that yielded by their plastic shear strain."""
    zones = sheet.scene.stage.zones
    if zones is None or not zones.yielded.any():
        return None
    chosen = np.flatnonzero(np.isin(zones.block, sheet.scene.shown) & (zones.yielded > 0))
    strain = zones.plastic_strain[chosen]
    remark, gone = _draw(sheet, zones, chosen, strain, "plastic shear strain")
    return f"plastic shear strain of {len(chosen)} zones that yielded, up to {strain.max():.3g}{remark}{gone}"


def _draw_stress(sheet: Sheet, which: int, name: str, words: str) -> str | None:
    zones = sheet.scene.stage.zones
    if zones is None or not zones.stress.any():
        return None
    chosen = np.flatnonzero(np.isin(zones.block, sheet.scene.shown))
    sigma = principal_stresses(zones.stress)[which][chosen]
    values, unit = scaled(sigma, "Pa")
    remark, gone = _draw(sheet, zones, chosen, values, f"{name}, {unit} (compression negative)")
    span = f"{engineering(float(sigma.min()), 'Pa')} to {engineering(float(sigma.max()), 'Pa')}"
    return f"{words} in {len(chosen)} zones, {span}{remark}{gone}"


def draw_moved_zones(sheet: Sheet, factor: float) -> None:
    """Draw the zones where they moved to, their displacement times a factor, by plastic shear strain."""
    zones = sheet.scene.stage.zones
    assert zones is not None
    corners = list((zones.points + factor * zones.displacement)[zones.cells[:, :3]])
    (low, high), _ = limits(zones.plastic_strain)
    drawn = sheet.polygons(corners, array=zones.plastic_strain, cmap="cividis", edgecolors="face", linewidths=0.1)
    drawn.set_clim(low, high)
    sheet.scale(drawn, "plastic shear strain")


def draw_deformed_zones(sheet: Sheet) -> float:
    """Draw zones by the displacement of their nodes and rigid blocks by their own; return how many times."""
    scene, zones = sheet.scene, sheet.scene.stage.zones
    assert zones is not None
    stays = ~scene.apart
    greatest = max(zones.max_displacement(scene.stage.present & stays), scene.greatest_movement)
    factor = exaggeration(greatest, scene.results.blocks, scene.here)
    rigid = scene.shown[stays[scene.shown] & ~np.isin(scene.shown, zones.block)]
    cells = zones.cells[stays[zones.block] & np.isin(zones.block, scene.shown)]
    ring = cells[:, :3] if cells.shape[1] == 3 else cells[:, [0, 3, 1, 4, 2, 5]]
    points = zones.points + factor * zones.displacement
    sheet.blocks(rigid, factor, facecolors=ROCKS[0], edgecolors="black", linewidths=0.8)
    sheet.polygons(list(points[ring]), facecolors=ROCKS[0], edgecolors="face", linewidths=0.2)
    sheet.lines(points[_rim(ring)], colors="black", linewidths=0.8)
    return factor


def _rim(ring: IntArray) -> IntArray:
    """Return the sides of triangles that belong to one of them only, (k, 2): joints and outer faces."""
    sides = np.stack([ring, np.roll(ring, -1, axis=1)], axis=2).reshape(-1, 2)
    found, count = np.unique(np.sort(sides, axis=1), axis=0, return_counts=True)
    rim: IntArray = found[count == 1]
    return rim


def _draw(sheet: Sheet, zones: ZoneResult, chosen: IntArray, values: FloatArray, label: str) -> tuple[str, str]:
    """Draw some zones by a value, (k,) each, and return remarks on its scale and on blocks that are gone."""
    add_paper(sheet)
    (low, high), remark = limits(values)
    corners = list(zones.points[zones.cells[chosen, :3]])
    drawn = sheet.polygons(corners, array=values, cmap="cividis", edgecolors="face", linewidths=0.1)
    drawn.set_clim(low, high)
    sheet.scale(drawn, label)
    add_joints(sheet)
    add_outline(sheet)
    return remark, add_excluded(sheet)
