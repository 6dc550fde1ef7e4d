"""Blocks cut into triangles or taken as quads, in whole outlines: every corner on an outline is a node of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.model.faces import find_faces
from bsm_mesh.model.polygons import next_corner, polygon_moments

FLATTEST = 1e-9  # of a polygon's area: a smaller triangle of its fan means that the centroid does not see the edge
LEAST_SINE = 0.02  # of a quad's angles: with less it is nearly a triangle, and cut


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Outlines:
    """Outlines with the corners of neighbours inserted: the start of every piece, and the edge it is part of."""

    node: IntArray
    offsets: IntArray
    edge: IntArray

    @property
    def ends(self) -> IntArray:
        """Nodes at both ends of every piece, (p, 2), in the direction of its edge."""
        return np.stack([self.node, self.node[next_corner(self.offsets)]], axis=1)


def refined_outlines(blocks: Blocks, node: IntArray) -> Outlines:
    """Return the outlines with every corner that is on an edge inserted into that edge."""
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
    return Outlines(
        node=np.concatenate([node, node[corner]])[order],
        offsets=np.concatenate([[0], np.cumsum(np.diff(blocks.offsets) + extra)]).astype(np.int32),
        edge=all_edges[order].astype(np.int32),
    )


def are_quads(points: FloatArray, outlines: Outlines) -> bool:
    """Whether all outlines have four nodes and bulge at each."""
    if (np.diff(outlines.offsets) != 4).any():
        return False
    corners = points[outlines.node].reshape(-1, 4, 2)
    after = np.roll(corners, -1, axis=1) - corners
    before = np.roll(after, 1, axis=1)
    sine = (before[..., 0] * after[..., 1] - before[..., 1] * after[..., 0]) / (
        np.linalg.norm(before, axis=2) * np.linalg.norm(after, axis=2)
    )
    return bool((sine > LEAST_SINE).all())


def fans(points: FloatArray, outlines: Outlines) -> tuple[FloatArray, IntArray, IntArray]:
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


def _constrained_triangles(points: FloatArray, outlines: Outlines, blocks: IntArray) -> tuple[IntArray, IntArray]:
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
