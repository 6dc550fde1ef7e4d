"""Forces of the water on blocks in large displacement, linear in the displacements near some."""

from __future__ import annotations

from typing import Any, NamedTuple

from bsm_mesh.arrays import FloatArray


class WaterNear(NamedTuple):
    """The forces of the water near displacements.

    Attributes
    ----------
    force : (N,) float64 [N/m]
        Forces there.
    stiffness : sparse (N, N) [Pa]
        By how much they fall as blocks move.
    at : (N,) float64 [m]
        These displacements.
    """

    force: FloatArray
    stiffness: Any
    at: FloatArray

    def change(self, u: FloatArray) -> FloatArray:
        """Return by how much the forces change up to displacements u (N,), (N,) [N/m]."""
        found: FloatArray = self.stiffness @ (self.at - u)
        return found
