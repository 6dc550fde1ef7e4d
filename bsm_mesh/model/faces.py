"""Faces: the parts of edges along which two blocks touch at the start.

Blocks of a conforming mesh share whole edges, found by the numbers of their end points. At a T-junction a corner of
one block lies within an edge of another. The face is then the common part of the two edges.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.errors import ModelError, place
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.model.loads import PointForces

COLLINEAR = 1e-6  # of the shorter edge: greatest distance of two edges that lie on each other
SHORTEST_FACE = 1e-6  # of the shorter edge: a shorter common part is a touching corner


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Faces:
    """Common parts of two blocks' edges, one row a face.

    Attributes
    ----------
    edge_a, edge_b : (k,) int32
        The two edges; b's direction is the face's.
    start, end : (k, 2) float64 [m]
        Ends of the common part, in the direction of `edge_b`.
    start_corner_of_a, end_corner_of_a : (k,) bool
        Whether the end is a corner of `edge_a`; else it is one of `edge_b`.
    """

    edge_a: IntArray
    edge_b: IntArray
    start: FloatArray
    end: FloatArray
    start_corner_of_a: BoolArray
    end_corner_of_a: BoolArray


def find_faces(blocks: Blocks) -> Faces:
    """Return all faces between blocks: shared edges first, then parts of edges at T-junctions.

    Raises
    ------
    ModelError
        If two blocks lie on the same side of an edge, that is, overlap.
    """
    table = blocks.edge_table
    contested = table.contested()
    if len(contested):
        raise ModelError(_overlap_faults(blocks, contested))
    edge_b, edge_a = (edges.astype(np.int32) for edges in table.pairs())
    start, end = blocks.vertices[edge_b], blocks.vertices[blocks.following[edge_b]]
    whole = np.ones(len(edge_a), dtype=bool)
    conforming = Faces(
        edge_a=edge_a, edge_b=edge_b, start=start, end=end, start_corner_of_a=whole, end_corner_of_a=whole
    )
    partial = _overlapping_edges(blocks, np.flatnonzero(table.unpaired()).astype(np.int32))
    if len(partial.edge_a) == 0:
        return conforming
    both = conforming, partial
    return Faces(**{name: np.concatenate([getattr(one, name) for one in both]) for name in Faces.__slots__})


def count_faces(blocks: Blocks, chosen: BoolArray) -> int:
    """Return how many faces lie between two of the chosen edges (n_edges,)."""
    one, other = blocks.edge_table.pairs()
    alone = np.flatnonzero(blocks.edge_table.unpaired() & chosen).astype(np.int32)
    return int((chosen[one] & chosen[other]).sum()) + len(_overlapping_edges(blocks, alone).edge_a)


def _overlap_faults(blocks: Blocks, contested: IntArray) -> list[str]:
    return [
        f"blocks {blocks.owner[one]} and {blocks.owner[other]} overlap: both lie on the same side of their edge at "
        f"{place(blocks.vertices[one])}; remove one or correct its corners"
        for one, other in contested
    ]


def _overlapping_edges(blocks: Blocks, edges: IntArray) -> Faces:
    """Return the faces between edges that share only a part of their length."""
    import shapely

    start = blocks.vertices[edges]
    along = blocks.edge_vectors[edges]
    length = np.hypot(*along.T)
    pairs = np.zeros((2, 0), dtype=np.int64)
    if len(edges) > 1:
        margin = COLLINEAR * length
        low, high = np.minimum(start, start + along), np.maximum(start, start + along)
        boxes = shapely.box(*(low - margin[:, None]).T, *(high + margin[:, None]).T)
        pairs = shapely.STRtree(boxes).query(boxes)
        pairs = pairs[:, pairs[0] < pairs[1]]
    a, b = pairs[1], pairs[0]
    keep = blocks.owner[edges[a]] != blocks.owner[edges[b]]
    shorter = np.minimum(length[a], length[b])
    unit = along[b] / length[b][:, None]
    from_b = start[a] - start[b]
    offset_start = unit[:, 0] * from_b[:, 1] - unit[:, 1] * from_b[:, 0]
    offset_end = offset_start + unit[:, 0] * along[a][:, 1] - unit[:, 1] * along[a][:, 0]
    # Edge a runs against b; where a is the longer one its far end may lie off b's line, so both are scaled.
    scale = COLLINEAR * shorter * np.maximum(1.0, length[a] / length[b])
    keep &= (np.abs(offset_start) <= scale) & (np.abs(offset_end) <= scale)
    a_high = (unit * from_b).sum(axis=1)
    a_low = a_high + (unit * along[a]).sum(axis=1)
    keep &= a_low < a_high
    tolerance = SHORTEST_FACE * shorter
    low, high = np.maximum(a_low, 0.0), np.minimum(a_high, length[b])
    keep &= high - low > tolerance
    a, b, unit, low, high, tolerance = a[keep], b[keep], unit[keep], low[keep], high[keep], tolerance[keep]
    return Faces(
        edge_a=edges[a],
        edge_b=edges[b],
        start=start[b] + low[:, None] * unit,
        end=start[b] + high[:, None] * unit,
        start_corner_of_a=a_low[keep] >= -tolerance,
        end_corner_of_a=a_high[keep] <= length[b] + tolerance,
    )


def pressure_between(blocks: Blocks, stays: BoolArray, leaves: BoolArray, pressure: float) -> PointForces:
    """Return a pressure on the faces between blocks that stay and blocks that leave, into those that stay."""
    faces, owner = find_faces(blocks), blocks.owner
    a, b = owner[faces.edge_a], owner[faces.edge_b]
    bare = (stays[b] & leaves[a]) | (stays[a] & leaves[b])
    start, end = faces.start[bare], faces.end[bare]
    along = end - start  # in the direction of b's edge, b to its left
    inward = np.stack([-along[:, 1], along[:, 0]], axis=1) * np.where(stays[b[bare]], 1.0, -1.0)[:, None]
    return PointForces(
        block=np.repeat(np.where(stays[b], b, a)[bare], 2),
        point=np.stack([start, end], axis=1).reshape(-1, 2),
        force=np.repeat(pressure * inward / 2, 2, axis=0),
    )
