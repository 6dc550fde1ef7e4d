"""Water under a table: forces on blocks wherever they are, and their change by movements."""

from __future__ import annotations

from typing import Any

import numpy as np

from .geometry import AGREES, Arrays, placed, scaled, shapes

WATER = 9810.0  # N/m3, where the model file gives none
SAME = 1e-9  # relative: numbers of two files of the same model


def water_on(a: Arrays, position: Any) -> tuple[Any, Any]:
    """Return the table's force and moment about the centroid on every block, (n, 3), and the stiffness, (n, 3, 3).

    A face d at the arm r has N = (-dy, dx, r.d) of a unit pressure; a movement changes the pressure by G = (g, r x g).
    All pressures turn with their faces.
    """
    moved = "outline" in a and position is a["position"]  # blocks that deformed have outlines of their own
    there = shapes(a) if moved else {"corner": placed(a, position), "following": a["following"]}
    owner = np.repeat(np.arange(len(position)), np.diff(there["offsets"])) if moved else a["owner"]
    start = there["corner"]
    along = start[there["following"]] - start
    arm = start - (a["at"] if moved else a["centroid"] + position[:, :2])[owner]
    total, change = np.zeros((len(position), 3)), np.zeros((len(position), 3, 3))

    def add(t: Any, pressure: Any, slope: Any, weight: Any) -> None:
        r = arm + t[:, None] * along
        force = np.column_stack([-along[:, 1], along[:, 0], (r * along).sum(axis=1)]) * weight[:, None]
        by = np.column_stack([slope, r[:, :1] * slope[:, 1:] - r[:, 1:] * slope[:, :1]])
        np.add.at(total, owner, force * pressure[:, None])
        np.add.at(change, owner, force[:, :, None] * by[:, None, :])

    ends = np.concatenate([[-np.inf], a["water_breaks"], [np.inf]])
    for piece, (level, slope, gradient) in enumerate(a["water_pieces"]):
        if np.isfinite(level):
            head, rise = level + slope * start[:, 0] - start[:, 1], slope * along[:, 0] - along[:, 1]
            first, last = wet(start, along, ends[piece : piece + 2], head, rise)
            by = np.tile(gradient * np.array([slope, -1.0]), (len(start), 1))
            for t, weight in ((first, 1 / 6), ((first + last) / 2, 2 / 3), (last, 1 / 6)):  # of degree 2: exact
                add(t, gradient * np.maximum(head + rise * t, 0.0), by, weight * (last - first))
    for x, before, after in zip(a["water_breaks"], a["water_pieces"], a["water_pieces"][1:], strict=False):
        with np.errstate(divide="ignore", invalid="ignore"):
            t = (x - start[:, 0]) / along[:, 0]
            crosses = (t > 0) & (t < 1)
            t = np.where(crosses, t, 0.0)
            y = start[:, 1] + t * along[:, 1]
            jump = [g * np.maximum(level + slope * x - y, 0.0) for level, slope, g in (before, after)]
            by_x = np.where(crosses, (jump[1] - jump[0]) / np.abs(along[:, 0]), 0.0)
        add(t, np.zeros(len(t)), np.column_stack([by_x, np.zeros(len(t))]), np.ones(len(t)))
    change[:, 0, 2] -= total[:, 1]
    change[:, 1, 2] += total[:, 0]
    return total, -change


def wet(start: Any, along: Any, between: Any, head: Any, rise: Any) -> tuple[Any, Any]:
    """Return where faces get under a piece of the table and leave it, as parts of their length; the same: never."""
    with np.errstate(divide="ignore", invalid="ignore"):
        first, last = np.clip(np.sort((between - start[:, :1]) / along[:, :1], axis=1).T, 0.0, 1.0)
        dry = -head / rise  # where the face leaves the water
    inside = (start[:, 0] >= between[0]) & (start[:, 0] < between[1])
    upright = along[:, 0] == 0
    first, last = np.where(upright, 0.0, first), np.where(upright, inside * 1.0, last)
    first = np.where((rise > 0) & (dry > first), np.minimum(dry, last), first)
    last = np.where((rise < 0) & (dry < last), np.maximum(dry, first), last)
    return first, np.where((rise == 0) & (head <= 0), first, last)


