"""Faces that meet at an angle where their blocks lie flat on each other: they touch in no place of their own.

A block that lies flat on another meets it with its other faces at the edges of the shared area. Meshes have triangles
that end there in a corner. The flat area has its contact points: others there would count twice, with other normals.
"""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.compiled import njit


def beside_flats(
    rows: FloatArray, sizes: IntArray, blocks: IntArray, flat: BoolArray, touch: BoolArray, narrow: float
) -> BoolArray:
    """Return which polygons at an angle (q,) are nearest to each other only where flat ones `touch`.

    Rows are those of `clipped`, `sizes` (q,) their numbers, `blocks` (q, 2) the polygons' blocks. Places nearer than
    `narrow` [m] are one.
    """
    if not len(sizes):
        return flat
    _, number = np.unique(blocks, axis=0, return_inverse=True)
    order = np.argsort(number.reshape(-1), kind="stable")
    groups = np.append(0, np.cumsum(np.bincount(number.reshape(-1))))
    found: BoolArray = _beside(rows, np.append(0, np.cumsum(sizes)), order, groups, flat, flat & touch, narrow)
    return found


@njit(allocates=True)
def _beside(
    rows: FloatArray,
    ends: IntArray,
    order: IntArray,
    groups: IntArray,
    flat: BoolArray,
    covers: BoolArray,
    narrow: float,
) -> BoolArray:  # pragma: no cover - compiled
    """Return `beside_flats` for polygons whose rows end at `ends`; in `order` they are in groups of two blocks."""
    beside, point = np.zeros(flat.size, np.bool_), np.empty(3)
    for g in range(groups.size - 1):
        for k in range(groups[g], groups[g + 1]):
            q = order[k]
            if flat[q]:
                continue
            least = rows[ends[q], 12]
            for c in range(ends[q], ends[q + 1]):
                least = min(least, rows[c, 12])
            beside[q] = True
            for c in range(ends[q], ends[q + 1]):
                if rows[c, 12] > least + narrow:
                    continue
                on = False
                for u in range(3):
                    point[u] = (rows[c, 3 + u] + rows[c, 6 + u]) / 2
                for m in range(groups[g], groups[g + 1]):
                    p = order[m]
                    on = covers[p] and lies_on(point, rows, ends[p], ends[p + 1], narrow)
                    if on:
                        break
                if not on:
                    beside[q] = False
                    break
    return beside


@njit(allocates=True)
def lies_on(
    point: FloatArray, rows: FloatArray, first: int, last: int, narrow: float
) -> bool:  # pragma: no cover - compiled
    """Return whether a point lies on the polygon of rows ``first:last``, which is midway between its two faces."""
    normal = rows[first, 9:12]
    left, right, nearest = True, True, np.inf
    place, edge, arm = np.empty(3), np.empty(3), np.empty(3)
    for k in range(first, last):
        following = k + 1 if k + 1 < last else first
        for u in range(3):
            place[u] = (rows[k, 3 + u] + rows[k, 6 + u]) / 2
            edge[u] = (rows[following, 3 + u] + rows[following, 6 + u]) / 2 - place[u]
            arm[u] = point[u] - place[u]
        height, long, along, turn = 0.0, 0.0, 0.0, 0.0
        for u in range(3):
            v, w = (u + 1) % 3, (u + 2) % 3
            height += arm[u] * normal[u]
            long += edge[u] * edge[u]
            along += arm[u] * edge[u]
            turn += normal[u] * (edge[v] * arm[w] - edge[w] * arm[v])
        if abs(height) > narrow:
            return False
        left &= turn >= 0
        right &= turn <= 0
        part = min(max(along / long, 0.0), 1.0) if long > 0 else 0.0
        apart = 0.0
        for u in range(3):
            apart += (arm[u] - part * edge[u] - height * normal[u]) ** 2
        nearest = min(nearest, apart)
    return left or right or nearest <= narrow**2
