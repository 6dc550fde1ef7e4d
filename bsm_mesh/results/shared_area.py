"""The area that blocks share: convex ones clipped by each other in one compiled pass, others by GEOS."""

from __future__ import annotations

from typing import Any

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray, rounding_of
from bsm_mesh.compiled import njit
from bsm_mesh.model.overlap import polygons_of

GRID = 1e-10  # of the smallest block's size: to what GEOS rounds
STRAIGHT = -1e-9  # sine of a turn to the right that still counts as straight on


def shared_area(corners: FloatArray, offsets: IntArray) -> float:
    """Return the sum of the areas that pairs of blocks share [m2].

    Parameters
    ----------
    corners : (n_vertices, 2) float64 [m]
        Corners, counter-clockwise, block after block.
    offsets : (n_blocks + 1,) int32
        Block b owns ``corners[offsets[b]:offsets[b + 1]]``.
    """
    return float(_pair_areas(corners, offsets, *_near_pairs(corners, offsets)).sum())


def greatest_pair(corners: FloatArray, offsets: IntArray) -> tuple[int, int]:
    """Return the two blocks that share the greatest area; arguments as `shared_area` takes them."""
    left, right = _near_pairs(corners, offsets)
    most = int(_pair_areas(corners, offsets, left, right).argmax())
    return int(left[most]), int(right[most])


def _near_pairs(corners: FloatArray, offsets: IntArray) -> tuple[IntArray, IntArray]:
    """Return the pairs of blocks whose boxes meet, (k,) each."""
    import shapely

    boxes = _boxes(corners, offsets)
    left, right = shapely.STRtree(boxes).query(boxes)
    first = left < right
    return left[first], right[first]


def shares_inside(corners: FloatArray, offsets: IntArray, blocks: IntArray) -> FloatArray:
    """Return what part of the area of some blocks (k,) lies inside others, (k,); arguments as `shared_area` takes them.

    Area inside two others counts twice.
    """
    import shapely

    boxes = _boxes(corners, offsets)
    row, other = shapely.STRtree(boxes).query(boxes[blocks])
    apart = blocks[row] != other
    row, other = row[apart], other[apart]
    inside = np.bincount(row, _pair_areas(corners, offsets, blocks[row], other), minlength=len(blocks))
    shares: FloatArray = inside / shapely.area(polygons_of(corners, offsets, blocks))
    return shares


def _boxes(corners: FloatArray, offsets: IntArray) -> Any:
    import shapely

    low, high = (bound.reduceat(corners, offsets[:-1], axis=0) for bound in (np.minimum, np.maximum))
    return shapely.box(*low.T, *high.T)


def _pair_areas(corners: FloatArray, offsets: IntArray, left: IntArray, right: IntArray) -> FloatArray:
    """Return the area that each pair of blocks shares, (k,) [m2]."""
    import shapely

    convex = _are_convex(corners, offsets)
    clipped = convex[left] & convex[right]
    area = np.zeros(len(left))
    area[clipped] = _clipped_areas(corners, offsets, left[clipped], right[clipped], int(np.diff(offsets).max()))
    others = np.flatnonzero(~clipped)
    if others.size:
        named, inverse = np.unique(np.concatenate([left[others], right[others]]), return_inverse=True)
        outlines = polygons_of(corners - corners.mean(axis=0), offsets, named)
        one, other = np.split(outlines[inverse], 2)
        grid = max(_grid(outlines), rounding_of(corners))
        area[others] = shapely.area(shapely.intersection(one, other, grid_size=grid))
    return area


def _grid(outlines: object) -> float:
    import shapely

    return GRID * float(np.sqrt(shapely.area(outlines).min()))


@njit(allocates=True)
def _are_convex(corners: FloatArray, offsets: IntArray) -> BoolArray:  # pragma: no cover - compiled
    """Return which outlines turn to the left at every corner."""
    convex = np.ones(offsets.size - 1, dtype=np.bool_)
    for b in range(convex.size):
        first, n = offsets[b], offsets[b + 1] - offsets[b]
        for i in range(n):
            p, q, r = corners[first + i], corners[first + (i + 1) % n], corners[first + (i + 2) % n]
            ux, uy, vx, vy = q[0] - p[0], q[1] - p[1], r[0] - q[0], r[1] - q[1]
            if ux * vy - uy * vx < STRAIGHT * np.sqrt((ux * ux + uy * uy) * (vx * vx + vy * vy)):
                convex[b] = False
    return convex


@njit(allocates=True)
def _clipped_areas(
    corners: FloatArray, offsets: IntArray, left: IntArray, right: IntArray, most: int
) -> FloatArray:  # pragma: no cover - compiled
    """Return the areas shared by pairs of convex outlines (Sutherland and Hodgman 1974)."""
    areas = np.zeros(left.size)
    kept, cut = np.empty((2 * most + 2, 2)), np.empty((2 * most + 2, 2))
    for pair in range(left.size):
        a, b = left[pair], right[pair]
        count = offsets[a + 1] - offsets[a]
        for i in range(count):  # no slice here and below: for those Numba compiles a message about shapes
            kept[i, 0], kept[i, 1] = corners[offsets[a] + i, 0], corners[offsets[a] + i, 1]
        first, n = offsets[b], offsets[b + 1] - offsets[b]
        for e in range(n):
            p, q = corners[first + e], corners[first + (e + 1) % n]
            count = _cut_off(kept, count, p[0], p[1], q[0] - p[0], q[1] - p[1], cut)
            kept, cut = cut, kept
            if count < 3:
                break
        x, y = kept[0, 0], kept[0, 1]  # areas from a corner: far from the origin nothing cancels
        for i in range(1, count - 1):
            ux, uy = kept[i, 0] - x, kept[i, 1] - y
            areas[pair] += 0.5 * (ux * (kept[i + 1, 1] - y) - uy * (kept[i + 1, 0] - x))
    return areas


@njit()
def _cut_off(
    outline: FloatArray, count: int, x: float, y: float, dx: float, dy: float, kept: FloatArray
) -> int:  # pragma: no cover - compiled
    """Put what of an outline lies left of a line in `kept`; return its number of corners."""
    found = 0
    for i in range(count):
        j = i + 1 if i + 1 < count else 0
        here = dx * (outline[i, 1] - y) - dy * (outline[i, 0] - x)
        there = dx * (outline[j, 1] - y) - dy * (outline[j, 0] - x)
        if here >= 0.0:
            kept[found, 0], kept[found, 1] = outline[i, 0], outline[i, 1]
            found += 1
        if (here > 0.0 and there < 0.0) or (here < 0.0 and there > 0.0):
            part = here / (here - there)
            kept[found, 0] = outline[i, 0] + part * (outline[j, 0] - outline[i, 0])
            kept[found, 1] = outline[i, 1] + part * (outline[j, 1] - outline[i, 1])
            found += 1
    return found
