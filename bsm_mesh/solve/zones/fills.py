"""Rock put back in a stage: without stress where it lies then, however the rest is displaced."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.solve.zones.fields import mean_gradient

if TYPE_CHECKING:
    from bsm_mesh.solve.zones.stage_run import StageRun


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


def put_back(run: StageRun, stays: BoolArray, comes: BoolArray) -> None:
    """Put blocks (n,) back as they were given, without stress and without force in their joints."""
    state, of = run.state, run.of
    fresh = np.zeros(of.basis.N, dtype=bool)
    fresh[of.basis.element_dofs[:, comes[of.mesh.block]]] = True
    fresh[of.basis.element_dofs[:, stays[of.mesh.block]]] = False
    state.u, state.origin = np.where(fresh, 0.0, state.u), np.where(fresh, 0.0, state.origin)
    state.relief = np.where(comes[run.plastic.block][:, None, None], 0.0, state.relief)
    state.fills = (*(fill.without(comes) for fill in state.fills), Fill(blocks=comes, u=state.u))
    if state.joints is not None and state.history is not None:
        state.history = state.joints.put_back(state.history, stays, comes, state.u)
