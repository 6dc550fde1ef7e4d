"""How far blocks moved before they came to rest: a landing after a fall is an equilibrium, and often a failure too."""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import IntArray
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.results.records import StageResult

FAR = 0.1  # of a block's size, the root of its area


def moved_far(blocks: Blocks, stage: StageResult) -> IntArray:
    """Return the blocks at rest that lie far from where the stage found them, (k,)."""
    if not stage.status.is_stable:
        return np.zeros(0, np.intp)
    return np.flatnonzero(np.hypot(*stage.stage_displacement[:, :2].T) > FAR * np.sqrt(blocks.moments.area))


def verdict_in_words(blocks: Blocks, stage: StageResult) -> str:
    """Return the verdict on a stage as a person reads it, with how far blocks moved before they came to rest.

    `stable, after moving 3.8 m`: blocks have given way, and lie somewhere.
    """
    verdict = stage.status.value
    far = moved_far(blocks, stage)
    if not far.size:
        return verdict
    return f"{verdict}, after moving {np.hypot(*stage.stage_displacement[far, :2].T).max():.3g} m"
