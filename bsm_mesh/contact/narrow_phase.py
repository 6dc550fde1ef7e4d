"""Narrow phase: which corners of one block may touch which edges of another, pair by pair.

Pure geometry: a corner faces an edge if it is convex, near it, and both edges of its block lead away from it.
Two rules of `contact_rules` that look at one candidate alone (seam, leaving) are applied here.
"""

from __future__ import annotations

from typing import NamedTuple

import numba as nb
import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.contact.outlines import Scene


class Rules(NamedTuple):
    """Tolerances of the contact rules: lengths over the smaller block's size h (`Scene.size`), sines, cosines.

    Lengths go with the smaller block of a pair, never above the median block. Between a pebble and a wall they must
    be small against the pebble, or its own length counts as a seam; between two very large blocks they must stay
    small against the steps, which follow the median block.
    """

    flat: float = 1e-6  # sine of the turn: a corner that turns right by more is concave and touches nothing
    entrance: float = 0.05  # sine: edges of the corner may lean into the edge's block by 3 degrees (blocks rotate)
    parallel: float = 0.1  # sine: edges within 6 degrees bear on each other along their length
    deepest: float = 0.25  # a corner deeper than this has come from the other side
    seam: float = 5e-3  # more than elastic penetration, less than a real step (0.02 h)
    leave: float = 1e-3  # an active contact ends when its corner is this far off the edge
    fresh: float = 1e-3  # a contact without history must not start deeper: it would push the blocks apart
    rounding: float = 1e-6  # positions nearer than this are equal (faces are found to 1e-6 of an edge, too)
    near: float = 0.1  # a dual takes over the shear force from no farther: blocks move 0.05 h a step
    aligned: float = 0.9  # cosine between the normals of a contact and of the one that takes over
    dual: float = 2.0  # over the band: a corner within this of its dual's corner is the same touching place
    corner_share: float = 0.05  # least length of a contact of a corner on an edge that is not parallel


RULES = Rules()


class ActiveArrays(NamedTuple):
    """The arrays of `search.ActiveContacts`, as the compiled search takes them."""

    pair: IntArray
    key: IntArray
    pressure: FloatArray
    point: FloatArray
    normal: FloatArray


class Rows(NamedTuple):
    """Candidates, one row each, as in `search.Candidates`; `state` is a mark of `contact_rules`.

    `tip` marks a corner that meets only the corner of a block that was its diagonal neighbour at the start.
    """

    block_a: IntArray
    block_b: IntArray
    corner: IntArray
    edge: IntArray
    gap: FloatArray
    along: FloatArray
    edge_length: FloatArray
    length: FloatArray
    parallel_edge: IntArray
    in_range: BoolArray
    tip: BoolArray
    history: IntArray
    inherits: IntArray
    state: IntArray


@nb.njit(cache=True)
def empty_rows(n: int) -> Rows:  # pragma: no cover - compiled
    """Return space for n candidates."""
    i4, f8, b1 = np.int32, np.float64, np.bool_
    return Rows(
        np.empty(n, i4),
        np.empty(n, i4),
        np.empty(n, i4),
        np.empty(n, i4),
        np.empty(n, f8),
        np.empty(n, f8),
        np.empty(n, f8),
        np.empty(n, f8),
        np.empty(n, i4),
        np.empty(n, b1),
        np.empty(n, b1),
        np.empty(n, i4),
        np.empty(n, i4),
        np.empty(n, np.int8),
    )


@nb.njit(cache=True)
def move_row(source: Rows, i: int, target: Rows, k: int) -> None:  # pragma: no cover - compiled
    """Copy row i of one table to row k of another (or the same)."""
    target.block_a[k], target.block_b[k] = source.block_a[i], source.block_b[i]
    target.corner[k], target.edge[k] = source.corner[i], source.edge[i]
    target.gap[k], target.along[k], target.edge_length[k] = source.gap[i], source.along[i], source.edge_length[i]
    target.length[k], target.parallel_edge[k] = source.length[i], source.parallel_edge[i]
    target.in_range[k], target.tip[k] = source.in_range[i], source.tip[i]
    target.history[k], target.inherits[k], target.state[k] = source.history[i], source.inherits[i], source.state[i]


@nb.njit(cache=True)
def with_space(rows: Rows, count: int) -> Rows:  # pragma: no cover - compiled
    """Return the rows with space for one more, moved to a table of twice the size where they are full."""
    if count < rows.gap.size:
        return rows
    longer = empty_rows(2 * count + 16)
    for i in range(count):
        move_row(rows, i, longer, i)
    return longer


@nb.njit(cache=True)
def facing_pairs(
    scene: Scene,
    active: ActiveArrays,
    first: int,
    last: int,
    a: int,
    b: int,
    size: float,
    band: float,
    rules: Rules,
    rows: Rows,
    count: int,
) -> tuple[Rows, int]:  # pragma: no cover - compiled
    """Append the corners of block a that face edges of block b; rows `first` to `last` of `active` are the pair's."""
    box, placed, direction = scene.box, scene.placed, scene.direction
    reach = 0.5 * band  # the boxes hold the other half
    for v in range(scene.offsets[a], scene.offsets[a + 1]):
        x, y = placed[v, 0], placed[v, 1]
        if x < box[b, 0] - reach or x > box[b, 2] + reach or y < box[b, 1] - reach or y > box[b, 3] + reach:
            continue
        u = scene.preceding[v]
        out_x, out_y, back_x, back_y = direction[v, 0], direction[v, 1], -direction[u, 0], -direction[u, 1]
        if out_x * back_y - out_y * back_x < -rules.flat:  # only convex corners touch
            continue
        for e in range(scene.offsets[b], scene.offsets[b + 1]):
            tx, ty = direction[e, 0], direction[e, 1]
            gap = (x - placed[e, 0]) * ty - (y - placed[e, 1]) * tx
            if gap > band or gap < -rules.deepest * size:
                continue
            if min(out_x * ty - out_y * tx, back_x * ty - back_y * tx) < -rules.entrance:
                continue
            along = (x - placed[e, 0]) * tx + (y - placed[e, 1]) * ty
            end = scene.following[e]
            length = (placed[end, 0] - placed[e, 0]) * tx + (placed[end, 1] - placed[e, 1]) * ty
            if along < -band or along > length + band:
                continue
            rows = with_space(rows, count)
            rows.block_a[count], rows.block_b[count], rows.corner[count], rows.edge[count] = a, b, v, e
            rows.gap[count], rows.along[count], rows.edge_length[count] = gap, along, length
            if _fill_row(scene, active, first, last, size, rules, rows, count):
                count += 1
    return rows, count


