"""Outlines of the blocks for the contact search: rigid polygons that translate and rotate."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray, own_array
from bsm_mesh.compiled import njit
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.model.faces import find_faces
from bsm_mesh.model.polygons import owner_of_corner

# The blocks at their current position, as the compiled search takes them: records, because a kernel that is handed many
# arrays in a tuple spends its time on counting references to them. A corner's record fills one cache line.
VERTEX = np.dtype(
    [
        ("x", "f8"),  # corner [m]
        ("y", "f8"),
        ("dx", "f8"),  # unit vector along the edge that starts there
        ("dy", "f8"),
        ("x0", "f8"),  # corner from its block's centroid, at zero rotation [m]
        ("y0", "f8"),
        ("following", "i4"),  # next and previous corner of the block
        ("preceding", "i4"),
        ("vertex_cluster", "i4"),  # as in `Outlines`
    ],
    align=True,
)
BLOCK = np.dtype(
    [
        *((name, "f8") for name in ("x0", "y0", "x1", "y1")),  # box, widened by half the band [m]
        ("size", "f8"),  # length that the rules are scaled with [m]
        ("first", "i4"),  # corners first .. last - 1 are the block's
        ("last", "i4"),
        ("fixed", "?"),
    ],
    align=True,
)
Record: TypeAlias = Any  # the types of numpy know nothing of the fields of a record
RecordArray: TypeAlias = Any


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Outlines:
    """Rigid outlines of the blocks. Edge e runs from corner e to the next corner of its block.

    Attributes
    ----------
    corners : (n_vertices, 2) float64 [m]
        Corners from the centroid of their block, at zero rotation.
    directions : (n_vertices, 2) float64
        Unit directions of the edges, at zero rotation.
    centroid : (n_blocks, 2) float64 [m]
        Centroids of the blocks as given.
    offsets : (n_blocks + 1,) int32
        Block b owns ``corners[offsets[b]:offsets[b + 1]]``.
    vertex_clusters : (n_vertices,) int32
        Corners at one point of the given geometry, each with a face to the next, have one number.
    neighbour_clusters : (n_vertices,) int32
        The same, also of corners at one point within an edge that both have a face with.
    fixed : (n_blocks,) bool
        Fixed blocks: two of them are no pair.
    block_size : (n_blocks,) float64 [m]
        Square root of each block's area.
    size : float [m]
        Median of `block_size` over the blocks that can move (over all if none can).
    """

    corners: FloatArray
    directions: FloatArray
    centroid: FloatArray
    offsets: IntArray
    vertex_clusters: IntArray
    neighbour_clusters: IntArray
    fixed: BoolArray
    block_size: FloatArray
    size: float

    def __post_init__(self) -> None:
        for name in ("corners", "directions", "centroid"):
            own_array(self, name, np.float64, (None, 2))
        for name in ("offsets", "vertex_clusters", "neighbour_clusters"):
            own_array(self, name, np.int32, (None,))
        own_array(self, "fixed", np.bool_, (None,))
        own_array(self, "block_size", np.float64, (None,))

    @classmethod
    def of(cls, blocks: Blocks, fixed: npt.ArrayLike) -> Outlines:
        """Return the outlines of blocks, of which those flagged in `fixed` (n_blocks,) are fixed."""
        flags = np.asarray(fixed, dtype=bool)
        block_size = np.sqrt(blocks.moments.area)
        corners = blocks.vertices - blocks.moments.centroid[owner_of_corner(blocks.offsets)]
        edge = corners[blocks.following] - corners
        clusters, with_edges = _vertex_clusters(blocks)
        return cls(
            corners=corners,
            directions=edge / np.hypot(*edge.T)[:, None],
            centroid=blocks.moments.centroid,
            offsets=blocks.offsets,
            vertex_clusters=clusters,
            neighbour_clusters=with_edges,
            fixed=flags,
            block_size=block_size,
            size=float(np.median(block_size if flags.all() else block_size[~flags])),
        )

    def placed(self, position: FloatArray) -> FloatArray:
        """Return centroid and rotation of blocks displaced by a position (n_blocks, 3)."""
        placed = position.copy()
        placed[:, :2] += self.centroid
        return placed


def _vertex_clusters(blocks: Blocks) -> tuple[IntArray, IntArray]:
    """Return the vertex clusters of the corners, and those across edges: `vertex_clusters`, `neighbour_clusters`."""
    faces, following = find_faces(blocks), blocks.following
    one = np.concatenate([faces.edge_a, following[faces.edge_a]])
    other = np.concatenate([following[faces.edge_b], faces.edge_b])
    same = blocks.nodes[one] == blocks.nodes[other]  # not at a T, where the corner lies within the other edge
    ends = (one[same], other[same])
    n = len(blocks.vertices)
    graph = coo_array((np.ones(len(ends[0])), ends), shape=(n, n))
    clusters: IntArray = connected_components(graph, directed=False)[1]
    corner_of_a = np.concatenate([faces.end_corner_of_a, faces.start_corner_of_a])[~same]  # a begins at the face's end
    edge = np.where(corner_of_a, np.tile(faces.edge_b, 2)[~same], np.tile(faces.edge_a, 2)[~same])
    corner = np.where(corner_of_a, one[~same], other[~same])
    place = np.unique(np.column_stack([edge, blocks.nodes[corner]]), axis=0, return_inverse=True)[1].reshape(-1)
    size = n + len(corner)  # corners, and the places on edges where faces end
    ends = np.concatenate([ends[0], corner]), np.concatenate([ends[1], n + place])
    graph = coo_array((np.ones(len(ends[0])), ends), shape=(size, size))
    return clusters, connected_components(graph, directed=False)[1][:n]


def corner_positions(outlines: Outlines, placed: FloatArray) -> FloatArray:
    """Return the positions of the corners, (n_vertices, 2) [m].

    Parameters
    ----------
    outlines : Outlines
        The blocks.
    placed : (n_blocks, 3) float64 [m, m, rad]
        Centroid and rotation of every block; rotations of any size are exact.
    """
    corners: FloatArray = _place(outlines.corners, outlines.offsets, np.ascontiguousarray(placed))
    return corners


def records_at(outlines: Outlines, placed: FloatArray, band: float) -> tuple[RecordArray, RecordArray]:
    """Return the records VERTEX (n_vertices,) and BLOCK (n_blocks,) of placed blocks (n_blocks, 3), for a band [m]."""
    size = np.minimum(outlines.block_size, outlines.size)
    records: tuple[RecordArray, RecordArray] = _records(
        corner_positions(outlines, placed),
        outlines.corners,
        outlines.offsets,
        outlines.vertex_clusters,
        outlines.fixed,
        size,
        0.5 * band,
    )
    return records


@njit(allocates=True)
def _place(corners: FloatArray, offsets: IntArray, placed: FloatArray) -> FloatArray:  # pragma: no cover - compiled
    """Return the corners, turned by each block's rotation and moved to its centroid."""
    there = np.empty_like(corners)
    for b in range(offsets.size - 1):
        c, s = np.cos(placed[b, 2]), np.sin(placed[b, 2])
        for i in range(offsets[b], offsets[b + 1]):
            there[i, 0] = placed[b, 0] + (c * corners[i, 0] - s * corners[i, 1])
            there[i, 1] = placed[b, 1] + (s * corners[i, 0] + c * corners[i, 1])
    return there


