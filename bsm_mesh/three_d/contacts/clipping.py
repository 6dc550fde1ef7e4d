"""Kernels of the search for contact polygons: boxes of blocks that are near, faces that face each other, clipping.

Two faces are projected along the mean of their normals and clipped against each other (Sutherland & Hodgman 1974). A
corner of the shared area is a corner of one face over the other, or a crossing of two edges: each has its own normal.

A corner of a face lies on its own block. A crossing lies on the block with which it moves where the blocks slide past
each other.
"""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.compiled import njit

FACING = 0.7071  # cosine: the normal of two edges that cross lies within 45 degrees of the mean of the faces'
PARALLEL = 0.1  # sine of 6 degrees: faces nearer to parallel touch flat, along the face's normal; such edges have no
# normal, and faces nearer to perpendicular do not face each other
DOUBLE = 1e-7  # of the faces' size: corners nearer than this are one
CORNER_OF_A, CORNER_OF_B, EDGES = 0, 1, 2  # what meets in a corner


@njit()
def near_blocks(
    low: FloatArray, high: FloatArray, moves: IntArray, band: float
) -> IntArray:  # pragma: no cover - compiled
    """Return the pairs of blocks, (p, 2), whose boxes (n, 3) come within `band` [m]; one of each pair `moves` (n,)."""
    order, found = np.argsort(low[:, 0]), [(0, 0)]
    for p in range(order.size):
        i = order[p]
        for q in range(p + 1, order.size):
            j = order[q]
            if low[j, 0] > high[i, 0] + band:
                break
            if not (moves[i] or moves[j]):
                continue
            apart = False
            for u in range(1, 3):
                apart |= low[j, u] > high[i, u] + band or low[i, u] > high[j, u] + band
            if not apart:
                found.append((min(i, j), max(i, j)))
    pairs = np.empty((len(found) - 1, 2), np.int64)
    for k in range(1, len(found)):
        pairs[k - 1, 0], pairs[k - 1, 1] = found[k]
    return pairs


@njit()
def facing_faces(
    pairs: IntArray, start: IntArray, normal: FloatArray, low: FloatArray, high: FloatArray, band: float
) -> IntArray:  # pragma: no cover - compiled
    """Return the pairs of surfaces (q, 2) of near blocks that face each other, their boxes within `band` [m].

    Block i owns the surfaces ``start[i]:start[i + 1]``.
    """
    found = [(0, 0)]
    for p in range(pairs.shape[0]):
        for f in range(start[pairs[p, 0]], start[pairs[p, 0] + 1]):
            for g in range(start[pairs[p, 1]], start[pairs[p, 1] + 1]):
                cosine = normal[f, 0] * normal[g, 0] + normal[f, 1] * normal[g, 1] + normal[f, 2] * normal[g, 2]
                if cosine > -PARALLEL:
                    continue
                apart = False
                for u in range(3):
                    apart |= low[g, u] > high[f, u] + band or low[f, u] > high[g, u] + band
                if not apart:
                    found.append((f, g))
    faces = np.empty((len(found) - 1, 2), np.int64)
    for k in range(1, len(found)):
        faces[k - 1, 0], faces[k - 1, 1] = found[k]
    return faces


@njit()
def clipped(
    faces: IntArray, corners: FloatArray, offsets: IntArray, normal: FloatArray, slide: FloatArray
) -> tuple[IntArray, FloatArray]:  # pragma: no cover - compiled
    """Return what pairs of surfaces (q, 2) share: numbers of corners (q,), and the corners' rows one after the other.

    Rows (k, 14): the corner in the plane across the mean normal, the points of a and of b over it, the normal into a,
    the gap. The last column is 1 for a point on b. The surfaces' `corners` (c, 3) run counter-clockwise about their
    outward `normal`; the first is a's. `slide` (q, 3): movement of a against b.
    """
    total = 0
    for q in range(faces.shape[0]):
        total += offsets[faces[q, 0] + 1] - offsets[faces[q, 0]] + offsets[faces[q, 1] + 1] - offsets[faces[q, 1]]
    rows, sizes, count = np.empty((total, 14)), np.zeros(faces.shape[0], np.int64), 0
    mean, first, second, base = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    for q in range(faces.shape[0]):
        f, g = faces[q]
        a, b = corners[offsets[f] : offsets[f + 1]][::-1], corners[offsets[g] : offsets[g + 1]]
        _set_axes(normal[f], normal[g], b, mean, first, second)
        flat_a, flat_b = _flat(a, b[0], first, second), _flat(b, b[0], first, second)
        least = DOUBLE * max(_farthest(flat_a), _farthest(flat_b))
        shared, kind, edge = _clip(flat_a, flat_b, least)
        if shared.shape[0] < 3:
            continue
        for k in range(shared.shape[0]):
            for u in range(3):
                base[u] = b[0, u] + shared[k, 0] * first[u] + shared[k, 1] * second[u]
            _set_row(rows[count], base, kind[k], edge[k], a, b, normal[f], normal[g], mean, slide[q])
            count += 1
        sizes[q] = shared.shape[0]
    return sizes, rows[:count]


