"""Which candidates of a pair of blocks stand: one contact at a place, whose history goes from one to the next.

Each rule mends a wrong answer: the tests of the rules show the answer with the rule and without it.
"""

from __future__ import annotations

import numba as nb

from bsm_mesh.arrays import IntArray
from bsm_mesh.contact.inheritance import carry_on, hand_over, one_of_active_duals, rows_of_pair
from bsm_mesh.contact.narrow_phase import DROPPED, KEPT, UNDECIDED
from bsm_mesh.contact.outlines import Record, RecordArray
from bsm_mesh.contact.rules import Rules
from bsm_mesh.contact.same_place import are_duals, are_rivals, bears_on_both, is_face, same_tips, touches


@nb.njit(cache=True, nogil=True)
def settle(
    vertices: RecordArray,
    blocks: RecordArray,
    pairs: IntArray,
    active: RecordArray,
    band: float,
    rules: Rules,
    rows: RecordArray,
    starts: IntArray,
) -> RecordArray:  # pragma: no cover - compiled
    """Return the candidates that stand, with their history: the first of `rows`, which are changed.

    Parameters
    ----------
    vertices, blocks : records VERTEX, BLOCK
        The blocks where they stand.
    pairs : (k, 2) int32
        Pairs of blocks, sorted.
    active : records ACTIVE
        Contacts at the last accepted step, sorted by pair.
    band : float [m]
        As in the search.
    rules : Rules
        Tolerances.
    rows, starts : records ROW, (k + 1,) int64
        Candidates of all pairs, and where each pair's begin (`narrow_phase.facing_rows`).
    """
    count = last = 0
    for p in range(pairs.shape[0]):
        i, j = pairs[p, 0], pairs[p, 1]
        first, last = rows_of_pair(active, last, i, j)
        if starts[p + 1] == starts[p]:
            continue
        h = min(blocks[i].size, blocks[j].size)
        here = rows[starts[p] : starts[p + 1]]
        _settle_pair(vertices, blocks, active[first:last], h, band, rules, here)
        _find_rivals(vertices, h, rules, here, count)
        for k in range(here.size):
            if here[k].state == KEPT:
                here[k].in_range &= here[k].play == 0.0  # it bears where it is pressed in, no more
                here[k].history += first if here[k].history >= 0 else 0  # from the pair's rows to the rows of all
                here[k].inherits += first if here[k].inherits >= 0 else 0
                rows[count] = here[k]
                count += 1
    return rows[:count]


@nb.njit(cache=True, forceinline=True)
def _settle_pair(
    vertices: RecordArray,
    blocks: RecordArray,
    active: RecordArray,
    h: float,
    band: float,
    rules: Rules,
    rows: RecordArray,
) -> None:  # pragma: no cover - compiled
    """Mark the rows of one pair, with both roles, that stand.

    (1) Active contacts: they end off their edge; one edge a corner; one of two duals. (2) History that no active
    contact carries on goes to the nearest candidate. (3) Fresh contacts must not start deep. (4) One edge a corner,
    and (5) no dual of a contact that bears; active contacts go before fresh ones, touching ones before open ones.
    """
    if active.size > 0:
        for i in range(rows.size):
            carry_on(active, h, rules, rows[i])
        for i in range(rows.size):
            if rows[i].history >= 0 and rows[i].state == UNDECIDED:
                _one_edge_a_corner(vertices, h, rules, rows, i)
        for i in range(rows.size):
            if rows[i].history >= 0 and rows[i].state == UNDECIDED:
                one_of_active_duals(vertices, active, h, rules, rows, i)
        hand_over(vertices, blocks, active, h, rules, rows)
    for i in range(rows.size):
        _low_step(vertices, h, rules, rows, i)
    for i in range(rows.size):
        fresh = rows[i].history < 0 and rows[i].inherits < 0
        if fresh and rows[i].gap < -_fresh_depth(h, band, rules, rows[i]):
            rows[i].state = DROPPED
    for i in range(rows.size):
        if rows[i].history < 0 and rows[i].state == UNDECIDED:
            _one_edge_a_corner(vertices, h, rules, rows, i)
    for touching in (True, False):
        for i in range(rows.size):
            if rows[i].state == UNDECIDED and touches(h, rules, rows[i]) == touching:
                _no_dual_of_kept(vertices, h, band, rules, rows, i)


