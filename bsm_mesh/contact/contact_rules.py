"""Which candidates of a pair of blocks stand: one contact at a place, whose history goes from one to the next.

Each rule mends a wrong answer: the tests of the search show the answer with the rule and without it.
"""

from __future__ import annotations

import numba as nb
import numpy as np

from bsm_mesh.arrays import IntArray
from bsm_mesh.contact.outlines import Record, RecordArray
from bsm_mesh.contact.rules import Rules

DROPPED, UNDECIDED, KEPT = -1, 0, 1  # marks in a row's state


ACTIVE = np.dtype(  # an active contact, as in `search.ActiveContacts`
    [("pair", "i8"), ("key", "i8"), ("pressure", "f8"), ("x", "f8"), ("y", "f8"), ("nx", "f8"), ("ny", "f8")]
)


@nb.njit(cache=True)
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
        first, last = _rows_of_pair(active, last, i, j)
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
def _rows_of_pair(active: RecordArray, start: int, i: int, j: int) -> tuple[int, int]:  # pragma: no cover - compiled
    """Return the first and behind the last row of a pair among the active contacts, from row `start` on."""
    pair = (np.int64(i) << 32) | np.int64(j)
    while start < active.size and active[start].pair < pair:
        start += 1
    end = start
    while end < active.size and active[end].pair == pair:
        end += 1
    return start, end


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
            _carry_on(active, h, rules, rows[i])
        for i in range(rows.size):
            if rows[i].history >= 0 and rows[i].state == UNDECIDED:
                _one_edge_a_corner(vertices, h, rules, rows, i)
        for i in range(rows.size):
            if rows[i].history >= 0 and rows[i].state == UNDECIDED:
                _one_of_active_duals(vertices, active, h, rules, rows, i)
        _hand_over(vertices, blocks, active, h, rules, rows)
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
            if rows[i].state == UNDECIDED and _touches(h, rules, rows[i]) == touching:
                _no_dual_of_kept(vertices, h, band, rules, rows, i)


@nb.njit(cache=True, forceinline=True)
def _carry_on(active: RecordArray, h: float, rules: Rules, row: Record) -> None:  # pragma: no cover - compiled
    """Find the candidate among the active contacts of its pair; one that has left its edge ends.

    Corner on corner there is no history until it is pressed in: it would hold them together.
    """
    if row.play > 0.0 and not -rules.let_in * h <= row.gap <= -row.play:
        return
    key = (np.int64(row.corner) << 32) | np.int64(row.edge)
    for q in range(active.size):
        if active[q].key == key and active[q].pressure > 0.0:
            row.history, row.play = q, 0.0
            row.in_range = -rules.leave * h <= row.along <= row.edge_length + rules.leave * h
            if not row.in_range:
                row.state = DROPPED
            return


@nb.njit(cache=True, forceinline=True)
def _touches(h: float, rules: Rules, row: Record) -> bool:  # pragma: no cover - compiled
    """Whether a candidate bears, or would at once."""
    return bool(row.in_range and row.play == 0.0 and row.gap <= rules.fresh * h)


@nb.njit(cache=True, forceinline=True)
def _is_face(h: float, rules: Rules, row: Record) -> bool:  # pragma: no cover - compiled
    """Whether edges lie along each other there."""
    return bool(row.parallel_edge >= 0 and row.overlap >= rules.seam * h)


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
        if level and _are_rivals(vertices, rules, rows[i], rows[j]):
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
        if rows[i].state != KEPT or rows[i].history >= 0 or rows[i].inherits >= 0 or _is_face(h, rules, rows[i]):
            continue
        place = first
        for j in range(rows.size):
            if rows[j].state == KEPT:
                if _are_rivals(vertices, rules, rows[i], rows[j]):
                    rows[i].rival = place
                    on_corner = max(abs(rows[i].gap), abs(rows[j].gap)) <= rules.closed * h
                    rows[i].in_range &= j > i or not (on_corner and rows[j].in_range)
                    break
                place += 1


