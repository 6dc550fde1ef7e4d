"""Nodes of a mesh that lie near lines are moved onto them, and lines are led through nodes to rounding.

A line that passes near a node would cut a sliver off the elements there. The line stays as it was given: a plane bent
to the nodes is another joint. The node moves. One on the rim, a joint, a boundary or the border of a rock moves
along that where it is straight, and stays where it is not.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray
from bsm_mesh.converters.meshes.regions import joined_pairs
from bsm_mesh.converters.meshes.segments import Segments, crossings, foot_points
from bsm_mesh.merged_points import merge_points
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.model.edges import LongArray

NEAR = 0.05  # of the narrowest element and the shortest edge at a node: nearer to a line, the node moves onto it
FARTHEST = 0.15  # of that width: no node moves further, where lines cross or along a rim
EXACT = 1e-6  # of that width: nearer to a node or an edge than this, a line goes through it
STRAIGHT = 1e-9  # sine of the angle between two edges that are one straight line


def node_places(blocks: Blocks) -> FloatArray:
    """Return the place of every node, (n_nodes, 2) [m]; not-a-number for numbers without a corner."""
    place = np.full((int(blocks.nodes.max()) + 1, 2), np.nan)
    place[blocks.nodes[::-1]] = blocks.vertices[::-1]
    return place


def single_edges(blocks: Blocks) -> LongArray:
    """Return the edges, of two that are sides of one face the first."""
    single = blocks.edge_table.unpaired()
    single[blocks.edge_table.pairs()[0]] = True
    return np.flatnonzero(single)


def element_widths(blocks: Blocks) -> FloatArray:
    """Return area over longest edge of every element [m]."""
    edge = np.hypot(*blocks.edge_vectors.T)
    width: FloatArray = blocks.moments.area / np.maximum.reduceat(edge, blocks.offsets[:-1])
    return width


def node_widths(blocks: Blocks) -> FloatArray:
    """Return the least of the widths of the elements and of the lengths of the edges at every node [m]."""
    width = np.full(int(blocks.nodes.max()) + 1, np.inf)
    edge = np.hypot(*blocks.edge_vectors.T)
    for ends in (blocks.nodes, blocks.nodes[blocks.following]):
        np.minimum.at(width, ends, np.minimum(edge, element_widths(blocks)[blocks.owner]))
    return width


def move_nodes(blocks: Blocks, segments: Segments) -> tuple[Blocks, LongArray, FloatArray]:
    """Return blocks with the nodes near segments on them, which nodes were moved, and how far [m]."""
    import shapely

    place, width = node_places(blocks), node_widths(blocks)
    there = np.flatnonzero(np.isfinite(place[:, 0]))
    tree = shapely.STRtree(segments.shapes)
    at, segment = tree.query(shapely.points(place[there]), predicate="dwithin", distance=NEAR * width[there])
    node, target = _targets(blocks, place, there[at], segment, segments)
    distance = np.hypot(*(target - place[node]).T)
    good = (distance <= FARTHEST * width[node]) & (distance > 0)
    node, target, distance = node[good], target[good], distance[good]
    moved = place.copy()
    moved[node] = target
    stays = _turned_over(blocks, place, moved)
    back = np.isin(node, stays)
    moved[node[back]] = place[node[back]]
    return _with_nodes_at(blocks, moved), node[~back], distance[~back]


def _targets(
    blocks: Blocks, place: FloatArray, node: LongArray, segment: LongArray, segments: Segments
) -> tuple[LongArray, FloatArray]:
    """Return nodes that may move, each once, and where to: the nearest point of a segment, or where two cross."""
    foot = foot_points(place[node], segments.ends[segment])
    order = np.lexsort([np.hypot(*(foot - place[node]).T), node])
    node, segment, foot = node[order], segment[order], foot[order]
    first = np.flatnonzero(np.append(True, node[1:] != node[:-1])[: len(node)])
    of_first = np.repeat(first, np.diff(np.append(first, len(node))))
    cross, sine = crossings(segments.ends[segment[of_first]], segments.ends[segment])
    steepest = np.lexsort([np.nan_to_num(sine), node])[np.append(first[1:], len(node)) - 1] if len(node) else first
    several = np.nan_to_num(sine[steepest]) > 0.1
    target = np.where(several[:, None], cross[steepest], foot[first])
    node, ends = node[first], segments.ends[segment[first]]
    free, along = _freedom(blocks, place)
    sliding = np.isfinite(along[node, 0]) & ~several
    track = np.stack([place[node], place[node] + np.nan_to_num(along[node])], axis=1)
    on_track, angle = crossings(track, ends)
    meets = sliding & (np.nan_to_num(angle) > 0.1)
    target = np.where(meets[:, None], on_track, target)
    chosen = free[node] | meets
    return node[chosen], target[chosen]


def _freedom(blocks: Blocks, place: FloatArray) -> tuple[BoolArray, FloatArray]:
    """Return which nodes may move anywhere, and the unit vectors along which others may; not-a-number for none."""
    one, other = blocks.edge_table.pairs()
    bound = np.ones(len(blocks.vertices), dtype=np.bool_)
    inner = joined_pairs(blocks, one, other)
    bound[one[inner]] = bound[other[inner]] = False
    kind = blocks.edge_joint.astype(np.int64)  # what an edge carries, as a number
    for edges in blocks.boundaries.values():
        bound[edges] = True
        on = np.zeros(len(blocks.vertices), dtype=np.int64)
        on[edges] = 1
        kind = np.unique(2 * (kind - kind.min()) + on, return_inverse=True)[1].reshape(-1)
    edge = np.flatnonzero(bound)
    ends = np.sort(np.stack([blocks.nodes[edge], blocks.nodes[blocks.following[edge]]], axis=1), axis=1)
    ends, index = np.unique(ends, axis=0, return_index=True)
    kind = kind[edge[index]]
    count = np.bincount(ends.ravel(), minlength=len(place))
    free = count == 0
    vector = place[ends[:, 1]] - place[ends[:, 0]]
    unit = vector / np.hypot(*vector.T)[:, None]
    flat, sign = ends.T.ravel(), np.repeat([1.0, -1.0], len(ends))
    order = np.argsort(flat, kind="stable")
    outward, bears = (np.tile(unit, (2, 1)) * sign[:, None])[order], np.tile(kind, 2)[order]
    start = np.searchsorted(flat[order], np.flatnonzero(count == 2))
    a, b = outward[start], outward[np.minimum(start + 1, len(order) - 1)]
    line = (np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]) <= STRAIGHT) & (np.einsum("nj,nj->n", a, b) < 0)
    line &= bears[start] == bears[np.minimum(start + 1, len(order) - 1)]
    along = np.full((len(place), 2), np.nan)
    along[np.flatnonzero(count == 2)[line]] = a[line]
    return free, along


def _turned_over(blocks: Blocks, place: FloatArray, moved: FloatArray) -> LongArray:
    """Return the nodes that have to stay where they were: those of elements that would not be simple polygons."""
    import shapely

    stays, before = np.empty(0, np.int64), blocks.moments.area
    for _ in range(len(moved)):
        here = moved.copy()
        here[stays] = place[stays]
        corners = here[blocks.nodes]
        changed = np.unique(blocks.owner[np.any(corners != blocks.vertices, axis=1)])
        mine = np.isin(blocks.owner, changed)
        rings = shapely.linearrings(corners[mine], indices=np.searchsorted(changed, blocks.owner[mine]))
        polygons = shapely.polygons(rings)
        bad = ~shapely.is_valid(polygons) | ~shapely.is_ccw(rings) | (shapely.area(polygons) < before[changed] / 2)
        if not bad.any():
            break
        stays = np.union1d(stays, blocks.nodes[np.isin(blocks.owner, changed[bad])])
    return stays


def _with_nodes_at(blocks: Blocks, place: FloatArray) -> Blocks:
    from dataclasses import replace

    vertices = place[blocks.nodes]
    return blocks if np.array_equal(vertices, blocks.vertices) else replace(blocks, vertices=vertices)


def lead_through(blocks: Blocks, segments: Segments) -> Segments:
    """Return segments whose ends lie on nodes, edges or other lines that they touch to rounding, and pass nodes so."""
    import shapely

    place, width = node_places(blocks), node_widths(blocks)
    there = np.flatnonzero(np.isfinite(place[:, 0]))
    least = EXACT * float(width[there].min())
    ends = _merged(segments.ends.reshape(-1, 2), least)
    ends = _on_edges(blocks, ends, segments.moved(ends), width)
    ends = _on_nodes(place[there], EXACT * width[there], _merged(ends, least))
    segments = segments.moved(ends)
    node, segment = shapely.STRtree(segments.shapes).query(
        shapely.points(place[there]), predicate="dwithin", distance=EXACT * width[there]
    )
    through = place[there[node]]
    between = ~(through[:, None] == segments.ends[segment]).all(axis=2).any(axis=1)
    return segments.divided(segment[between], through[between])


def _merged(points: FloatArray, tolerance: float) -> FloatArray:
    """Return points, those nearer than the tolerance at the place of the first."""
    number = merge_points(points, tolerance)
    first = np.empty((int(number.max(initial=-1)) + 1, 2))
    first[number[::-1]] = points[::-1]
    return first[number]


def _on_nodes(nodes: FloatArray, reach: FloatArray, points: FloatArray) -> FloatArray:
    from scipy.spatial import cKDTree

    distance, nearest = cKDTree(nodes).query(points)
    return np.where((distance <= reach[nearest])[:, None], nodes[nearest], points)


def _on_edges(blocks: Blocks, points: FloatArray, segments: Segments, width: FloatArray) -> FloatArray:
    """Return points, those that lie on an edge or another segment to rounding exactly there."""
    import shapely

    first = single_edges(blocks)
    sides = np.stack([blocks.vertices[first], blocks.vertices[blocks.following[first]]], axis=1)
    reach = np.minimum(width[blocks.nodes[first]], width[blocks.nodes[blocks.following[first]]])
    ends = np.concatenate([sides, segments.ends])
    size = np.concatenate([reach, np.full(len(segments.ends), float(reach.min()))])
    tree: Any = shapely.STRtree(shapely.linestrings(ends))
    unique, one, inverse = np.unique(points, axis=0, return_index=True, return_inverse=True)
    at, edge = tree.query(shapely.points(unique), predicate="dwithin", distance=EXACT * float(reach.max()))
    foot = foot_points(unique[at], ends[edge])
    distance = np.hypot(*(foot - unique[at]).T)
    straight, _ = crossings(ends[edge], points.reshape(-1, 2, 2)[one[at] // 2])  # along its own line, which stays
    off = np.hypot(*(straight - unique[at]).T)
    foot = np.where((off <= 4 * EXACT * size[edge])[:, None], straight, foot)
    own = (ends[edge] == unique[at][:, None]).all(axis=2).any(axis=1)
    near = (distance <= EXACT * size[edge]) & (distance > 0) & ~own
    at, foot, distance, edge = at[near], foot[near], distance[near], edge[near]
    order = np.lexsort([distance, edge >= len(sides), at])[::-1]  # edges of elements before lines, the nearest first
    unique[at[order]] = foot[order]
    return unique[inverse.reshape(-1)]
