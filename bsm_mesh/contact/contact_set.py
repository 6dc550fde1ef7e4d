"""The contact set of a step: candidates near a position with stiffness, strength and history."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.contact.features import features_of
from bsm_mesh.contact.force_kernels import given_geometry
from bsm_mesh.contact.forces import ContactSet, rows_by_law
from bsm_mesh.contact.history import History
from bsm_mesh.contact.properties import ContactProperties, JointCatalogue
from bsm_mesh.contact.rules import CONTACT_TOLERANCE
from bsm_mesh.contact.search import Candidates, Outlines, detect_contacts
from bsm_mesh.contact.state import plainly_remembered, remembered
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.model.model import Model


def gather_contacts(
    model: Model,
    outlines: Outlines,
    catalogue: JointCatalogue,
    history: History,
    position: FloatArray,
    band: float,
    *,
    first: bool,
    keeps_lengths: bool = False,
) -> ContactSet:
    """Return the contact candidates near a position with their history.

    At the start (`first`) all contacts within tolerance are intact, and small overlaps of the given geometry carry no
    pressure. Later ones have no cohesion, no tensile strength, residual friction. `keeps_lengths`: of closed contacts.
    """
    placed = outlines.placed(position)
    found = _keeping_lengths(history, detect_contacts(outlines, placed, history.active, band), always=keeps_lengths)
    blocks, near = model.blocks, CONTACT_TOLERANCE * outlines.size
    sides = found.block_a, found.block_b, found.corner, found.edge, found.parallel_edge
    properties = catalogue.look_up(placed, sides, outlines.corners, outlines.directions)
    source = np.where(found.history >= 0, found.history, found.predecessor)
    known = source >= 0
    meeting = ~known & _meet_at_a_node(blocks, outlines.neighbour_clusters, found, near)
    recalled = _offsets_of_open(history, found)
    within_tolerance = found.in_range & (found.gap <= recalled + near) & ~meeting
    fresh = ~known & within_tolerance
    offset = remembered(history.offset, source, _offsets(found, fresh, meeting, near, (not first) * band, recalled))
    failed, mated = _since_the_start(history, source, properties.joint, first)
    within_tolerance |= known & found.in_range & (found.gap <= offset + near)  # in situ, with a large gap too
    normal_stiffness = properties.normal_stiffness * found.length
    shear_stiffness = np.where(catalogue.smooth[properties.law], 0.0, properties.shear_stiffness * found.length)
    entering = np.flatnonzero(found.entering_edge >= 0)
    entering_edges = found.entering_edge[entering], found.corner[entering]
    return ContactSet(
        outlines=outlines,
        candidates=found.contact_pairs,
        joint=properties.joint,
        law=properties.law,
        geometry=given_geometry(*sides[:4], outlines.centroid, outlines.corners, outlines.directions),
        normal_stiffness=normal_stiffness,
        **_tensions(properties, found.length, known | within_tolerance, failed, mated),
        offset=offset,
        old_shear=remembered(history.shear, source, np.zeros(found.count)),
        old_pressure=remembered(history.active.pressure, source, np.zeros(found.count)),
        **_anchors(history, found, fresh),
        failed=failed,
        mated=mated,
        **plainly_remembered(history, source),
        edge_overhang=np.where(within_tolerance, band, 0.0),
        within_tolerance=within_tolerance,
        opposing=np.flatnonzero(found.opposing_candidate >= 0),
        entering=entering,
        entering_direction=_edges_from_corners(outlines.corners, blocks.following, *entering_edges),
        shear_stiffness=shear_stiffness,
        features=features_of(catalogue, properties.joint, found.length, (normal_stiffness, shear_stiffness), mated),
        by_law=rows_by_law(properties.law),
    )


def _since_the_start(history: History, source: IntArray, joint: IntArray, first: bool) -> tuple[BoolArray, BoolArray]:
    """Return which contacts have failed or arose later, and which have been closed since the start, (m,) each.

    Those that slide off their face onto one of another joint, or of rock, have not been there since the start.
    """
    elsewhere = (source >= 0) & (remembered(history.joint, source, joint) != joint)
    failed = remembered(history.failed, source, np.full(len(joint), not first)) | elsewhere
    mated = remembered(history.mated, source, np.full(len(joint), first)) & ~elsewhere
    return failed, mated


def _tensions(
    properties: ContactProperties, length: FloatArray, bears: BoolArray, failed: BoolArray, mated: BoolArray
) -> dict[str, FloatArray]:
    """Return the greatest tension of contacts (m,) [N/m], and what slip leaves of it where they have not opened."""
    if not properties.tension.any():  # nor has slip any to leave
        none = np.zeros(len(length))
        return {"tension": none, "residual_tension": none}
    residual = np.where(mated, properties.residual_tension * length, 0.0)
    tension = np.where(bears, np.where(failed, residual, properties.tension * length), 0.0)
    return {"tension": tension, "residual_tension": residual}


def _keeping_lengths(history: History, found: Candidates, *, always: bool) -> Candidates:
    """Return candidates that keep the length of their history while an edge that shared it is turned away, or past it.

    `always`: in any case.

    A face that has slid off another would represent a lone corner, twenty times as much as at last. Blocks that rock on
    an edge would sink and rise. Two edges at a flat corner turn away one by one. Without memory of both a block may
    have no equilibrium near the angle at which one counts, and steps flip between two lengths for ever.
    """
    length, edges = found.length.copy(), found.parallel_edges.copy()
    known = np.flatnonzero(found.history >= 0)
    row = found.history[known]
    turned = edges[known] < history.parallel_edges[row]
    rows, row = known[turned], row[turned]
    ended = (edges[rows] == 0) & (found.parallel_edge[rows] >= 0)
    length[rows] = np.where(ended, history.length[row], np.maximum(length[rows], history.length[row]))
    edges[rows] = history.parallel_edges[row]
    if always:
        length[known] = history.length[found.history[known]]
    return replace(found, length=length, parallel_edges=edges)


def _anchors(history: History, found: Candidates, fresh: BoolArray) -> dict[str, FloatArray]:
    """Return the tangential coordinates of the shear force, and of first contact, (m,) each [m].

    An heir continues the slip of its predecessor: that has one sign from both sides of a joint.
    """
    heir = np.flatnonzero((found.history < 0) & (found.predecessor >= 0))
    anchor = np.where(fresh, found.tangential, np.nan)
    anchor[heir] = found.tangential[heir]
    first = anchor.copy()
    first[heir] -= (history.tangential - history.first_tangential)[found.predecessor[heir]]
    return {
        "old_tangential": remembered(history.tangential, found.history, anchor),
        "first_tangential": remembered(history.first_tangential, found.history, first),
    }


def _offsets_of_open(history: History, found: Candidates) -> FloatArray:
    """Return the offsets that open contacts remember, (m,) [m]; 0 for candidates that recall none.

    None presses at once: a gap that is smaller already becomes its offset.
    """
    offset, again = np.zeros(found.count), np.flatnonzero(found.recalled >= 0)
    offset[again] = np.clip(found.gap[again], 0.0, history.offset[found.recalled[again]])
    return offset


def _offsets(
    found: Candidates, fresh: BoolArray, meeting: BoolArray, near: float, slid: float, recalled: FloatArray
) -> FloatArray:
    """Return the gaps at zero pressure of contacts without history, (m,) [m].

    `slid`: up to this length a face counts as having just slid onto another; `recalled` (m,) [m]: those of contacts
    that are open.
    """
    offset = recalled.copy()
    overlapping = fresh & (found.gap < 0)
    offset[overlapping] = found.gap[overlapping]
    slid_on = overlapping & _slid_on(found, slid)
    offset[slid_on] = np.minimum(found.gap[slid_on] + near, 0.0)
    offset[meeting] = -near
    offset[found.corner_gap > 0] = -found.corner_gap[found.corner_gap > 0]
    return offset


def _slid_on(found: Candidates, band: float) -> BoolArray:
    """Return which candidates are at the end of a face that has begun to slide onto another, (m,).

    The last face behind them has the same penetration: they are closed at once, or the block would sink on and on.
    """
    from_end = np.minimum(np.abs(found.tangential), np.abs(found.tangential - found.edge_length))
    short: BoolArray = (found.parallel_edge >= 0) & (from_end < band) & (2 * found.length < band)
    return short


def _meet_at_a_node(blocks: Blocks, clusters: IntArray, found: Candidates, near: float) -> BoolArray:
    """Return which candidates are corners of a mesh's node that touch a diagonal neighbour's corner there, (m,).

    Other blocks, connected by faces, lie between the two: their corners have one number in `clusters`. While they have
    not moved apart or together by more than `near` that point carries no force: it would stiffen a continuum of blocks
    that has only faces. Blocks that touch at a node without others between them do so as on any other point of an edge.
    """
    corner, start, end = clusters[found.corner], clusters[found.edge], clusters[blocks.following[found.edge]]
    at_start = (corner == start) & (np.abs(found.tangential) <= near)
    at_end = (corner == end) & (np.abs(found.tangential - found.edge_length) <= near)
    meeting: BoolArray = (found.parallel_edge < 0) & (at_start | at_end)
    return meeting


def _edges_from_corners(corners: FloatArray, following: IntArray, edge: IntArray, corner: IntArray) -> FloatArray:
    """Return the unit directions (l, 2) of edges at their corners, away from those."""
    vector = corners[following[edge]] - corners[edge]
    vector[edge != corner] *= -1.0
    unit: FloatArray = vector / np.hypot(*vector.T)[:, None]
    return unit
