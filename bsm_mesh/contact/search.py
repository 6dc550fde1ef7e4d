"""Contact search: candidates for contact between the blocks where they stand now, with the history they carry on."""

from __future__ import annotations

from dataclasses import dataclass

import numba as nb
import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray, own_array
from bsm_mesh.contact.broad_phase import near_pairs
from bsm_mesh.contact.contact_rules import settle_pair
from bsm_mesh.contact.narrow_phase import RULES, ActiveArrays, Rows, Rules, empty_rows, facing_pairs
from bsm_mesh.contact.outlines import Outlines, Scene, corner_positions, scene_at

__all__ = ["ActiveContacts", "Candidates", "Outlines", "corner_positions", "detect_contacts"]

ROWS_PER_PAIR = 3  # space at first; the tables grow where more are found


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
class Candidates:
    """Places where a corner of `block_a` touches an edge of `block_b`, or may within the next step; sorted by pair.

    Attributes
    ----------
    block_a, block_b : (m,) int32
        The block with the corner, and the block with the edge.
    corner, edge : (m,) int32
        Number of the corner, and of the edge.
    pair, key : (m,) int64
        As in `ActiveContacts`.
    gap : (m,) float64 [m]
        Distance of the corner from the edge's line, positive outside.
    along : (m,) float64 [m]
        Coordinate of the corner along the edge, from the edge's start.
    edge_length : (m,) float64 [m]
        Length of the edge.
    length : (m,) float64 [m]
        Length that the contact stands for: half of what a's parallel edge shares with b's edge; without one, 0.05 of
        the smaller block's size.
    parallel_edge : (m,) int32
        Edge of a at the corner that is parallel to b's edge; -1 if there is none.
    in_range : (m,) bool
        Whether the corner's projection lies on the edge. A candidate that is not in range bears only once its
        projection has come onto the edge.
    history : (m,) int32
        Row of the same contact among the active ones; -1 if it was not active.
    inherits : (m,) int32
        Row of an active contact that has ended and whose shear force this one takes over; else -1.
    """

    block_a: IntArray
    block_b: IntArray
    corner: IntArray
    edge: IntArray
    pair: IntArray
    key: IntArray
    gap: FloatArray
    along: FloatArray
    edge_length: FloatArray
    length: FloatArray
    parallel_edge: IntArray
    in_range: BoolArray
    history: IntArray
    inherits: IntArray

    @property
    def count(self) -> int:
        """Number of candidates."""
        return len(self.corner)


def detect_contacts(
    outlines: Outlines, position: FloatArray, active: ActiveContacts, band: float, *, rules: Rules = RULES
) -> Candidates:
    """Return the candidates for contact at a position.

    Parameters
    ----------
    outlines : Outlines
        The blocks.
    position : (n_blocks, 3) float64 [m, m, rad]
        Centroid and rotation of every block.
    active : ActiveContacts
        Contacts at the last accepted step.
    band : float [m]
        Corners nearer than this to an edge are candidates, those still open too. Take it a little more than blocks
        move in a step.
    rules : Rules
        Tolerances of the contact rules.
    """
    scene = scene_at(outlines, position, band)
    history = ActiveArrays(active.pair, active.key, active.pressure, active.point, active.normal)
    rows, count = _search(scene, history, near_pairs(scene), band, rules)
    return _as_candidates(rows, count)


def _as_candidates(rows: Rows, count: int) -> Candidates:
    columns = {name: getattr(rows, name)[:count].copy() for name in Rows._fields if name not in ("tip", "state")}
    lower = np.minimum(columns["block_a"], columns["block_b"]).astype(np.int64)
    higher = np.maximum(columns["block_a"], columns["block_b"])
    return Candidates(
        pair=(lower << 32) | higher, key=(columns["corner"].astype(np.int64) << 32) | columns["edge"], **columns
    )


@nb.njit(cache=True)
def _search(
    scene: Scene, active: ActiveArrays, pairs: IntArray, band: float, rules: Rules
) -> tuple[Rows, int]:  # pragma: no cover - compiled
    """Return the candidates of all pairs (k, 2), in their order, and how many there are."""
    rows = empty_rows(ROWS_PER_PAIR * pairs.shape[0] + 64)
    count = 0
    last = 0
    for p in range(pairs.shape[0]):
        i, j = pairs[p, 0], pairs[p, 1]
        pair = (np.int64(i) << 32) | np.int64(j)
        while last < active.pair.size and active.pair[last] < pair:
            last += 1
        first = last
        while last < active.pair.size and active.pair[last] == pair:
            last += 1
        size = min(scene.size[i], scene.size[j])
        start = count
        rows, count = facing_pairs(scene, active, first, last, i, j, size, band, rules, rows, count)
        rows, count = facing_pairs(scene, active, first, last, j, i, size, band, rules, rows, count)
        count = settle_pair(scene, active, first, last, size, band, rules, rows, start, count)
    return rows, count
