"""Narrow phase: which corners of one block may touch which edges of another, pair by pair.

Geometry only: a corner faces an edge if it is convex, near it, and both edges of its block lead away from it. The
rules that look at one candidate alone (seam, leaving, corner on corner) are applied here, those that weigh
candidates against each other in `contact_rules`.
"""

from __future__ import annotations

import numba as nb
import numpy as np

from bsm_mesh.contact.outlines import Record, RecordArray
from bsm_mesh.contact.rules import Rules

FULL = -1  # returned where the table of rows has no space left
ACTIVE = np.dtype(  # an active contact, as in `search.ActiveContacts`
    [("pair", "i8"), ("key", "i8"), ("pressure", "f8"), ("x", "f8"), ("y", "f8"), ("nx", "f8"), ("ny", "f8")]
)
ROW = np.dtype(  # a candidate, as in `search.Candidates`; history and inherits are rows of the pair's active contacts
    [
        *((name, "f8") for name in ("gap", "along", "edge_length", "length")),
        *((name, "i4") for name in ("block_a", "block_b", "corner", "edge", "parallel_edge", "history", "inherits")),
        ("in_range", "?"),
        ("tip", "?"),  # meets only the corner of a block that was its diagonal neighbour at the start
        ("state", "i1"),  # a mark of `contact_rules`
    ],
    align=True,
)


@nb.njit(cache=True)
def add_facing(
    vertices: RecordArray,
    blocks: RecordArray,
    active: RecordArray,
    a: int,
    b: int,
    rules: Rules,
    rows: RecordArray,
    count: int,
) -> int:  # pragma: no cover - compiled
    """Add the corners of block a that face edges of block b to the first `count` rows; return how many there are.

    `active` are the active contacts of this pair; `rules` are in metres. Returns FULL where the table is too short.
    """
    box, reach = blocks[b], 0.5 * rules.band  # the box holds the other half
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
            if gap > rules.band or gap < -rules.deepest:
                continue
            if min(out_x * ty - out_y * tx, back_x * ty - back_y * tx) < -rules.entrance:
                continue  # an edge of the corner leads into the other block
            along = x_e * tx + y_e * ty
            end = vertices[vertices[e].following]
            length = (end.x - vertices[e].x) * tx + (end.y - vertices[e].y) * ty
            if along < -rules.band or along > length + rules.band:
                continue
            if count == rows.size:
                return FULL
            row = rows[count]
            row.block_a, row.block_b, row.corner, row.edge = a, b, v, e
            row.gap, row.along, row.edge_length = gap, along, length
            if _fill(vertices, active, rules, row):
                count += 1
    return count


@nb.njit(cache=True)
def _fill(vertices: RecordArray, active: RecordArray, rules: Rules, row: Record) -> bool:  # pragma: no cover - compiled
    """Fill in what follows from corner, edge, gap and place along the edge; return whether it is a candidate."""
    overlap, parallel_edge, shorter = _overlap(vertices, rules, row)
    from_end = min(abs(row.along), abs(row.along - row.edge_length))
    at_end = from_end < rules.seam
    if parallel_edge >= 0 and at_end and overlap < min(rules.seam, 0.5 * shorter):
        return False  # parallel edges that only meet end to end
    row.parallel_edge = parallel_edge
    row.length = 0.5 * overlap if overlap > 0.0 else rules.corner_share
    row.tip = at_end and parallel_edge < 0 and _meets_diagonally(vertices, rules, row)
    row.history = -1 if row.tip else _row_among(active, row)
    slack = rules.leave if row.history >= 0 else rules.rounding
    row.in_range = not row.tip and -slack <= row.along <= row.edge_length + slack
    row.inherits = -1
    row.state = 0
    return bool(row.in_range or row.history < 0)  # an active contact that has left its edge ends


@nb.njit(cache=True)
def _overlap(
    vertices: RecordArray, rules: Rules, row: Record
) -> tuple[float, int, float]:  # pragma: no cover - compiled
    """Return the length that a's parallel edges at the corner share with the edge, the one with most, the shorter edge.

    Faces lie against each other, so their edges run in opposite directions.
    """
    v, along, length = row.corner, row.along, row.edge_length
    tx, ty = vertices[row.edge].dx, vertices[row.edge].dy
    total, most, best, shorter = 0.0, -1.0, -1, length
    for side in range(2):
        f = v if side == 0 else vertices[v].preceding
        far = vertices[v].following if side == 0 else f
        dx, dy = vertices[f].dx, vertices[f].dy
        if dx * tx + dy * ty > 0.0 or abs(dx * ty - dy * tx) > rules.parallel:
            continue
        other = along + (vertices[far].x - vertices[v].x) * tx + (vertices[far].y - vertices[v].y) * ty
        shared = max(0.0, min(length, max(along, other)) - max(0.0, min(along, other)))
        total += shared
        if shared > most:
            most, best, shorter = shared, f, min(length, abs(other - along))
    return total, best, shorter


@nb.njit(cache=True)
def _meets_diagonally(vertices: RecordArray, rules: Rules, row: Record) -> bool:  # pragma: no cover - compiled
    """Whether a corner is at the edge's end, and the blocks met at the start in this point alone, without a face."""
    v, e = row.corner, row.edge
    w = e if abs(row.along) < 0.5 * row.edge_length else vertices[e].following
    if vertices[v].node != vertices[w].node or abs(row.gap) > rules.seam:
        return False
    u = vertices[w].preceding
    if vertices[u].dx * vertices[w].dy - vertices[u].dy * vertices[w].dx < rules.parallel:
        return False  # the other outline is smooth here: a corner on an edge
    return not (
        _ran_against(vertices, v, vertices[v].following, u, w)
        or _ran_against(vertices, vertices[v].preceding, v, w, vertices[w].following)
    )


@nb.njit(cache=True)
def _ran_against(vertices: RecordArray, p: int, q: int, r: int, s: int) -> bool:  # pragma: no cover - compiled
    """Whether the edges p-q and r-s ran against each other at the start."""
    ax, ay = vertices[q].x0 - vertices[p].x0, vertices[q].y0 - vertices[p].y0
    bx, by = vertices[s].x0 - vertices[r].x0, vertices[s].y0 - vertices[r].y0
    along = ax * bx + ay * by
    return bool(abs(ax * by - ay * bx) < -1e-3 * along)


@nb.njit(cache=True)
def _row_among(active: RecordArray, row: Record) -> int:  # pragma: no cover - compiled
    """Return the row of the same contact among the active ones, -1 if it is not there."""
    key = (np.int64(row.corner) << 32) | np.int64(row.edge)
    for q in range(active.size):
        if active[q].key == key and active[q].pressure > 0.0:
            return q
    return -1
