"""Elements replaced by the faces into which they are cut: each part has the data of its element or edge."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.converters.meshes.nodes_on_lines import node_places
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.model.edges import LongArray
from bsm_mesh.model.polygons import owner_of_corner


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Faces:
    """Faces within elements.

    Attributes
    ----------
    points : (n_points, 2) float64 [m]
        Their corners, exactly.
    corners : (n_corners,) int64
        Points of the faces, counter-clockwise, face after face.
    offsets : (n_faces + 1,) int32
        Face f owns ``corners[offsets[f]:offsets[f + 1]]``.
    parent : (n_faces,) int64
        Element that each is a part of.
    """

    points: FloatArray
    corners: LongArray
    offsets: IntArray
    parent: LongArray


def with_faces(blocks: Blocks, crossed: LongArray, faces: Faces, tolerance: float) -> tuple[Blocks, LongArray]:
    """Return the blocks with the faces in place of those that are divided, and the given block of each."""
    from scipy.spatial import cKDTree

    place = node_places(blocks)
    count = np.bincount(faces.parent, minlength=blocks.count)
    sizes = np.diff(faces.offsets)
    changed = np.bincount(faces.parent, sizes, minlength=blocks.count) != np.diff(blocks.offsets)
    divided = (count > 1) | ((count == 1) & changed)
    there = np.unique(blocks.nodes[np.isin(blocks.owner, crossed)])
    distance, nearest = cKDTree(place[there]).query(faces.points)
    known = distance <= tolerance
    number = len(place) + np.cumsum(~known) - 1
    number[known] = there[nearest[known]]
    everywhere = np.concatenate([place, faces.points[~known]])
    parts = divided[faces.parent]
    kept = np.flatnonzero(~divided)
    nodes = np.concatenate([blocks.nodes[~divided[blocks.owner]], number[faces.corners][np.repeat(parts, sizes)]])
    size = np.concatenate([np.diff(blocks.offsets)[kept], sizes[parts]])
    parent = np.concatenate([kept, faces.parent[parts]])
    order = np.argsort(parent, kind="stable")
    begin = (np.cumsum(size) - size)[order]
    size, parent = size[order], parent[order]
    offsets = np.concatenate([[0], np.cumsum(size)]).astype(np.int32)
    nodes = nodes[np.arange(len(nodes)) + np.repeat(begin - offsets[:-1], size)]
    return _inherited(blocks, everywhere[nodes], nodes, offsets, parent, tolerance), parent


def _inherited(
    blocks: Blocks, vertices: FloatArray, nodes: LongArray, offsets: IntArray, parent: LongArray, tolerance: float
) -> Blocks:
    """Return blocks of these corners with all that the given blocks and edges have."""
    source = _source(blocks, vertices, offsets, parent, tolerance)
    on_edge = source >= 0
    return replace(
        blocks,
        vertices=vertices,
        offsets=offsets,
        nodes=nodes.astype(np.int32),
        rock=blocks.rock[parent],
        edge_joint=np.where(on_edge, blocks.edge_joint[source], -1).astype(np.int32),
        boundaries={
            name: np.flatnonzero(on_edge & np.isin(source, edges)).astype(np.int32)
            for name, edges in blocks.boundaries.items()
        },
        excavations={
            name: np.flatnonzero(np.isin(parent, ids)).astype(np.int32) for name, ids in blocks.excavations.items()
        },
    )


def _source(blocks: Blocks, vertices: FloatArray, offsets: IntArray, parent: LongArray, tolerance: float) -> LongArray:
    """Return the given edge on which each edge lies; -1 for those inside a given block."""
    import shapely

    following = np.arange(1, len(vertices) + 1)
    following[offsets[1:] - 1] = offsets[:-1]
    middle = shapely.points((vertices + vertices[following]) / 2)
    given = shapely.linestrings(np.stack([blocks.vertices, blocks.vertices[blocks.following]], axis=1))
    new, old = shapely.STRtree(given).query(middle, predicate="dwithin", distance=tolerance)
    same = blocks.owner[old] == parent[owner_of_corner(offsets)[new]]
    source = np.full(len(vertices), -1, dtype=np.int64)
    source[new[same]] = old[same]
    return source
