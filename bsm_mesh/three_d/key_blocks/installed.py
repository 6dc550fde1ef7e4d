"""Pull of installed bolts on key blocks, by statics: the greatest tension that yield, plate and bond allow."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray
from bsm_mesh.errors import ModelError
from bsm_mesh.model.bolt_layout import label, pass_blocks
from bsm_mesh.model.bolts import Bolt
from bsm_mesh.three_d.blocks.polyhedra import Polyhedra


def pulls_of(bolts: Sequence[Bolt], blocks: Polyhedra, present: BoolArray) -> FloatArray:
    """Return the greatest pulls of bolts on all blocks, each towards the tip of its bolt, (n, 3) [N].

    The block is held by the bond along it, at the head with the plate, or by the anchorage of the head. Towards the tip
    the bond in other blocks holds the bolt: these count as firm. Only blocks that are present (n,) hold bolts.

    Raises
    ------
    ModelError
        As `bsm_mesh.model.bolt_layout.pass_blocks`; for a bolt without any limit.
    """
    pull = np.zeros((blocks.count, 3))
    if not bolts:
        return pull
    passed = pass_blocks([replace(bolt, stage=None) for bolt in bolts], blocks)
    kept = present[passed.block]
    bolt, block, length = passed.bolt[kept], passed.block[kept], (passed.last - passed.first)[kept]
    head, tip = np.ones(len(bolt), dtype=bool), np.ones(len(bolt), dtype=bool)
    head[1:], tip[:-1] = (bolt[1:] != bolt[:-1], bolt[1:] != bolt[:-1])

    def of(name: str) -> FloatArray:
        return np.array([getattr(each, name) for each in bolts], dtype=np.float64)[bolt]

    anchored = np.array([each.kind == "end_anchored" for each in bolts])[bolt]
    anchor = np.array([np.inf if each.anchor_capacity is None else each.anchor_capacity for each in bolts])[bolt]
    bond = np.where(length > 0, of("bond_capacity") * length, 0.0)
    total = np.cumsum(np.where(np.isfinite(bond), bond, 0.0))
    last = np.flatnonzero(tip)[np.searchsorted(np.flatnonzero(tip), np.arange(len(bolt)))]
    beyond = np.where(np.isinf(bond), np.inf, total[last] - total)
    holds = np.minimum(bond + np.where(head, of("plate"), 0.0), np.where(tip, 0.0, beyond))
    holds = np.where(anchored, np.where(head & ~tip, anchor, 0.0), holds)
    along = np.array([np.subtract(each.end, each.start) / each.length for each in bolts])[bolt]
    most = np.minimum(holds, of("yield_force"))
    if np.isinf(most).any():
        which = label(bolts, int(bolt[np.isinf(most)][0]))
        raise ModelError(f"key blocks: {which} carries any force; give it a yield_strength")
    np.add.at(pull, block, most[:, None] * along)
    return pull