@nb.njit(cache=True)
def _fill_row(
    scene: Scene, active: ActiveArrays, first: int, last: int, size: float, rules: Rules, rows: Rows, i: int
) -> bool:  # pragma: no cover - compiled
    """Fill in what follows from corner, edge, gap and place along the edge; return whether it is a candidate."""
    overlap, parallel_edge, shorter = _overlap(scene, rows, i, rules)
    along, length = rows.along[i], rows.edge_length[i]
    from_end = min(abs(along), abs(along - length))
    if parallel_edge >= 0 and overlap < min(rules.seam * size, 0.5 * shorter) and from_end < rules.seam * size:
        return False  # seam: parallel edges that only meet end to end
    rows.parallel_edge[i] = parallel_edge
    rows.length[i] = 0.5 * overlap if overlap > 0.0 else rules.corner_share * size
    rows.tip[i] = parallel_edge < 0 and from_end < rules.seam * size and _meets_diagonally(scene, rows, i, size, rules)
    rows.history[i] = -1 if rows.tip[i] else _active_row(active, first, last, rows.corner[i], rows.edge[i])
    slack = (rules.leave if rows.history[i] >= 0 else rules.rounding) * size
    rows.in_range[i] = not rows.tip[i] and -slack <= along <= length + slack
    rows.inherits[i], rows.state[i] = -1, 0
    return bool(rows.in_range[i] or rows.history[i] < 0)  # an active contact that has left its edge ends


@nb.njit(cache=True)
def _overlap(scene: Scene, rows: Rows, i: int, rules: Rules) -> tuple[float, int, float]:  # pragma: no cover - compiled
    """Return the length that the corner's parallel edges share with the edge, the one with most, the shorter edge."""
    v, e, along, length = rows.corner[i], rows.edge[i], rows.along[i], rows.edge_length[i]
    tx, ty = scene.direction[e, 0], scene.direction[e, 1]
    total, most, best, shorter = 0.0, -1.0, -1, length
    for side in range(2):  # the edge that leaves the corner runs against the other block's, and so does the one before
        f = v if side == 0 else scene.preceding[v]
        far = scene.following[v] if side == 0 else f
        dx, dy = scene.direction[f, 0], scene.direction[f, 1]
        if dx * tx + dy * ty > 0.0 or abs(dx * ty - dy * tx) > rules.parallel:
            continue
        other = (
            along + (scene.placed[far, 0] - scene.placed[v, 0]) * tx + (scene.placed[far, 1] - scene.placed[v, 1]) * ty
        )
        shared = max(0.0, min(length, max(along, other)) - max(0.0, min(along, other)))
        total += shared
        if shared > most:
            most, best, shorter = shared, f, min(length, abs(other - along))
    return total, best, shorter


@nb.njit(cache=True)
def _meets_diagonally(
    scene: Scene, rows: Rows, i: int, size: float, rules: Rules
) -> bool:  # pragma: no cover - compiled
    """Whether a corner lies at the edge's end, and the two met at the start in this point alone, without a face."""
    v, e = rows.corner[i], rows.edge[i]
    w = e if abs(rows.along[i]) < 0.5 * rows.edge_length[i] else scene.following[e]
    if scene.nodes[v] != scene.nodes[w] or abs(rows.gap[i]) > rules.seam * size:
        return False
    u, direction = scene.preceding[w], scene.direction
    if direction[u, 0] * direction[w, 1] - direction[u, 1] * direction[w, 0] < rules.parallel:
        return False  # on a smooth outline it is a corner on an edge
    return not (
        _run_against(scene.corners, v, scene.following[v], u, w)
        or _run_against(scene.corners, scene.preceding[v], v, w, scene.following[w])
    )


@nb.njit(cache=True)
def _run_against(corners: FloatArray, p: int, q: int, r: int, s: int) -> bool:  # pragma: no cover - compiled
    """Whether the edges p-q and r-s ran against each other at the start, within the angle of faces."""
    ax, ay = corners[q, 0] - corners[p, 0], corners[q, 1] - corners[p, 1]
    bx, by = corners[s, 0] - corners[r, 0], corners[s, 1] - corners[r, 1]
    dot = ax * bx + ay * by
    return bool(dot < 0.0 and abs(ax * by - ay * bx) < -1e-3 * dot)


@nb.njit(cache=True)
def _active_row(
    active: ActiveArrays, first: int, last: int, corner: int, edge: int
) -> int:  # pragma: no cover - compiled
    """Return the row of the active contact of this corner and edge, -1 if there is none."""
    key = (np.int64(corner) << 32) | np.int64(edge)
    for q in range(first, last):
        if active.key[q] == key and active.pressure[q] > 0.0:
            return q
    return -1