@njit()
def _set_axes(
    of_a: FloatArray, of_b: FloatArray, b: FloatArray, mean: FloatArray, first: FloatArray, second: FloatArray
) -> None:  # pragma: no cover - compiled
    """Set the mean normal, which points into a, and two axes across it, right-handed."""
    along, longest = np.empty(3), 0.0
    _set_difference(mean, of_b, of_a)
    _divide(mean, np.sqrt(_dot(mean, mean)))
    for k in range(b.shape[0]):
        _set_difference(along, b[(k + 1) % b.shape[0]], b[k])
        over = _dot(along, mean)
        for u in range(3):
            along[u] -= over * mean[u]
        size = np.sqrt(_dot(along, along))
        if size > longest:
            longest = size
            _divide(along, size)
            first[:] = along
    _set_cross(second, mean, first)


@njit()
def _dot(a: FloatArray, b: FloatArray) -> float:  # pragma: no cover - compiled
    """Return the product of two vectors; expressions of arrays take seconds to compile."""
    found: float = a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    return found


@njit()
def _set_difference(found: FloatArray, a: FloatArray, b: FloatArray) -> None:  # pragma: no cover - compiled
    for u in range(3):
        found[u] = a[u] - b[u]


@njit()
def _divide(vector: FloatArray, by: float) -> None:  # pragma: no cover - compiled
    for u in range(3):
        vector[u] /= by


@njit()
def _set_cross(found: FloatArray, a: FloatArray, b: FloatArray) -> None:  # pragma: no cover - compiled
    for u in range(3):
        v, w = (u + 1) % 3, (u + 2) % 3
        found[u] = a[v] * b[w] - a[w] * b[v]


@njit()
def _flat(
    points: FloatArray, origin: FloatArray, first: FloatArray, second: FloatArray
) -> FloatArray:  # pragma: no cover - compiled
    found, arm = np.empty((points.shape[0], 2)), np.empty(3)
    for k in range(points.shape[0]):
        _set_difference(arm, points[k], origin)
        found[k, 0], found[k, 1] = _dot(arm, first), _dot(arm, second)
    return found


@njit()
def _farthest(points: FloatArray) -> float:  # pragma: no cover - compiled
    """Return the greatest coordinate of points (k, 2) by its size."""
    found = 0.0
    for k in range(points.shape[0]):
        found = max(found, abs(points[k, 0]), abs(points[k, 1]))
    return found