@nb.njit(cache=True, forceinline=True)
def _fresh_depth(h: float, band: float, rules: Rules, row: Record) -> float:  # pragma: no cover - compiled
    """Return how deep a contact without history may be.

    One that came over the end of its edge, or past a corner, was let in as deep as a step that is none.
    """
    from_end = min(abs(row.along), abs(row.along - row.edge_length))
    over_the_end = from_end < band and row.overlap < band
    return float((rules.let_in if row.play > 0.0 or row.was_tip or over_the_end else rules.fresh) * h)


@nb.njit(cache=True, forceinline=True)
def _low_step(
    vertices: RecordArray, h: float, rules: Rules, rows: RecordArray, i: int
) -> None:  # pragma: no cover - compiled
    """Make row i corner on corner if it is the front of a step that is none.

    The corner is then level with the face that lies beyond, and an edge of its own parallel to that face: it slides
    on there, and must not catch on what elastic blocks stand out.
    """
    if rows[i].history >= 0 or rows[i].parallel_edge >= 0:  # parallel ones are told by the length they share
        return
    for j in range(rows.size):
        level = rows[j].parallel_edge >= 0 and abs(rows[j].gap) < rules.seam * h
        if level and are_rivals(vertices, rules, rows[i], rows[j]):
            rows[i].play = rules.seam * h


@nb.njit(cache=True, forceinline=True)
def _find_rivals(
    vertices: RecordArray, h: float, rules: Rules, rows: RecordArray, first: int
) -> None:  # pragma: no cover - compiled
    """Fill in the rivals of the rows that stand; they will be rows `first`, `first` + 1, ... of the table.

    Those on a face have none. Where two rivals touch, one does at first: together they would hold a block that stands
    on its corner.
    """
    for i in range(rows.size):
        if rows[i].state != KEPT or rows[i].history >= 0 or rows[i].inherits >= 0 or is_face(h, rules, rows[i]):
            continue
        place = first
        for j in range(rows.size):
            if rows[j].state == KEPT:
                if are_rivals(vertices, rules, rows[i], rows[j]):
                    rows[i].rival = place
                    on_corner = max(abs(rows[i].gap), abs(rows[j].gap)) <= rules.closed * h
                    rows[i].in_range &= j > i or not (on_corner and rows[j].in_range)
                    break
                place += 1


@nb.njit(cache=True, forceinline=True)
def _one_edge_a_corner(
    vertices: RecordArray, h: float, rules: Rules, rows: RecordArray, i: int
) -> None:  # pragma: no cover - compiled
    """Drop row i if it is closed and the same corner has a better edge: an active one, else the one with more gap.

    The way out of a convex block leads over the edge with the greatest gap.
    """
    if not rows[i].in_range or rows[i].gap > rules.closed * h:
        return
    for j in range(rows.size):
        if j == i or rows[j].corner != rows[i].corner or not rows[j].in_range or rows[j].state == DROPPED:
            continue
        on_corner = min(rows[i].gap, rows[j].gap) > -rules.closed * h
        on_corner &= not (is_face(h, rules, rows[i]) or is_face(h, rules, rows[j]))
        if rows[i].play > 0.0 or rows[j].play > 0.0 or (on_corner and are_rivals(vertices, rules, rows[i], rows[j])):
            continue  # which one it will be is found while it moves
        if (rows[i].history >= 0) == (rows[j].history >= 0):
            better = rows[j].gap - rows[i].gap
            if abs(better) <= rules.rounding * h:
                better = rows[j].length - rows[i].length
            wins = better > 0.0 or (better == 0.0 and j < i)
        else:
            wins = rows[j].history >= 0
        if wins and not bears_on_both(vertices, h, rules, rows[i], rows[j]):
            rows[i].state = DROPPED
            return


@nb.njit(cache=True, forceinline=True)
def _no_dual_of_kept(
    vertices: RecordArray, h: float, band: float, rules: Rules, rows: RecordArray, i: int
) -> None:  # pragma: no cover - compiled
    """Keep fresh row i unless its dual stands and bears: two would halve the friction, one of them without history."""
    for j in range(rows.size):
        if (
            rows[j].state == KEPT
            and touches(h, rules, rows[j])
            and are_duals(vertices, rows[i], rows[j], rules.dual * band)
            and (rows[j].parallel_edge >= 0 or not are_rivals(vertices, rules, rows[i], rows[j]))
        ) or (rows[j].state == KEPT and same_tips(vertices, rules, rows[i], rows[j])):
            rows[i].state = DROPPED
            return
    rows[i].state = KEPT
