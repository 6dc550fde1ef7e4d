"""Which candidates of a pair of blocks stand: one place of contact, one contact; history goes from one to the next.

Each rule mends a wrong answer: see the tests of the search, which show the answer with and without it.
"""

from __future__ import annotations

import numba as nb
import numpy as np

from bsm_mesh.contact.narrow_phase import ActiveArrays, Rows, Rules, move_row
from bsm_mesh.contact.outlines import Scene

DROPPED = -1  # marks in Rows.state; a row starts with 0, undecided
KEPT = 1


@nb.njit(cache=True)
def settle_pair(
    scene: Scene,
    active: ActiveArrays,
    first: int,
    last: int,
    size: float,
    band: float,
    rules: Rules,
    rows: Rows,
    start: int,
    end: int,
) -> int:  # pragma: no cover - compiled
    """Apply the rules to the rows `start` to `end` of one pair; return the end of those that are left.

    (1) Active contacts: one edge a corner, then one of two duals. (2) History that no active contact carries on goes
    to the nearest candidate. (3) Fresh contacts must not start deep. (4) One edge a corner, and (5) no dual of a
    contact that touches already, where active contacts go before fresh ones and touching before open ones.
    """
    if end == start:
        return end
    for i in range(start, end):
        if rows.history[i] >= 0:
            _lose_to_other_edge(scene, size, rules, rows, start, end, i)
    for i in range(start, end):
        if rows.history[i] >= 0 and rows.state[i] != DROPPED:
            _lose_to_active_dual(scene, active, size, rules, rows, start, end, i)
    if last > first:
        _hand_over(scene, active, first, last, size, rules, rows, start, end)
    for i in range(start, end):
        if rows.history[i] < 0 and rows.inherits[i] < 0:
            deepest = rules.seam if rows.tip[i] else rules.fresh
            if rows.gap[i] < -deepest * size:
                rows.state[i] = DROPPED
    for i in range(start, end):
        if rows.history[i] < 0 and rows.state[i] != DROPPED:
            _lose_to_other_edge(scene, size, rules, rows, start, end, i)
    for touching in (True, False):
        for i in range(start, end):
            if rows.history[i] < 0 and rows.state[i] == 0 and _touches(rows, i, size, rules) == touching:
                _lose_to_kept_dual(scene, size, band, rules, rows, start, end, i)
    kept = start
    for i in range(start, end):
        if rows.state[i] == KEPT:
            move_row(rows, i, rows, kept)
            kept += 1
    return kept


@nb.njit(cache=True, inline="always")
def _touches(rows: Rows, i: int, size: float, rules: Rules) -> bool:  # pragma: no cover - compiled
    """Whether a candidate bears (or would at once)."""
    return bool(rows.in_range[i] and rows.gap[i] <= rules.fresh * size)


@nb.njit(cache=True)
def _lose_to_other_edge(
    scene: Scene, size: float, rules: Rules, rows: Rows, start: int, end: int, i: int
) -> None:  # pragma: no cover - compiled
    """One edge a corner: drop row i, closed, if the same corner has a better edge. An active row meets active ones."""
    if not rows.in_range[i] or rows.gap[i] > rules.rounding * size:
        return
    is_active = rows.history[i] >= 0
    for j in range(start, end):
        if j == i or rows.corner[j] != rows.corner[i] or not rows.in_range[j] or rows.state[j] == DROPPED:
            continue
        other_active = rows.history[j] >= 0
        if is_active and not other_active:
            continue
        if is_active == other_active:
            nearer = rows.gap[j] - rows.gap[i]  # the way out of a convex block is over the edge with the greatest gap
            if abs(nearer) <= rules.rounding * size:
                nearer = rows.length[j] - rows.length[i]
            if nearer < 0.0 or (nearer == 0.0 and j > i):
                continue
        if not _both_bear(scene, rows, i, j, rules):
            rows.state[i] = DROPPED
            return


@nb.njit(cache=True)
def _both_bear(scene: Scene, rows: Rows, i: int, j: int, rules: Rules) -> bool:  # pragma: no cover - compiled
    """Whether a corner bears on both edges: in a notch, or at a flat corner where two of its own edges lie on them."""
    e, f = rows.edge[i], rows.edge[j]
    if scene.following[f] == e:
        e, f = f, e
    if scene.following[e] != f:
        return False
    direction = scene.direction
    turn = direction[e, 0] * direction[f, 1] - direction[e, 1] * direction[f, 0]
    if turn < -rules.flat:
        return True
    p, q = rows.parallel_edge[i], rows.parallel_edge[j]
    return turn <= rules.flat and p >= 0 and q >= 0 and p != q