@njit()
def _clip(
    a: FloatArray, b: FloatArray, least: float
) -> tuple[FloatArray, IntArray, IntArray]:  # pragma: no cover - compiled
    """Return what convex polygons (k, 2) share: corners, what meets there, and both numbers of it.

    `source` is the edge of a on which a side lies, or minus one less that of b.
    """
    most = a.shape[0] + b.shape[0] + 2
    here, kind, mark, source = (
        np.empty((most, 2)),
        np.zeros(most, np.int64),
        np.zeros((most, 2), np.int64),
        np.zeros(most, np.int64),
    )
    there, kinds, marks, sources = (
        np.empty((most, 2)),
        np.zeros(most, np.int64),
        np.zeros((most, 2), np.int64),
        np.zeros(most, np.int64),
    )
    count = a.shape[0]
    for k in range(count):
        here[k], kind[k], mark[k, 0], source[k] = a[k], CORNER_OF_A, k, k
    for j in range(b.shape[0]):
        o, e = b[j], b[(j + 1) % b.shape[0]] - b[j]
        size, new = np.sqrt((e**2).sum()), 0
        for k in range(count):
            p, r = here[k], here[(k + 1) % count]
            inside = (e[0] * (p[1] - o[1]) - e[1] * (p[0] - o[0])) / size
            next_one = (e[0] * (r[1] - o[1]) - e[1] * (r[0] - o[0])) / size
            if inside >= -least:
                there[new], kinds[new], marks[new], sources[new] = p, kind[k], mark[k], source[k]
                new += 1
            if (inside >= -least) != (next_one >= -least):
                along = min(max(inside / (inside - next_one), 0.0), 1.0)  # both may lie within `least` of the edge
                there[new] = p + along * (r - p)
                kinds[new] = EDGES if source[k] >= 0 else CORNER_OF_B
                marks[new, 0], marks[new, 1] = max(source[k], 0), j
                sources[new] = source[k] if inside < -least else -1 - j
                new += 1
        count = new
        here, there, kind, kinds = there, here, kinds, kind
        mark, marks, source, sources = marks, mark, sources, source
        if count < 3:
            break
    kept = np.ones(count, np.bool_)
    for k in range(count):
        kept[k] = np.sqrt(((here[k] - here[(k + 1) % count]) ** 2).sum()) > 4 * least
    chosen = np.flatnonzero(kept)
    return here[chosen], kind[chosen], mark[chosen]


@njit()
def _set_row(
    row: FloatArray,
    base: FloatArray,
    kind: int,
    edge: IntArray,
    a: FloatArray,
    b: FloatArray,
    of_a: FloatArray,
    of_b: FloatArray,
    mean: FloatArray,
    slide: FloatArray,
) -> None:  # pragma: no cover - compiled
    """Set corner, the points of both faces over it, normal into a, gap and its block of a row (14,)."""
    on_a, on_b, across, turn, one, other = np.empty((6, 3))
    _set_over(on_a, base, a[0], of_a, mean)
    _set_over(on_b, base, b[0], of_b, mean)
    _set_difference(one, a[(edge[0] + 1) % a.shape[0]], a[edge[0]])
    _set_difference(other, b[(edge[1] + 1) % b.shape[0]], b[edge[1]])
    is_on_b = _crossing_is_on_b(one, other, mean, slide) if kind == EDGES else kind == CORNER_OF_B
    for u in range(3):
        across[u] = -of_a[u] if is_on_b else of_b[u]
    _set_cross(turn, of_a, of_b)
    if kind == EDGES and _dot(turn, turn) >= PARALLEL**2:
        _set_cross(turn, one, other)
        size, sizes = np.sqrt(_dot(turn, turn)), np.sqrt(_dot(one, one) * _dot(other, other))
        across[:] = mean
        if size > PARALLEL * sizes and abs(_dot(turn, mean)) > FACING * size:
            _divide(turn, size * np.sign(_dot(turn, mean)))
            across[:] = turn
    _set_difference(one, on_a, on_b)
    gap = _dot(one, across)
    for u in range(3):
        if is_on_b:
            on_a[u] = on_b[u] + gap * across[u]
        else:
            on_b[u] = on_a[u] - gap * across[u]
    row[:3], row[3:6], row[6:9], row[9:12], row[12], row[13] = base, on_a, on_b, across, gap, is_on_b


@njit()
def _crossing_is_on_b(
    one: FloatArray, other: FloatArray, mean: FloatArray, slide: FloatArray
) -> bool:  # pragma: no cover - compiled
    """Return whether the crossing of an edge of a with one of b lies on b rather than on a.

    Where a slides by `slide` the crossing moves on b's edge by ``(slide x one) / (other x one)`` of its length.
    """
    turn = np.empty(3)
    _set_cross(turn, slide, one)
    moved = _dot(turn, mean)
    _set_cross(turn, other, one)
    whole = _dot(turn, mean)
    is_on_b: bool = whole != 0.0 and 2 * moved / whole * _dot(other, slide) < _dot(slide, slide)
    return is_on_b


@njit()
def _set_over(
    found: FloatArray, base: FloatArray, point: FloatArray, normal: FloatArray, mean: FloatArray
) -> None:  # pragma: no cover - compiled
    """Set the point of the plane through `point` that lies over `base` along `mean`."""
    _set_difference(found, point, base)
    along = _dot(found, normal) / _dot(mean, normal)
    for u in range(3):
        found[u] = base[u] + along * mean[u]
