"""Results in the zones of blocks: displacements of their nodes, stresses of their triangles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray, Portable, show_only
from bsm_mesh.movements import lengths


@dataclass(frozen=True, eq=False, repr=False, slots=True, kw_only=True)
class ZoneResult(Portable):
    """The zones at the end of a stage, of the blocks that are there; rigid blocks have some too.

    Attributes
    ----------
    points : (p, 2) float64 [m]
        Nodes, where they were given.
    displacement : (p, 2) float64 [m]
        Of the nodes; counts as `StageResult.displacement`.
    cells : (t, 3) or (t, 6) int32
        Nodes of every triangle, counter-clockwise: corners, then the middles of sides 0-1, 1-2, 2-0 (VTK's order).
    block : (t,) int32
        Block of every triangle.
    stress : (t, 2, 2) float64 [Pa]
        Average total stress of every triangle, tension positive.
    yielded : (t,) float64 [-]
        Part of every triangle in which rock yielded, up to 1; 0 where it is elastic.
    plastic_strain : (t,) float64 [-]
        Average of the greatest plastic shear strain, e1 - e3.
    """

    points: FloatArray
    displacement: FloatArray
    cells: IntArray
    block: IntArray
    stress: FloatArray
    yielded: FloatArray
    plastic_strain: FloatArray

    def __post_init__(self) -> None:
        show_only(self)

    def max_displacement(self, counts: BoolArray) -> float:
        """Return the greatest displacement of a node of the blocks that count, by a mask (n,) of all blocks [m]."""
        nodes = self.cells[counts[self.block]]
        return float(lengths(self.displacement[nodes.ravel()]).max(initial=0.0))

    def of_pieces(self, bulk: FloatArray) -> FloatArray:
        """Return the sum of `bulk` (n,) over the piece of every block, (n,): blocks that share nodes are one piece."""
        from scipy.sparse import coo_array
        from scipy.sparse.csgraph import connected_components

        corner = len(bulk) + self.cells[:, :3].ravel()
        links = coo_array(
            (np.ones(len(corner)), (np.repeat(self.block, 3), corner)), shape=(len(bulk) + len(self.points),) * 2
        )
        piece = connected_components(links, directed=False)[1][: len(bulk)]
        whole: FloatArray = np.bincount(piece, bulk)[piece]
        return whole

    def displacement_at(self, block: IntArray, point: FloatArray) -> FloatArray:
        """Return the displacement of points (k, 2) [m] of blocks (k,), by the shape functions of their triangles.

        Points are in the given geometry. One outside its block has the displacement of the nearest triangle, continued.
        A block without zones gives NaN.

        Returns
        -------
        (k, 2) float64 [m]
        """
        found = np.full(point.shape, np.nan)
        for number, (own, at) in enumerate(zip(block.tolist(), point, strict=True)):
            cells = self.cells[self.block == own]
            if not len(cells):
                continue
            shares = _area_coordinates(self.points[cells[:, :3]], at)
            nearest = int(shares.min(axis=1).argmax())
            weight = _shape_functions(shares[nearest], len(cells[nearest]))
            found[number] = weight @ self.displacement[cells[nearest]]
        return found


def _area_coordinates(corners: FloatArray, point: FloatArray) -> FloatArray:
    """Return the area coordinates (t, 3) of a point (2,) in triangles (t, 3, 2)."""
    to = corners - point
    opposite = np.roll(to, -1, axis=1), np.roll(to, -2, axis=1)
    area: FloatArray = opposite[0][:, :, 0] * opposite[1][:, :, 1] - opposite[0][:, :, 1] * opposite[1][:, :, 0]
    shares: FloatArray = area / area.sum(axis=1, keepdims=True)
    return shares


def _shape_functions(shares: FloatArray, nodes: int) -> FloatArray:
    """Return the shape functions of a triangle with 3 or 6 nodes, by area coordinates (3,)."""
    if nodes == 3:
        return shares
    sides = 4 * shares * np.roll(shares, -1)  # the middles of sides 0-1, 1-2, 2-0
    return np.concatenate([shares * (2 * shares - 1), sides])
