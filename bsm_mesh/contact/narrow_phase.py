"""Narrow phase of the contact search: corner-edge candidates of every pair of blocks.

Geometry only: a corner faces an edge if it is convex, near it, and both edges of its block lead away from it. What
else depends on one candidate alone is decided here (overlap along parallel edges, corner-corner contacts); history, and
the rules that compare candidates, are in `contact_rules`.
"""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import IntArray
from bsm_mesh.compiled import njit
from bsm_mesh.contact.outlines import Record, RecordArray
from bsm_mesh.contact.rules import Rules

ROWS_PER_PAIR = 3  # space at first; the table grows where there are more
DROPPED, UNDECIDED, KEPT = -1, 0, 1  # marks in a row's state, set by `contact_rules`
FULL = -1  # returned where the table of rows has no space left
ROW = np.dtype(  # a candidate, as in `search.Candidates`
    [
        *((name, "f8") for name in ("gap", "tangential", "edge_length", "overlap", "length", "corner_gap", "beyond")),
        *((name, "i4") for name in ("block_a", "block_b", "corner", "edge", "parallel_edge", "history", "predecessor")),
        ("recalled", "i4"),
        ("opposing_candidate", "i4"),
        ("entering_edge", "i4"),
        ("parallel_edges", "i1"),
        ("in_range", "?"),
        ("was_vertex_contact", "?"),  # was a corner-corner contact; now edges of both corners lie on each other
        ("state", "i1"),
    ],
    align=True,
)


@njit(nogil=True, allocates=True)
def facing_rows(
    vertices: RecordArray, blocks: RecordArray, pairs: IntArray, band: float, rules: Rules
) -> tuple[RecordArray, IntArray]:  # pragma: no cover - compiled
    """Return the candidates of all pairs, records ROW, and where each pair's begin (k + 1,).

    Parameters
    ----------
    vertices, blocks : records VERTEX, BLOCK
        The blocks at their current position.
    pairs : (k, 2) int32
        Pairs of blocks, lower number first.
    band : float [m]
        How near a corner must be to an edge.
    rules : Rules
        Tolerances.
    """
    rows = np.empty(ROWS_PER_PAIR * pairs.shape[0] + 64, ROW)
    starts = np.zeros(pairs.shape[0] + 1, np.int64)
    for p in range(pairs.shape[0]):
        i, j = pairs[p, 0], pairs[p, 1]
        h = min(blocks[i].size, blocks[j].size)
        end = FULL
        while end == FULL:
            end = _add_facing(vertices, blocks, i, j, h, band, rules, rows, starts[p])
            if end != FULL:
                end = _add_facing(vertices, blocks, j, i, h, band, rules, rows, end)
            if end == FULL:
                longer = np.empty(2 * rows.size, ROW)
                for k in range(starts[p]):  # no slice: for those Numba compiles a message about shapes
                    longer[k] = rows[k]
                rows = longer
        starts[p + 1] = end
    return rows, starts


