"""Blocks that share all their corners: one that lies in the middle of a neighbour's edge becomes a corner there too."""

from __future__ import annotations

import dataclasses

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.model.blocks import MERGE_TOLERANCE, Blocks
from bsm_mesh.model.edges import LongArray


def conforming(blocks: Blocks, tolerance: float = MERGE_TOLERANCE) -> Blocks:
    """Return the blocks with a corner wherever another block has one within the tolerance of their edge.

    The parts of a divided edge keep its joint and boundaries. The new corners lie at the old ones, so the area may
    change by the tolerance times the length of the edge.
    """
    edge, corner, along = _corners_on_edges(blocks, tolerance)
    if edge.size == 0:
        return blocks
    count = len(blocks.vertices)
    parent = np.concatenate([np.arange(count), edge])
    order = np.lexsort([np.concatenate([np.zeros(count), along]), parent])
    source = np.concatenate([np.arange(count), corner])[order]
    parent = parent[order]
    sizes = np.bincount(blocks.owner[parent], minlength=blocks.count)
    return dataclasses.replace(
        blocks,
        vertices=blocks.vertices[source],
        nodes=blocks.nodes[source],
        offsets=np.concatenate([[0], np.cumsum(sizes)]).astype(np.int32),
        edge_joint=blocks.edge_joint[parent],
        boundaries={
            name: np.flatnonzero(np.isin(parent, edges)).astype(np.int32) for name, edges in blocks.boundaries.items()
        },
    )


def _corners_on_edges(blocks: Blocks, tolerance: float) -> tuple[LongArray, LongArray, FloatArray]:
    """Return edge, corner (of another block) and the share of the edge's length before it."""
    import shapely

    unpaired = np.flatnonzero(blocks.edge_table.unpaired())
    start, end = blocks.vertices[unpaired], blocks.vertices[blocks.following[unpaired]]
    _, first = np.unique(blocks.nodes, return_index=True)
    lines = shapely.linestrings(np.stack([start, end], axis=1))
    edge, point = shapely.STRtree(shapely.points(blocks.vertices[first])).query(
        lines, predicate="dwithin", distance=tolerance
    )
    corner = first[point]
    vector = end[edge] - start[edge]
    along = np.einsum("nj,nj->n", blocks.vertices[corner] - start[edge], vector) / np.einsum("nj,nj->n", vector, vector)
    node = blocks.nodes[corner]
    middle = (node != blocks.nodes[unpaired[edge]]) & (node != blocks.nodes[blocks.following[unpaired[edge]]])
    middle &= (along > 0) & (along < 1)
    return unpaired[edge[middle]], corner[middle], along[middle]
