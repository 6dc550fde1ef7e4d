"""When blocks that move count as fallen: of rigid blocks and of zones."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class CollapseSettings:
    """The criterion of collapse.

    Attributes
    ----------
    free_move : float
        Movement of a block without contact, over its size or the mean one, the larger, at which it is unstable. In one
        step a block may jump.
    runs : float
        Sizes by which a block moved that is no slower than a size before: it runs on.
    moves : float
        Part of the largest movement since the last equilibrium; blocks that moved further are named unstable.
    inside : float
        Part of its area (in space: volume) with which a block lies inside others when its contacts are no longer found.
    """

    free_move: float = 0.1
    runs: float = 3.0
    moves: float = 0.25
    inside: float = 0.05


SETTINGS = CollapseSettings()