@nb.njit(cache=True, forceinline=True)
def _same_tips(vertices: RecordArray, rules: Rules, one: Record, other: Record) -> bool:  # pragma: no cover - compiled
    """Whether two rows are the same two corners and the same way out, with corner and edge swapped."""
    if one.play == 0.0 or other.play == 0.0 or one.block_a != other.block_b:
        return False
    w, f = other.corner, other.edge
    at_w = w == (one.edge if one.along < 0.5 * one.edge_length else vertices[one.edge].following)
    at_v = f == one.corner or vertices[f].following == one.corner
    return bool(at_w and at_v and not _are_rivals(vertices, rules, one, other))


@nb.njit(cache=True, forceinline=True)
def _are_rivals(vertices: RecordArray, rules: Rules, one: Record, other: Record) -> bool:  # pragma: no cover - compiled
    """Whether two rows are the two ways out for one corner that is pressed into another.

    What corner v cannot reach beside corner w of the other block is a wedge, convex as both are. Its two sides are
    edges at v or w: v on an edge at w, or w on an edge at v. Inside, the nearer side is the way out.
    """
    v, e = one.corner, one.edge
    w = e if one.along < 0.5 * one.edge_length else vertices[e].following
    f = other.edge
    cosine = vertices[e].dx * vertices[f].dx + vertices[e].dy * vertices[f].dy
    sine = vertices[e].dx * vertices[f].dy - vertices[e].dy * vertices[f].dx
    if other.corner == v:
        if f == e or (f != w and vertices[f].following != w):
            return False
        if (sine if f == w else -sine) <= rules.flat:
            return False  # a notch, or no corner
    elif other.corner == w and (f == v or vertices[f].following == v):
        cosine = -cosine
    else:
        return False
    if one.lean >= 0 or other.lean >= 0:
        return False  # no way out before the blocks have turned
    return bool(cosine < 0.0 or abs(sine) > rules.parallel)


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
        on_corner &= not (_is_face(h, rules, rows[i]) or _is_face(h, rules, rows[j]))
        if rows[i].play > 0.0 or rows[j].play > 0.0 or (on_corner and _are_rivals(vertices, rules, rows[i], rows[j])):
            continue  # which one it will be is found while it moves
        if (rows[i].history >= 0) == (rows[j].history >= 0):
            better = rows[j].gap - rows[i].gap
            if abs(better) <= rules.rounding * h:
                better = rows[j].length - rows[i].length
            wins = better > 0.0 or (better == 0.0 and j < i)
        else:
            wins = rows[j].history >= 0
        if wins and not _bears_on_both(vertices, h, rules, rows[i], rows[j]):
            rows[i].state = DROPPED
            return


@nb.njit(cache=True, forceinline=True)
def _bears_on_both(
    vertices: RecordArray, h: float, rules: Rules, one: Record, other: Record
) -> bool:  # pragma: no cover - compiled
    """Whether a corner that has closed on edge `one` bears on it whatever it does on the edge `other`.

    So it is where the block is not convex: the edge lies in front of the other (the floor of a wide notch and its
    wall), or the two meet in a notch. So it is, too, at a flat corner where each bears on an edge of its own.
    """
    e, f = one.edge, other.edge
    cosine = vertices[e].dx * vertices[f].dx + vertices[e].dy * vertices[f].dy
    if other.gap - one.gap * cosine > rules.rounding * h:  # the foot on the one edge, seen from the other
        return True
    if vertices[f].following == e:
        e, f = f, e
    if vertices[e].following != f:
        return False
    turn = vertices[e].dx * vertices[f].dy - vertices[e].dy * vertices[f].dx
    if turn < -rules.flat:
        return True
    p, q = one.parallel_edge, other.parallel_edge
    return bool(turn <= rules.flat and p >= 0 and q >= 0 and p != q)


@nb.njit(cache=True, forceinline=True)
def _one_of_active_duals(
    vertices: RecordArray, active: RecordArray, h: float, rules: Rules, rows: RecordArray, i: int
) -> None:  # pragma: no cover - compiled
    """Keep active row i unless its dual is active at the same point and bears more: else both would bear for ever."""
    reach = 2.0 * (rules.fresh * h + max(0.0, -rows[i].gap))
    for j in range(rows.size):
        if j != i and rows[j].history >= 0 and rows[j].state != DROPPED:
            more = active[rows[j].history].pressure - active[rows[i].history].pressure
            if (more > 0.0 or (more == 0.0 and j < i)) and _are_duals(vertices, rows[i], rows[j], reach):
                rows[i].state = DROPPED
                return
    rows[i].state = KEPT


