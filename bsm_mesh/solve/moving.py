"""Blocks in motion: the contacts of a position, their forces by law, and what accepted steps remember."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.contact.moving_kernels import add_moving_forces, fill_tangent, relative_positions
from bsm_mesh.contact.properties import ContactProperties, JointCatalogue
from bsm_mesh.contact.rules import RULES
from bsm_mesh.contact.search import ActiveContacts, Candidates, Outlines, detect_contacts
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.model.joint_laws import JointLaw
from bsm_mesh.model.model import Model

IDLE = 1e-6  # of the block size: an intact contact open by less has not been parted
FULL = 1 - 1e-9  # of its strength: what a contact bears that slips
TOUCHING = 1e-3  # of the block size: a gap or overlap up to this is contact when two blocks meet


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class History:
    """What contacts that bear force carry from step to step.

    Attributes
    ----------
    active : ActiveContacts
        Who they are and where, sorted by pair.
    shear : (k,) float64 [N/m]
        Shear force.
    along : (k,) float64 [m]
        Coordinate along the edge at which it had that shear force.
    first_along : (k,) float64 [m]
        Coordinate at which it first touched.
    offset : (k,) float64 [m]
        Gap at which the contact bears nothing.
    failed : (k,) bool
        Asperities sheared off, cohesion and tension lost; true for contacts that arose after the start.
    """

    active: ActiveContacts
    shear: FloatArray
    along: FloatArray
    first_along: FloatArray
    offset: FloatArray
    failed: BoolArray

    @classmethod
    def none(cls) -> History:
        """Return the empty history of the start."""
        empty = np.zeros(0)
        return cls(
            active=ActiveContacts.none(),
            shear=empty,
            along=empty,
            first_along=empty,
            offset=empty,
            failed=np.zeros(0, bool),
        )


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class MovingContacts:
    """Candidates of a step with everything that their forces depend on; constant within the step."""

    candidates: Candidates
    properties: ContactProperties
    corner: FloatArray  # (m, 2) corner in a's frame
    start: FloatArray  # (m, 2) start of the edge in b's frame
    along: FloatArray  # (m, 2) unit direction of the edge in b's frame
    normal_stiffness: FloatArray  # (m,) per metre of thickness
    shear_stiffness: FloatArray
    tension: FloatArray  # (m,) N/m
    offset: FloatArray
    old_shear: FloatArray
    old_along: FloatArray  # nan: no shear until the contact is anchored by an accepted step
    first_along: FloatArray  # nan: not touched yet
    failed: BoolArray
    reach: FloatArray  # (m,) how far past the edge's ends the contact still bears, within this step
    touching: BoolArray
    rivals: IntArray  # (k,) candidates that have a rival
    leaning: IntArray  # (l,) candidates whose corner has an edge that leads into the other block
    lean: FloatArray  # (l, 2) that edge's unit direction from the corner, in a's frame

    @property
    def count(self) -> int:
        """Number of candidates."""
        return len(self.offset)


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Evaluation:
    """Contact forces at a position and their derivatives; evaluating changes nothing."""

    gap: FloatArray
    along: FloatArray
    tangent: FloatArray
    arm_a: FloatArray
    arm_b: FloatArray
    pressure: FloatArray
    shear: FloatArray
    bearing: BoolArray
    sticking: BoolArray
    strength: FloatArray
    by_pressure: FloatArray
    failed: BoolArray
    forces: FloatArray

    @property
    def at_strength(self) -> BoolArray:
        """Which contacts bear all the shear they can, (m,): they slip, or would under the least more."""
        full: BoolArray = self.bearing & ~(self.sticking & (np.abs(self.shear) < FULL * self.strength))
        return full


def gather_contacts(
    model: Model,
    outlines: Outlines,
    catalogue: JointCatalogue,
    history: History,
    position: FloatArray,
    band: float,
    *,
    first: bool,
) -> MovingContacts:
    """Return the contacts near a position with their history.

    At the start (`first`) all touching contacts are intact, and small overlaps of the given geometry bear nothing.
    Later ones have no cohesion, no tension and residual friction.
    """
    found = detect_contacts(outlines, position, history.active, band)
    near = TOUCHING * outlines.size
    blocks = model.blocks
    start = outlines.corners[found.edge]
    vector = outlines.corners[blocks.following[found.edge]] - start
    along = vector / np.hypot(*vector.T)[:, None]
    corner = outlines.corners[found.corner]
    cos_b, sin_b = np.cos(position[found.block_b, 2]), np.sin(position[found.block_b, 2])
    normal = np.stack([along[:, 1], -along[:, 0]], axis=1)
    turned = np.stack(
        [cos_b * normal[:, 0] - sin_b * normal[:, 1], sin_b * normal[:, 0] + cos_b * normal[:, 1]], axis=1
    )
    cos_a, sin_a = np.cos(position[found.block_a, 2]), np.sin(position[found.block_a, 2])
    arm_a = np.stack([cos_a * corner[:, 0] - sin_a * corner[:, 1], sin_a * corner[:, 0] + cos_a * corner[:, 1]], axis=1)
    arm_b = position[found.block_a, :2] + arm_a - position[found.block_b, :2]
    properties = catalogue.look_up(found.block_a, found.block_b, found.edge, found.parallel_edge, arm_a, arm_b, turned)
    source = np.where(found.history >= 0, found.history, found.inherits)
    known = source >= 0
    touching = found.in_range & (found.gap <= near)
    meeting = ~known & _meet_at_a_node(blocks, found, near)
    touching &= ~meeting
    fresh = ~known & touching
    offset, shear, anchor = np.zeros(len(source)), np.zeros(len(source)), np.full(len(source), np.nan)
    failed = np.full(len(source), not first)
    offset[known], shear[known] = history.offset[source[known]], history.shear[source[known]]
    failed[known] = history.failed[source[known]]
    anchor[known] = np.where(found.history[known] >= 0, history.along[source[known]], found.along[known])
    anchor[fresh] = found.along[fresh]
    first_along = anchor.copy()
    same = found.history >= 0
    first_along[same] = history.first_along[found.history[same]]
    overlapping = fresh & (found.gap < 0)
    offset[overlapping] = found.gap[overlapping]
    slid_on = overlapping & (not first) & _slid_on(found, band)
    offset[slid_on] = np.minimum(found.gap[slid_on] + near, 0.0)
    offset[meeting] = -near
    leaning = np.flatnonzero(found.lean >= 0)
    corner_on_corner = ~known & (found.play > 0)
    offset[corner_on_corner] = -found.play[corner_on_corner]
    return MovingContacts(
        candidates=found,
        properties=properties,
        corner=corner,
        start=start,
        along=along,
        normal_stiffness=properties.normal_stiffness * found.length,
        shear_stiffness=properties.shear_stiffness * found.length,
        tension=np.where(failed | ~(known | touching), 0.0, properties.tension * found.length),
        offset=offset,
        old_shear=shear,
        old_along=anchor,
        first_along=first_along,
        failed=failed,
        reach=np.where(touching, band, 0.0),
        touching=touching,
        rivals=np.flatnonzero(found.rival >= 0),
        leaning=leaning,
        lean=_edges_from_corners(outlines.corners, blocks.following, found.lean[leaning], found.corner[leaning]),
    )


def _slid_on(found: Candidates, band: float) -> BoolArray:
    """Return which candidates are at the end of a face that has begun to slide onto another, (m,).

    What lies behind them on the last face is pressed in as deep: they bear at once, or the block would sink on and on.
    """
    from_end = np.minimum(np.abs(found.along), np.abs(found.along - found.edge_length))
    short: BoolArray = (found.parallel_edge >= 0) & (from_end < band) & (2 * found.length < band)
    return short


def _meet_at_a_node(blocks: Blocks, found: Candidates, near: float) -> BoolArray:
    """Return which candidates are corners of a mesh's node that touch another block's corner there, (m,).

    Blocks around a node that share no face touch in a point only. While they have not moved apart or together by
    more than `near` that point bears nothing: it would stiffen a continuum of blocks that has only faces.
    """
    node, start, end = blocks.nodes[found.corner], blocks.nodes[found.edge], blocks.nodes[blocks.following[found.edge]]
    at_start = (node == start) & (np.abs(found.along) <= near)
    at_end = (node == end) & (np.abs(found.along - found.edge_length) <= near)
    meeting: BoolArray = (found.parallel_edge < 0) & (at_start | at_end)
    return meeting


def turned(vectors: FloatArray, angle: FloatArray) -> FloatArray:
    """Return vectors (k, 2) turned by angles (k,) [rad]."""
    cosine, sine = np.cos(angle), np.sin(angle)
    x, y = vectors.T
    return np.stack([cosine * x - sine * y, sine * x + cosine * y], axis=1)


def evaluate(
    contacts: MovingContacts,
    laws: tuple[JointLaw, ...],
    position: FloatArray,
    friction_pressure: FloatArray | None = None,
) -> Evaluation:
    """Return the contact forces on the blocks at a position, (n, 3), and all that the tangent needs.

    Where `friction_pressure` (m,) is given, shear strengths are those at that pressure, whatever a contact bears.
    """
    c = contacts.candidates
    gap, along, tangent, arm_a, arm_b = relative_positions(
        position, c.block_a, c.block_b, contacts.corner, contacts.start, contacts.along
    )
    pressure = -contacts.normal_stiffness * (gap - contacts.offset)
    in_range = (along >= -contacts.reach) & (along <= c.edge_length + contacts.reach)
    bearing = in_range & (pressure >= -contacts.tension) & ((pressure > 0) | (contacts.tension > 0))
    bearing &= may_bear(contacts, position, gap, tangent)
    anchored = ~np.isnan(contacts.old_along)
    moved = np.where(anchored, along - contacts.old_along, 0.0)
    trial = np.where(anchored, contacts.old_shear + contacts.shear_stiffness * moved, 0.0)
    pressure = np.where(bearing, pressure, 0.0)
    shear, by_pressure, strength = np.zeros_like(gap), np.zeros_like(gap), np.zeros_like(gap)
    sticking, failed = np.zeros(len(gap), dtype=bool), contacts.failed.copy()
    law_of = contacts.properties.law
    given = pressure if friction_pressure is None else friction_pressure
    rubbing = bearing if friction_pressure is None else in_range & (friction_pressure > 0)
    for number in np.unique(law_of[rubbing]):
        chosen = rubbing & (law_of == number)
        answer = laws[number].respond(given[chosen], trial[chosen], c.length[chosen], contacts.failed[chosen])
        shear[chosen], strength[chosen] = answer.shear, answer.strength
        sticking[chosen], failed[chosen] = answer.sticking, answer.failed
        if friction_pressure is None:
            by_pressure[chosen] = answer.by_pressure
    forces = np.zeros((len(position), 3))
    add_moving_forces(c.block_a, c.block_b, tangent, arm_a, arm_b, pressure, shear, forces)
    return Evaluation(
        gap=gap,
        along=along,
        tangent=tangent,
        arm_a=arm_a,
        arm_b=arm_b,
        pressure=pressure,
        shear=shear,
        bearing=bearing,
        sticking=sticking & anchored,
        strength=strength,
        by_pressure=by_pressure,
        failed=failed,
        forces=forces,
    )


def may_bear(contacts: MovingContacts, position: FloatArray, gap: FloatArray, tangent: FloatArray) -> BoolArray:
    """Return which candidates may bear at a position, (m,): of two ways out of a corner the nearer, and no way back."""
    allowed = np.ones(contacts.count, dtype=bool)
    allowed[contacts.rivals] = _nearer_way_out(contacts.candidates, contacts.rivals, gap)
    allowed[contacts.leaning] &= _turned_away(contacts, position, tangent)
    return allowed


def _nearer_way_out(candidates: Candidates, rows: IntArray, gap: FloatArray) -> BoolArray:
    """Return which of the rows that have a rival have more gap than it, (k,); of equal ones the first."""
    rival = candidates.rival[rows]
    nearer: BoolArray = (gap[rows] > gap[rival]) | ((gap[rows] == gap[rival]) & (rows < rival))
    return nearer


def _turned_away(contacts: MovingContacts, position: FloatArray, tangent: FloatArray) -> BoolArray:
    """Return which of the leaning rows have no edge any more that leads into the other block, (l,)."""
    edge = turned(contacts.lean, position[contacts.candidates.block_a[contacts.leaning], 2])
    t = tangent[contacts.leaning]
    away: BoolArray = edge[:, 1] * t[:, 0] - edge[:, 0] * t[:, 1] <= RULES.entrance
    return away


def _edges_from_corners(corners: FloatArray, following: IntArray, edge: IntArray, corner: IntArray) -> FloatArray:
    """Return the unit directions (l, 2) of edges at their corners, away from those."""
    vector = corners[following[edge]] - corners[edge]
    vector[edge != corner] *= -1.0
    unit: FloatArray = vector / np.hypot(*vector.T)[:, None]
    return unit


def tangent_stiffness(contacts: MovingContacts, at: Evaluation, places: IntArray, n_places: int) -> FloatArray:
    """Return the blocks of the tangent."""
    normal = np.where(at.bearing, contacts.normal_stiffness, 0.0)
    shear = np.where(at.sticking, contacts.shear_stiffness, 0.0)
    by_gap = -at.by_pressure * contacts.normal_stiffness * at.bearing
    data: FloatArray = fill_tangent(
        places, n_places, at.tangent, at.arm_a, at.arm_b, normal, by_gap, shear, at.pressure, at.shear
    )
    return data


def first_tangent(contacts: MovingContacts, at: Evaluation, places: IntArray, n_places: int) -> FloatArray:
    """Return the tangent with every touching contact closed and sticking: where a step from rest begins."""
    closed = replace(at, bearing=contacts.touching, sticking=contacts.touching, by_pressure=np.zeros_like(at.gap))
    return tangent_stiffness(contacts, closed, places, n_places)


def elastic_tangent(
    contacts: MovingContacts, at: Evaluation, places: IntArray, n_places: int, size: float
) -> FloatArray:
    """Return the stiffest tangent there can be: every contact that bears or nearly touches closed and sticking."""
    near = contacts.touching & (at.gap <= TOUCHING * size)
    closed = replace(at, bearing=at.bearing | near, sticking=at.bearing | near, by_pressure=np.zeros_like(at.gap))
    return tangent_stiffness(contacts, closed, places, n_places)


def commit(contacts: MovingContacts, at: Evaluation, position: FloatArray, size: float) -> tuple[History, int]:
    """Return what the accepted step leaves, and how many contacts changed their state for good.

    Intact contacts of the start that touch without bearing anything are kept too: they have not lost their strength.
    """
    kept = _kept(contacts, at, size)
    changed = int((at.failed & ~contacts.failed)[kept].sum())
    first_along = np.where(np.isnan(contacts.first_along), at.along, contacts.first_along)
    history = History(
        active=_active(contacts, at, position, kept),
        shear=at.shear[kept],
        along=at.along[kept],
        first_along=first_along[kept],
        offset=np.where(_still_inside(contacts, at), at.gap, contacts.offset)[kept],
        failed=at.failed[kept],
    )
    return history, changed


def recall(again: MovingContacts, before: MovingContacts, at: Evaluation, size: float) -> MovingContacts:
    """Return contacts gathered from a commit that is taken back, with what those that stay remembered before it."""
    stay = again.candidates.history >= 0
    source = _kept(before, at, size)[again.candidates.history[stay]]
    names = ("old_shear", "old_along", "first_along", "failed")
    memory = {name: getattr(again, name).copy() for name in names}
    for name in names:
        memory[name][stay] = getattr(before, name)[source]
    return replace(again, **memory)


def _kept(contacts: MovingContacts, at: Evaluation, size: float) -> IntArray:
    broken = (contacts.tension > 0) & ~at.bearing
    idle = contacts.touching & ~at.failed & (at.gap <= IDLE * size) & ~broken
    return np.flatnonzero(at.bearing | idle | _still_inside(contacts, at))


def _still_inside(contacts: MovingContacts, at: Evaluation) -> BoolArray:
    """Return which contacts were let in deep and bear nothing now, but have not come out, (m,).

    Forgotten, they could not start anew: it would be too deep.
    """
    inside: BoolArray = (contacts.candidates.history >= 0) & contacts.failed & ~at.bearing & (at.gap < 0)
    return inside & (contacts.offset < 0) & contacts.touching


def _active(contacts: MovingContacts, at: Evaluation, position: FloatArray, kept: IntArray) -> ActiveContacts:
    c = contacts.candidates
    normal = np.stack([at.tangent[:, 1], -at.tangent[:, 0]], axis=1)
    return ActiveContacts(
        pair=c.pair[kept],
        key=c.key[kept],
        pressure=np.maximum(at.pressure[kept], np.finfo(float).tiny),
        point=position[c.block_a[kept], :2] + at.arm_a[kept],
        normal=normal[kept],
    )
