"""How many times movements are drawn larger than they are, in pictures, pages and ParaView."""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import IntArray
from bsm_mesh.model.blocks import Blocks

OF_MODEL = 0.05  # of the model's size: the greatest displacement that is drawn ...
OF_OPENING = 0.1  # ... and of the opening's, which else would look as if it closed
LEAST_VOID = 1e-3  # of the model's box: less is no opening
ROUND = (1, 2, 5)  # times powers of ten


def round_factor(factor: float) -> float:
    """Return 1, 2 or 5 times a power of ten, not above `factor`.

    Examples
    --------
    >>> [round_factor(f) for f in (0.7, 3.9, 50.0, 940.0)]
    [0.5, 2.0, 50.0, 500.0]
    """
    power = 10.0 ** np.floor(np.log10(factor))
    return float(max(step for step in ROUND if step * power <= factor * (1 + 1e-9)) * power)


def factors_up_to(greatest: float) -> list[float]:
    """Return 0 and the round factors from 1 to `greatest`.

    Examples
    --------
    >>> factors_up_to(20)
    [0.0, 1.0, 2.0, 5.0, 10.0, 20.0]
    """
    powers = range(int(np.floor(np.log10(max(greatest, 1.0)))) + 1)
    return [0.0, *(float(step * 10**power) for power in powers for step in ROUND if step * 10**power <= greatest)]


def size_of(blocks: Blocks) -> float:
    """Return the diagonal of the blocks' box [m]."""
    return float(np.linalg.norm(np.ptp(blocks.vertices, axis=0)))


def opening_of(blocks: Blocks, here: IntArray) -> float:
    """Return the size of the room that blocks leave in their box: openings, the air before a slope; 0: none [m].

    Parameters
    ----------
    blocks : Blocks
        As they were given.
    here : (k,) int
        Those that are there.
    """
    sides = np.ptp(blocks.vertices, axis=0)
    box = float(np.prod(sides))
    void = box - float(blocks.moments.bulk[here].sum())
    return float(void ** (1 / len(sides))) if void > LEAST_VOID * box else 0.0


def exaggeration(greatest: float, blocks: Blocks, here: IntArray) -> float:
    """Return the factor on movements, round and at least 1, at which they are seen and nothing looks like a collapse.

    Parameters
    ----------
    greatest : float [m]
        The greatest movement.
    blocks, here
        As for `opening_of`.
    """
    opening = opening_of(blocks, here)
    most = min(OF_MODEL * size_of(blocks), OF_OPENING * opening if opening else np.inf)
    return max(round_factor(most / greatest), 1.0) if greatest > 0 else 1.0
