"""Collapse criterion: blocks without contact or support in free motion, or with too large displacement (Wang 4.4.3)."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.errors import place
from bsm_mesh.model.falls import Falls
from bsm_mesh.movements import distances
from bsm_mesh.results.movement import LOST_CONTACT, moved_beyond
from bsm_mesh.solve.bolts.state import holding_pairs
from bsm_mesh.solve.continuation.state import CollapseMemory
from bsm_mesh.solve.motion.falling import SETTINGS
from bsm_mesh.solve.step.system import Contacts, System


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Collapse:
    """Why a run ends without an equilibrium.

    Attributes
    ----------
    reason : str
        In words.
    down : (k,) int32
        Blocks that fall; empty where there is no verdict.
    small : (k,) bool
        Which of them are too small to count.
    unstable : (l,) int32
        Those, and blocks that move with them.
    """

    reason: str
    down: IntArray = field(default_factory=lambda: np.zeros(0, dtype=np.int32))
    small: BoolArray = field(default_factory=lambda: np.zeros(0, dtype=bool))
    unstable: IntArray = field(default_factory=lambda: np.zeros(0, dtype=np.int32))


class CollapseCriterion:
    """Collapse criterion over the accepted steps of a run.

    Parameters
    ----------
    system : System
        The blocks.
    position : (n, axes) float64 [m, rad]
        Where movement counts from.
    limit : float or None [m]
        A block with a larger displacement is unstable. None: the model's extent, and what runs on is not followed.
    falls : Falls
        Which blocks are too small to count.
    """

    def __init__(self, system: System, position: FloatArray, limit: float | None, falls: Falls) -> None:
        self.system, self.begin, self._followed = system, position, limit is not None
        self.limit = limit or system.model.blocks.span
        self.last_supported = position  # position of each block when it last had a contact or a support
        self.detached = np.zeros(len(position), dtype=bool)  # blocks without either after the last step,
        self.thrown = self.detached  # and not before
        self.rest = position  # the last equilibrium
        blocks, free = system.model.blocks, ~system.prescribed_blocks
        self.small = falls.small(blocks, free) & free
        self.mean_size = blocks.moments.mean_size(free) if free.any() else 0.0
        self.own_size = blocks.moments.size
        self.size = np.maximum(self.own_size, self.mean_size)  # small ones by the mean
        self.sizes_moved = np.zeros(len(position), dtype=int)
        self.speed = np.zeros(len(position))  # of every block when it had last moved by a whole number of sizes

    @property
    def memory(self) -> CollapseMemory:
        """Its memory now."""
        return CollapseMemory(
            last_supported=self.last_supported,
            detached=self.detached,
            thrown=self.thrown,
            rest=self.rest,
            sizes_moved=self.sizes_moved,
            speed=self.speed,
        )

    def recall(self, memory: CollapseMemory) -> None:
        """Restore its memory between two steps of the same run."""
        self.last_supported, self.rest = memory.last_supported, memory.rest
        self.detached, self.thrown = memory.detached, memory.thrown
        self.sizes_moved, self.speed = memory.sizes_moved, memory.speed

    def check(
        self,
        contacts: Contacts,
        contacted: BoolArray,
        position: FloatArray,
        velocity: FloatArray | None = None,
        flight: float = SETTINGS.free_move,
    ) -> Collapse | None:
        """Return the fallen blocks after an accepted step, or None.

        `contacted`: contacts (m,) closed at its end, or during the step; `flight`: as `CollapseSettings.free_move`.
        """
        system, supported = self.system, self._supported(contacts, contacted, position)
        self.last_supported = np.where(supported[:, None], position, self.last_supported)
        moved, fallen = distances(position - self.begin), distances(position - self.last_supported)
        loose = ~supported & self.detached & (np.abs(system.loads).max(axis=1) > 0)
        chips = self.small & ((loose & (fallen > flight * self.own_size)) | (moved > self.mean_size))
        free = loose & ~self.small & (fallen > flight * self.size)
        runs = self._runs_on(moved, velocity) & ~self.small
        self.thrown = ~supported & ~self.detached
        self.detached = ~supported
        moves = np.abs((position - self.rest) / system.scale).max(axis=1) * ~system.prescribed_blocks
        if free.any():
            if sunk := self._sunk(np.flatnonzero(free), position):
                return Collapse(reason=sunk)
            return self._collapse(LOST_CONTACT, free, moves)
        if not self._followed and runs.any():
            reason = f"a block moved by more than {SETTINGS.runs:g} times its size without slowing down"
            return self._collapse(reason, runs, moves)
        if (far := (moved > self.limit) & ~self.small).any():
            return self._collapse(moved_beyond(self.limit), far, moves)
        if chips.any():
            number = np.flatnonzero(chips).astype(np.int32)
            small = np.ones(len(number), dtype=bool)
            return Collapse(reason="small blocks fall", down=number, small=small, unstable=number)
        self.rest = position if velocity is None else self.rest
        return None

    def _collapse(self, reason: str, down: BoolArray, moves: FloatArray) -> Collapse:
        """Return a collapse: unstable blocks (n,), and those that move nearly as far (n,) since the last rest."""
        unstable = down | (moves > SETTINGS.moves * moves.max())
        return Collapse(
            reason=reason,
            down=np.flatnonzero(down).astype(np.int32),
            small=self.small[down],
            unstable=np.flatnonzero(unstable).astype(np.int32),
        )

    def _runs_on(self, moved: FloatArray, velocity: FloatArray | None) -> BoolArray:
        """Return which blocks moved several sizes (n,) [m] and are no slower than a size before, (n,)."""
        speed = np.zeros(len(moved)) if velocity is None else distances(velocity)
        sizes = (moved / self.size).astype(int)
        passed = sizes > self.sizes_moved
        runs: BoolArray = passed & (sizes >= SETTINGS.runs) & (self.speed > 0) & (speed >= self.speed)
        self.speed, self.sizes_moved = np.where(passed, speed, self.speed), np.where(passed, sizes, self.sizes_moved)
        return runs

    def _sunk(self, free: IntArray, position: FloatArray) -> str:
        """Return which of the blocks (k,) that seem free lies inside others, in words; nothing where none does."""
        shares = self.system.shares_inside(position, free)
        worst = int(shares.argmax())
        if shares[worst] < SETTINGS.inside:
            return ""
        where, bulk = place(self.system.placed(position)[free[worst]]), self.system.model.blocks.bulk_name
        return (
            f"the block that is now at {where} overlaps its neighbours by {shares[worst]:.2g} of its {bulk}, more than "
            "contacts can follow. Its joints are too soft for the forces, or a fill was placed where others are now: "
            "check stiffness, loads, units and fill"
        )

    def _supported(self, contacts: Contacts, contacted: BoolArray, position: FloatArray) -> BoolArray:
        """Return which blocks are connected to a support by closed contacts and bolts, (n,)."""
        c, n, bolts = contacts.candidates, self.system.model.blocks.count, self.system.bolts
        near, far = holding_pairs(bolts, bolts.evaluate(position))
        ends = (np.concatenate([c.block_a[contacted], near]), np.concatenate([c.block_b[contacted], far]))
        _, part = connected_components(coo_array((np.ones(len(ends[0])), ends), shape=(n, n)), directed=False)
        supported: BoolArray = np.isin(part, part[self.system.bars.block])
        return supported
