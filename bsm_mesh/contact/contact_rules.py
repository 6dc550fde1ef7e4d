"""Which candidates of a pair of blocks stand: one contact at a place, whose history goes from one to the next.

Each rule mends a wrong answer: the tests of the search show the answer with the rule and without it.
"""

from __future__ import annotations

import numba as nb
import numpy as np

from bsm_mesh.contact.outlines import Record, RecordArray
from bsm_mesh.contact.rules import Rules

DROPPED, UNDECIDED, KEPT = -1, 0, 1  # marks in a row's state


@nb.njit(cache=True)
def settle_pair(
    vertices: RecordArray, blocks: RecordArray, active: RecordArray, rules: Rules, rows: RecordArray
) -> int:  # pragma: no cover - compiled
    """Apply the rules to the rows of one pair; those that stand come first, in their order: return how many.

    (1) Active contacts: one edge a corner, one of two duals. (2) History that no active contact carries on goes to
    the nearest candidate. (3) Fresh contacts must not start deep. (4) One edge a corner, and (5) no dual of a
    contact that bears; active contacts go before fresh ones, touching ones before open ones.

    Parameters
    ----------
    vertices, blocks : records VERTEX, BLOCK
        The blocks.
    active : records ACTIVE
        The active contacts of this pair.
    rules : Rules
        Tolerances in metres.
    rows : records ROW
        The candidates of this pair, with both roles.
    """
    if active.size > 0:
        for i in range(rows.size):
            if rows[i].history >= 0:
                _one_edge_a_corner(vertices, rules, rows, i)
        for i in range(rows.size):
            if rows[i].history >= 0 and rows[i].state == UNDECIDED:
                _one_of_active_duals(vertices, active, rules, rows, i)
        _hand_over(vertices, blocks, active, rules, rows)
    for i in range(rows.size):
        if rows[i].history < 0 and rows[i].inherits < 0 and rows[i].gap < -_fresh_depth(rules, rows[i]):
            rows[i].state = DROPPED
    for i in range(rows.size):
        if rows[i].history < 0 and rows[i].state == UNDECIDED:
            _one_edge_a_corner(vertices, rules, rows, i)
    for touching in (True, False):
        for i in range(rows.size):
            if rows[i].state == UNDECIDED and _touches(rules, rows[i]) == touching:
                _no_dual_of_kept(vertices, rules, rows, i)
    kept = 0
    for i in range(rows.size):
        if rows[i].state == KEPT:
            rows[kept] = rows[i]
            kept += 1
    return kept


@nb.njit(cache=True)
def _touches(rules: Rules, row: Record) -> bool:  # pragma: no cover - compiled
    """Whether a candidate bears, or would at once."""
    return bool(row.in_range and row.gap <= rules.fresh)


@nb.njit(cache=True)
def _fresh_depth(rules: Rules, row: Record) -> float:  # pragma: no cover - compiled
    """Return how deep a contact without history may be; corner on corner it has none as long as it is there."""
    return float(rules.seam if row.tip else rules.fresh)


@nb.njit(cache=True)
def _one_edge_a_corner(
    vertices: RecordArray, rules: Rules, rows: RecordArray, i: int
) -> None:  # pragma: no cover - compiled
    """Drop row i if it is closed and the same corner has a better edge: an active one, else the one with more gap.

    The way out of a convex block leads over the edge with the greatest gap.
    """
    if not rows[i].in_range or rows[i].gap > rules.rounding:
        return
    for j in range(rows.size):
        if j == i or rows[j].corner != rows[i].corner or not rows[j].in_range or rows[j].state == DROPPED:
            continue
        if (rows[i].history >= 0) == (rows[j].history >= 0):
            better = rows[j].gap - rows[i].gap
            if abs(better) <= rules.rounding:
                better = rows[j].length - rows[i].length
            wins = better > 0.0 or (better == 0.0 and j < i)
        else:
            wins = rows[j].history >= 0
        if wins and not _bears_on_both(vertices, rules, rows[i], rows[j]):
            rows[i].state = DROPPED
            return


@nb.njit(cache=True)
def _bears_on_both(
    vertices: RecordArray, rules: Rules, one: Record, other: Record
) -> bool:  # pragma: no cover - compiled
    """Whether a corner bears on two edges: in a notch, or at a flat corner with an edge of its own on each of them."""
    e, f = one.edge, other.edge
    if vertices[f].following == e:
        e, f = f, e
    if vertices[e].following != f:
        return False
    turn = vertices[e].dx * vertices[f].dy - vertices[e].dy * vertices[f].dx
    if turn < -rules.flat:
        return True
    p, q = one.parallel_edge, other.parallel_edge
    return bool(turn <= rules.flat and p >= 0 and q >= 0 and p != q)


