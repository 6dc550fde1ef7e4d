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


@njit(allocates=True)
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


@njit(allocates=True)
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


@njit(allocates=True)
def clipped(
    faces: IntArray, corners: FloatArray, offsets: IntArray, normal: FloatArray, slide: FloatArray
) -> tuple[IntArray, FloatArray]:  # pragma: no cover - compiled
    """Return what pairs of surfaces (q, 2) share: numbers of corners (q,), and the corners' rows one after the other.

    Rows (k, 14): the corner in the plane across the mean normal, the points of a and of b over it, the normal into a,
    the gap. The last column is 1 for a point on b. The surfaces' `corners` (c, 3) run counter-clockwise about their
    outward `normal`; the first is a's. `slide` (q, 3): movement of a against b.
    """
    total, most = 0, 0
    for q in range(faces.shape[0]):
        both = offsets[faces[q, 0] + 1] - offsets[faces[q, 0]] + offsets[faces[q, 1] + 1] - offsets[faces[q, 1]]
        total, most = total + both, max(most, both + 2)
    rows, sizes, count = np.empty((total, 14)), np.zeros(faces.shape[0], np.int64), 0
    flat, shared, marks = np.empty((2, most, 2)), np.empty((2, most, 2)), np.empty((2, most, 4), np.int64)
    axes, base, room = np.empty((3, 3)), np.empty(3), np.empty((3, 3))
    for q in range(faces.shape[0]):
        f, g = faces[q]
        a, b = corners[offsets[f] : offsets[f + 1]][::-1], corners[offsets[g] : offsets[g + 1]]
        _set_axes(normal[f], normal[g], b, axes, base)
        _set_flat(a, b[0], axes, base, flat[0])
        _set_flat(b, b[0], axes, base, flat[1])
        least = DOUBLE * max(_farthest(flat[0], a.shape[0]), _farthest(flat[1], b.shape[0]))
        size = clip(flat, a.shape[0], b.shape[0], least, shared, marks)
        if size < 3:
            continue
        for k in range(size):
            for u in range(3):
                base[u] = b[0, u] + shared[0, k, 0] * axes[1, u] + shared[0, k, 1] * axes[2, u]
            _set_row(rows[count], base, marks[0, k], a, b, normal[f], normal[g], axes[0], slide[q], room)
            count += 1
        sizes[q] = size
    return sizes, rows[:count]


@njit()
def _set_axes(
    of_a: FloatArray, of_b: FloatArray, b: FloatArray, axes: FloatArray, along: FloatArray
) -> None:  # pragma: no cover - compiled
    """Set the mean normal, which points into a, and two axes across it, right-handed; `along` (3,): room."""
    mean, first, longest = axes[0], axes[1], 0.0
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
            for u in range(3):
                first[u] = along[u]
    _set_cross(axes[2], mean, first)


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
def _set_flat(
    points: FloatArray, origin: FloatArray, axes: FloatArray, arm: FloatArray, found: FloatArray
) -> None:  # pragma: no cover - compiled
    """Set the first rows of `found` (>= k, 2) to points (k, 3) in the plane of the last two axes; `arm` (3,): room."""
    for k in range(points.shape[0]):
        _set_difference(arm, points[k], origin)
        found[k, 0], found[k, 1] = _dot(arm, axes[1]), _dot(arm, axes[2])


@njit()
def _farthest(points: FloatArray, count: int) -> float:  # pragma: no cover - compiled
    """Return the greatest coordinate of the first points (k, 2) by its size."""
    found = 0.0
    for k in range(count):
        found = max(found, abs(points[k, 0]), abs(points[k, 1]))
    return found


