"""Blocks to a conforming mesh of triangles for the continuum solution of the same domain."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.model.blocks import Blocks, merge_points
from bsm_mesh.model.faces import SHORTEST_FACE, find_faces
from bsm_mesh.model.polygons import next_corner, polygon_moments

FLATTEST = 1e-9  # of a polygon's area: a smaller triangle of its fan means that the centroid does not see the edge


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class ContinuumMesh:
    """Triangles that fill the blocks, and where the blocks' edges are among their sides.

    An edge on which a corner of another block stands (a T-junction) is cut there into pieces; each piece is a
    side of a triangle, so that neighbours share whole sides.

    Attributes
    ----------
    mesh : skfem.MeshTri
        The triangles.
    block : (t,) int32
        Block of every triangle.
    piece_facet : (p,) int32
        Side (facet of the mesh) of every piece, edge after edge.
    piece_start : (n_vertices + 1,) int32
        Edge e consists of the pieces ``piece_start[e]:piece_start[e + 1]``.
    """

    mesh: Any
    block: IntArray
    piece_facet: IntArray
    piece_start: IntArray

    @property
    def edge_of_piece(self) -> IntArray:
        """Edge of every piece, (p,)."""
        return np.repeat(np.arange(len(self.piece_start) - 1, dtype=np.int32), np.diff(self.piece_start))

    def facets_of(self, edges: IntArray) -> tuple[IntArray, IntArray]:
        """Return the facets of all pieces of `edges`, (p,), and for each the place of its edge in `edges`."""
        count = np.diff(self.piece_start)[edges]
        place = np.repeat(np.arange(len(edges), dtype=np.int32), count)
        within = np.arange(len(place)) - np.repeat(np.cumsum(count) - count, count)
        return self.piece_facet[self.piece_start[edges][place] + within], place


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class _Outlines:
    """Outlines with the corners of neighbours inserted: the start of every piece, and the edge it is part of."""

    node: IntArray
    offsets: IntArray
    edge: IntArray


def build_continuum_mesh(blocks: Blocks) -> ContinuumMesh:
    """Return the conforming triangles of all blocks.

    Triangles stay as they are. Every other polygon becomes a fan about its centroid; where the centroid does not
    see the whole outline (a concave block) the polygon is cut by constrained Delaunay triangulation.
    """
    import skfem

    points, node_of_corner = _merged_nodes(blocks)
    outlines = _refined_outlines(blocks, node_of_corner)
    points, triangles, owner = _triangulate(points, outlines)
    mesh = skfem.MeshTri(np.ascontiguousarray(points.T), np.ascontiguousarray(triangles.T))
    following = next_corner(outlines.offsets)
    return ContinuumMesh(
        mesh=mesh,
        block=owner,
        piece_facet=facets_between(mesh, outlines.node, outlines.node[following]),
        piece_start=np.searchsorted(outlines.edge, np.arange(len(blocks.vertices) + 1)).astype(np.int32),
    )


def _merged_nodes(blocks: Blocks) -> tuple[FloatArray, IntArray]:
    """Return the points (n, 2) where corners are, and the point of every corner.

    Corners that lie apart by no more than what `find_faces` takes as touching become one, else a slit of no width
    would be left between their blocks.
    """
    _, first, number = np.unique(blocks.nodes, return_index=True, return_inverse=True)
    shortest = float(np.hypot(*blocks.edge_vectors.T).min())
    merged = merge_points(blocks.vertices[first], SHORTEST_FACE * shortest)
    _, kept, label = np.unique(merged, return_index=True, return_inverse=True)
    return blocks.vertices[first][kept], label.reshape(-1)[number.reshape(-1)].astype(np.int32)


def _refined_outlines(blocks: Blocks, node: IntArray) -> _Outlines:
    """Return the outlines with every corner that stands on an edge inserted into that edge."""
    faces = find_faces(blocks)
    after_a, after_b = blocks.following[faces.edge_a], blocks.following[faces.edge_b]
    start_of_a, end_of_a = faces.start_corner_of_a, faces.end_corner_of_a
    edge = np.concatenate(
        [np.where(start_of_a, faces.edge_b, faces.edge_a), np.where(end_of_a, faces.edge_b, faces.edge_a)]
    )
    corner = np.concatenate([np.where(start_of_a, after_a, faces.edge_b), np.where(end_of_a, faces.edge_a, after_b)])
    between = (node[corner] != node[edge]) & (node[corner] != node[blocks.following[edge]])
    edge, corner = edge[between], corner[between]
    _, once = np.unique(np.column_stack([edge, node[corner]]), axis=0, return_index=True)
    edge, corner = edge[once], corner[once]
    along = blocks.edge_vectors[edge]
    share = ((blocks.vertices[corner] - blocks.vertices[edge]) * along).sum(axis=1) / (along**2).sum(axis=1)

    all_edges = np.concatenate([np.arange(len(blocks.vertices)), edge])
    order = np.lexsort([np.concatenate([np.zeros(len(blocks.vertices)), share]), all_edges])
    extra = np.bincount(blocks.owner[edge], minlength=blocks.count)
    return _Outlines(
        node=np.concatenate([node, node[corner]])[order],
        offsets=np.concatenate([[0], np.cumsum(np.diff(blocks.offsets) + extra)]).astype(np.int32),
        edge=all_edges[order].astype(np.int32),
    )


def _triangulate(points: FloatArray, outlines: _Outlines) -> tuple[FloatArray, IntArray, IntArray]:
    """Return the points with the fans' centres added, the triangles (t, 3), and the block of every triangle."""
    offsets, node = outlines.offsets, outlines.node
    count = np.diff(offsets)
    following = next_corner(offsets)
    block = np.repeat(np.arange(len(count), dtype=np.int32), count)
    moments = polygon_moments(points[node], offsets)
    spoke = points[node] - moments.centroid[block]
    fan_area = spoke[:, 0] * spoke[following][:, 1] - spoke[:, 1] * spoke[following][:, 0]
    hidden = np.minimum.reduceat(fan_area, offsets[:-1]) <= FLATTEST * moments.area
    plain = count == 3
    fanned = ~plain & ~hidden

    triangles = [node[offsets[:-1][plain, None] + np.arange(3)]]
    centre = len(points) + np.cumsum(fanned) - 1
    rows = fanned[block]
    triangles.append(np.column_stack([centre[block[rows]], node[rows], node[following[rows]]]))
    owner = [np.flatnonzero(plain), block[rows]]
    if (hidden & ~plain).any():
        cut, of_block = _constrained_triangles(points, outlines, np.flatnonzero(hidden & ~plain))
        triangles.append(cut)
        owner.append(of_block)
    all_points = np.concatenate([points, moments.centroid[fanned]])
    return all_points, np.concatenate(triangles).astype(np.int32), np.concatenate(owner).astype(np.int32)


