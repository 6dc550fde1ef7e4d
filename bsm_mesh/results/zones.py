"""Results in the zones of blocks: displacements of their nodes, stresses of their triangles."""

from __future__ import annotations

from dataclasses import dataclass

from bsm_mesh.arrays import FloatArray, IntArray, Portable, show_only


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
