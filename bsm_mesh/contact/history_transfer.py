"""History transfer: active contacts continue in the same candidate, or in the nearest one when they have ended."""

from __future__ import annotations

import numpy as np

from bsm_mesh.compiled import njit
from bsm_mesh.contact.narrow_phase import DROPPED, KEPT
from bsm_mesh.contact.outlines import Record, RecordArray
from bsm_mesh.contact.rules import Rules
from bsm_mesh.contact.same_place import are_duals

ACTIVE = np.dtype(  # an active contact, as in `search.ActiveContacts`
    [("pair", "i8"), ("key", "i8"), ("pressure", "f8"), ("x", "f8"), ("y", "f8"), ("nx", "f8"), ("ny", "f8")]
)


@njit(forceinline=True)
def rows_of_pair(active: RecordArray, start: int, i: int, j: int) -> tuple[int, int]:  # pragma: no cover - compiled
    """Return the first and behind the last row of a pair among the active contacts, from row `start` on."""
    pair = (np.int64(i) << 32) | np.int64(j)
    while start < active.size and active[start].pair < pair:
        start += 1
    end = start
    while end < active.size and active[end].pair == pair:
        end += 1
    return start, end


@njit(forceinline=True)
def match_history(active: RecordArray, h: float, rules: Rules, row: Record) -> None:  # pragma: no cover - compiled
    """Match a candidate with an active contact of its pair; one that has left its edge ends.

    A corner-corner contact has no history until it is closed: its history would hold the corners together.
    """
    if row.corner_gap > 0.0 and not -rules.initial_penetration * h <= row.gap <= -row.corner_gap:
        return
    key = (np.int64(row.corner) << 32) | np.int64(row.edge)
    for q in range(active.size):
        if active[q].key == key and active[q].pressure > 0.0:
            row.history, row.corner_gap = q, 0.0
            row.in_range = -rules.detach_tol * h <= row.tangential <= row.edge_length + rules.detach_tol * h
            if not row.in_range:
                row.state = DROPPED
            return


@njit(forceinline=True)
def keep_one_active_dual(
    vertices: RecordArray, active: RecordArray, h: float, rules: Rules, rows: RecordArray, i: int
) -> None:  # pragma: no cover - compiled
    """Keep active row i unless its dual at the same point carries more pressure: else both stay closed for ever."""
    reach = 2.0 * (rules.new_penetration * h + max(0.0, -rows[i].gap))
    for j in range(rows.size):
        if j != i and rows[j].history >= 0 and rows[j].state != DROPPED:
            more = active[rows[j].history].pressure - active[rows[i].history].pressure
            if (more > 0.0 or (more == 0.0 and j < i)) and are_duals(vertices, rows[i], rows[j], reach):
                rows[i].state = DROPPED
                return
    rows[i].state = KEPT


@njit(forceinline=True)
def transfer_history(
    vertices: RecordArray, blocks: RecordArray, active: RecordArray, h: float, rules: Rules, rows: RecordArray
) -> None:  # pragma: no cover - compiled
    """Transfer the history of every contact that has ended to the nearest candidate with an aligned normal, once.

    Of two that are nearest to one candidate the nearer goes there, and the other to its next: in any order the same.
    """
    displaced = True
    while displaced:
        displaced = False
        for q in range(active.size):
            if active[q].pressure <= 0.0 or _goes_on(rows, q):
                continue
            best = _nearest_free(vertices, blocks, active, h, rules, rows, q)
            if best >= 0:
                displaced |= rows[best].predecessor >= 0
                rows[best].predecessor = q


@njit(forceinline=True)
def recall_open(
    vertices: RecordArray, blocks: RecordArray, active: RecordArray, h: float, rules: Rules, rows: RecordArray
) -> None:  # pragma: no cover - compiled
    """Hand the memory of open contacts, rows without pressure, on to candidates that are kept and have no history.

    One goes to the same corner over the same edge, or else to the nearest candidate with an aligned normal, as its
    dual once the corner has left the edge. It has had no say in which candidates are kept.
    """
    for q in range(active.size):
        if active[q].pressure > 0.0:
            continue
        best, nearest = -1, rules.transfer_distance * h
        for i in range(rows.size):
            if rows[i].state != KEPT or rows[i].corner_gap > 0.0 or not rows[i].in_range:
                continue
            if rows[i].history >= 0 or rows[i].predecessor >= 0 or rows[i].recalled >= 0:
                continue
            same = active[q].key == (np.int64(rows[i].corner) << 32) | np.int64(rows[i].edge)
            distance = -1.0 if same else _distance(vertices, active[q], rows[i])
            if distance < nearest and _alignment(vertices, blocks, active[q], rows[i]) >= rules.min_cosine:
                best, nearest = i, distance
        if best >= 0:
            rows[best].recalled = q


@njit(forceinline=True)
def _nearest_free(
    vertices: RecordArray, blocks: RecordArray, active: RecordArray, h: float, rules: Rules, rows: RecordArray, q: int
) -> int:  # pragma: no cover - compiled
    """Return the nearest row whose history active contact q may become, unless a nearer one is; -1: there is none."""
    best, nearest = -1, rules.transfer_distance * h
    for i in range(rows.size):
        if rows[i].history >= 0 or rows[i].corner_gap > 0.0 or not rows[i].in_range:
            continue
        distance = _distance(vertices, active[q], rows[i])
        if distance >= nearest or _alignment(vertices, blocks, active[q], rows[i]) < rules.min_cosine:
            continue
        taken = rows[i].predecessor
        if taken < 0 or distance < _distance(vertices, active[taken], rows[i]):
            best, nearest = i, distance
    return best


@njit(forceinline=True)
def _goes_on(rows: RecordArray, q: int) -> bool:  # pragma: no cover - compiled
    """Whether an active contact continues in a kept row, or has its history transferred to one."""
    found = False
    for i in range(rows.size):
        found |= (rows[i].history == q and rows[i].state == KEPT) or rows[i].predecessor == q
    return found


@njit(forceinline=True)
def _distance(vertices: RecordArray, old: Record, row: Record) -> float:  # pragma: no cover - compiled
    """Return the distance from the last position of a contact to the candidate's corner."""
    return float(np.hypot(old.x - vertices[row.corner].x, old.y - vertices[row.corner].y))


@njit(forceinline=True)
def _alignment(
    vertices: RecordArray, blocks: RecordArray, old: Record, row: Record
) -> float:  # pragma: no cover - compiled
    """Return the cosine between the normals of an old contact and of a candidate, both out of the same block."""
    cosine = old.nx * vertices[row.edge].dy - old.ny * vertices[row.edge].dx
    corner, block = old.key >> 32, blocks[row.block_a]
    return float(cosine if block.first <= corner < block.last else -cosine)