@njit(allocates=True)
def _records(
    there: FloatArray,
    corners: FloatArray,
    offsets: IntArray,
    vertex_clusters: IntArray,
    fixed: BoolArray,
    size: FloatArray,
    margin: float,
) -> tuple[RecordArray, RecordArray]:  # pragma: no cover - compiled
    """Return the records of the corners, and of the blocks with their boxes widened by a margin."""
    n = offsets.size - 1
    vertices, blocks = np.empty(vertex_clusters.size, VERTEX), np.empty(n, BLOCK)
    for b in range(n):
        first, last = offsets[b], offsets[b + 1]
        x0, y0, x1, y1 = np.inf, np.inf, -np.inf, -np.inf
        for i in range(first, last):
            k = i + 1 if i + 1 < last else first
            x, y = there[i, 0], there[i, 1]
            dx, dy = there[k, 0] - x, there[k, 1] - y
            length = np.sqrt(dx * dx + dy * dy)
            vertex = vertices[i]
            vertex.x, vertex.y, vertex.dx, vertex.dy = x, y, dx / length, dy / length
            vertex.x0, vertex.y0 = corners[i, 0], corners[i, 1]
            vertex.following, vertex.preceding = k, (i if i > first else last) - 1
            vertex.vertex_cluster = vertex_clusters[i]
            x0, y0, x1, y1 = min(x0, x), min(y0, y), max(x1, x), max(y1, y)
        block = blocks[b]
        block.x0, block.y0, block.x1, block.y1 = x0 - margin, y0 - margin, x1 + margin, y1 + margin
        block.first, block.last, block.size, block.fixed = first, last, size[b], fixed[b]
    return vertices, blocks