@njit(forceinline=True)
def _add_facing(
    vertices: RecordArray,
    blocks: RecordArray,
    a: int,
    b: int,
    h: float,
    band: float,
    rules: Rules,
    rows: RecordArray,
    count: int,
) -> int:  # pragma: no cover - compiled
    """Add the corners of block a that face edges of block b to the first `count` rows; return how many there are.

    h is the length that the rules are scaled with [m]. Returns FULL where the table is too short.
    """
    box, reach = blocks[b], 0.5 * band  # the box holds the other half
    max_sine = rules.entrance + rules.turn * band / h
    for v in range(blocks[a].first, blocks[a].last):
        x, y = vertices[v].x, vertices[v].y
        if x < box.x0 - reach or x > box.x1 + reach or y < box.y0 - reach or y > box.y1 + reach:
            continue
        before = vertices[vertices[v].preceding]
        out_x, out_y, back_x, back_y = vertices[v].dx, vertices[v].dy, -before.dx, -before.dy
        if out_x * back_y - out_y * back_x < -rules.flat:
            continue  # only convex corners touch
        for e in range(box.first, box.last):
            tx, ty = vertices[e].dx, vertices[e].dy
            x_e, y_e = x - vertices[e].x, y - vertices[e].y
            gap = x_e * ty - y_e * tx
            if gap > band or gap < -rules.max_penetration * h:
                continue
            sine_out, sine_back = out_y * tx - out_x * ty, back_y * tx - back_x * ty
            sine = max(sine_out, sine_back)
            if sine > rules.entrance and (sine > max_sine or gap < sine * rules.ahead * h):
                continue  # an edge of the corner leads into the other block
            tangential = x_e * tx + y_e * ty
            end = vertices[vertices[e].following]
            length = (end.x - vertices[e].x) * tx + (end.y - vertices[e].y) * ty
            off = max(0.0, -tangential, tangential - length)
            if off * off + max(0.0, gap) ** 2 > band * band:
                continue
            if count == rows.size:
                return FULL
            row = rows[count]
            row.block_a, row.block_b, row.corner, row.edge = a, b, v, e
            row.gap, row.tangential, row.edge_length = gap, tangential, length
            row.entering_edge = -1
            if sine > rules.entrance:
                row.entering_edge = v if sine_out > sine_back else vertices[v].preceding
            _fill(vertices, h, rules, row)
            count += 1
    return count


@njit(forceinline=True)
def _fill(vertices: RecordArray, h: float, rules: Rules, row: Record) -> None:  # pragma: no cover - compiled
    """Set the fields that follow from corner, edge, gap and tangential coordinate.

    Parallel edges that only meet end to end, and corners of diagonal neighbours, are corner-corner contacts.
    """
    overlap, parallel_edge, parallel_edges, shorter = _overlap(
        vertices, rules, row.corner, row.edge, row.tangential, row.edge_length
    )
    from_end = min(abs(row.tangential), abs(row.tangential - row.edge_length))
    short = overlap < min(rules.min_overlap * h, 0.5 * shorter)
    end_to_end = parallel_edge >= 0 and from_end < rules.min_overlap * h and short
    row.beyond = _overlap_beyond(vertices, rules, row) if end_to_end else 0.0
    row.parallel_edge, row.overlap = parallel_edge, overlap
    row.parallel_edges = 0 if end_to_end else parallel_edges
    row.length = 0.5 * overlap if row.parallel_edges > 0 and overlap > 0.0 else rules.corner_share * h
    diagonal = from_end < rules.vertex_tol * h and _meets_diagonally(vertices, h, rules, row)
    row.was_vertex_contact = diagonal and _lies_on(vertices, h, rules, row, overlap)
    row.corner_gap = 0.0
    if end_to_end:
        row.corner_gap = rules.min_overlap * h
    elif diagonal and not row.was_vertex_contact:
        row.corner_gap = rules.new_penetration * h
    before, behind = _notches(vertices, rules, row)
    slack_before = h * (rules.detach_tol if before else rules.rounding)
    slack_behind = h * (rules.detach_tol if behind else rules.rounding)
    row.in_range = -slack_before <= row.tangential <= row.edge_length + slack_behind
    row.history = row.predecessor = row.recalled = row.opposing_candidate = -1
    row.state = 0


@njit(forceinline=True)
def _overlap_beyond(vertices: RecordArray, rules: Rules, row: Record) -> float:  # pragma: no cover - compiled
    """Return the length that a's parallel edges share with the edge that continues in line beyond the nearer end."""
    e = row.edge
    at_start = row.tangential < 0.5 * row.edge_length
    next_edge = vertices[e].preceding if at_start else vertices[e].following
    cosine = vertices[e].dx * vertices[next_edge].dx + vertices[e].dy * vertices[next_edge].dy
    sine = vertices[e].dx * vertices[next_edge].dy - vertices[e].dy * vertices[next_edge].dx
    if cosine < 0.0 or abs(sine) > rules.parallel:
        return 0.0
    end = vertices[vertices[next_edge].following]
    length = np.hypot(end.x - vertices[next_edge].x, end.y - vertices[next_edge].y)
    tangential = row.tangential + length if at_start else row.tangential - row.edge_length
    shared: float = _overlap(vertices, rules, row.corner, next_edge, tangential, length)[0]
    return shared


