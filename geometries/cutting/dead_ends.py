"""Ends of joints in the rock, and their extension to the next joint."""

from __future__ import annotations

import dataclasses

import numpy as np

from bsm_mesh.geometries.cutting.graph import Graph
from bsm_mesh.geometries.cutting.pieces import BoolArray, IntArray, Pieces
from bsm_mesh.geometries.joint_sets import FloatArray

FIRST_REACH = 4.0  # of the median edge; doubled until the next joint is met


def dead_ends(graph: Graph) -> IntArray:
    """Return the points at which a single edge ends."""
    return np.flatnonzero(np.bincount(graph.edges.ravel(), minlength=len(graph.points)) == 1)


def extend_ends(graph: Graph, pieces: Pieces, in_rock: BoolArray, tolerance: float) -> Pieces:
    """Return the pieces, their dead ends extended to the next edge.

    Only ends of pieces that extend, at points in the rock (`in_rock`, (n_points,)), are looked at. Ends that meet
    nothing ahead are left as they are; of two ends in line that reach for each other, one does.
    """
    node, piece, outward = _ends_to_extend(graph, pieces)
    here = in_rock[node]
    node, piece, outward = node[here], piece[here], outward[here]
    start = graph.points[node]
    far = np.full(len(node), np.nan)
    reach = FIRST_REACH * float(np.median(graph.length))
    limit = 2 * float(np.hypot(*np.ptp(graph.points, axis=0)))
    open_ends = np.arange(len(node))
    while open_ends.size and reach < 2 * limit:
        far[open_ends] = _distance_to_next(graph, start[open_ends], outward[open_ends], reach, 2 * tolerance)
        open_ends = open_ends[np.isnan(far[open_ends])]
        reach *= 2
    hit = np.flatnonzero(~np.isnan(far))
    target = start[hit] + far[hit, None] * outward[hit]
    once = _once(np.stack([start[hit], target], axis=1), tolerance)
    hit, target = hit[once], target[once]
    side = (np.einsum("nj,nj->n", outward[hit], pieces.direction[piece[hit]]) > 0).astype(np.int64)
    ends = pieces.ends.copy()
    ends[piece[hit], side] = target
    return dataclasses.replace(pieces, ends=ends)


def _ends_to_extend(graph: Graph, pieces: Pieces) -> tuple[IntArray, IntArray, FloatArray]:
    """Return point, piece and outward direction of the dead ends of pieces that extend."""
    is_dead = np.zeros(len(graph.points), dtype=np.bool_)
    is_dead[dead_ends(graph)] = True
    row = np.flatnonzero(pieces.extends[graph.piece] & is_dead[graph.edges[graph.edge]].any(axis=1))
    _, once = np.unique(graph.edge[row], return_index=True)
    row = np.repeat(row[once], 2)
    side = np.tile([0, 1], len(row) // 2)
    node, other = graph.edges[graph.edge[row], side], graph.edges[graph.edge[row], 1 - side]
    row, node, other = row[is_dead[node]], node[is_dead[node]], other[is_dead[node]]
    piece = graph.piece[row]
    direction = pieces.direction[piece]
    sign = np.sign(np.einsum("nj,nj->n", graph.points[node] - graph.points[other], direction))
    return node, piece, sign[:, None] * direction


def _distance_to_next(graph: Graph, start: FloatArray, outward: FloatArray, reach: float, least: float) -> FloatArray:
    """Return the distance along each ray to the first edge between `least` and `reach`; not-a-number if none.

    An edge in line with the ray, the next trace of the same joint, is met at its nearer end.
    """
    import shapely

    edges = graph.points[graph.edges]
    rays = shapely.linestrings(np.stack([start, start + reach * outward], axis=1))
    ray, edge = shapely.STRtree(shapely.linestrings(edges)).query(rays, predicate="dwithin", distance=least / 4)
    along = edges[edge, 1] - edges[edge, 0]
    gap = edges[edge] - start[ray][:, None]
    cross = outward[ray, 0] * along[:, 1] - outward[ray, 1] * along[:, 0]
    ends = np.einsum("nij,nj->ni", gap, outward[ray])
    in_line = np.abs(cross) <= least
    with np.errstate(divide="ignore", invalid="ignore"):
        crossing = (gap[:, 0, 0] * along[:, 1] - gap[:, 0, 1] * along[:, 0]) / cross
    distance = np.where(in_line, ends.min(axis=1), np.clip(crossing, ends.min(axis=1), ends.max(axis=1)))
    good = np.isfinite(distance) & (distance > least) & (distance <= 1.001 * reach)
    nearest = np.full(len(start), np.inf)
    np.minimum.at(nearest, ray[good], distance[good])
    return np.where(np.isinf(nearest), np.nan, nearest)


def _once(ends: FloatArray, tolerance: float) -> BoolArray:
    """Return which of the lines are the first between their ends: two dead ends in line reach for each other."""
    key = np.round(ends / (4 * tolerance)).astype(np.int64)
    swap = (key[:, 0, 0] > key[:, 1, 0]) | ((key[:, 0, 0] == key[:, 1, 0]) & (key[:, 0, 1] > key[:, 1, 1]))
    key[swap] = key[swap][:, ::-1]
    _, first = np.unique(key.reshape(-1, 4), axis=0, return_index=True)
    once = np.zeros(len(ends), dtype=np.bool_)
    once[first] = True
    return once