@njit()
def clip(
    flat: FloatArray, size_a: int, size_b: int, least: float, corners: FloatArray, marks: IntArray
) -> int:  # pragma: no cover - compiled
    """Set what convex polygons ``flat[0, :size_a]`` and ``flat[1, :size_b]`` share; return how many corners it has.

    The corners (k, 2) are in ``corners[0]``. In ``marks[0]`` are the kind of each, the numbers on a and on b, and the
    edge of a that the next side lies on, or minus one less that of b. The other halves are room.
    """
    b, count, now = flat[1], size_a, 0
    for k in range(count):
        corners[0, k, 0], corners[0, k, 1] = flat[0, k, 0], flat[0, k, 1]
        marks[0, k, 0], marks[0, k, 1], marks[0, k, 2], marks[0, k, 3] = CORNER_OF_A, k, 0, k
    for j in range(size_b):
        x, y = b[j, 0], b[j, 1]
        ex, ey = b[(j + 1) % size_b, 0] - x, b[(j + 1) % size_b, 1] - y
        here, there, old, new = corners[now], corners[1 - now], marks[now], marks[1 - now]
        size, left = np.sqrt(ex**2 + ey**2), 0
        for k in range(count):
            p, r = here[k], here[(k + 1) % count]
            inside = (ex * (p[1] - y) - ey * (p[0] - x)) / size
            next_one = (ex * (r[1] - y) - ey * (r[0] - x)) / size
            if inside >= -least:
                _copy(p, there[left])
                _copy(old[k], new[left])
                left += 1
            if (inside >= -least) != (next_one >= -least):
                along = min(max(inside / (inside - next_one), 0.0), 1.0)  # both may lie within `least` of the edge
                there[left, 0], there[left, 1] = p[0] + along * (r[0] - p[0]), p[1] + along * (r[1] - p[1])
                source = old[k, 3]
                new[left, 0], new[left, 1], new[left, 2] = EDGES if source >= 0 else CORNER_OF_B, max(source, 0), j
                new[left, 3] = source if inside < -least else -1 - j
                left += 1
        count, now = left, 1 - now
        if count < 3:
            break
    kept: int = _drop_doubles(corners, marks, now, count, 4 * least)
    return kept


@njit()
def _copy(one: FloatArray, other: FloatArray) -> None:  # pragma: no cover - compiled
    for u in range(one.size):
        other[u] = one[u]


@njit()
def _drop_doubles(
    corners: FloatArray, marks: IntArray, now: int, count: int, least: float
) -> int:  # pragma: no cover - compiled
    """Put those corners of half `now` into the first half that lie away from the next one; return how many."""
    here, left = corners[now], 0
    x, y = here[0, 0], here[0, 1]  # the first corner may be overwritten before the last one is compared with it
    for k in range(count):
        is_last = k + 1 == count
        next_x, next_y = x if is_last else here[k + 1, 0], y if is_last else here[k + 1, 1]
        if np.sqrt((here[k, 0] - next_x) ** 2 + (here[k, 1] - next_y) ** 2) > least:
            _copy(here[k], corners[0, left])
            _copy(marks[now, k], marks[0, left])
            left += 1
    return left


@njit()
def _set_row(
    row: FloatArray,
    base: FloatArray,
    mark: IntArray,
    a: FloatArray,
    b: FloatArray,
    of_a: FloatArray,
    of_b: FloatArray,
    mean: FloatArray,
    slide: FloatArray,
    room: FloatArray,
) -> None:  # pragma: no cover - compiled
    """Set corner, the points of both faces over it, normal into a, gap and its block of a row (14,); `room` (3, 3)."""
    on_a, on_b, across, kind = row[3:6], row[6:9], row[9:12], mark[0]
    turn, one, other = room[0], room[1], room[2]
    _set_over(on_a, base, a[0], of_a, mean)
    _set_over(on_b, base, b[0], of_b, mean)
    _set_difference(one, a[(mark[1] + 1) % a.shape[0]], a[mark[1]])
    _set_difference(other, b[(mark[2] + 1) % b.shape[0]], b[mark[2]])
    is_on_b = _crossing_is_on_b(one, other, mean, slide, turn) if kind == EDGES else kind == CORNER_OF_B
    for u in range(3):
        across[u] = -of_a[u] if is_on_b else of_b[u]
    _set_cross(turn, of_a, of_b)
    if kind == EDGES and _dot(turn, turn) >= PARALLEL**2:
        _set_cross(turn, one, other)
        size, sizes = np.sqrt(_dot(turn, turn)), np.sqrt(_dot(one, one) * _dot(other, other))
        _copy(mean, across)
        if size > PARALLEL * sizes and abs(_dot(turn, mean)) > FACING * size:
            _divide(turn, size * np.sign(_dot(turn, mean)))
            _copy(turn, across)
    _set_difference(one, on_a, on_b)
    gap = _dot(one, across)
    for u in range(3):
        if is_on_b:
            on_a[u] = on_b[u] + gap * across[u]
        else:
            on_b[u] = on_a[u] - gap * across[u]
    _copy(base, row[:3])
    row[12], row[13] = gap, is_on_b


@njit()
def _crossing_is_on_b(
    one: FloatArray, other: FloatArray, mean: FloatArray, slide: FloatArray, turn: FloatArray
) -> bool:  # pragma: no cover - compiled
    """Return whether the crossing of an edge of a with one of b lies on b rather than on a.

    Where a slides by `slide` the crossing moves on b's edge by ``(slide x one) / (other x one)`` of its length.
    `turn` (3,) is room.
    """
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
