"""Contact rules: of the candidates of a pair of blocks, which are kept, and the history that each continues.

Each rule corrects a wrong answer: the tests of the rules show the answer with the rule and without it.
"""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.compiled import njit
from bsm_mesh.contact.history_transfer import (
    keep_one_active_dual,
    match_history,
    recall_open,
    rows_of_pair,
    transfer_history,
)
from bsm_mesh.contact.inner_edges import slides_over
from bsm_mesh.contact.narrow_phase import DROPPED, KEPT, UNDECIDED
from bsm_mesh.contact.outlines import Record, RecordArray
from bsm_mesh.contact.rules import Rules
from bsm_mesh.contact.same_place import (
    are_duals,
    are_opposing,
    at_one_node,
    closed_on_both,
    is_closing,
    is_face,
    same_vertices,
)


@njit(nogil=True, allocates=True)
def resolve_candidates(
    vertices: RecordArray,
    blocks: RecordArray,
    pairs: IntArray,
    active: RecordArray,
    band: float,
    rules: Rules,
    rows: RecordArray,
    starts: IntArray,
    given: FloatArray,
    on_block: IntArray,
) -> RecordArray:  # pragma: no cover - compiled
    """Return the candidates that are kept, with their history: the first of `rows`, which change in place.

    Parameters
    ----------
    vertices, blocks : records VERTEX, BLOCK
        The blocks at their current position.
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
    given : (n_vertices, 2) float64 [m]
        The corners as given.
    on_block : (n_vertices, 2) int32
        Blocks on which edges lie flat (`inner_edges.edges_on_blocks`).
    """
    count = last = np.int64(0)  # the kernels below would be compiled for a constant too
    for p in range(pairs.shape[0]):
        i, j = pairs[p, 0], pairs[p, 1]
        first, last = rows_of_pair(active, last, i, j)
        if starts[p + 1] == starts[p]:
            continue
        h = min(blocks[i].size, blocks[j].size)
        here = rows[starts[p] : starts[p + 1]]
        for k in range(here.size):
            alone = here[k].parallel_edge < 0 and here[k].corner_gap == 0.0
            if alone and slides_over(vertices, given, on_block, h, rules, here[k]):
                here[k].corner_gap = rules.min_overlap * h
        _resolve_pair(vertices, blocks, active[first:last], h, band, rules, here)
        _find_opposing(vertices, h, rules, here, count)
        for k in range(here.size):
            if here[k].state == KEPT:
                here[k].in_range &= here[k].corner_gap == 0.0  # closed where it is pressed in, no further
                here[k].history += first if here[k].history >= 0 else 0  # from the pair's rows to all rows
                here[k].predecessor += first if here[k].predecessor >= 0 else 0
                here[k].recalled += first if here[k].recalled >= 0 else 0
                rows[count] = here[k]
                count += 1
    return rows[:count]


@njit(forceinline=True)
def _resolve_pair(
    vertices: RecordArray,
    blocks: RecordArray,
    active: RecordArray,
    h: float,
    band: float,
    rules: Rules,
    rows: RecordArray,
) -> None:  # pragma: no cover - compiled
    """Mark the rows of one pair, with both roles, as kept or dropped.

    Before all others (0): a corner that has passed a node may lie on the line beyond. (1) Active contacts end off their
    edge; one edge per corner; one of two duals. (2) History that no active contact continues is transferred to the
    nearest candidate. (3) New contacts must not start with a large penetration. (4) One edge per corner, and (5) no
    dual of a closed contact. Active contacts take precedence over new ones, closed ones over open ones. (6) Contacts
    chosen so take over the history of open ones.
    """
    for i in range(rows.size):
        _lay_beyond(vertices, h, rules, rows, i)
    if active.size > 0:
        for i in range(rows.size):
            match_history(active, h, rules, rows[i])
        for i in range(rows.size):
            if rows[i].history >= 0 and rows[i].state == UNDECIDED:
                _drop_second_edge(vertices, h, rules, rows, i)
        for i in range(rows.size):
            if rows[i].history >= 0 and rows[i].state == UNDECIDED:
                keep_one_active_dual(vertices, active, h, rules, rows, i)
        transfer_history(vertices, blocks, active, h, rules, rows)
    for i in range(rows.size):
        _mark_low_step(vertices, h, rules, rows, i)
    for i in range(rows.size):
        fresh = rows[i].history < 0 and rows[i].predecessor < 0
        if fresh and rows[i].gap < -_max_new_penetration(h, band, rules, rows[i]):
            rows[i].state = DROPPED
    for i in range(rows.size):
        if rows[i].history < 0 and rows[i].state == UNDECIDED:
            _drop_second_edge(vertices, h, rules, rows, i)
    for closing in (True, False):
        for i in range(rows.size):
            if rows[i].state == UNDECIDED and is_closing(h, rules, rows[i]) == closing:
                _keep_unless_dual(vertices, h, band, rules, rows, i)
    recall_open(vertices, blocks, active, h, rules, rows)