@nb.njit(cache=True)
def _one_of_active_duals(
    vertices: RecordArray, active: RecordArray, rules: Rules, rows: RecordArray, i: int
) -> None:  # pragma: no cover - compiled
    """Keep active row i unless its dual is active at the same point and bears more: else both would bear for ever."""
    reach = 2.0 * (rules.fresh + max(0.0, -rows[i].gap))
    for j in range(rows.size):
        if j != i and rows[j].history >= 0 and rows[j].state != DROPPED:
            more = active[rows[j].history].pressure - active[rows[i].history].pressure
            if (more > 0.0 or (more == 0.0 and j < i)) and _are_duals(vertices, rows[i], rows[j], reach):
                rows[i].state = DROPPED
                return
    rows[i].state = KEPT


@nb.njit(cache=True)
def _no_dual_of_kept(
    vertices: RecordArray, rules: Rules, rows: RecordArray, i: int
) -> None:  # pragma: no cover - compiled
    """Keep fresh row i unless its dual stands and bears: two would halve the friction, one of them without history."""
    for j in range(rows.size):
        if rows[j].state == KEPT and _touches(rules, rows[j]) and _are_duals(vertices, rows[i], rows[j], rules.dual):
            rows[i].state = DROPPED
            return
    rows[i].state = KEPT


@nb.njit(cache=True)
def _are_duals(vertices: RecordArray, one: Record, other: Record, reach: float) -> bool:  # pragma: no cover - compiled
    """Whether two rows are one place of contact with corner and edge swapped."""
    if one.block_a != other.block_b:
        return False
    v, e, w, f = one.corner, one.edge, other.corner, other.edge
    w_starts, w_ends = e == w, vertices[e].following == w
    v_starts, v_ends = f == v, vertices[f].following == v
    if not ((w_starts or w_ends) and (v_starts or v_ends)):
        return False
    if one.parallel_edge >= 0 and other.parallel_edge >= 0:
        if one.parallel_edge != f or other.parallel_edge != e:
            return False  # two faces that meet at a flat corner
        if not ((w_starts and v_ends) or (w_ends and v_starts)):
            return False  # the two ends of a short face
    return bool(np.hypot(vertices[v].x - vertices[w].x, vertices[v].y - vertices[w].y) < reach)


@nb.njit(cache=True)
def _hand_over(
    vertices: RecordArray, blocks: RecordArray, active: RecordArray, rules: Rules, rows: RecordArray
) -> None:  # pragma: no cover - compiled
    """Give the history of every contact that has ended to the nearest candidate with an aligned normal, once."""
    for q in range(active.size):
        if active[q].pressure <= 0.0 or _goes_on(rows, q):
            continue
        best, nearest = -1, rules.near
        for i in range(rows.size):
            if rows[i].history >= 0 or not rows[i].in_range:
                continue
            distance = _distance(vertices, active[q], rows[i])
            if distance >= nearest or _alignment(vertices, blocks, active[q], rows[i]) < rules.aligned:
                continue
            taken = rows[i].inherits
            if taken < 0 or distance < _distance(vertices, active[taken], rows[i]):
                best, nearest = i, distance
        if best >= 0:
            rows[best].inherits = q


@nb.njit(cache=True)
def _goes_on(rows: RecordArray, q: int) -> bool:  # pragma: no cover - compiled
    """Whether an active contact goes on in a row that stands."""
    found = False
    for i in range(rows.size):
        found |= rows[i].history == q and rows[i].state == KEPT
    return found


@nb.njit(cache=True)
def _distance(vertices: RecordArray, old: Record, row: Record) -> float:  # pragma: no cover - compiled
    """Return the distance from where a contact was to the candidate's corner."""
    return float(np.hypot(old.x - vertices[row.corner].x, old.y - vertices[row.corner].y))


@nb.njit(cache=True)
def _alignment(
    vertices: RecordArray, blocks: RecordArray, old: Record, row: Record
) -> float:  # pragma: no cover - compiled
    """Return the cosine between the normals of an old contact and of a candidate, both out of the same block."""
    cosine = old.nx * vertices[row.edge].dy - old.ny * vertices[row.edge].dx
    corner, block = old.key >> 32, blocks[row.block_a]
    return float(cosine if block.first <= corner < block.last else -cosine)
