"""The faces of every cell of polyhedra, seen from the cell: outward normals, cell after cell."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.model.blocks import MERGE_TOLERANCE
from bsm_mesh.three_d.blocks.polygons import polygon_moments
from bsm_mesh.three_d.blocks.polyhedra import Polyhedra


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class CellSides:
    """The sides of all cells: a face between two cells is a side of either.

    Attributes
    ----------
    face, cell : (s,) int64
        Face and cell of every side.
    normal : (s, 3) float64
        Unit normal out of the cell.
    point : (s, 3) float64 [m]
        Centroid of the face.
    start : (n_cells + 1,) int64
        Cell c has the sides ``start[c]`` to ``start[c + 1] - 1``.
    """

    face: IntArray
    cell: IntArray
    normal: FloatArray
    point: FloatArray
    start: IntArray


def polyhedra_at(blocks: Polyhedra, point: FloatArray) -> IntArray:
    """Return the blocks that a point (3,) [m] lies in or on, in rising order, (k,) int32."""
    sides = sides_of_cells(blocks)
    height = np.einsum("ij,ij->i", point - sides.point, sides.normal)
    outside = np.maximum.reduceat(height, sides.start[:-1])
    found = blocks.cell_block[outside <= MERGE_TOLERANCE * blocks.span]
    return np.unique(found[found >= 0]).astype(np.int32)


def sides_of_cells(blocks: Polyhedra) -> CellSides:
    """Return the sides of all cells of polyhedra as they are given."""
    first, second = (np.flatnonzero(cells >= 0) for cells in blocks.face_cells.T)
    face = np.concatenate([first, second])
    cell = np.concatenate([blocks.face_cells[first, 0], blocks.face_cells[second, 1]])
    outward = np.repeat([1.0, -1.0], [len(first), len(second)])  # normals point out of a face's first cell
    order = np.argsort(cell, kind="stable")
    face, cell = face[order], cell[order]
    moments = polygon_moments(blocks.vertices[blocks.face_vertices], blocks.face_offsets)
    return CellSides(
        face=face,
        cell=cell,
        normal=outward[order, None] * moments.normal[face],
        point=moments.centroid[face],
        start=np.searchsorted(cell, np.arange(len(blocks.cell_block) + 1)),
    )
