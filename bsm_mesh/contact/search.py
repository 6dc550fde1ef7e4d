"""Contact search: candidates between the blocks at their current position, with the history that they continue."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, fields
from typing import Any, NamedTuple

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray, own_array
from bsm_mesh.compiled import njit
from bsm_mesh.contact.broad_phase import near_pairs
from bsm_mesh.contact.contact_rules import resolve_candidates
from bsm_mesh.contact.history_transfer import ACTIVE
from bsm_mesh.contact.inner_edges import edges_on_blocks
from bsm_mesh.contact.narrow_phase import facing_rows
from bsm_mesh.contact.outlines import Outlines, RecordArray, corner_positions, records_at
from bsm_mesh.contact.rules import RULES, Rules
from bsm_mesh.model.polygons import owner_of_corner

__all__ = [
    "ActiveContacts",
    "Candidates",
    "ContactPairs",
    "Outlines",
    "corner_positions",
    "detect_contacts",
    "key_of",
    "numbers_of",
]


PAIRS_AT_ONCE = 25_000  # pairs of blocks that a thread searches in one go


class Slid(NamedTuple):
    """Where blocks have slid from, and on what.

    Attributes
    ----------
    given : (n_vertices, 2) float64 [m]
        The corners as given.
    on_block : (n_vertices, 2) int32
        Blocks on which edges lie flat; -1: none.
    """

    given: FloatArray
    on_block: IntArray


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class ActiveContacts:
    """Contacts that were closed at the last accepted step, sorted by pair.

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
class ContactPairs:
    """Pairs of corner and edge that may come into contact within a step, sorted by pair of blocks.

    Attributes
    ----------
    block_a, block_b : (m,) int32
        The block with the corner, and the block with the edge.
    corner, edge : (m,) int32
        Number of the corner, and of the edge.
    edge_length : (m,) float64 [m]
        Length of the edge.
    length : (m,) float64 [m]
        Length that the contact represents: half of the overlap of a's parallel edge with b's edge; without one, 0.05 of
        the smaller block's size.
    parallel_edge : (m,) int32
        Edge of a at the corner that is parallel to b's edge, of two the one that shares more; -1 if there is none.
    parallel_edges : (m,) int8
        How many share a length with b's edge: 0, 1, or 2 at a flat corner.
    history : (m,) int32
        Row of the same contact among the active ones; -1 if it was not active.
    opposing_candidate : (m,) int32
        Row of the opposing candidate where two corners meet; -1 if there is none. Of two the one with the smaller
        penetration is closed.
    """

    block_a: IntArray
    block_b: IntArray
    corner: IntArray
    edge: IntArray
    edge_length: FloatArray
    length: FloatArray
    parallel_edge: IntArray
    parallel_edges: IntArray
    history: IntArray
    opposing_candidate: IntArray

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
class Candidates(ContactPairs):
    """Contact candidates: a corner of `block_a` that touches an edge of `block_b`, or may within the next step.

    Attributes
    ----------
    gap : (m,) float64 [m]
        Distance of the corner from the edge's line, positive outside.
    tangential : (m,) float64 [m]
        Coordinate of the corner along the edge, from the edge's start.
    in_range : (m,) bool
        Whether the corner's projection lies on the edge. A candidate that is not in range closes only once its
        projection has come onto the edge.
    predecessor : (m,) int32
        Row of an active contact that has ended and whose history is transferred to this one; else -1.
    recalled : (m,) int32
        Row of an open contact, without pressure, whose offset this one has; else -1.
    corner_gap : (m,) float64 [m]
        Of a corner-corner contact: penetration at which it closes; else 0.
    entering_edge : (m,) int32
        Edge of a at the corner that enters b: the contact closes only once the blocks have rotated; else -1.
    """

    gap: FloatArray
    tangential: FloatArray
    in_range: BoolArray
    predecessor: IntArray
    recalled: IntArray
    corner_gap: FloatArray
    entering_edge: IntArray

    @property
    def contact_pairs(self) -> ContactPairs:
        """The pairs alone, without the rest, which would take as much memory again."""
        return ContactPairs(**{field.name: getattr(self, field.name) for field in fields(ContactPairs)})


def key_of(first: IntArray, second: IntArray) -> IntArray:
    """Return one int64 for two numbers: first << 32 | second."""
    key: IntArray = (first.astype(np.int64) << 32) | second
    return key


def numbers_of(key: IntArray) -> tuple[IntArray, IntArray]:
    """Return the two numbers that a key represents, as `key_of` takes them."""
    return key >> 32, key & 0xFFFFFFFF


NAMES = tuple(field.name for field in fields(Candidates))
Columns = tuple[Any, ...]


