"""How much a step after an excavation may leave out of balance.

Few blocks move then, and the others need not be solved again for what those lack: the steps to come take it up.
"""

from __future__ import annotations

from bsm_mesh.solve.methods.regularized_newton import WORTHWHILE
from bsm_mesh.solve.step.equations import SCATTERED, Balance, Step

FEW_MOVE = 1e-2  # root mean square out of balance [weights] of which few blocks that move are the cause
UNPOLISHED = 1.0  # greatest out of balance [weights] with which a moving step may end
LONG, SHORTENED = 0.1, 1.0  # the same where blocks jam [reference weights], and in a step that failed and was shortened
JAMMED = 1.0  # greatest out of balance at a step's start [weights], more than which no free block lacks: so blocks jam


class Leftover:
    """What a step may leave, by what was out of balance where it began.

    Blocks that jam lack many weights, and what they may lack is measured by the force that contacts bear. But jammed
    blocks that hardly come nearer to balance would stay where they are, however many such steps are taken.

    Parameters
    ----------
    step : Step
        The equations.
    """

    def __init__(self, step: Step) -> None:
        before = step.balance_at(step.start)
        self._step, self._before = step, before.norm
        self._weights = step.moving.stressed if before.greatest > JAMMED else 1.0

    def is_of_few(self, here: Balance) -> bool:
        """Return whether few blocks are the cause of what is out of balance."""
        return self._step.is_scattered(here, SCATTERED * self._weights)

    def is_little(self, here: Balance, *, shortened: bool = False) -> bool:
        """Return whether the step may end with it; `shortened`: after it failed, when other ways leave as much."""
        weights = 1.0 if here.norm > WORTHWHILE * self._before else self._weights
        greatest = max(UNPOLISHED, (SHORTENED if shortened else LONG) * weights)
        return self._step.is_scattered(here, FEW_MOVE * weights) and here.greatest < greatest
