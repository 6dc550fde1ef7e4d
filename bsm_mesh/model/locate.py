"""Which blocks are at a point."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.model.blocks import Blocks


def blocks_at(blocks: Blocks, point: tuple[float, float], tolerance: float = 1e-9) -> IntArray:
    """Return the blocks with a corner at `point`, else those that contain it, their outline included.

    Parameters
    ----------
    blocks : Blocks
        Where to look.
    point : (x, y) [m]
        Where.
    tolerance : float [m]
        Distance within which the point is on a corner or an edge; far from the origin not less than rounding.
    """
    return pairs_at(blocks, [point], tolerance)[1]


def pairs_at(
    blocks: Blocks, points: FloatArray | Sequence[tuple[float, float]], tolerance: float = 1e-9
) -> tuple[IntArray, IntArray]:
    """Return rows of points (k, 2) [m], in rising order, and the blocks there, as `blocks_at` finds them, (l,) each."""
    places = np.array(points, dtype=np.float64).reshape(-1, 2)
    within = np.maximum(tolerance, 16 * np.finfo(np.float64).eps * np.abs(places).max(axis=1, initial=0.0))
    row, block = _candidates(blocks, places, within)
    count = np.diff(blocks.offsets)[block]
    first = np.cumsum(count) - count
    pair = np.repeat(np.arange(len(row)), count)
    edge = blocks.offsets[block][pair] + np.arange(len(pair)) - first[pair]
    start, along, near = blocks.vertices[edge] - places[row][pair], blocks.edge_vectors[edge], within[row][pair]
    corner = np.hypot(*start.T) <= near
    length = np.hypot(*along.T)
    cross = along[:, 0] * start[:, 1] - along[:, 1] * start[:, 0]  # > 0: the point is right of the edge
    along_edge = -(along * start).sum(axis=1)
    on_edge = (np.abs(cross) <= near * length) & (along_edge >= 0) & (along_edge <= length**2)
    end_y = start[:, 1] + along[:, 1]
    crosses = (start[:, 1] > 0) != (end_y > 0)
    with np.errstate(divide="ignore", invalid="ignore"):
        right = start[:, 0] - start[:, 1] * along[:, 0] / along[:, 1] > 0
    has_corner = np.bincount(pair, corner, len(row)) > 0
    inside = (np.bincount(pair, crosses & right, len(row)) % 2 == 1) | (np.bincount(pair, on_edge, len(row)) > 0)
    at_corner = np.bincount(row, has_corner, len(places)) > 0
    found = np.where(at_corner[row], has_corner, inside)
    return row[found], block[found]


def _candidates(blocks: Blocks, places: FloatArray, within: FloatArray) -> tuple[IntArray, IntArray]:
    """Return rows of points (k, 2) [m] and the blocks whose extent they are in, to distances (k,) [m], (l,) each."""
    low, high = (reduce.reduceat(blocks.vertices, blocks.offsets[:-1]).T for reduce in (np.minimum, np.maximum))
    near = [
        np.flatnonzero(
            (low[0] <= x + e) & (low[1] <= y + e) & (high[0] >= x - e) & (high[1] >= y - e),
        )
        for (x, y), e in zip(places, within, strict=True)
    ]
    row = np.repeat(np.arange(len(places)), [len(some) for some in near])
    return row, np.concatenate([*near, np.zeros(0, np.int64)]).astype(np.int32)
