"""Blocks to a conforming mesh of triangles or quads for the continuum solution of the same domain."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.errors import ModelError
from bsm_mesh.merged_points import merge_points
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.model.faces import SHORTEST_FACE
from bsm_mesh.solve.zones.outlines import Outlines, are_quads, fans, refined_outlines

MOST_REFINEMENTS = 6  # halvings of every side: 4096 cells for each
Mesher = Callable[[FloatArray, IntArray, IntArray, IntArray], tuple[FloatArray, IntArray, IntArray, IntArray, IntArray]]
"""Meshes the inside of outlines: `bsm_mesh.geometries.OutlineMesher`, or a function like it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Discretization:
    """How a model becomes finite elements.

    Attributes
    ----------
    order : {1, 2}
        Polynomial order of the displacements.
    joints : bool
        Whether joints are interfaces of zero thickness (`joint_points`); else they are ignored.
    rock_breaks : bool
        Whether faces of rock that gives a strength are interfaces too, with that strength; else it is elastic.
    elastic_bolts : bool
        Whether bolts are elastic about their pretension, as in the linear scheme; else they slip, slacken and yield.
    refinements : int
        How often every side of the elements, and with them of the interfaces, is halved.
    large : bool
        Whether displacements are large: forces act where blocks are, and turn with them.
    mesher : Mesher or None
        Meshes the inside of the blocks; None: as `build_continuum_mesh` says.

    Raises
    ------
    ModelError
        If a number is out of range.
    """

    order: int = 2
    joints: bool = False
    rock_breaks: bool = False
    elastic_bolts: bool = False
    refinements: int = 0
    large: bool = False
    mesher: Mesher | None = None

    def __post_init__(self) -> None:
        if self.order not in (1, 2):
            raise ModelError(f"order = {self.order!r} must be 1 or 2")
        if self.refinements not in range(MOST_REFINEMENTS + 1):
            raise ModelError(f"refinements = {self.refinements!r} must be 0 to {MOST_REFINEMENTS}")


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class ContinuumMesh:
    """Cells (triangles or quads) that fill the blocks, and where the blocks' edges are among their sides.

    An edge on which a corner of another block stands (a T-junction) is cut there into pieces; each piece is a
    side of a cell, so that neighbours share whole sides.

    Attributes
    ----------
    mesh : skfem.MeshTri or skfem.MeshQuad
        The cells.
    block : (t,) int32
        Block of every cell.
    piece_ends : (p, 2) int32
        Vertices at both ends of every piece in the direction of its edge, edge after edge.
    piece_facet : (p,) int32
        Side (facet of the mesh) of every piece.
    piece_start : (n_vertices + 1,) int32
        Edge e consists of the pieces ``piece_start[e]:piece_start[e + 1]``.
    """

    mesh: Any
    block: IntArray
    piece_ends: IntArray
    piece_facet: IntArray
    piece_start: IntArray

    @classmethod
    def of(cls, mesh: Any, block: IntArray, piece_ends: IntArray, piece_start: IntArray) -> ContinuumMesh:
        """Return the mesh with the facets of its pieces."""
        return cls(
            mesh=mesh,
            block=block.astype(np.int32),
            piece_ends=piece_ends.astype(np.int32),
            piece_facet=facets_between(mesh, *piece_ends.T),
            piece_start=piece_start.astype(np.int32),
        )

    @property
    def edge_of_piece(self) -> IntArray:
        """Edge of every piece, (p,)."""
        return np.repeat(np.arange(len(self.piece_start) - 1, dtype=np.int32), np.diff(self.piece_start))

    @property
    def are_quads(self) -> bool:
        """Whether the cells are quads."""
        return int(self.mesh.t.shape[0]) == 4

    def facets_of(self, edges: IntArray) -> tuple[IntArray, IntArray]:
        """Return the facets of all pieces of `edges`, (p,), and for each the place of its edge in `edges`."""
        count = np.diff(self.piece_start)[edges]
        place = np.repeat(np.arange(len(edges), dtype=np.int32), count)
        within = np.arange(len(place)) - np.repeat(np.cumsum(count) - count, count)
        return self.piece_facet[self.piece_start[edges][place] + within], place

    def refined(self) -> ContinuumMesh:
        """Return the mesh with every side halved: four cells for each."""
        middle = self.mesh.p.shape[1] + self.piece_facet  # skfem puts the middles of the facets behind the vertices
        first, last = self.piece_ends.T
        ends = np.stack([np.stack([first, middle], axis=1), np.stack([middle, last], axis=1)], axis=1).reshape(-1, 2)
        return ContinuumMesh.of(self.mesh.refined(), np.tile(self.block, 4), ends, 2 * self.piece_start)


