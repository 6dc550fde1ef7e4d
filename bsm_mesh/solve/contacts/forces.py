"""Contacts of blocks in motion: their forces at a position by law, and the tangents of those."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields, replace

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.contact.rules import RULES
from bsm_mesh.contact.search import ContactPairs, Outlines
from bsm_mesh.model.joint_laws import JointLaw, JointResponse
from bsm_mesh.solve.contacts.force_kernels import (
    add_moving_forces,
    fill_tangent,
    pressures_and_trial_shears,
    relative_positions,
)

FULL = 1 - 1e-9  # of its strength: what a contact bears that slips
AT_ONCE = 30_000  # contacts whose response is worked out in one go
TOUCHING = 1e-3  # of the block size: a gap or overlap up to this is contact when two blocks meet


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class MovingContacts:
    """Candidates of a step with everything that their forces depend on; constant within the step."""

    outlines: Outlines  # of all blocks
    candidates: ContactPairs
    joint: IntArray  # (m,) number in ``model.joints``; -1: unjointed rock
    law: IntArray  # (m,) number in `JointCatalogue.laws`
    geometry: FloatArray  # (m, 8) where the blocks were given, as in `given_geometry`
    normal_stiffness: FloatArray  # (m,) per metre of thickness
    shear_stiffness: FloatArray
    tension: FloatArray  # (m,) N/m
    offset: FloatArray
    old_shear: FloatArray
    old_tangential: FloatArray  # nan: no shear until the contact is anchored by an accepted step
    first_tangential: FloatArray  # nan: not touched yet
    failed: BoolArray
    reach: FloatArray  # (m,) how far past the edge's ends the contact still bears, within this step
    touching: BoolArray
    opposing: IntArray  # (k,) candidates that have a rival
    entering: IntArray  # (l,) candidates whose corner has an edge that leads into the other block
    entering_direction: FloatArray  # (l, 2) that edge's unit direction from the corner, in a's frame
    by_law: tuple[tuple[int, IntArray | slice], ...]  # number of every law that is in use, and its rows

    @property
    def count(self) -> int:
        """Number of candidates."""
        return len(self.offset)

    def relative_positions(self, position: FloatArray) -> tuple[FloatArray, ...]:
        """Return gap and coordinate along the edge (m,), edge direction (m, 2), both arms to the corner (m, 2)."""
        blocks = self.candidates.block_a, self.candidates.block_b
        found: tuple[FloatArray, ...] = relative_positions(position, *blocks, self.geometry)
        return found

    def frames(self, position: FloatArray) -> tuple[FloatArray, ...]:
        """Return edge direction and both arms to the corner, (m, 2) each."""
        return self.relative_positions(position)[2:]


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Evaluation:
    """Contact forces at a position and their derivatives; evaluating changes nothing.

    Several are kept while a step is solved. So edge directions and arms, half of what there is, are not: `frames` works
    them out again where a tangent is made, in a hundredth of the time of its factorization.
    """

    position: FloatArray
    gap: FloatArray
    tangential: FloatArray
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
    """Return the contact forces on the blocks at a position (n, 3) and all that the tangent needs.

    Where `friction_pressure` (m,) is given, shear strengths are those at that pressure, whatever a contact bears.
    """
    c = contacts.candidates
    gap, tangential, *frames = contacts.relative_positions(position)
    pressure, trial, bearing, in_range = pressures_and_trial_shears(
        gap,
        tangential,
        contacts.offset,
        c.edge_length,
        contacts.reach,
        contacts.normal_stiffness,
        contacts.shear_stiffness,
        contacts.tension,
        contacts.old_tangential,
        contacts.old_shear,
    )
    if len(contacts.opposing) or len(contacts.entering):
        bearing &= may_bear(contacts, position, gap, frames[0])
        pressure[~bearing] = 0.0
    if friction_pressure is None:
        answer = respond(contacts, laws, pressure, trial, bearing)
    else:
        rubbing = in_range & (friction_pressure > 0)
        answer = respond(contacts, laws, friction_pressure, trial, rubbing)
        answer = replace(answer, by_pressure=np.zeros_like(gap))
    forces = np.zeros((len(position), 3))
    add_moving_forces(c.block_a, c.block_b, *frames, pressure, answer.shear, forces)
    return Evaluation(
        position=position,
        gap=gap,
        tangential=tangential,
        pressure=pressure,
        shear=answer.shear,
        bearing=bearing,
        sticking=answer.sticking & ~np.isnan(contacts.old_tangential),
        strength=answer.strength,
        by_pressure=answer.by_pressure,
        failed=answer.failed,
        forces=forces,
    )


def respond(
    contacts: MovingContacts,
    laws: tuple[JointLaw, ...],
    pressure: FloatArray,
    trial: FloatArray,
    rubbing: BoolArray | None = None,
) -> JointResponse:
    """Return every contact's response by its own law to pressures and trial shears (m,).

    Contacts that do not rub (m,) bear no shear. Some are asked at a time: what laws work out on the way so stays in the
    processor's cache.
    """
    pieces = [(laws[law], k) for law, rows in contacts.by_law for k in _pieces(rows, contacts.count)]
    answers = (_answer(contacts, law, k, pressure, trial, rubbing) for law, k in pieces)
    if len(pieces) == 1:
        return next(answers)
    whole = {
        field.name: np.zeros(contacts.count, bool if field.name in ("sticking", "failed") else float)
        for field in fields(JointResponse)
    }
    for (_, k), answer in zip(pieces, answers, strict=True):
        for name, values in whole.items():
            values[k] = getattr(answer, name)
    return JointResponse(**whole)


def _answer(
    contacts: MovingContacts,
    law: JointLaw,
    k: IntArray | slice,
    pressure: FloatArray,
    trial: FloatArray,
    rubbing: BoolArray | None,
) -> JointResponse:
    """Return the response of the rows k by a law; the rest as `respond` takes it."""
    length, failed = contacts.candidates.length[k], contacts.failed[k]
    if rubbing is None:
        return law.respond(pressure[k], trial[k], length, failed)
    rubs = rubbing[k]
    answer = law.respond(np.where(rubs, pressure[k], 0.0), np.where(rubs, trial[k], 0.0), length, failed)
    return replace(answer, strength=np.where(rubs, answer.strength, 0.0), sticking=answer.sticking & rubs)


def _pieces(rows: IntArray | slice, count: int) -> Iterator[IntArray | slice]:
    """Return some of the rows at a time; all of `count` where they are a slice."""
    if not isinstance(rows, slice):
        return (rows[k : k + AT_ONCE] for k in range(0, len(rows), AT_ONCE))
    return (slice(k, k + AT_ONCE) for k in range(0, count, AT_ONCE))


def slipping(contacts: MovingContacts, laws: tuple[JointLaw, ...], pressure: FloatArray) -> JointResponse:
    """Return the response where every contact slips at pressures (m,): its strength, and whether it fails by that."""
    return respond(contacts, laws, pressure, np.full_like(pressure, np.finfo(float).max / 4))


def rows_by_law(law: IntArray) -> tuple[tuple[int, IntArray | slice], ...]:
    """Return the number of every law in use, and its rows among the laws of contacts (m,)."""
    used = np.flatnonzero(np.bincount(law))  # much quicker than unique
    if len(used) == 1:
        return ((int(used[0]), slice(None)),)
    return tuple((int(number), np.flatnonzero(law == number)) for number in used)


def may_bear(contacts: MovingContacts, position: FloatArray, gap: FloatArray, tangent: FloatArray) -> BoolArray:
    """Return which candidates may bear at a position, (m,): of two ways out of a corner the nearer, and no way back."""
    allowed = np.ones(contacts.count, dtype=bool)
    allowed[contacts.opposing] = _nearer_way_out(contacts.candidates, contacts.opposing, gap)
    allowed[contacts.entering] &= _turned_away(contacts, position, tangent)
    return allowed


def _nearer_way_out(candidates: ContactPairs, rows: IntArray, gap: FloatArray) -> BoolArray:
    """Return which of the rows that have a rival have more gap than it, (k,); of equal ones the first."""
    other = candidates.opposing_candidate[rows]
    nearer: BoolArray = (gap[rows] > gap[other]) | ((gap[rows] == gap[other]) & (rows < other))
    return nearer


def _turned_away(contacts: MovingContacts, position: FloatArray, tangent: FloatArray) -> BoolArray:
    """Return which of the leaning rows have no edge any more that leads into the other block, (l,)."""
    edge = turned(contacts.entering_direction, position[contacts.candidates.block_a[contacts.entering], 2])
    t = tangent[contacts.entering]
    away: BoolArray = edge[:, 1] * t[:, 0] - edge[:, 0] * t[:, 1] <= RULES.entrance
    return away


def tangent_stiffness(
    contacts: MovingContacts, at: Evaluation, places: IntArray, n_places: int, softness: float = 0.0
) -> FloatArray:
    """Return the blocks of the tangent.

    Of their stiffness, `softness` is left to open contacts, and in shear to slipping ones. The forces out of balance
    stay exact. Where thousands of contacts change, the exact tangent lets blocks that bear on little fly off; held
    softly, more of a correction holds.
    """
    anchored = ~np.isnan(contacts.old_tangential)
    normal = np.where(at.bearing, 1.0, softness * contacts.touching) * contacts.normal_stiffness
    slip_soft = (at.bearing | contacts.touching) & anchored
    shear = np.where(at.sticking, 1.0, softness * slip_soft) * contacts.shear_stiffness
    by_gap = -at.by_pressure * contacts.normal_stiffness * at.bearing
    frames = contacts.frames(at.position)
    data: FloatArray = fill_tangent(places, n_places, *frames, normal, by_gap, shear, at.pressure, at.shear)
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
