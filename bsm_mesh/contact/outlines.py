"""Outlines of the blocks as the contact search needs them: rigid shapes that are only moved and turned."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numba as nb
import numpy as np
import numpy.typing as npt

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray, own_array
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.model.polygons import owner_of_corner


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Outlines:
    """What never changes while blocks move. Edge e runs from corner e to corner ``following[e]``.

    Attributes
    ----------
    corners : (n_vertices, 2) float64 [m]
        Corners from the centroid of their block, at zero rotation.
    offsets : (n_blocks + 1,) int32
        Block b owns ``corners[offsets[b]:offsets[b + 1]]``.
    following, preceding : (n_vertices,) int32
        Next and previous corner of the same block.
    nodes : (n_vertices,) int32
        Number of the point at which each corner lies at the start; corners that touch there share it.
    held : (n_blocks,) bool
        Blocks that cannot move at all: two of them are no pair.
    block_size : (n_blocks,) float64 [m]
        Square root of each block's area.
    size : float [m]
        Median of `block_size` over the blocks that can move (over all if none can).
    """

    corners: FloatArray
    offsets: IntArray
    following: IntArray
    preceding: IntArray
    nodes: IntArray
    held: BoolArray
    block_size: FloatArray
    size: float

    def __post_init__(self) -> None:
        own_array(self, "corners", np.float64, (None, 2))
        for name in ("offsets", "following", "preceding", "nodes"):
            own_array(self, name, np.int32, (None,))
        own_array(self, "held", np.bool_, (None,))
        own_array(self, "block_size", np.float64, (None,))

    @classmethod
    def of(cls, blocks: Blocks, held: npt.ArrayLike) -> Outlines:
        """Return the outlines of blocks, of which those flagged in `held` (n_blocks,) cannot move."""
        fixed = np.asarray(held, dtype=bool)
        block_size = np.sqrt(blocks.moments.area)
        preceding = np.empty_like(blocks.following)
        preceding[blocks.following] = np.arange(len(blocks.following), dtype=np.int32)
        return cls(
            corners=blocks.vertices - blocks.moments.centroid[owner_of_corner(blocks.offsets)],
            offsets=blocks.offsets,
            following=blocks.following,
            preceding=preceding,
            nodes=blocks.nodes,
            held=fixed,
            block_size=block_size,
            size=float(np.median(block_size if fixed.all() else block_size[~fixed])),
        )


class Scene(NamedTuple):
    """The blocks where they stand now, as the compiled search takes them.

    `placed` are the corners (n_vertices, 2) [m], `direction` the unit vectors along the edges, `box` the bounding
    boxes (x0, y0, x1, y1), widened by half the band; `size` is the length that rules are scaled with, one a block.
    The rest is as in `Outlines`.
    """

    placed: FloatArray
    direction: FloatArray
    box: FloatArray
    corners: FloatArray
    offsets: IntArray
    following: IntArray
    preceding: IntArray
    nodes: IntArray
    held: BoolArray
    size: FloatArray


def corner_positions(outlines: Outlines, position: FloatArray) -> FloatArray:
    """Return where the corners are, (n_vertices, 2) [m].

    Parameters
    ----------
    outlines : Outlines
        The blocks.
    position : (n_blocks, 3) float64 [m, m, rad]
        Centroid and rotation of every block; rotations of any size are exact.
    """
    placed: FloatArray = _place(outlines.corners, outlines.offsets, np.ascontiguousarray(position))
    return placed


def scene_at(outlines: Outlines, position: FloatArray, band: float) -> Scene:
    """Return the blocks at a position (n_blocks, 3), with boxes widened by half the band [m] on every side."""
    placed = corner_positions(outlines, position)
    direction, box = _frame(placed, outlines.offsets, 0.5 * band)
    return Scene(
        placed=placed,
        direction=direction,
        box=box,
        corners=outlines.corners,
        offsets=outlines.offsets,
        following=outlines.following,
        preceding=outlines.preceding,
        nodes=outlines.nodes,
        held=outlines.held,
        size=np.minimum(outlines.block_size, outlines.size),
    )


@nb.njit(cache=True)
def _place(corners: FloatArray, offsets: IntArray, position: FloatArray) -> FloatArray:  # pragma: no cover - compiled
    """Return the corners, turned by each block's rotation and moved to its centroid."""
    placed = np.empty_like(corners)
    for b in range(offsets.size - 1):
        c, s = np.cos(position[b, 2]), np.sin(position[b, 2])
        for i in range(offsets[b], offsets[b + 1]):
            placed[i, 0] = position[b, 0] + (c * corners[i, 0] - s * corners[i, 1])
            placed[i, 1] = position[b, 1] + (s * corners[i, 0] + c * corners[i, 1])
    return placed


@nb.njit(cache=True)
def _frame(
    placed: FloatArray, offsets: IntArray, margin: float
) -> tuple[FloatArray, FloatArray]:  # pragma: no cover - compiled
    """Return the unit vector along every edge and every block's box, widened by a margin."""
    direction = np.empty_like(placed)
    box = np.empty((offsets.size - 1, 4))
    for b in range(offsets.size - 1):
        box[b, 0], box[b, 1], box[b, 2], box[b, 3] = np.inf, np.inf, -np.inf, -np.inf
        for i in range(offsets[b], offsets[b + 1]):
            k = i + 1 if i + 1 < offsets[b + 1] else offsets[b]
            x, y = placed[i, 0], placed[i, 1]
            dx, dy = placed[k, 0] - x, placed[k, 1] - y
            length = np.sqrt(dx * dx + dy * dy)
            direction[i, 0], direction[i, 1] = dx / length, dy / length
            box[b, 0], box[b, 1] = min(box[b, 0], x - margin), min(box[b, 1], y - margin)
            box[b, 2], box[b, 3] = max(box[b, 2], x + margin), max(box[b, 3], y + margin)
    return direction, box