def continuum_mesh(blocks: Blocks, discretization: Discretization) -> ContinuumMesh:
    """Return the conforming cells of all blocks, refined as asked for."""
    mesh = build_continuum_mesh(blocks, discretization.mesher)
    for _ in range(discretization.refinements):
        mesh = mesh.refined()
    return mesh


def build_continuum_mesh(blocks: Blocks, mesher: Mesher | None = None, *, triangles: bool = False) -> ContinuumMesh:
    """Return the conforming cells of all blocks.

    Where all blocks are convex quads that share whole sides these are the cells. Else triangles stay as they are and
    every other polygon becomes a fan about its centroid; where the centroid does not see the whole outline (a concave
    block) the polygon is cut by constrained Delaunay triangulation.

    Parameters
    ----------
    blocks : Blocks
        The blocks to be filled.
    mesher : Mesher, optional
        Fills the outlines instead, with triangles of its own size.
    triangles : bool
        Whether quads become fans too.
    """
    import skfem

    points, node_of_corner = _merged_nodes(blocks)
    outlines = refined_outlines(blocks, node_of_corner)
    if mesher is not None:
        return _meshed(points, outlines, len(blocks.vertices), mesher)
    start = np.searchsorted(outlines.edge, np.arange(len(blocks.vertices) + 1))
    if not triangles and are_quads(points, outlines):
        cells, owner, kind = outlines.node.reshape(-1, 4), np.arange(blocks.count), skfem.MeshQuad
    else:
        points, cells, owner = fans(points, outlines)
        kind = skfem.MeshTri
    mesh = kind(np.ascontiguousarray(points.T), np.ascontiguousarray(cells.T))
    return ContinuumMesh.of(mesh, owner, outlines.ends, start)


def _meshed(points: FloatArray, outlines: Outlines, edges: int, mesher: Mesher) -> ContinuumMesh:
    """Return the mesh of a mesher, whose lines are the different pieces of the outlines."""
    import skfem

    ends = outlines.ends
    lines, number = np.unique(np.sort(ends, axis=1), axis=0, return_inverse=True)
    number = number.reshape(-1)
    forwards = ends[:, 0] == lines[number, 0]
    filled, cells, owner, along, start = mesher(
        points, lines, np.where(forwards, number + 1, -number - 1), outlines.offsets
    )
    count = np.diff(start)[number] - 1  # pieces of each line, from node to node
    of_piece = np.repeat(np.arange(len(ends)), count)
    within = np.arange(len(of_piece)) - np.repeat(np.cumsum(count) - count, count)
    first = start[number][of_piece] + np.where(forwards[of_piece], within, count[of_piece] - within)
    piece_ends = np.stack([along[first], along[first + np.where(forwards[of_piece], 1, -1)]], axis=1)
    edge = outlines.edge[of_piece]
    mesh = skfem.MeshTri(np.ascontiguousarray(filled.T), np.ascontiguousarray(cells.T))
    return ContinuumMesh.of(mesh, owner, piece_ends, np.searchsorted(edge, np.arange(edges + 1)))


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


def facets_between(mesh: Any, first: IntArray, last: IntArray) -> IntArray:
    """Return the facet of the mesh between each pair of vertices."""
    size = mesh.p.shape[1]
    facets = mesh.facets.astype(np.int64)
    keys = facets.min(axis=0) * size + facets.max(axis=0)
    order = np.argsort(keys)
    wanted = np.minimum(first, last).astype(np.int64) * size + np.maximum(first, last)
    found: IntArray = order[np.searchsorted(keys, wanted, sorter=order).clip(max=len(keys) - 1)].astype(np.int32)
    assert np.array_equal(keys[found], wanted)  # every piece is a side of its block's cells
    return found
