"""State of the linear scheme from stage to stage."""

from __future__ import annotations

from dataclasses import dataclass

from bsm_mesh.arrays import FloatArray
from bsm_mesh.solve.bolts.memory import BoltMemory


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class LinearState:
    """The state of the linear scheme between two stages, in the numbers of the whole.

    Attributes
    ----------
    normal_force, shear_force : (m,) float64 [N/m]
        Of the contacts.
    opening, slip : (m,) float64 [m]
        Of the contacts.
    moved : (n, 3) float64 [m, m, rad]
        Displacement of every block.
    bolts : BoltMemory
        Of the bolts.
    tension, bolt_shear : (n_elements,), (k,) float64 [N]
        Of their elements and crossings.
    linear_solver : str
        Name of the solver used.
    """

    normal_force: FloatArray
    shear_force: FloatArray
    opening: FloatArray
    slip: FloatArray
    moved: FloatArray
    bolts: BoltMemory
    tension: FloatArray
    bolt_shear: FloatArray
    linear_solver: str
