"""Acceptance of a step after an excavation with a residual of few blocks.

Few blocks move then, and the others need not be solved again: the residual is left to the following steps.
"""

from __future__ import annotations

from bsm_mesh.solve.methods.regularized_newton import WORTHWHILE
from bsm_mesh.solve.step.equations import LOCALIZED_RMS, Residual, Step

FEW_MOVE = 1e-2  # rms residual over the weight, of which few moving blocks are the cause
MAX_RESIDUAL_MOVING = 1.0  # maximum norm over the weight with which a moving step may end
MAX_RESIDUAL_INTERLOCKED = 0.1  # the same of interlocked blocks, over the reference weight
MAX_RESIDUAL_RETRIED = 1.0  # the same in a step that failed and was shortened
INTERLOCKED = 1.0  # maximum norm over the weight at a step's start, beyond that of a free block: blocks interlock


class Acceptance:
    """Acceptance of a residual at the end of a step, depending on that at its start.

    The residual of interlocked blocks is many weights, and its limit is relative to the contact forces. But where it
    hardly falls, blocks would stay where they are, however many such steps are taken.

    Parameters
    ----------
    step : Step
        The equations.
    """

    def __init__(self, step: Step) -> None:
        before = step.residual_at(step.start)
        self._step, self._before = step, before.l2_norm
        self._weights = step.system.residual_scale if before.max_norm > INTERLOCKED else 1.0

    def is_localized(self, here: Residual) -> bool:
        """Return whether few blocks are the cause of the residual."""
        return self._step.is_localized(here, LOCALIZED_RMS * self._weights)

    def accepts(self, here: Residual, *, shortened: bool = False) -> bool:
        """Return whether the step may end with a residual; `shortened`: after a failed attempt."""
        weights = 1.0 if here.l2_norm > WORTHWHILE * self._before else self._weights
        greatest = max(MAX_RESIDUAL_MOVING, (MAX_RESIDUAL_RETRIED if shortened else MAX_RESIDUAL_INTERLOCKED) * weights)
        return self._step.is_localized(here, FEW_MOVE * weights) and here.max_norm < greatest
