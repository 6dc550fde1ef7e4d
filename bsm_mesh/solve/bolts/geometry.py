"""The geometry of bolts in blocks of either kind: places of their nodes, and dowels across joints."""

from __future__ import annotations

from typing import Protocol

from bsm_mesh import space
from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.solve.bolts.dowels import Dowels
from bsm_mesh.solve.bolts.kernels import node_movements


class BoltGeometry(Protocol):
    """Bolts in blocks of one kind."""

    @property
    def dowels(self) -> type[Dowels]:
        """Class of the dowels, which resist shear across joints."""

    def node_movements(self, position: FloatArray, block: IntArray, arm: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return how far nodes moved and the arms to them from the centroids, as many coordinates as `arm` each [m]."""


class PlaneBolts:
    """Bolts in polygons, as `BoltGeometry` asks for them."""

    dowels = Dowels

    def node_movements(self, position: FloatArray, block: IntArray, arm: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return how far nodes moved (n_nodes, 2), and the arms to them from the centroids [m]."""
        found: tuple[FloatArray, FloatArray] = node_movements(position, block, arm)
        return found


def geometry_of(point: FloatArray) -> BoltGeometry:
    """Return the geometry of bolts whose points (k, 2) or (k, 3) are given."""
    return space.SpaceBolts() if point.shape[1] > PlaneBolts.dowels.coordinates else PlaneBolts()
