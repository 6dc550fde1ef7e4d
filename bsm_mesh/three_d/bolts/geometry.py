"""Places of the nodes of bolts in polyhedra at a position."""

from __future__ import annotations

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.movements import carried
from bsm_mesh.three_d.bolts.dowels import SpaceDowels


class SpaceBolts:
    """Bolts in polyhedra, as `bsm_mesh.solve.bolts.geometry.BoltGeometry` asks for them."""

    dowels = SpaceDowels

    def node_movements(self, position: FloatArray, block: IntArray, arm: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return how far nodes moved (n_nodes, 3), and the arms to them from the centroids [m]."""
        moved = carried(arm, position[block])
        return moved, arm + moved - position[block, :3]