@njit(forceinline=True)
def _overlap(
    vertices: RecordArray, rules: Rules, v: int, e: int, tangential: float, length: float
) -> tuple[float, int, int, float]:  # pragma: no cover - compiled
    """Return the overlap of a's parallel edges at corner v with edge e, the one with most, how many, the shorter.

    Faces lie against each other, so their edges run in opposite directions.
    """
    tx, ty = vertices[e].dx, vertices[e].dy
    total, most, best, count, shorter = 0.0, -1.0, -1, 0, length
    for side in range(2):
        f = v if side == 0 else vertices[v].preceding
        far = vertices[v].following if side == 0 else f
        dx, dy = vertices[f].dx, vertices[f].dy
        if dx * tx + dy * ty > 0.0 or abs(dx * ty - dy * tx) > rules.parallel:
            continue
        other = tangential + (vertices[far].x - vertices[v].x) * tx + (vertices[far].y - vertices[v].y) * ty
        shared = max(0.0, min(length, max(tangential, other)) - max(0.0, min(tangential, other)))
        shared /= -(dx * tx + dy * ty)  # along the edge that turns, or a face would grow softer while it opens
        total += shared
        count += 1
        if shared > most:
            most, best, shorter = shared, f, min(length, abs(other - tangential))
    return total, best, count, shorter


@njit(forceinline=True)
def _lies_on(
    vertices: RecordArray, h: float, rules: Rules, row: Record, overlap: float
) -> bool:  # pragma: no cover - compiled
    """Whether the parallel edge lies on b's edge: nowhere in their overlap is there a step."""
    if row.parallel_edge < 0 or overlap < rules.min_overlap * h:
        return False
    one, other = vertices[row.parallel_edge], vertices[row.edge]
    return bool(abs(one.dx * other.dy - one.dy * other.dx) * overlap < rules.min_overlap * h)


@njit(forceinline=True)
def _notches(vertices: RecordArray, rules: Rules, row: Record) -> tuple[bool, bool]:  # pragma: no cover - compiled
    """Return whether the edge starts, and whether it ends, in a notch.

    There a corner is off the floor by its penetration into the wall, and must still be in contact with the floor.
    """
    here = vertices[row.edge]
    before, after = vertices[here.preceding], vertices[here.following]
    starts = before.dx * here.dy - before.dy * here.dx < -rules.flat
    return starts, here.dx * after.dy - here.dy * after.dx < -rules.flat


@njit(forceinline=True)
def _meets_diagonally(
    vertices: RecordArray, h: float, rules: Rules, row: Record
) -> bool:  # pragma: no cover - compiled
    """Whether a corner is at the corner of a diagonal neighbour: blocks between them keep them apart.

    Both corners belong to one vertex cluster, but have no face in common. Two corners that just touch are no diagonal
    neighbours: they must support each other.
    """
    v, e = row.corner, row.edge
    w = e if abs(row.tangential) < 0.5 * row.edge_length else vertices[e].following
    if vertices[v].vertex_cluster != vertices[w].vertex_cluster or abs(row.gap) > rules.vertex_tol * h:
        return False
    return not (
        _ran_against(vertices, v, vertices[v].following, vertices[w].preceding, w)
        or _ran_against(vertices, vertices[v].preceding, v, w, vertices[w].following)
    )


@njit(forceinline=True)
def _ran_against(vertices: RecordArray, p: int, q: int, r: int, s: int) -> bool:  # pragma: no cover - compiled
    """Whether the edges p-q and r-s ran against each other at the start."""
    ax, ay = vertices[q].x0 - vertices[p].x0, vertices[q].y0 - vertices[p].y0
    bx, by = vertices[s].x0 - vertices[r].x0, vertices[s].y0 - vertices[r].y0
    tangential = ax * bx + ay * by
    return bool(abs(ax * by - ay * bx) < -1e-3 * tangential)
