"""The convex cells of polyhedra where a movement has brought them, and by how much pairs of them overlap."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.movements import carried, turned
from bsm_mesh.three_d.blocks.cell_sides import CellSides
from bsm_mesh.three_d.blocks.polygons import spread
from bsm_mesh.three_d.blocks.polyhedra import Polyhedra

AT_ONCE = 2_000_000  # products of faces and corners in one array


@dataclass(frozen=True, eq=False, slots=True)
class PlacedCells:
    """Half spaces and corners of all cells where they are, cell after cell."""

    normal: FloatArray
    height: FloatArray
    first_face: IntArray
    corner: FloatArray
    first_corner: IntArray

    @classmethod
    def of(cls, blocks: Polyhedra, sides: CellSides, movement: FloatArray) -> PlacedCells:
        """Return the cells, by their sides as given, where a movement (n, 6) has brought the blocks."""
        centroid = blocks.moments.centroid
        block = blocks.cell_block[sides.cell]
        normal = turned(sides.normal, movement[block, 3:])
        point = sides.point + carried(sides.point - centroid[block], movement[block])
        sizes = np.diff(blocks.face_offsets)[sides.face]
        corner = blocks.vertices[blocks.face_vertices[spread(blocks.face_offsets[sides.face], sizes)]]
        owner = np.repeat(block, sizes)
        return cls(
            normal=normal,
            height=np.einsum("ij,ij->i", normal, point),
            first_face=sides.start,
            corner=corner + carried(corner - centroid[owner], movement[owner]),
            first_corner=np.append(0, np.cumsum(sizes))[sides.start],
        )

    def least_along(self, cell: IntArray, point: FloatArray, direction: FloatArray) -> FloatArray:
        """Return how far every cell (k,) lies ahead of a point (k, 3), in a direction (k, 3), at least, (k,) [m]."""
        count = np.diff(self.first_corner)[cell]
        corner, of = spread(self.first_corner[cell], count), np.repeat(np.arange(len(cell)), count)
        ahead = np.einsum("ij,ij->i", self.corner[corner] - point[of], direction[of])
        found: FloatArray = np.minimum.reduceat(ahead, np.cumsum(count) - count)
        return found

    def depths(self, pairs: IntArray) -> FloatArray:
        """Return by how much pairs of cells overlap along the face normals of either, the least of all, (p,) [m]."""
        faces, corners = np.diff(self.first_face), np.diff(self.first_corner)
        depth = np.full(len(pairs), np.inf)
        for one, other in (pairs.T, pairs.T[::-1]):
            products = faces[one] * corners[other]
            part = np.cumsum(products) // AT_ONCE
            for k in np.unique(part):
                rows = np.flatnonzero(part == k)
                of_face = np.repeat(rows, faces[one[rows]])
                face = spread(self.first_face[one[rows]], faces[one[rows]])
                count = corners[other[of_face]]
                corner = spread(self.first_corner[other[of_face]], count)
                over = np.einsum("ij,ij->i", self.corner[corner], np.repeat(self.normal[face], count, axis=0))
                least = np.minimum.reduceat(over, np.cumsum(count) - count)
                np.minimum.at(depth, of_face, self.height[face] - least)
        return depth