@nb.njit(cache=True)
def _lose_to_active_dual(
    scene: Scene, active: ActiveArrays, size: float, rules: Rules, rows: Rows, start: int, end: int, i: int
) -> None:  # pragma: no cover - compiled
    """Of two active duals at one point keep the one that bears more, else both would bear for ever."""
    for j in range(start, end):
        if j == i or rows.history[j] < 0 or rows.state[j] == DROPPED:
            continue
        more = active.pressure[rows.history[j]] - active.pressure[rows.history[i]]
        if more < 0.0 or (more == 0.0 and j > i):
            continue
        reach = 2.0 * rules.fresh * size + 2.0 * max(0.0, -rows.gap[i])
        if _is_dual(scene, rows, i, j, reach):
            rows.state[i] = DROPPED
            return
    rows.state[i] = KEPT


@nb.njit(cache=True)
def _lose_to_kept_dual(
    scene: Scene, size: float, band: float, rules: Rules, rows: Rows, start: int, end: int, i: int
) -> None:  # pragma: no cover - compiled
    """No swapped-role candidate while the contact that stands is in range and touches."""
    for j in range(start, end):
        if rows.state[j] == KEPT and _touches(rows, j, size, rules) and _is_dual(scene, rows, i, j, rules.dual * band):
            rows.state[i] = DROPPED
            return
    rows.state[i] = KEPT


@nb.njit(cache=True)
def _is_dual(scene: Scene, rows: Rows, i: int, j: int, reach: float) -> bool:  # pragma: no cover - compiled
    """Whether two rows are one place of contact with corner and edge swapped."""
    if rows.block_a[i] != rows.block_b[j]:
        return False
    v, e, w, f = rows.corner[i], rows.edge[i], rows.corner[j], rows.edge[j]
    w_starts, w_ends = e == w, scene.following[e] == w
    v_starts, v_ends = f == v, scene.following[f] == v
    if not ((w_starts or w_ends) and (v_starts or v_ends)):
        return False
    if rows.parallel_edge[i] >= 0 and rows.parallel_edge[j] >= 0:
        if rows.parallel_edge[i] != f or rows.parallel_edge[j] != e:
            return False  # two faces that meet at a flat corner
        if not ((w_starts and v_ends) or (w_ends and v_starts)):
            return False  # the two ends of a short face
    placed = scene.placed
    return bool(np.hypot(placed[v, 0] - placed[w, 0], placed[v, 1] - placed[w, 1]) < reach)


@nb.njit(cache=True)
def _hand_over(
    scene: Scene,
    active: ActiveArrays,
    first: int,
    last: int,
    size: float,
    rules: Rules,
    rows: Rows,
    start: int,
    end: int,
) -> None:  # pragma: no cover - compiled
    """Give the history of every active contact that has ended to the nearest candidate with an aligned normal, once."""
    for q in range(first, last):
        if active.pressure[q] <= 0.0 or _carried_on(rows, start, end, q):
            continue
        best, nearest = -1, rules.near * size
        for i in range(start, end):
            if rows.history[i] >= 0 or not rows.in_range[i] or _alignment(scene, active, q, rows, i) < rules.aligned:
                continue
            distance = _distance(scene, active, q, rows, i)
            if distance >= nearest:
                continue
            taken = rows.inherits[i]
            if taken < 0 or distance < _distance(scene, active, taken, rows, i):
                best, nearest = i, distance
        if best >= 0:
            rows.inherits[best] = q


@nb.njit(cache=True)
def _carried_on(rows: Rows, start: int, end: int, q: int) -> bool:  # pragma: no cover - compiled
    """Whether an active contact goes on as a row that stands."""
    for i in range(start, end):
        if rows.history[i] == q and rows.state[i] != DROPPED:
            return True
    return False


@nb.njit(cache=True)
def _distance(scene: Scene, active: ActiveArrays, q: int, rows: Rows, i: int) -> float:  # pragma: no cover - compiled
    """Return the distance from where the active contact was to the candidate's corner."""
    v = rows.corner[i]
    return float(np.hypot(active.point[q, 0] - scene.placed[v, 0], active.point[q, 1] - scene.placed[v, 1]))


@nb.njit(cache=True)
def _alignment(scene: Scene, active: ActiveArrays, q: int, rows: Rows, i: int) -> float:  # pragma: no cover - compiled
    """Return the cosine between the normals of the active contact and of the candidate, both out of the same block."""
    e, a = rows.edge[i], rows.block_a[i]
    cosine = active.normal[q, 0] * scene.direction[e, 1] - active.normal[q, 1] * scene.direction[e, 0]
    corner = active.key[q] >> 32
    return cosine if scene.offsets[a] <= corner < scene.offsets[a + 1] else -cosine