@nb.njit(cache=True, forceinline=True)
def _no_dual_of_kept(
    vertices: RecordArray, h: float, band: float, rules: Rules, rows: RecordArray, i: int
) -> None:  # pragma: no cover - compiled
    """Keep fresh row i unless its dual stands and bears: two would halve the friction, one of them without history."""
    for j in range(rows.size):
        if (
            rows[j].state == KEPT
            and _touches(h, rules, rows[j])
            and _are_duals(vertices, rows[i], rows[j], rules.dual * band)
            and (rows[j].parallel_edge >= 0 or not _are_rivals(vertices, rules, rows[i], rows[j]))
        ) or (rows[j].state == KEPT and _same_tips(vertices, rules, rows[i], rows[j])):
            rows[i].state = DROPPED
            return
    rows[i].state = KEPT


@nb.njit(cache=True, forceinline=True)
def _are_duals(vertices: RecordArray, one: Record, other: Record, reach: float) -> bool:  # pragma: no cover - compiled
    """Whether two rows are one place of contact with corner and edge swapped."""
    if one.block_a != other.block_b:
        return False
    v, e, w, f = one.corner, one.edge, other.corner, other.edge
    w_starts, w_ends = e == w, vertices[e].following == w
    v_starts, v_ends = f == v, vertices[f].following == v
    if not ((w_starts or w_ends) and (v_starts or v_ends)):
        return False
    if one.parallel_edge >= 0 and other.parallel_edge >= 0 and not ((w_starts and v_ends) or (w_ends and v_starts)):
        return False  # the two ends of a short face
    return bool(np.hypot(vertices[v].x - vertices[w].x, vertices[v].y - vertices[w].y) < reach)


@nb.njit(cache=True, forceinline=True)
def _hand_over(
    vertices: RecordArray, blocks: RecordArray, active: RecordArray, h: float, rules: Rules, rows: RecordArray
) -> None:  # pragma: no cover - compiled
    """Give the history of every contact that has ended to the nearest candidate with an aligned normal, once."""
    for q in range(active.size):
        if active[q].pressure <= 0.0 or _goes_on(rows, q):
            continue
        best, nearest = -1, rules.near * h
        for i in range(rows.size):
            if rows[i].history >= 0 or rows[i].play > 0.0 or not rows[i].in_range:
                continue
            distance = _distance(vertices, active[q], rows[i])
            if distance >= nearest or _alignment(vertices, blocks, active[q], rows[i]) < rules.aligned:
                continue
            taken = rows[i].inherits
            if taken < 0 or distance < _distance(vertices, active[taken], rows[i]):
                best, nearest = i, distance
        if best >= 0:
            rows[best].inherits = q


@nb.njit(cache=True, forceinline=True)
def _goes_on(rows: RecordArray, q: int) -> bool:  # pragma: no cover - compiled
    """Whether an active contact goes on in a row that stands."""
    found = False
    for i in range(rows.size):
        found |= rows[i].history == q and rows[i].state == KEPT
    return found


@nb.njit(cache=True, forceinline=True)
def _distance(vertices: RecordArray, old: Record, row: Record) -> float:  # pragma: no cover - compiled
    """Return the distance from where a contact was to the candidate's corner."""
    return float(np.hypot(old.x - vertices[row.corner].x, old.y - vertices[row.corner].y))


@nb.njit(cache=True, forceinline=True)
def _alignment(
    vertices: RecordArray, blocks: RecordArray, old: Record, row: Record
) -> float:  # pragma: no cover - compiled
    """Return the cosine between the normals of an old contact and of a candidate, both out of the same block."""
    cosine = old.nx * vertices[row.edge].dy - old.ny * vertices[row.edge].dx
    corner, block = old.key >> 32, blocks[row.block_a]
    return float(cosine if block.first <= corner < block.last else -cosine)
