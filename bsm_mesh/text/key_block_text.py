"""Key blocks in words: lines and rows of a table, from the columns of the answer or of its file."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from bsm_mesh.arrays import IntArray
from bsm_mesh.errors import counted
from bsm_mesh.text.tables import engineering
from bsm_mesh.three_d.key_blocks.modes import FALLS, HELD, MODES, NOT_JUDGED, ONE

HEADER = ("block", "movement", "factor", "m3", "weight", "support")
ROUND = 2  # where its column goes in a header
Columns = Mapping[str, Any]


def unstable_rows(columns: Columns) -> IntArray:
    """Return the rows of blocks below the required factor, round by round, the heaviest first."""
    rows = np.flatnonzero(columns["round"] > 0)
    order: IntArray = rows[np.lexsort((-columns["weight"][rows], columns["round"][rows]))]
    return order


def key_block_table(columns: Columns, rows: IntArray) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
    """Return header and rows of a table of some blocks; with their round where there are several."""
    several = columns["round"].max(initial=0) > 1
    header = (*HEADER[:ROUND], *(("round",) if several else ()), *HEADER[ROUND:])
    return header, [_row(columns, k, several) for k in rows.tolist()]


def key_block_lines(told: Mapping[str, Any], columns: Columns) -> list[str]:
    """Return lines on all blocks at free faces, by the record of the answer and its columns."""
    rows, required = unstable_rows(columns), told["required"]
    falls, slides = len(told["falls"]), len(told["slides"])
    lines = [
        f"{counted(told['blocks'], 'block')}: {told['at_free_faces']} at free faces, {told['removable']} removable",
        f"{falls} fall and {slides} slide below a factor of {required:g}: {told['volume']:.4g} m3 in all",
    ]
    factor, free = columns["bolted_factor"], columns["round"] == 0
    least = np.flatnonzero(columns["removable"] & ~columns["sliver"] & np.isfinite(factor) & free)
    if not len(rows) and len(least):
        block, movement, value = _row(columns, int(least[np.argmin(factor[least])]), several=False)[:3]
        lines.append(f"least factor {value}: block {block} {movement}")
    held = int(((columns["factor"] < required) & free & (columns["bolt_pull"] > 0)).sum())
    if held:
        lines.append(f"bolts hold {counted(held, 'block')} that would fall or slide without them")
    return lines


def _row(columns: Columns, k: int, several: bool) -> tuple[str, ...]:
    factor, support = float(columns["bolted_factor"][k]), float(columns["bolted_support"][k])
    removable = bool(columns["removable"][k])
    return (
        str(columns["block"][k]),
        _movement(columns, k),
        *((str(columns["round"][k] or "-"),) if several else ()),
        f"{factor:.3f}" if removable and np.isfinite(factor) else "-",
        f"{columns['volume'][k]:.4g}",
        engineering(float(columns["weight"][k]), "N"),
        engineering(support, "Pa") if removable and np.isfinite(support) else "-",
    )


def _movement(columns: Columns, k: int) -> str:
    """Return how a block moves: on which joints it slides, or its mode in block theory."""
    mode = MODES.index(columns["mode"][k])
    if mode in (HELD, FALLS):
        return MODES[mode]
    if mode == NOT_JUDGED:
        return f"{MODES[mode]}: reaches a side"
    if mode < ONE:
        return f"removable, {MODES[mode]}"
    planes = [columns[name][k] or "rock" for name in ("joint_1", "joint_2")[: mode - FALLS]]
    return f"slides on {', '.join(planes)}"
