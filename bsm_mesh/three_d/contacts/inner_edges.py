"""Faces that meet at an angle at the end of a flat contact: which of them gives the direction of the contact.

A block that lies flat on a second one may slide against the edge of a third, which ends in the plane of the second. The
edge is level with that plane. Springs let the block sink a little, so its front face would catch on the edge. Instead
the block's own edge meets the face of the third one.
"""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.compiled import njit
from bsm_mesh.three_d.contacts.beside_flats import lies_on


def at_inner_edges(
    rows: FloatArray,
    sizes: IntArray,
    blocks: IntArray,
    kinds: tuple[BoolArray, BoolArray],
    there: tuple[FloatArray, FloatArray],
    slide: FloatArray,
    narrow: float,
) -> FloatArray:
    """Return rows that have the normal of the other face where a face ends in the plane of a flat contact.

    Where a slid against b it is only the normal of a face along which a slid more. Before any slide it is that of the
    face beyond the edge that is nearer to its plane.

    Parameters
    ----------
    rows : (k, 14) float64
        As `clipped` gives them.
    sizes : (q,) int
        Rows of every polygon.
    blocks : (q, 2) int
        Blocks a and b of every polygon.
    kinds : two of (q,) bool
        Which polygons are flat, and which touch.
    there : two of (q, 2, 3) float64
        A corner [m] and the normal of both faces of every polygon.
    slide : (q, 3) float64 [m]
        Movement of a against b.
    narrow : float [m]
        Places nearer than this are one.
    """
    (corner, normal), of = there, np.repeat(np.arange(len(sizes)), sizes)
    mean = normal[:, 1] - normal[:, 0]
    over = [over_points(rows[:, :3], mean[of], corner[of, side], normal[of, side]) for side in (0, 1)]
    height = _heights_of_edges(rows, (over[0], over[1]), sizes, blocks, *kinds, narrow)
    across = np.abs(np.einsum("qsj,qj->qs", normal, slide))[of]
    moved = np.abs(np.diff(across)) > narrow
    less = np.where(moved, across[:, ::-1], height)
    others = np.isfinite(height) & (less < less[:, ::-1])
    found = rows.copy()
    for side, k in enumerate(map(np.flatnonzero, others.T)):
        across = normal[of[k], 1] if side == 0 else -normal[of[k], 0]
        apart = over[0][k] - over[1][k]
        gap = np.einsum("ij,ij->i", apart, across)[:, None]
        points = (over[0][k], over[0][k] - gap * across) if side == 0 else (over[1][k] + gap * across, over[1][k])
        found[k, 3:] = np.hstack([*points, across, gap, np.full_like(gap, side)])
    return found


def over_points(point: FloatArray, mean: FloatArray, corner: FloatArray, normal: FloatArray) -> FloatArray:
    """Return the points of faces, by a corner and a normal of each, that lie over points along `mean`, (k, 3)."""
    height = np.einsum("ij,ij->i", corner - point, normal) / np.einsum("ij,ij->i", mean, normal)
    found: FloatArray = point + height[:, None] * mean
    return found


def _heights_of_edges(
    rows: FloatArray,
    over: tuple[FloatArray, FloatArray],
    sizes: IntArray,
    blocks: IntArray,
    flat: BoolArray,
    touch: BoolArray,
    narrow: float,
) -> FloatArray:
    """Return by how much the edges of b, and those of a, are out of the plane of a flat contact, (k, 2) [m].

    The other block touches a third one flat in that plane, and the edge lies at the end of that contact. Elsewhere, and
    for polygons that are flat, the height is infinite.

    Parameters
    ----------
    rows : (k, 14) float64
        As `clipped` gives them.
    over : two of (k, 3) float64 [m]
        The points of the faces of a and of b over the corner of each row.
    sizes : (q,) int
        Rows of every polygon.
    blocks : (q, 2) int
        Blocks a and b of every polygon.
    flat, touch : (q,) bool
        Which polygons are of faces that are parallel, and of faces that touch.
    narrow : float [m]
        Places nearer than this are one.
    """
    flats = np.flatnonzero(flat & touch)
    of = blocks[flats].ravel()
    order = np.argsort(of, kind="stable")
    first = np.append(0, np.cumsum(np.bincount(of, minlength=blocks.max(initial=0) + 1)))
    ends = np.append(0, np.cumsum(sizes))
    found: FloatArray = _heights(rows, np.stack(over), ends, blocks, flat, flats.repeat(2)[order], first, narrow)
    return found


@njit(allocates=True)
def _heights(
    rows: FloatArray,
    over: FloatArray,
    ends: IntArray,
    blocks: IntArray,
    flat: BoolArray,
    flats: IntArray,
    first: IntArray,
    narrow: float,
) -> FloatArray:  # pragma: no cover - compiled
    """Return `_heights_of_edges`.

    Flat contacts of block i are ``flats[first[i]:first[i + 1]]``. The faces are apart at a row by as much as its points
    `over` (2, k, 3), and may be as far from the flat contact.
    """
    found = np.full((rows.shape[0], 2), np.inf)
    for q in range(flat.size):
        if flat[q]:
            continue
        for side in range(2):
            own, other = blocks[q, side], blocks[q, 1 - side]
            for m in range(first[own], first[own + 1]):
                p = flats[m]
                if blocks[p, 0] == other or blocks[p, 1] == other:
                    continue
                for c in range(ends[q], ends[q + 1]):
                    point, apart = over[1 - side, c], 0.0
                    height = _height(point, rows[ends[p]])
                    if height > min(narrow, found[c, side]):
                        continue
                    for u in range(3):
                        apart += (over[0, c, u] - over[1, c, u]) ** 2
                    if lies_on(point, rows, ends[p], ends[p + 1], narrow + np.sqrt(apart)):
                        found[c, side] = height
    return found


@njit()
def _height(point: FloatArray, row: FloatArray) -> float:  # pragma: no cover - compiled
    """Return how far a point is out of the plane of the flat polygon of a row [m]."""
    height = 0.0
    for u in range(3):
        height += (point[u] - (row[3 + u] + row[6 + u]) / 2) * row[9 + u]
    return abs(height)
