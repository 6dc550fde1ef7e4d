"""Cycles of explicit motion shared by threads: a strip of the model each.

A thread moves its own blocks by all contacts that they have; contacts between two strips are worked out by both. So
every block's forces are added up in the same order whatever the number of threads: it changes no digit.
"""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.contact.forces import AT_ONCE
from bsm_mesh.solve.motion.contact_columns import ChunkArray, chosen, column_of, put
from bsm_mesh.solve.motion.contact_kernels import ROOM, add_contact_forces
from bsm_mesh.solve.motion.kernels import advance
from bsm_mesh.solve.motion.meeting import give_up, meeting_of

CHUNKS = "contacts", "strengths", "closures", "slips", "growths"


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Share:
    """Contacts as `add_contact_forces` takes them; all but their blocks change in place.

    `works` (c,) WORK are there where their work is asked for.
    """

    block_a: IntArray
    block_b: IntArray
    contacts: ChunkArray
    strengths: ChunkArray
    closures: ChunkArray
    slips: ChunkArray
    growths: ChunkArray
    works: ChunkArray | None = None

    def of(self, rows: IntArray) -> Share:
        """Return some of the contacts."""
        chunks = {name: chosen(getattr(self, name), rows) for name in self._chunks}
        return Share(block_a=self.block_a[rows], block_b=self.block_b[rows], **chunks)

    def take(self, rows: IntArray, part: Share) -> None:
        """Take over the new state of some of the contacts."""
        for name in self._chunks:
            put(getattr(self, name), rows, getattr(part, name))

    @property
    def _chunks(self) -> tuple[str, ...]:
        return CHUNKS if self.works is None else (*CHUNKS, "works")

    def happened(self, name: str) -> BoolArray:
        """Return to which contacts something has happened in the window, (m,): `contacted`, `failed` or `broken`."""
        chunks = self.contacts if name == "contacted" else self.strengths
        if not len(chunks):
            return np.zeros(len(self.block_a), dtype=bool)
        happened: BoolArray = column_of(chunks, name, len(self.block_a)) > 0
        return happened

    @property
    def columns(self) -> tuple[Any, ...]:
        """The arrays, in the order in which kernels take them."""
        return tuple(getattr(self, field.name) for field in fields(self))


def strips(centroid: FloatArray, threads: int) -> list[IntArray]:
    """Return the blocks (n, 2) in as many strips along the model's longer side as there are threads; 0: cores."""
    order = np.argsort(centroid[:, int(np.ptp(centroid, axis=0).argmax())], kind="stable")
    return np.array_split(order, max(1, threads or os.cpu_count() or 1))


def advance_window(
    share: Share,
    strips: list[IntArray],
    cycles: int,
    farthest: float,
    *,
    supports: tuple[IntArray, FloatArray, FloatArray],
    bolts: tuple[Any, ...] | None,
    loads: tuple[FloatArray, FloatArray, FloatArray],
    constants: tuple[FloatArray, FloatArray, float],
    velocity: FloatArray,
    shaken: tuple[FloatArray, FloatArray] | None = None,
    ends: tuple[Any, ...] | None = None,
) -> tuple[int, FloatArray, FloatArray]:
    """Return the number of cycles, the displacements of blocks in them, and their velocities, (n, 3) each.

    `share` changes in place; the rest as `kernels.advance` takes it, `ends` without its rows.
    """
    velocity = velocity.copy()
    moved, turns = np.zeros((2, *velocity.shape)), np.zeros((2, 2, len(velocity)), np.float32)
    count = min(len(strips), len(share.block_a) // AT_ONCE)
    common = bolts, loads, constants, velocity, moved, turns, shaken, ends
    if count <= 1:
        part = _Strip(share, np.arange(len(velocity)), supports, common)
        went = part.advance(cycles, farthest, meeting_of(1))
        part.end(went)
    else:
        went = _by_threads(share, np.array_split(np.concatenate(strips), count), cycles, farthest, supports, common)
    return went, moved[went % 2], velocity


class _Strip:
    """Some of the blocks, with all contacts that they have."""

    def __init__(self, share: Share, own: IntArray, supports: Any, common: Any) -> None:
        supported, projector, prescribed = supports
        here = np.isin(supported, own)
        self.share = share
        self._own = np.sort(own[~np.isin(own, supported)]).astype(np.uint32)  # unsigned: none counts from the end
        self._supports = supported[here].astype(np.uint32), projector[here], prescribed
        self._common = common
        self._ends = None if common[7] is None else np.flatnonzero(np.isin(common[7][0], own))
        # Room for the forces of blocks, and for those of bolts alone; for a block, for a chunk of contacts.
        forces = np.empty((2 if common[6] is not None else 1, *common[3].shape))
        self._room = forces, np.empty((3, 3)), np.zeros(1, ROOM)

    def advance(self, cycles: int, farthest: float, meeting: IntArray) -> int:
        bolts, loads, constants, velocity, moved, turns, shaken, ends = self._common
        if ends is not None:
            ends = self._ends, *ends
        went: int = advance(
            cycles, meeting, farthest, self._own, self._supports, self.share.columns, bolts, loads, constants,
            velocity, moved, turns, self._room, shaken, ends,
        )  # fmt: skip
        return went

    def end(self, went: int) -> None:
        """Take contacts to where the last cycle has moved blocks, if their work is asked for: that of it is part."""
        if self.share.works is None:
            return
        _, _, _, _, moved, turns, *_ = self._common
        add_contact_forces(moved[went % 2], *turns[went % 2], *self.share.columns, self._room[2], self._room[0][0])


def _by_threads(share: Share, strips: list[IntArray], cycles: int, farthest: float, supports: Any, common: Any) -> int:
    """Go through cycles, a thread for every strip; they meet after each."""
    meeting = meeting_of(len(strips))

    def gone_through(own: IntArray) -> int:
        try:
            mine = np.zeros(len(common[3]), dtype=bool)
            mine[own] = True
            rows = np.flatnonzero(mine[share.block_a] | mine[share.block_b])
            part = _Strip(share.of(rows), own, supports, common)
            went = part.advance(cycles, farthest, meeting)
            part.end(went)
            share.take(rows, part.share)
        except BaseException:
            give_up(meeting)
            raise
        return went

    with ThreadPoolExecutor(len(strips) - 1) as threads:
        try:
            others = [threads.submit(gone_through, own) for own in strips[1:]]
            went = gone_through(strips[0])
        except BaseException:  # the system may start no more, or the user interrupts
            give_up(meeting)
            raise
        for other in others:
            other.result()
    return went
