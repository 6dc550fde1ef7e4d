"""By what the forces of a linear program are measured: loads of the blocks, from boulders to chips."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray

LIGHT = 1e-9  # of the mean load: a block with less is measured by that


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
        size = np.hypot(np.hypot(*loads[:, :2].T), loads[:, 2] / radius)
        loaded = free & (size > 0)
        mean = float(size[loaded].mean()) if loaded.any() else float(size.mean()) or 1.0
        return cls(mean, np.where(loaded, np.maximum(size, LIGHT * mean), np.inf))

    @property
    def of_rows(self) -> FloatArray:
        """What equilibrium of the blocks is multiplied by, so that all are in balance to the same digit, (n,)."""
        return np.maximum(self.mean / self.block, 1.0)

    def of_contacts(self, one: IntArray, other: IntArray) -> FloatArray:
        """Return the load on the less loaded of two blocks (m,) each [N/m]."""
        load = np.minimum(self.block[one], self.block[other])
        return np.where(np.isinf(load), self.mean, load)
