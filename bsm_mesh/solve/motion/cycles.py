"""Some explicit cycles of all blocks, which threads share: a strip of the model each.

A thread moves its own blocks, by all contacts that they have; of contacts between two strips both threads work out the
forces. Every block's forces so are added up in the same order, whatever the number of threads: it changes no digit.
"""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.solve.motion.kernels import changed_shears, relax_cycles

WORTH_A_THREAD = 15_000  # contacts: with fewer, threads wait more than they work


@dataclass(frozen=True, eq=False, slots=True)
class Springs:
    """Contacts as `relax_cycles` takes them; the last four change in place."""

    block_a: IntArray
    block_b: IntArray
    frame: FloatArray
    spring: FloatArray
    tension: FloatArray
    stuck: FloatArray
    bore: BoolArray
    slipped: BoolArray

    def of(self, rows: IntArray) -> Springs:
        """Return some of the contacts."""
        return Springs(*(values[rows] for values in self.columns))

    def update(self, rows: IntArray, part: Springs) -> None:
        """Take what has changed in some of the contacts."""
        for values, changed in zip(self.columns[-4:], part.columns[-4:], strict=True):
            values[rows] = changed

    @property
    def columns(self) -> tuple[Any, ...]:
        """The arrays, in the order in which `relax_cycles` takes them."""
        return tuple(getattr(self, field.name) for field in fields(self))


@dataclass(frozen=True, eq=False, slots=True)
class Driven:
    """What drives blocks, as `relax_cycles` takes it."""

    unbalanced: FloatArray
    missing: FloatArray
    inverse_mass: FloatArray
    supported: IntArray
    projector: FloatArray
    damping: float
    velocity: FloatArray


def blocks_in_order(centroid: FloatArray) -> IntArray:
    """Return the blocks in the order in which they lie along the model's longer side, (n,)."""
    order: IntArray = np.argsort(centroid[:, int(np.ptp(centroid, axis=0).argmax())], kind="stable")
    return order


def go_through(
    springs: Springs, driven: Driven, lacking: FloatArray, order: IntArray, threads: int
) -> tuple[FloatArray, FloatArray]:
    """Return by what cycles move blocks (n, 3), and by what shears of contacts change (m,).

    `lacking`: as `relax_cycles` takes it; `order`: of the blocks, so that some in a row are a strip of the model;
    `threads`: at most; 0: as many as there are cores.
    """
    moved = np.zeros((2, *driven.velocity.shape))
    threads = min(threads or os.cpu_count() or 1, len(springs.stuck) // WORTH_A_THREAD)
    if threads > 1:
        _share_out(springs, driven, lacking, np.array_split(order, threads), moved)
    else:
        _Share(springs, driven, np.arange(len(order))).go_on(lacking, 0, moved)
    end = moved[lacking.size % 2]
    shears = springs.block_a, springs.block_b, springs.frame, springs.spring, springs.stuck
    changed: FloatArray = changed_shears(*shears, end)
    return end, changed


class _Share:
    """Some of the blocks, all contacts that they have, and what drives them."""

    def __init__(self, springs: Springs, driven: Driven, own: IntArray) -> None:
        self.springs, self._driven = springs, driven
        supported = np.isin(driven.supported, own)
        self._supports = driven.supported[supported], driven.projector[supported]
        self._own = own[~np.isin(own, driven.supported)]
        self._forces = np.empty_like(driven.velocity)

    def go_on(self, lacking: FloatArray, begun: int, moved: FloatArray) -> None:
        """Go on by some cycles; arguments as `relax_cycles` takes them."""
        d = self._driven
        loads = d.unbalanced, d.missing, d.inverse_mass, *self._supports, d.damping
        relax_cycles(lacking, begun, self._own, *self.springs.columns, *loads, self._forces, d.velocity, moved)


def _share_out(
    springs: Springs, driven: Driven, lacking: FloatArray, shares: list[IntArray], moved: FloatArray
) -> None:
    """Go through cycles one by one, a thread for every share; one begins when all have ended that before."""
    parts = []
    for own in shares:
        mine = np.zeros(len(driven.velocity), dtype=bool)
        mine[own] = True
        rows = np.flatnonzero(mine[springs.block_a] | mine[springs.block_b])
        parts.append((rows, _Share(springs.of(rows), driven, np.flatnonzero(mine))))
    with ThreadPoolExecutor(len(parts) - 1) as threads:
        for cycle in range(lacking.size):
            given = lacking[cycle : cycle + 1], cycle, moved
            others = [threads.submit(share.go_on, *given) for _, share in parts[1:]]
            parts[0][1].go_on(*given)
            for other in others:
                other.result()
    for rows, share in parts:
        springs.update(rows, share.springs)
