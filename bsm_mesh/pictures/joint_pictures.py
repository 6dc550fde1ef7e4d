"""Pictures of the joints: state, slip, opening, utilisation, pressure; and forces as lines of thrust.

Each draws on a sheet and returns its caption, or None where there is nothing to show.
"""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.pictures.canvas import (
    HOLDS,
    OPENS,
    SLIPS,
    Sheet,
    add_outline,
    add_paper,
    gone,
    limits,
    middle,
    scaled,
)
from bsm_mesh.pictures.marks import add_bolts, add_gone, add_gravity, add_supports, add_water_table
from bsm_mesh.pictures.scene import Scene
from bsm_mesh.results.records import ContactStatus
from bsm_mesh.text.tables import engineering, percent

WIDEST, NARROWEST = 7.0, 0.4  # points: lines of the greatest and of the least force that is drawn
LEAST = 1e-6  # of the greatest: what is less is not drawn
LEAST_IN_SPACE = 0.1  # of the greatest: what is less would hide what lies behind
TRUE = 1.0  # joints are drawn where the blocks are, to scale


def draw_state(sheet: Sheet) -> str | None:
    """Draw the joints by their state: sticking, slipping, open; the shares are those of the tables."""
    scene = sheet.scene
    chosen = _joints(scene)
    if not chosen.any():
        return None
    sheet.background(TRUE)
    status, length, given = scene.faces.status, scene.faces.length, scene.results.blocks
    total = float(length[chosen].sum())
    slipping, is_open = scene.faces.slipping, scene.faces.open
    measure = "length" if scene.is_plane else "area"
    for kind, colour, width, part in (
        (ContactStatus.STICKING, HOLDS, 1.0, 1.0 - slipping - is_open),
        (ContactStatus.OPEN, OPENS, 2.6, is_open),
        (ContactStatus.SLIPPING, SLIPS, 2.6, slipping),
    ):
        if scene.is_plane or kind != ContactStatus.STICKING:  # in space these would hide the others
            mine = np.flatnonzero(chosen & (status == kind))
            sheet.faces(mine, TRUE, widths=width, colors=colour, zorder=2.5)
        share = percent(float((length * part)[chosen].sum()) / total) if total else "0 %"
        sheet.explain(f"{kind.name.lower()}, {share} of the {measure}", color=colour, linewidth=width)
    return f"state of the joints, {engineering(total, given.face_unit)} in all{_over(sheet)}"


def draw_slip(sheet: Sheet) -> str | None:
    """Draw the joints by how far they have slipped."""
    return _by_value(sheet, np.abs(sheet.scene.faces.slip), "m", "slip", "viridis_r")


def draw_opening(sheet: Sheet) -> str | None:
    """Draw the joints by how far they have opened."""
    return _by_value(sheet, np.maximum(sheet.scene.faces.opening, 0.0), "m", "opening", "viridis_r")


def draw_utilisation(sheet: Sheet) -> str | None:
    """Draw the joints by shear force over shear strength."""
    scene = sheet.scene
    values = np.minimum(scene.faces.utilisation, 1.0)
    caption = _by_value(sheet, values, "", "utilisation", "viridis_r", (0.0, 1.0))
    return None if caption is None else caption.replace("greatest", "shear force over strength, greatest")


def draw_pressure(sheet: Sheet) -> str | None:
    """Draw the joints by the pressure that they carry."""
    pressure = np.maximum(sheet.scene.faces.pressure, 0.0)
    return _by_value(sheet, pressure, "Pa", "pressure", "cividis_r")


