"""Collapse criterion: blocks without contact or support in free motion, or with too large displacement (Wang 4.4.3)."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.contact.search import corner_positions
from bsm_mesh.errors import place
from bsm_mesh.solve.bolts.state import holding_pairs
from bsm_mesh.solve.contacts.forces import ContactSet
from bsm_mesh.solve.step.block_system import BlockSystem

INSIDE = 0.05  # of its area: a block that lies so far inside others has contacts that are no longer found
FREE_MOVE = 0.1  # over its size: movement of a block without contact, at which it is unstable
RECENT_STEPS, MOVES = 5, 0.25  # unstable: moved more than a quarter of the largest over the last five steps


class CollapseCriterion:
    """Collapse criterion over the accepted steps of a run.

    Parameters
    ----------
    system : MovingModel
        The blocks.
    position : (n, 3) float64 [m, m, rad]
        Initial position.
    limit : float [m]
        A block with a larger displacement is unstable.
    """

    def __init__(self, system: BlockSystem, position: FloatArray, limit: float) -> None:
        self.system, self.begin, self.limit = system, position, limit
        self.last_supported = position.copy()  # position of each block when it last had a contact or a support
        self.detached = np.zeros(len(position), dtype=bool)  # blocks without either after the last step
        self.recent: list[FloatArray] = [position]
        self.steps = 0

    def check(self, contacts: ContactSet, contacted: BoolArray, position: FloatArray) -> tuple[str, IntArray]:
        """Return reason and unstable blocks after an accepted step; an empty reason if there is none.

        A reason without blocks says why there is no verdict: blocks that seem free have sunk into others.

        `contacted`: contacts (m,) closed at its end, or during the step.
        """
        self.recent, self.steps = [*self.recent[-RECENT_STEPS:], position], self.steps + 1
        system, supported = self.system, self._supported(contacts, contacted, position)
        self.last_supported[supported] = position[supported]
        moved = np.hypot(*(position - self.begin)[:, :2].T)
        fallen = np.hypot(*(position - self.last_supported)[:, :2].T)
        size = np.sqrt(system.model.blocks.moments.area)
        loaded = np.abs(system.loads).max(axis=1) > 0
        free = ~supported & self.detached & loaded & (fallen > FREE_MOVE * size)  # in one step a block may jump
        self.detached = ~supported
        if free.any():
            sunk = self._sunk(np.flatnonzero(free), position)
            if sunk:
                return sunk, np.zeros(0, dtype=np.int32)
            reason = "a block has lost all contact and moves freely"
        elif moved.max() > self.limit:
            reason = f"a block has moved more than {self.limit:.3g} m"
        else:
            return "", np.zeros(0, dtype=np.int32)
        steps = min(RECENT_STEPS, self.steps - self.steps // 2)  # of few steps the first half is settlement
        last = np.abs((self.recent[-1] - self.recent[-1 - steps]) / system.scale).max(axis=1)
        lately = last * ~system.prescribed_blocks
        return reason, np.flatnonzero(free | (lately > MOVES * lately.max())).astype(np.int32)

    def _sunk(self, free: IntArray, position: FloatArray) -> str:
        """Return which of the blocks (k,) that seem free lies inside others, in words; nothing where none does."""
        from bsm_mesh.results.shared_area import shares_inside

        outlines = self.system.outlines
        placed = outlines.placed(position)
        shares = shares_inside(corner_positions(outlines, placed), self.system.model.blocks.offsets, free)
        worst = int(shares.argmax())
        if shares[worst] < INSIDE:
            return ""
        return (
            f"the block that is now at {place(placed[free[worst], :2])} has sunk into its neighbours by "
            f"{shares[worst]:.2g} of its area, deeper than contacts are followed, and seems free: not an answer; "
            "the joints are too soft for the forces: look at stiffness, loads and units"
        )

    def _supported(self, contacts: ContactSet, contacted: BoolArray, position: FloatArray) -> BoolArray:
        """Return which blocks are connected to a support by closed contacts and bolts, (n,)."""
        c, n, bolts = contacts.candidates, self.system.model.blocks.count, self.system.bolts
        near, far = holding_pairs(bolts, bolts.evaluate(position))
        ends = (np.concatenate([c.block_a[contacted], near]), np.concatenate([c.block_b[contacted], far]))
        _, part = connected_components(coo_array((np.ones(len(ends[0])), ends), shape=(n, n)), directed=False)
        supported: BoolArray = np.isin(part, part[self.system.bars.block])
        return supported
