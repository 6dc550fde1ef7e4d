"""Volumes, centroids and inertia of polyhedra."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.three_d.blocks.polygons import sums

PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))  # of the axes, for the six numbers of a symmetric tensor


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Moments:
    """Volumes and moments of blocks.

    Attributes
    ----------
    volume : (n,) float64 [m3]
        Volumes.
    centroid : (n, 3) float64 [m]
        Centre of volume.
    inertia : (n, 3, 3) float64 [m5]
        Inertia tensor about the centroid for unit density.
    """

    volume: FloatArray
    centroid: FloatArray
    inertia: FloatArray

    @property
    def bulk(self) -> FloatArray:
        """Volumes [m3]: the factor of a unit weight."""
        return self.volume

    def mean_size(self, chosen: BoolArray) -> float:
        """Size of a block of the mean volume of those chosen (n,) [m]."""
        return float(np.cbrt(self.volume[chosen].mean()))

    @property
    def median_size(self) -> float:
        """Size of the block of median volume [m]."""
        return float(np.cbrt(np.median(self.volume)))

    @property
    def gyration(self) -> FloatArray:
        """Mean radius of gyration [m]: turns a moment into a force of the block's own size."""
        radius: FloatArray = np.sqrt(np.trace(self.inertia, axis1=1, axis2=2) / (3 * self.volume))
        return radius

    @property
    def size(self) -> FloatArray:
        """Side of the cube of the same volume [m]."""
        side: FloatArray = np.cbrt(self.volume)
        return side


def fan_triangles(offsets: IntArray) -> tuple[IntArray, IntArray]:
    """Return the triangles of every polygon from its first corner: (t, 3) numbers of corners, (t,) polygon."""
    sizes = np.diff(offsets)
    polygon = np.repeat(np.arange(len(sizes)), sizes - 2)
    within = np.arange(len(polygon)) - np.repeat(np.cumsum(sizes - 2) - (sizes - 2), sizes - 2)
    first = offsets[:-1][polygon]
    return np.stack([first, first + within + 1, first + within + 2], axis=1), polygon


def cell_moments(
    vertices: FloatArray, face_vertices: IntArray, face_offsets: IntArray, face_cells: IntArray, cell_block: IntArray
) -> Moments:
    """Return volume, centroid and inertia of the blocks that cells make up.

    By the divergence theorem over the triangles of the faces, from a corner of each cell: a model far from the origin
    loses no digits.

    Parameters
    ----------
    vertices : (n_vertices, 3) float64 [m]
        Points.
    face_vertices, face_offsets : (k,), (n_faces + 1,) int32
        Corners of the faces, counter-clockwise seen from outside their first cell.
    face_cells : (n_faces, 2) int32
        The two cells of every face; -1 where there is no second.
    cell_block : (n_cells,) int32
        Block of every cell.
    """
    count = len(cell_block)
    triangles, face = fan_triangles(face_offsets)
    corner = face_vertices[triangles]
    anchor = np.zeros((count, 3))
    for side in (0, 1):
        chosen = face_cells[:, side] >= 0
        anchor[face_cells[chosen, side]] = vertices[face_vertices[face_offsets[:-1][chosen]]]
    volume, first, second = np.zeros(count), np.zeros((count, 3)), np.zeros((count, 6))
    for side, sign in ((0, 1.0), (1, -1.0)):
        chosen = face_cells[face, side] >= 0
        cell = face_cells[face[chosen], side]
        a, b, c = (vertices[corner[chosen, k]] - anchor[cell] for k in range(3))
        part = sign * np.einsum("ij,ij->i", a, np.cross(b, c)) / 6
        total = a + b + c
        volume += sums(cell, part, count)
        first += sums(cell, part[:, None] * total / 4, count)
        products = [total[:, i] * total[:, j] + sum(p[:, i] * p[:, j] for p in (a, b, c)) for i, j in PAIRS]
        second += sums(cell, part[:, None] * np.stack(products, axis=1) / 20, count)
    return _of_blocks(volume, anchor, first, second, cell_block)


def _of_blocks(
    volume: FloatArray, anchor: FloatArray, first: FloatArray, second: FloatArray, block: IntArray
) -> Moments:
    """Return the moments of blocks from those of their cells about a point of each."""
    count = int(block.max(initial=-1)) + 1
    first_cell = np.zeros(count, dtype=np.int64)
    first_cell[block[::-1]] = np.arange(len(block))[::-1]
    shift = anchor - anchor[first_cell][block]  # all cells of a block from one point
    second = second + np.stack(
        [first[:, i] * shift[:, j] + shift[:, i] * (first[:, j] + volume * shift[:, j]) for i, j in PAIRS], axis=1
    )
    whole = sums(block, volume, count)
    arm = sums(block, first + volume[:, None] * shift, count) / whole[:, None]
    central = sums(block, second, count) - np.stack([whole * arm[:, i] * arm[:, j] for i, j in PAIRS], axis=1)
    xx, yy, zz, xy, yz, xz = central.T
    inertia = np.stack([yy + zz, -xy, -xz, -xy, xx + zz, -yz, -xz, -yz, xx + yy], axis=1).reshape(-1, 3, 3)
    return Moments(volume=whole, centroid=anchor[first_cell] + arm, inertia=inertia)
