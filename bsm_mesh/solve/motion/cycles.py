"""Explicit cycles of all blocks, divided among threads: a strip of the model each.

A thread moves its own blocks, by all their contacts; forces of contacts between two strips are evaluated by both
threads. So the forces on a block are summed in the same order whatever the number of threads: no digit changes.
"""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.solve.motion.kernels import changed_shears, relax_cycles

WORTH_A_THREAD = 15_000  # contacts per thread: with fewer, threads wait more than they work


@dataclass(frozen=True, eq=False, slots=True)
class ExplicitContacts:
    """Contacts in explicit motion, as `relax_cycles` takes them; the last four arrays change in place."""

    block_a: IntArray
    block_b: IntArray
    frame: FloatArray
    spring: FloatArray
    tension: FloatArray
    shear_offset: FloatArray
    contacted: BoolArray
    slipped: BoolArray

    def of(self, rows: IntArray) -> ExplicitContacts:
        """Return some of the contacts."""
        return ExplicitContacts(*(values[rows] for values in self.columns))

    def update(self, rows: IntArray, part: ExplicitContacts) -> None:
        """Copy the changed arrays of some of the contacts back."""
        for values, changed in zip(self.columns[-4:], part.columns[-4:], strict=True):
            values[rows] = changed

    @property
    def columns(self) -> tuple[Any, ...]:
        """The arrays, in the order in which `relax_cycles` takes them."""
        return tuple(getattr(self, field.name) for field in fields(self))


@dataclass(frozen=True, eq=False, slots=True)
class ExplicitLoads:
    """Loads, masses and supports in explicit motion, as `relax_cycles` takes them."""

    residual: FloatArray
    ramped_load: FloatArray
    inverse_mass: FloatArray
    supported: IntArray
    projector: FloatArray
    damping: float
    velocity: FloatArray


def blocks_in_order(centroid: FloatArray) -> IntArray:
    """Return the blocks in the order of their coordinates along the model's longer side, (n,)."""
    order: IntArray = np.argsort(centroid[:, int(np.ptp(centroid, axis=0).argmax())], kind="stable")
    return order


def run_cycles(
    contacts: ExplicitContacts, loads: ExplicitLoads, unramped_fraction: FloatArray, order: IntArray, threads: int
) -> tuple[FloatArray, FloatArray]:
    """Return the movement of blocks (n, 3) and the change of shear forces (m,) in some cycles.

    `unramped_fraction`: as in `relax_cycles`; `order`: of the blocks, so that successive ones are a strip of the model;
    `threads`: largest number; 0: one per core.
    """
    moved = np.zeros((2, *loads.velocity.shape))
    threads = min(threads or os.cpu_count() or 1, len(contacts.shear_offset) // WORTH_A_THREAD)
    if threads > 1:
        _run_in_strips(contacts, loads, unramped_fraction, np.array_split(order, threads), moved)
    else:
        _Strip(contacts, loads, np.arange(len(order))).advance(unramped_fraction, 0, moved)
    end = moved[unramped_fraction.size % 2]
    shears = contacts.block_a, contacts.block_b, contacts.frame, contacts.spring, contacts.shear_offset
    changed: FloatArray = changed_shears(*shears, end)
    return end, changed


class _Strip:
    """Some of the blocks, all their contacts, and their loads."""

    def __init__(self, contacts: ExplicitContacts, loads: ExplicitLoads, own: IntArray) -> None:
        self.contacts, self._loads = contacts, loads
        supported = np.isin(loads.supported, own)
        self._supports = loads.supported[supported], loads.projector[supported]
        self._own = own[~np.isin(own, loads.supported)]
        self._forces = np.empty_like(loads.velocity)

    def advance(self, unramped_fraction: FloatArray, begun: int, moved: FloatArray) -> None:
        """Advance by some cycles; arguments as in `relax_cycles`."""
        d, columns = self._loads, self.contacts.columns
        loads = d.residual, d.ramped_load, d.inverse_mass, *self._supports, d.damping
        relax_cycles(unramped_fraction, begun, self._own, *columns, *loads, self._forces, d.velocity, moved)


def _run_in_strips(
    contacts: ExplicitContacts,
    loads: ExplicitLoads,
    unramped_fraction: FloatArray,
    shares: list[IntArray],
    moved: FloatArray,
) -> None:
    """Run cycles one by one, a thread for every share; each begins when all have ended the last."""
    parts = []
    for own in shares:
        mine = np.zeros(len(loads.velocity), dtype=bool)
        mine[own] = True
        rows = np.flatnonzero(mine[contacts.block_a] | mine[contacts.block_b])
        parts.append((rows, _Strip(contacts.of(rows), loads, np.flatnonzero(mine))))
    with ThreadPoolExecutor(len(parts) - 1) as threads:
        for cycle in range(unramped_fraction.size):
            arguments = unramped_fraction[cycle : cycle + 1], cycle, moved
            others = [threads.submit(share.advance, *arguments) for _, share in parts[1:]]
            parts[0][1].advance(*arguments)
            for other in others:
                other.result()
    for rows, share in parts:
        contacts.update(rows, share.contacts)
