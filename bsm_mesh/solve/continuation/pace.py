"""For how many steps blocks are followed before an equilibrium nearby is looked for again."""

from __future__ import annotations

from dataclasses import dataclass

MAX_PAUSE = 8  # moving steps after which one is looked for again, at most


@dataclass(frozen=True, slots=True, kw_only=True)
class Pace:
    """For how many steps blocks are followed before an equilibrium is looked for, twice as many after each failure.

    Attributes
    ----------
    wait : int
        Steps to go until one is looked for.
    pause : int
        Steps to wait after the next failure.
    moving_steps : int
        Steps of explicit motion since blocks were last in equilibrium.
    """

    wait: int = 0
    pause: int = 1
    moving_steps: int = 0

    def followed(self) -> Pace:
        """Return the pace of blocks that leave an unstable equilibrium, which is near: the longest there is."""
        return Pace(wait=MAX_PAUSE, pause=MAX_PAUSE, moving_steps=self.moving_steps)

    def counted(self, *, moves: bool, near_rest: bool) -> Pace:
        """Return the pace after a step: anew at rest; `near_rest`: there was no equilibrium nearby, so wait longer."""
        if not moves:
            return Pace()
        wait, pause = (self.pause, min(2 * self.pause, MAX_PAUSE)) if near_rest else (self.wait, self.pause)
        return Pace(wait=max(0, wait - 1), pause=pause, moving_steps=self.moving_steps + 1)
