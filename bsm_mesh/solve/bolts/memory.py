"""Memory of bolts from accepted steps; all else of them follows from the model."""

from __future__ import annotations

from dataclasses import dataclass, replace

from bsm_mesh.arrays import BoolArray, FloatArray
from bsm_mesh.solve.bolts.installed import InstalledBolts, coupled_pairs


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class BoltMemory:
    """State variables of bolts, as in `InstalledBolts`.

    Attributes
    ----------
    alive : (n_elements,) bool
        Installed, and in blocks that are there.
    rest, yielded : (n_elements,) float64 [m]
        Length at zero tension; plastic stretch.
    anchor : (n_nodes,) float64 [m]
        Slip at zero bond force.
    sheared : (k,) float64 [m]
        Coordinate of the dowels at zero force.
    """

    alive: BoolArray
    rest: FloatArray
    yielded: FloatArray
    anchor: FloatArray
    sheared: FloatArray

    @classmethod
    def of(cls, bolts: InstalledBolts) -> BoltMemory:
        """Return what bolts remember."""
        return cls(
            alive=bolts.alive,
            rest=bolts.rest,
            yielded=bolts.yielded,
            anchor=bolts.anchor,
            sheared=bolts.dowels.rest,
        )

    def recalled(self, bolts: InstalledBolts) -> InstalledBolts:
        """Return bolts of the same model with this memory."""
        return replace(
            bolts,
            pairs=coupled_pairs(bolts.layout, self.alive),
            alive=self.alive,
            rest=self.rest,
            yielded=self.yielded,
            anchor=self.anchor,
            dowels=replace(bolts.dowels, rest=self.sheared),
        )
