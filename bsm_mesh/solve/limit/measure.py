"""Scales of the forces of a linear program: loads of the blocks, from boulders to chips.

So every row, unknown and multiplier is of the order of 1, whatever the sizes of the blocks side by side.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array

from bsm_mesh.arrays import ROUNDING, BoolArray, FloatArray, IntArray
from bsm_mesh.movements import angles, distances, lengths


@dataclass(frozen=True, eq=False, slots=True)
class Measure:
    """Forces by which loads are measured.

    Attributes
    ----------
    mean : float [N/m]
        Mean load of the blocks that may move and are loaded.
    block : (n,) float64 [N/m]
        Load of every block; infinite where it is held, or not loaded.
    """

    mean: float
    block: FloatArray

    @classmethod
    def of(cls, loads: FloatArray, radius: FloatArray, free: BoolArray) -> Measure:
        """Return the measure of loads (n, 3) on blocks with radii of gyration (n,), of which some may move (n,)."""
        size = lengths(np.column_stack([distances(loads), angles(loads) / radius]))
        loaded = free & (size > 0)
        mean = float(size[loaded].mean()) if loaded.any() else float(size.mean()) or 1.0
        return cls(mean, np.where(loaded, np.maximum(size, ROUNDING * mean), np.inf))

    @property
    def of_rows(self) -> FloatArray:
        """Factors on the equilibrium of the blocks, so that all are in balance to the same digit, (n,)."""
        return np.maximum(self.mean / self.block, 1.0)

    def of_contacts(self, one: IntArray, other: IntArray) -> FloatArray:
        """Return the load on the less loaded of two blocks (m,) each [N/m]."""
        load = np.minimum(self.block[one], self.block[other])
        return np.where(np.isinf(load), self.mean, load)


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Measured:
    """Equilibrium and bounds in forces that are measured by the loads of the blocks on which they act.

    Attributes
    ----------
    balance, bounded : (p, k), (r, k) float64
        Equilibrium of the blocks that may move, moments as forces, and rows that bound the forces.
    bound : (r,) float64
        Their bounds.
    of_balance : (p,) float64 [m/N, 1/N]
        Scale of the rows of equilibrium.
    of_force, of_bound : (k,), (r,) float64 [N/m]
        Scales of the forces and the bounds.
    """

    balance: csr_array
    bounded: csr_array
    bound: FloatArray
    of_balance: FloatArray
    of_force: FloatArray
    of_bound: FloatArray

    @classmethod
    def of(
        cls, balance: csr_array, bounded: csr_array, bound: FloatArray, of_balance: FloatArray, of_force: FloatArray
    ) -> Measured:
        """Return rows (p, k) and (r, k) with bounds (r,), measured; a bound by the greatest force in its row."""
        entries, of_bound = bounded.tocoo(), np.zeros(len(bound))
        np.maximum.at(of_bound, entries.row, of_force[entries.col])
        of_bound[of_bound == 0] = of_force.max(initial=1.0)  # of bolts that lie within one block
        return cls(
            balance=csr_array((balance * of_balance[:, None]) * of_force),
            bounded=csr_array((bounded * of_force) * (1 / of_bound)[:, None]),
            bound=bound / of_bound,
            of_balance=of_balance,
            of_force=of_force,
            of_bound=of_bound,
        )
