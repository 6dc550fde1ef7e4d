"""Loads of a stage; in large displacement the water's part is linear in the displacements near some."""

from __future__ import annotations

from typing import Any, NamedTuple

from bsm_mesh.arrays import FloatArray


class WaterNear(NamedTuple):
    """The forces of the water near displacements.

    Attributes
    ----------
    on_blocks : (M,) float64 [N/m]
        Forces there, on nodes that no two blocks share (`Apart`).
    force : (N,) float64 [N/m]
        The same on the unknowns that are solved for.
    stiffness : sparse (N, N) [Pa]
        By how much they fall as blocks move.
    at : (N,) float64 [m]
        These displacements.
    """

    on_blocks: FloatArray
    force: FloatArray
    stiffness: Any
    at: FloatArray

    def change(self, u: FloatArray) -> FloatArray:
        """Return by how much the forces change up to displacements u (N,), (N,) [N/m]."""
        found: FloatArray = self.stiffness @ (self.at - u)
        return found


class StageLoads(NamedTuple):
    """Weights, loads and water.

    Attributes
    ----------
    forces : (M,) float64 [N/m]
        All of them, on the unknowns of `Continuum.loaded`.
    water : WaterNear or None
        The part of them that changes as blocks move.
    """

    forces: FloatArray
    water: WaterNear | None = None