def draw_thrust(sheet: Sheet) -> str | None:
    """Draw the contact forces as lines of thrust: from block to block through where the resultant acts.

    Of a row of blocks it is the line of thrust of an arch.
    """
    scene = sheet.scene
    contacts = scene.stage.contacts
    if not len(contacts.length):
        return None
    pairs, pair = np.unique(
        np.sort(np.column_stack([contacts.block_a, contacts.block_b]), axis=1), axis=0, return_inverse=True
    )
    pair = pair.reshape(-1)
    sense = np.where(contacts.block_b == pairs[pair, 1], 1.0, -1.0)[:, None]
    force, at, weight = np.zeros((len(pairs), 2)), np.zeros((len(pairs), 2)), np.zeros(len(pairs))
    np.add.at(force, pair, sense * contacts.force)
    share = np.hypot(contacts.normal_force, contacts.shear_force)
    np.add.at(weight, pair, share)
    np.add.at(at, pair, share[:, None] * contacts.point)
    size = np.hypot(*force.T)
    chosen = (weight > 0) & (size > LEAST * size.max(initial=0.0)) & _seen(scene, pairs)
    if not chosen.any():
        return None
    add_paper(sheet, TRUE)
    at = at[chosen] / weight[chosen, None]
    ends = _turning_points(scene, pairs[chosen], at)
    lines = np.concatenate([np.stack([end, at], axis=1) for end in ends])
    values, unit = scaled(np.tile(size[chosen], 2), "N/m")
    (_, high), remark = limits(values)
    width = np.clip(WIDEST * values / (high or 1.0), NARROWEST, WIDEST)
    drawn = sheet.lines(lines, array=values, cmap="cividis_r", linewidths=width, zorder=2.5, capstyle="round")
    drawn.set_clim(0, high or 1.0)
    sheet.scale(drawn, f"force between two blocks, {unit}")
    told = f"lines of thrust, greatest force {engineering(float(size[chosen].max()), 'N/m')}; width by force"
    return f"{told}{remark}{_over(sheet)}"


def _turning_points(scene: Scene, pairs: IntArray, at: FloatArray) -> list[FloatArray]:
    """Return where lines of thrust through points (k, 2) turn in both blocks of pairs (k, 2): two arrays (k, 2).

    That is the centroid. A block between two others, such as a stone of an arch, has one straight line.
    """
    count = scene.results.blocks.count
    forces = np.bincount(pairs.ravel(), minlength=count)
    forces[scene.stage.supports.block] = 0  # a support is a further force
    half = np.zeros((count, 2))
    np.add.at(half, pairs.ravel(), np.repeat(at, 2, axis=0) / 2)
    return [
        np.where(forces[block, None] == 2, half[block], middle(scene, block, TRUE))
        for block in (pairs[:, 0], pairs[:, 1])
    ]


def _by_value(
    sheet: Sheet, values: FloatArray, unit: str, name: str, colours: str, ends: tuple[float, float] | None = None
) -> str | None:
    """Draw the joints by a value (k,) that is not negative, wide where it is large."""
    scene = sheet.scene
    chosen = _joints(scene)
    greatest = float(values[chosen].max(initial=0.0))
    if greatest <= 0 or (unit == "m" and greatest < 1e-12 * scene.size):
        return None
    sheet.background(TRUE)
    if not scene.is_plane:
        chosen = chosen & (values >= LEAST_IN_SPACE * greatest)
    shown, prefixed = scaled(values[chosen], unit) if unit else (values[chosen], "")
    (_, high), remark = ((0.0, ends[1]), "") if ends else limits(shown)
    order = np.argsort(shown, kind="stable")  # the greatest on top
    width = np.clip(4.0 * shown / (high or 1.0), 0.7, 4.0)
    faces = np.flatnonzero(chosen)[order]
    drawn = sheet.faces(faces, TRUE, widths=width[order], array=shown[order], cmap=colours, zorder=2.5)
    drawn.set_clim(0, high or 1.0)
    sheet.scale(drawn, f"{name}, {prefixed}" if prefixed else name)
    told = engineering(greatest, unit) if unit else f"{greatest:.3g}"
    least = "" if scene.is_plane else f", those above {percent(LEAST_IN_SPACE)} of it"
    return f"joints by {name}, greatest {told}{least}{remark}{_over(sheet)}"


def _joints(scene: Scene) -> BoolArray:
    """Return which faces have a joint, stay and are seen, (k,)."""
    faces = scene.faces
    seen = _seen(scene, scene.face_pairs)
    chosen: BoolArray = (faces.joint >= 0) & seen & ~gone(scene)
    return chosen


def _seen(scene: Scene, pairs: IntArray) -> BoolArray:
    """Return of which pairs of blocks (k, 2) one is seen."""
    seen = np.zeros(scene.results.blocks.count, dtype=bool)
    seen[scene.shown] = True
    return np.asarray(seen[pairs].any(axis=1))


def _over(sheet: Sheet) -> str:
    """Draw what these pictures show besides, and return what to say of blocks that have gone."""
    add_outline(sheet, TRUE)
    add_supports(sheet)
    add_water_table(sheet)
    add_bolts(sheet)
    add_gravity(sheet)
    return add_gone(sheet, TRUE)
