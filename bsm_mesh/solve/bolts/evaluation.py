"""The forces of bolts at a position."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.solve.bolts.dowels import DowelEvaluation


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class BoltEvaluation:
    """Forces of the bolts at a position; evaluating changes nothing.

    Attributes
    ----------
    point, arm : (n_nodes, 2) or (n_nodes, 3) float64 [m]
        Where the nodes are, and from the centroids of their blocks to them.
    length : (n_elements,) float64 [m]
        Of the elements.
    direction : (n_elements, 2) or (n_elements, 3) float64
        From head to tip.
    stretch : (n_elements,) float64 [m]
        Elongation of each element from its length at zero tension.
    tension : (n_elements,) float64 [N]
        Axial force, of one bolt.
    slip : (n_nodes,) float64 [m]
        Of the bolt against the rock, towards the tip positive.
    bond_force : (n_nodes,) float64 [N]
        On the rock, towards the tip positive: the tension after the node less that before it (Wang Eq. 5.6).
    dowels : DowelEvaluation
        Shear where bolts cross joints.
    forces : (n_blocks, axes) float64 [N/m, N; in space N, N m]
        On the blocks, over the spacing.
    """

    point: FloatArray
    arm: FloatArray
    length: FloatArray
    direction: FloatArray
    stretch: FloatArray
    tension: FloatArray
    slip: FloatArray
    bond_force: FloatArray
    dowels: DowelEvaluation
    forces: FloatArray

    @classmethod
    def none(cls, position: FloatArray, dowels: DowelEvaluation) -> BoltEvaluation:
        """Return the forces of no bolts at a position (n_blocks, axes), for which no kernel is compiled."""
        point, value = np.zeros_like(dowels.point, shape=(0, dowels.point.shape[1])), np.zeros(0)
        return cls(
            point=point,
            arm=point,
            length=value,
            direction=point,
            stretch=value,
            tension=value,
            slip=value,
            bond_force=value,
            dowels=dowels,
            forces=np.zeros_like(position),
        )