@njit(forceinline=True)
def _lay_beyond(
    vertices: RecordArray, h: float, rules: Rules, rows: RecordArray, i: int
) -> None:  # pragma: no cover - compiled
    """Let row i carry if its corner passed a node, its face lies on the line beyond, and nothing carries at the node.

    The contact at the node carries until the face has turned away from it. The corner carries while it reaches the
    line beyond.
    """
    if rows[i].beyond < rules.min_overlap * h:
        return
    for j in range(rows.size):
        reaches = rows[j].corner == rows[i].corner and rows[j].edge != rows[i].edge
        if rows[j].in_range and (reaches or at_one_node(vertices, rows[i], rows[j])):
            return
    rows[i].corner_gap, rows[i].parallel_edges = 0.0, 1
    rows[i].overlap += rows[i].beyond
    rows[i].length = 0.5 * rows[i].overlap


@njit(forceinline=True)
def _max_new_penetration(h: float, band: float, rules: Rules, row: Record) -> float:  # pragma: no cover - compiled
    """Return the largest penetration of a contact without history.

    One that came over the end of its edge, or past a corner, may be as deep as a step too low to count as one.
    """
    from_end = min(abs(row.tangential), abs(row.tangential - row.edge_length))
    over_the_end = from_end < band and row.overlap < band
    came_over = row.corner_gap > 0.0 or row.was_vertex_contact or over_the_end
    return float((rules.initial_penetration if came_over else rules.new_penetration) * h)


@njit(forceinline=True)
def _mark_low_step(
    vertices: RecordArray, h: float, rules: Rules, rows: RecordArray, i: int
) -> None:  # pragma: no cover - compiled
    """Make row i a corner-corner contact if it is the front of a step too low to count as one.

    The corner is level with the face beyond, and one of its edges is parallel to that face. It slides on there, and
    must not catch on an elastic overlap.
    """
    if rows[i].history >= 0 or rows[i].parallel_edge >= 0:  # parallel edges are known by their overlap
        return
    for j in range(rows.size):
        level = rows[j].parallel_edge >= 0 and abs(rows[j].gap) < rules.min_overlap * h
        if level and are_opposing(vertices, rules, rows[i], rows[j]):
            rows[i].corner_gap = rules.min_overlap * h


@njit(forceinline=True)
def _find_opposing(
    vertices: RecordArray, h: float, rules: Rules, rows: RecordArray, first: int
) -> None:  # pragma: no cover - compiled
    """Set the opposing candidates of the kept rows, which become rows `first`, `first` + 1, ... of the table.

    Rows on a face have none. Of two closed opposing candidates one is in range at first: together they would support
    a block that is on its corner.
    """
    for i in range(rows.size):
        if rows[i].state != KEPT or rows[i].history >= 0 or rows[i].predecessor >= 0 or is_face(h, rules, rows[i]):
            continue
        place = first
        for j in range(rows.size):
            if rows[j].state == KEPT:
                if are_opposing(vertices, rules, rows[i], rows[j]):
                    rows[i].opposing_candidate = place
                    on_corner = max(abs(rows[i].gap), abs(rows[j].gap)) <= rules.closure_tol * h
                    rows[i].in_range &= j > i or not (on_corner and rows[j].in_range)
                    break
                place += 1


@njit(forceinline=True)
def _drop_second_edge(
    vertices: RecordArray, h: float, rules: Rules, rows: RecordArray, i: int
) -> None:  # pragma: no cover - compiled
    """Drop row i if it is closed and its corner has a better edge: an active one, else the one with the larger gap.

    A corner leaves a convex block over the edge with the smallest penetration.
    """
    if not rows[i].in_range or rows[i].gap > rules.closure_tol * h:
        return
    for j in range(rows.size):
        if j == i or rows[j].corner != rows[i].corner or not rows[j].in_range or rows[j].state == DROPPED:
            continue
        on_corner = min(rows[i].gap, rows[j].gap) > -rules.closure_tol * h
        on_corner &= not (is_face(h, rules, rows[i]) or is_face(h, rules, rows[j]))
        opposing = on_corner and are_opposing(vertices, rules, rows[i], rows[j])
        if rows[i].corner_gap > 0.0 or rows[j].corner_gap > 0.0 or opposing:
            continue  # resolved while the blocks move
        if (rows[i].history >= 0) == (rows[j].history >= 0):
            better = rows[j].gap - rows[i].gap
            if abs(better) <= rules.rounding * h:
                better = rows[j].length - rows[i].length
            wins = better > 0.0 or (better == 0.0 and j < i)
        else:
            wins = rows[j].history >= 0
        if wins and not closed_on_both(vertices, h, rules, rows[i], rows[j]):
            rows[i].state = DROPPED
            return


@njit(forceinline=True)
def _keep_unless_dual(
    vertices: RecordArray, h: float, band: float, rules: Rules, rows: RecordArray, i: int
) -> None:  # pragma: no cover - compiled
    """Keep new row i unless its dual is kept and closed: both would share the friction, one of them without history."""
    for j in range(rows.size):
        if (
            rows[j].state == KEPT
            and is_closing(h, rules, rows[j])
            and are_duals(vertices, rows[i], rows[j], rules.dual_distance * band)
            and (rows[j].parallel_edge >= 0 or not are_opposing(vertices, rules, rows[i], rows[j]))
        ) or (rows[j].state == KEPT and same_vertices(vertices, rules, rows[i], rows[j])):
            rows[i].state = DROPPED
            return
    rows[i].state = KEPT
