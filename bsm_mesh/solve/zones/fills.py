"""Rock put back in a stage: without stress where it lies then, however the rest is displaced."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.solve.zones.fields import mean_gradient


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Fill:
    """Blocks put back in one stage.

    Attributes
    ----------
    blocks : (n,) bool
        Which.
    u : (N,) float64 [m]
        Displacements at which they have no stress.
    """

    blocks: BoolArray
    u: FloatArray

    def without(self, gone: BoolArray) -> Fill:
        """Return a copy of fewer blocks (n,)."""
        return replace(self, blocks=self.blocks & ~gone)


def gradient_at_fill(fills: Sequence[Fill], basis: Any, block: IntArray) -> FloatArray:
    """Return the displacement gradient (t, 2, 2) that is no strain, in cells of blocks (t,) that were put back."""
    gradient = np.zeros((len(block), 2, 2))
    for fill in fills:
        gradient += mean_gradient(basis, fill.u) * fill.blocks[block][:, None, None]
    return gradient
