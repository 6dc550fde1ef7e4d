"""Which blocks are at a point."""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import IntArray
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
    at = np.array(point, dtype=np.float64)
    tolerance = max(tolerance, 16 * np.finfo(np.float64).eps * float(np.abs(at).max()))
    start = blocks.vertices - at
    corner = np.hypot(*start.T) <= tolerance
    if corner.any():
        return np.unique(blocks.owner[corner])
    along = blocks.edge_vectors
    length = np.hypot(*along.T)
    cross = along[:, 0] * start[:, 1] - along[:, 1] * start[:, 0]  # > 0: the point is right of the edge
    along_edge = -(along * start).sum(axis=1)
    on_edge = (np.abs(cross) <= tolerance * length) & (along_edge >= 0) & (along_edge <= length**2)
    end_y = start[:, 1] + along[:, 1]
    crosses = (start[:, 1] > 0) != (end_y > 0)
    with np.errstate(divide="ignore", invalid="ignore"):
        right = start[:, 0] - start[:, 1] * along[:, 0] / along[:, 1] > 0
    inside = np.add.reduceat((crosses & right).astype(np.int64), blocks.offsets[:-1]) % 2 == 1
    inside |= np.logical_or.reduceat(on_edge, blocks.offsets[:-1])
    return np.flatnonzero(inside).astype(np.int32)