def detect_contacts(
    outlines: Outlines,
    placed: FloatArray,
    active: ActiveContacts,
    band: float,
    *,
    rules: Rules = RULES,
    slid: Slid | None = None,
) -> Candidates:
    """Return the contact candidates of placed blocks.

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
    slid : Slid, optional
        Where blocks have slid from; by default the outlines as given, and the active contacts.
    """
    vertices, blocks = records_at(outlines, placed, band)
    old = np.empty(len(active.key), dtype=ACTIVE)
    old["pair"], old["key"], old["pressure"] = active.pair, active.key, active.pressure
    old["x"], old["y"], old["nx"], old["ny"] = *active.point.T, *active.normal.T
    pairs = near_pairs(vertices, blocks)
    owner = owner_of_corner(outlines.offsets)
    if slid is None:
        given = outlines.corners + outlines.centroid[owner]
        slid = Slid(given=given, on_block=edges_on_blocks(vertices, owner, old, rules))
    found = _resolved_candidates(vertices, blocks, pairs, (old, slid), band, rules)
    return Candidates(**dict(zip(NAMES, found, strict=True)))


def _resolved_candidates(
    vertices: RecordArray,
    blocks: RecordArray,
    pairs: IntArray,
    known: tuple[RecordArray, Slid],
    band: float,
    rules: Rules,
) -> Columns:
    """Return the fields of the candidates of pairs of blocks, in their order.

    `known`: records ACTIVE, and where blocks have slid from.

    Pairs do not depend on each other: two threads share them, some at a time, so that their records take little memory.
    """
    old, slid = known
    first = np.arange(0, max(len(pairs), 1), PAIRS_AT_ONCE)
    parts = [pairs[k : k + PAIRS_AT_ONCE] for k in first]
    split = [0, *np.searchsorted(old["pair"], key_of(*pairs[first[1:]].T)).tolist(), len(old)]

    def resolved(part: int) -> Columns:
        rows, starts = facing_rows(vertices, blocks, parts[part], band, rules)
        active = old[split[part] : split[part + 1]]
        kept = resolve_candidates(vertices, blocks, parts[part], active, band, rules, rows, starts, *slid)
        columns: Columns = _columns(kept)
        return columns

    if len(parts) == 1:
        return resolved(0)
    with ThreadPoolExecutor(2) as threads:
        found = list(threads.map(resolved, range(len(parts))))
    count = np.cumsum([0, *(len(columns[0]) for columns in found)])
    for name, before in (
        ("history", split),
        ("predecessor", split),
        ("recalled", split),
        ("opposing_candidate", count),
    ):
        for part, columns in enumerate(found):
            number = columns[NAMES.index(name)]
            number[number >= 0] += before[part]
    in_parts = list(zip(*found, strict=True))
    del found  # so that the parts of a column go once it is whole
    return tuple(np.concatenate(in_parts.pop(0)) for _ in NAMES)


@njit(nogil=True, allocates=True)
def _columns(rows: RecordArray) -> tuple[Any, ...]:  # pragma: no cover - compiled
    """Return the fields of `Candidates`, in their order, in one pass over the records ROW."""
    n, i4 = rows.size, np.int32
    block_a, block_b, corner, edge = np.empty(n, i4), np.empty(n, i4), np.empty(n, i4), np.empty(n, i4)
    gap, tangential, edge_length, length = np.empty(n), np.empty(n), np.empty(n), np.empty(n)
    parallel_edge, parallel_edges, in_range = np.empty(n, i4), np.empty(n, np.int8), np.empty(n, np.bool_)
    history, predecessor, recalled, opposing_candidate = np.empty((4, n), i4)
    corner_gap, entering_edge = np.empty(n), np.empty(n, i4)
    for i in range(n):
        row = rows[i]
        block_a[i], block_b[i], corner[i], edge[i] = row.block_a, row.block_b, row.corner, row.edge
        gap[i], tangential[i], edge_length[i], length[i] = row.gap, row.tangential, row.edge_length, row.length
        parallel_edge[i], parallel_edges[i], in_range[i] = row.parallel_edge, row.parallel_edges, row.in_range
        history[i], predecessor[i], opposing_candidate[i] = row.history, row.predecessor, row.opposing_candidate
        recalled[i], corner_gap[i], entering_edge[i] = row.recalled, row.corner_gap, row.entering_edge
    sides = block_a, block_b, corner, edge, edge_length, length, parallel_edge, parallel_edges
    found = gap, tangential, in_range, predecessor, recalled, corner_gap, entering_edge
    return (*sides, history, opposing_candidate, *found)
