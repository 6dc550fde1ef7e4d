"""Contact search: candidates for contact between the blocks where they stand now, with the history they carry on."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, fields
from typing import Any

import numba as nb
import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray, own_array
from bsm_mesh.contact.broad_phase import near_pairs
from bsm_mesh.contact.contact_rules import settle
from bsm_mesh.contact.inheritance import ACTIVE
from bsm_mesh.contact.narrow_phase import facing_rows
from bsm_mesh.contact.outlines import Outlines, RecordArray, corner_positions, records_at
from bsm_mesh.contact.rules import RULES, Rules

__all__ = [
    "ActiveContacts",
    "Candidates",
    "Outlines",
    "Sides",
    "corner_positions",
    "detect_contacts",
    "key_of",
    "numbers_of",
]


PAIRS_AT_ONCE = 25_000  # pairs of blocks whose contacts a thread looks for in one go


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class ActiveContacts:
    """Contacts that bore pressure at the last accepted step, sorted by pair.

    Attributes
    ----------
    pair : (k,) int64
        Lower block << 32 | higher block, ascending.
    key : (k,) int64
        Corner << 32 | edge: number of the corner of a, and of the edge of b.
    pressure : (k,) float64 [N/m]
        Normal force, compression positive; a row with none counts as not active.
    point : (k, 2) float64 [m]
        Where the contact was.
    normal : (k, 2) float64
        Outward unit normal of b's edge then.
    """

    pair: IntArray
    key: IntArray
    pressure: FloatArray
    point: FloatArray
    normal: FloatArray

    def __post_init__(self) -> None:
        own_array(self, "pair", np.int64, (None,))
        own_array(self, "key", np.int64, (None,))
        own_array(self, "pressure", np.float64, (None,))
        own_array(self, "point", np.float64, (None, 2))
        own_array(self, "normal", np.float64, (None, 2))

    @classmethod
    def none(cls) -> ActiveContacts:
        """Return no contacts: the start."""
        ids, vectors = np.empty(0, dtype=np.int64), np.empty((0, 2))
        return cls(pair=ids, key=ids, pressure=np.empty(0), point=vectors, normal=vectors)


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Sides:
    """What of candidates lasts for a step: who may touch whom, wherever the blocks are then; sorted by pair.

    Attributes
    ----------
    block_a, block_b : (m,) int32
        The block with the corner, and the block with the edge.
    corner, edge : (m,) int32
        Number of the corner, and of the edge.
    edge_length : (m,) float64 [m]
        Length of the edge.
    length : (m,) float64 [m]
        Length that the contact stands for: half of what a's parallel edge shares with b's edge; without one, 0.05 of
        the smaller block's size.
    parallel_edge : (m,) int32
        Edge of a at the corner that is parallel to b's edge; -1 if there is none.
    history : (m,) int32
        Row of the same contact among the active ones; -1 if it was not active.
    rival : (m,) int32
        Row of the other way out where two corners meet; -1 if there is none. Of the two the one with more gap bears.
    """

    block_a: IntArray
    block_b: IntArray
    corner: IntArray
    edge: IntArray
    edge_length: FloatArray
    length: FloatArray
    parallel_edge: IntArray
    history: IntArray
    rival: IntArray

    @property
    def count(self) -> int:
        """Number of candidates."""
        return len(self.corner)

    @property
    def pair(self) -> IntArray:
        """Numbers of the pairs, (m,) int64, as in `ActiveContacts`."""
        return key_of(np.minimum(self.block_a, self.block_b), np.maximum(self.block_a, self.block_b))

    @property
    def key(self) -> IntArray:
        """Numbers of corner and edge, (m,) int64, as in `ActiveContacts`."""
        return key_of(self.corner, self.edge)


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Candidates(Sides):
    """Places where a corner of `block_a` touches an edge of `block_b`, or may within the next step.

    Attributes
    ----------
    gap : (m,) float64 [m]
        Distance of the corner from the edge's line, positive outside.
    along : (m,) float64 [m]
        Coordinate of the corner along the edge, from the edge's start.
    in_range : (m,) bool
        Whether the corner's projection lies on the edge. A candidate that is not in range bears only once its
        projection has come onto the edge.
    inherits : (m,) int32
        Row of an active contact that has ended and whose shear force this one takes over; else -1.
    play : (m,) float64 [m]
        Corner on corner: how deep the one may go into the other before it bears; else 0.
    lean : (m,) int32
        Edge of a at the corner that leads into b: the contact bears only once the blocks have turned; else -1.
    """

    gap: FloatArray
    along: FloatArray
    in_range: BoolArray
    inherits: IntArray
    play: FloatArray
    lean: IntArray

    @property
    def sides(self) -> Sides:
        """What lasts, without the rest, which would take as much memory again."""
        return Sides(**{field.name: getattr(self, field.name) for field in fields(Sides)})


def key_of(first: IntArray, second: IntArray) -> IntArray:
    """Return one int64 for two numbers: first << 32 | second."""
    key: IntArray = (first.astype(np.int64) << 32) | second
    return key


def numbers_of(key: IntArray) -> tuple[IntArray, IntArray]:
    """Return the two numbers that a key stands for, as `key_of` takes them."""
    return key >> 32, key & 0xFFFFFFFF


NAMES = tuple(field.name for field in fields(Candidates))
Columns = tuple[Any, ...]


def detect_contacts(
    outlines: Outlines, placed: FloatArray, active: ActiveContacts, band: float, *, rules: Rules = RULES
) -> Candidates:
    """Return the candidates for contact where the blocks are.

    Parameters
    ----------
    outlines : Outlines
        The blocks.
    placed : (n_blocks, 3) float64 [m, m, rad]
        Centroid and rotation of every block.
    active : ActiveContacts
        Contacts at the last accepted step.
    band : float [m]
        Corners nearer than this to an edge are candidates, those still open too. Take it a little more than blocks
        move in a step.
    rules : Rules
        Tolerances of the contact rules.
    """
    vertices, blocks = records_at(outlines, placed, band)
    old = np.empty(len(active.key), dtype=ACTIVE)
    old["pair"], old["key"], old["pressure"] = active.pair, active.key, active.pressure
    old["x"], old["y"], old["nx"], old["ny"] = *active.point.T, *active.normal.T
    pairs = near_pairs(vertices, blocks)
    return Candidates(**dict(zip(NAMES, _settled(vertices, blocks, pairs, old, band, rules), strict=True)))


def _settled(
    vertices: RecordArray, blocks: RecordArray, pairs: IntArray, old: RecordArray, band: float, rules: Rules
) -> Columns:
    """Return the fields of the candidates of pairs of blocks, in their order.

    Pairs do not depend on each other: two threads share them, some at a time, so that their records take little memory.
    """
    first = np.arange(0, max(len(pairs), 1), PAIRS_AT_ONCE)
    parts = [pairs[k : k + PAIRS_AT_ONCE] for k in first]
    split = [0, *np.searchsorted(old["pair"], key_of(*pairs[first[1:]].T)).tolist(), len(old)]

    def settled(part: int) -> Columns:
        rows, starts = facing_rows(vertices, blocks, parts[part], band, rules)
        active = old[split[part] : split[part + 1]]
        columns: Columns = _columns(settle(vertices, blocks, parts[part], active, band, rules, rows, starts))
        return columns

    if len(parts) == 1:
        return settled(0)
    with ThreadPoolExecutor(2) as threads:
        found = list(threads.map(settled, range(len(parts))))
    count = np.cumsum([0, *(len(columns[0]) for columns in found)])
    for name, before in (("history", split), ("inherits", split), ("rival", count)):
        for part, columns in enumerate(found):
            number = columns[NAMES.index(name)]
            number[number >= 0] += before[part]
    in_parts = list(zip(*found, strict=True))
    del found  # so that the parts of a column go once it is whole
    return tuple(np.concatenate(in_parts.pop(0)) for _ in NAMES)


@nb.njit(cache=True, nogil=True)
def _columns(rows: RecordArray) -> tuple[Any, ...]:  # pragma: no cover - compiled
    """Return the fields of `Candidates`, in their order, in one pass over the records ROW."""
    n, i4 = rows.size, np.int32
    block_a, block_b, corner, edge = np.empty(n, i4), np.empty(n, i4), np.empty(n, i4), np.empty(n, i4)
    gap, along, edge_length, length = np.empty(n), np.empty(n), np.empty(n), np.empty(n)
    parallel_edge, in_range = np.empty(n, i4), np.empty(n, np.bool_)
    history, inherits, rival = np.empty(n, i4), np.empty(n, i4), np.empty(n, i4)
    play, lean = np.empty(n), np.empty(n, i4)
    for i in range(n):
        row = rows[i]
        block_a[i], block_b[i], corner[i], edge[i] = row.block_a, row.block_b, row.corner, row.edge
        gap[i], along[i], edge_length[i], length[i] = row.gap, row.along, row.edge_length, row.length
        parallel_edge[i], in_range[i] = row.parallel_edge, row.in_range
        history[i], inherits[i], rival[i] = row.history, row.inherits, row.rival
        play[i], lean[i] = row.play, row.lean
    sides = block_a, block_b, corner, edge, edge_length, length, parallel_edge, history, rival
    return (*sides, gap, along, in_range, inherits, play, lean)