def water_faults(a: Arrays, reference: float) -> list[str]:
    """Return whether the water on the blocks is that of the table."""
    if "water_pieces" not in a:
        return []
    found = water_on(a, a["position"])[0] * a["present"][:, None]
    off = np.abs(scaled(a, found - a["water"])).max(axis=1)
    allowed = AGREES * (reference + np.abs(a["water"][:, :2]).max(initial=0.0))
    return [] if off.max(initial=0.0) <= allowed else [f"block {int(off.argmax())} has other water than the table's"]


def load_stiffness(a: Arrays) -> Any:
    """Return the stiffness of loads that follow their points and of the table's water, symmetric part (n, 3, 3)."""
    found = water_on(a, a["position"])[1]
    arm = a["load_point"] - a["at"][a["load_block"]]
    np.add.at(found[:, 2, 2], a["load_block"], (arm * a["load_force"]).sum(axis=1))
    return (found + found.transpose(0, 2, 1)) / 2 * a["present"][:, None, None]


def stiffness_faults(a: Arrays) -> list[str]:
    """Return whether the stiffness of loads and water is theirs; that of flow and joints is as given."""
    if "water_pieces" not in a or "load_point" not in a:
        return []
    wanted = load_stiffness(a)
    given = a.get("load_stiffness", np.zeros_like(wanted))
    scale = 1 / np.column_stack([np.ones((len(given), 2)), a["gyration"]])
    off, most = (np.abs(k) * scale[:, :, None] * scale[:, None, :] for k in (given - wanted, wanted))
    steepest = np.where(np.isfinite(a["water_pieces"][:, 0]), a["water_pieces"][:, 2], 0.0).max()
    allowed = AGREES * (most.max(initial=0.0) + steepest * np.ptp(a["vertices"]))
    return [] if off.max(initial=0.0) <= allowed else ["the stiffness of loads and water is not theirs"]


def table_faults(a: Arrays, water: dict[str, Any], file: str) -> list[str]:
    """Return whether the table is another one than that of the model file's [water], or of its highest lines."""
    lines = water.get("table", [])
    if not lines:
        return [f"there is a water table, and none in {file}"] if np.isfinite(a["water_pieces"][:, 0]).any() else []
    lines = [np.array(one, dtype=float) for one in (lines if isinstance(lines[0][0], list) else [lines])]
    breaks = np.unique(np.concatenate([a["water_breaks"], *(one[:, 0] for one in lines)]))
    ends = np.concatenate([[breaks[0] - 1.0], breaks, [breaks[-1] + 1.0]])
    x = np.concatenate([ends[:-1] + share * np.diff(ends) for share in (0.25, 0.75)])
    level, slope, gradient = a["water_pieces"][np.searchsorted(a["water_breaks"], x)].T
    high = max(np.ptp(a["vertices"]), *(np.abs(one[:, 1]).max() for one in lines))
    same = np.abs(level + slope * x - table_at(lines, x)).max() <= SAME * high
    heavy = water.get("unit_weight", WATER)
    wanted = heavy / (1 + slope**2 * (water.get("head") == "parallel"))
    same &= np.abs(gradient - wanted).max() <= SAME * heavy
    return [] if same else [f"the water table is not that of {file}"]


def table_at(lines: list[Any], x: Any) -> Any:
    """Return the highest line at abscissas x, of those that reach there; straight over gaps, level beyond all ends."""
    over = np.full((len(lines), len(x)), -np.inf)
    for row, line in zip(over, lines, strict=True):  # a few lines
        inside = (x > line[0, 0]) & (x < line[-1, 0])
        row[inside] = np.interp(x[inside], *line.T)
    highest = over.max(axis=0)
    points = np.concatenate(lines)
    points = points[np.lexsort((points[:, 1], points[:, 0]))]
    dry = np.flatnonzero(~np.isfinite(highest))
    for k in dry:  # beside all lines
        left, right = points[points[:, 0] <= x[k]], points[points[:, 0] >= x[k]]
        near = [side[side[:, 0] == at(side[:, 0])][-1] for side, at in ((left, np.max), (right, np.min)) if len(side)]
        highest[k] = np.interp(x[k], *np.array(near).T)
    return highest
