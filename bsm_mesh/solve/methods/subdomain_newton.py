"""Newton's corrections of a subdomain alone: the blocks with the largest residual and those near them, others fixed.

After an excavation in a large model the residual is that of few blocks, and hardly felt further away. A global
correction would be much the same at ten times the cost.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array

from bsm_mesh.arrays import BoolArray, FloatArray
from bsm_mesh.solve.algebra.block_matrix import BlockPattern
from bsm_mesh.solve.methods.corrections import line_search, newton_correction, tangent_regularization
from bsm_mesh.solve.step.equations import StepEquations
from bsm_mesh.solve.step.subproblem import SubdomainEquations


@dataclass(frozen=True, slots=True, kw_only=True)
class SubdomainSettings:
    """Which blocks a correction moves.

    Attributes
    ----------
    cutoff : float
        Residual of a block, over the greatest, above which it is in the subdomain.
    layers : int
        Contacts away from those blocks within which others are: how far a correction is felt.
    max_share : float
        Part of all blocks; a larger subdomain saves nothing.
    """

    cutoff: float = 3e-3
    layers: int = 25
    max_share: float = 0.25


SETTINGS = SubdomainSettings()


def subdomain_correction(step: StepEquations, position: FloatArray) -> FloatArray | None:
    """Return the position after a regularised correction of the subdomain, or None where it is empty or too large."""
    sizes, weight = block_residuals(step, position)
    large = sizes > SETTINGS.cutoff * sizes.max()
    moves = _with_layers(step.pattern, large, step.system.prescribed_blocks, SETTINGS.layers)
    if not 0 < moves.sum() <= SETTINGS.max_share * len(moves):
        return None
    local = SubdomainEquations(step, moves, position)
    try:
        here = local.residual_at(local.start, weight)
        correction = newton_correction(local, here, tangent_regularization(here.max_norm))
        corrected = here if correction is None else line_search(local, here, correction, here.l2_norm)
    finally:
        local.close()
    return local.whole(corrected.position)


def block_residuals(step: StepEquations, position: FloatArray) -> tuple[FloatArray, float]:
    """Return the maximum norm of every block's residual over the mean weight (n,), and that weight."""
    at = step.evaluate(position)
    weight = step.system.weight(at)
    free = step.project(step.residual(position, at.forces))
    return np.abs(free).max(axis=1) / weight, weight


def _with_layers(pattern: BlockPattern, marked: BoolArray, fixed: BoolArray, layers: int) -> BoolArray:
    """Return the marked blocks and those at most `layers` contacts away, not counted across fixed ones."""
    near = csr_array((np.ones(len(pattern.column), np.float32), pattern.column, pattern.row_start))
    for _ in range(layers):
        marked = marked | ((near @ marked.astype(np.float32) > 0) & ~fixed)
    return marked