def _constrained_triangles(points: FloatArray, outlines: _Outlines, blocks: IntArray) -> tuple[IntArray, IntArray]:
    """Return triangles of the outlines of a few blocks without new points (by GEOS), and the block of each."""
    import shapely

    sizes = np.diff(outlines.offsets)[blocks]
    place = np.repeat(np.arange(len(blocks)), sizes)
    corner = outlines.offsets[blocks][place] + np.arange(len(place)) - np.repeat(np.cumsum(sizes) - sizes, sizes)
    rings = shapely.linearrings(points[outlines.node[corner]], indices=place)
    parts, of_ring = shapely.get_parts(
        shapely.constrained_delaunay_triangles(shapely.polygons(rings)), return_index=True
    )
    corners = shapely.get_coordinates(parts).reshape(-1, 4, 2)[:, :3]
    # No new points: each corner has exactly the coordinates of one of its own ring's nodes.
    known = np.column_stack([place, points[outlines.node[corner]]])
    wanted = np.column_stack([np.repeat(of_ring, 3), corners.reshape(-1, 2)])
    _, number = np.unique(np.concatenate([known, wanted]), axis=0, return_inverse=True)
    number = number.reshape(-1)
    node_of = np.full(number.max() + 1, -1)
    node_of[number[: len(known)]] = outlines.node[corner]
    triangles = node_of[number[len(known) :]].reshape(-1, 3)
    assert (triangles >= 0).all()
    return triangles, blocks[of_ring]


def facets_between(mesh: Any, first: IntArray, last: IntArray) -> IntArray:
    """Return the facet of the mesh between each pair of vertices."""
    size = mesh.p.shape[1]
    facets = mesh.facets.astype(np.int64)
    keys = facets.min(axis=0) * size + facets.max(axis=0)
    order = np.argsort(keys)
    wanted = np.minimum(first, last).astype(np.int64) * size + np.maximum(first, last)
    found: IntArray = order[np.searchsorted(keys, wanted, sorter=order).clip(max=len(keys) - 1)].astype(np.int32)
    assert np.array_equal(keys[found], wanted)  # every piece is a side of its block's triangles
    return found
