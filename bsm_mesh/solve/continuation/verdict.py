"""Which blocks come down: those that nothing holds any more, and those that have moved too far (Wang 4.4.3)."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.solve.bolts.state import holding_pairs
from bsm_mesh.solve.contacts.forces import MovingContacts
from bsm_mesh.solve.step.block_system import MovingModel

FREE_MOVE = 0.1  # of its size: a block that has moved this far without contact comes down
RECENT_STEPS, MOVES = 5, 0.25  # unstable: moved more than a quarter of the greatest over the last five steps at most


class Falling:
    """Watches the blocks over the accepted steps of a run.

    Parameters
    ----------
    moving : MovingModel
        The blocks.
    position : (n, 3) float64 [m, m, rad]
        Where they start.
    limit : float [m]
        A block that has moved farther comes down.
    """

    def __init__(self, moving: MovingModel, position: FloatArray, limit: float) -> None:
        self.moving, self.begin, self.limit = moving, position, limit
        self.parted = position.copy()  # where each block last had a contact or a support
        self.loose = np.zeros(len(position), dtype=bool)  # blocks without either after the last step
        self.recent: list[FloatArray] = [position]
        self.steps = 0

    def look(self, contacts: MovingContacts, bore: BoolArray, position: FloatArray) -> tuple[str, IntArray]:
        """Return why and which blocks come down after an accepted step; an empty reason if none does.

        `bore`: contacts (m,) that bear at its end, or bore on the way there.
        """
        self.recent, self.steps = [*self.recent[-RECENT_STEPS:], position], self.steps + 1
        moving, supported = self.moving, self._supported(contacts, bore, position)
        self.parted[supported] = position[supported]
        moved = np.hypot(*(position - self.begin)[:, :2].T)
        fallen = np.hypot(*(position - self.parted)[:, :2].T)
        size = np.sqrt(moving.model.blocks.moments.area)
        loaded = np.abs(moving.loads).max(axis=1) > 0
        free = ~supported & self.loose & loaded & (fallen > FREE_MOVE * size)  # a step alone may jump off and land
        self.loose = ~supported
        if free.any():
            reason = "a block has lost all contact and moves freely"
        elif moved.max() > self.limit:
            reason = f"a block has moved more than {self.limit:.3g} m"
        else:
            return "", np.zeros(0, dtype=np.int32)
        steps = min(RECENT_STEPS, self.steps - self.steps // 2)  # in the first half of few all settle
        lately = np.abs((self.recent[-1] - self.recent[-1 - steps]) / moving.scale).max(axis=1) * ~moving.driven
        return reason, np.flatnonzero(free | (lately > MOVES * lately.max())).astype(np.int32)

    def _supported(self, contacts: MovingContacts, bore: BoolArray, position: FloatArray) -> BoolArray:
        """Return which blocks a chain of bearing contacts and bolts joins to a support, (n,); others fall."""
        c, n, bolts = contacts.candidates, self.moving.model.blocks.count, self.moving.bolts
        near, far = holding_pairs(bolts, bolts.evaluate(position))
        ends = (np.concatenate([c.block_a[bore], near]), np.concatenate([c.block_b[bore], far]))
        _, part = connected_components(coo_array((np.ones(len(ends[0])), ends), shape=(n, n)), directed=False)
        held: BoolArray = np.isin(part, part[self.moving.bars.block])
        return held
