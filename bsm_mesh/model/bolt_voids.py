"""Bolts that cross open space between their head and their tip when they are installed."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from bsm_mesh.model.bolt_layout import ROUNDED, label, pass_blocks

if TYPE_CHECKING:
    from bsm_mesh.model.model import Model

MOST = 3  # bolts that are named


def of_bolts_across_voids(model: Model) -> Iterator[str]:
    """Say which bolts cross an opening or a gap, and over which length [m]: most likely a coordinate is wrong."""
    if not model.bolts:
        return
    passed = pass_blocks(model.bolts, model.blocks, model.stages)
    void = np.zeros(len(model.bolts))
    for b, bolt in enumerate(model.bolts):
        mine = slice(*np.searchsorted(passed.bolt, (b, b + 1)))
        gaps = passed.first[mine][1:] - np.maximum.accumulate(passed.last[mine])[:-1]
        void[b] = gaps[gaps > ROUNDED * bolt.length].sum()
    across = np.flatnonzero(void)
    for b in across[:MOST].tolist():
        more = f" [{len(across) - MOST} more of this kind]" if b == across[:MOST][-1] and len(across) > MOST else ""
        yield (
            f"{label(model.bolts, b)} crosses {void[b]:.4g} m without rock where it is installed, and is a free bar "
            f"there; if it belongs in the rock, correct its ends or its stage{more}"
        )
