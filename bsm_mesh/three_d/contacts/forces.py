"""Contact forces at a position by the exact laws, their rest after an accepted step, and their tangents."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from bsm_mesh.arrays import ROUNDING, BoolArray, FloatArray, IntArray
from bsm_mesh.contact.feature import Movement, Springs
from bsm_mesh.contact.forces import pressures_of, respond, strength_of
from bsm_mesh.contact.rules import CONTACT_TOLERANCE, RULES
from bsm_mesh.model.joint_laws import JointLaw
from bsm_mesh.three_d.contacts.contact_set import ContactSet
from bsm_mesh.three_d.contacts.history import PointHistory
from bsm_mesh.three_d.contacts.kernels import add_forces, fill_tangent


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Evaluation:
    """Contact forces at a position and their derivatives; evaluating changes no state."""

    position: FloatArray
    place: FloatArray  # (m, 3) movement of the points against their faces
    gap: FloatArray
    on_polygon: BoolArray
    pressure: FloatArray
    shear: FloatArray  # (m, 3) on a, in b's frame
    trial: FloatArray  # (m,) magnitude of the shear force if it stuck
    normal_stiffness: FloatArray  # derivative of the pressure by the closure
    closed: BoolArray
    sticking: BoolArray
    strength: FloatArray
    dshear_dpressure: FloatArray  # of the magnitude
    failed: BoolArray
    forces: FloatArray
    slip: FloatArray  # (h,) of the dilating contacts in this step [m], not negative

    @property
    def size(self) -> FloatArray:
        """Magnitude of the shear force, (m,) [N]."""
        size: FloatArray = np.linalg.norm(self.shear, axis=1)
        return size

    @property
    def bears(self) -> BoolArray:
        """Which contacts bear more than rounding of the greatest force, (m,)."""
        force = np.maximum(np.abs(self.pressure), self.size)
        more: BoolArray = self.closed & (force > ROUNDING * force.max(initial=0.0))
        return more

    @property
    def at_strength(self) -> BoolArray:
        """Which contacts carry their full shear strength, (m,): they slip, or are about to."""
        full: BoolArray = self.bears & ~(self.sticking & (self.size < (1 - ROUNDING) * self.strength))
        return full


class PointMovement(Movement):
    """Contact points at a position in a step: `along` (m,) [N] is the magnitude of the shear force if they stuck."""

    __slots__ = ()

    def trial(self, rows: IntArray, springs: Springs) -> FloatArray:
        """Return the shear force of some contacts if they stuck, (h,) [N]."""
        trial: FloatArray = self.along[rows]
        return trial


def evaluate(contacts: ContactSet, laws: tuple[JointLaw, ...], position: FloatArray) -> Evaluation:
    """Return the contact forces on the blocks at a position (n, 6) and their derivatives."""
    swing, place, arm_a, arm_b = contacts.frames(position)
    gap, tangential = contacts.gaps(place), contacts.along(place)
    on_polygon = np.linalg.norm(tangential, axis=1) <= contacts.reach
    trial = trial_shears(contacts, place)
    size = np.linalg.norm(trial, axis=1)
    here = PointMovement(contacts, gap, size, partial(pressures_of, contacts), partial(strength_of, contacts, laws))
    slip, offset, springs = gap[:0], contacts.offset, Springs(contacts.shear_stiffness, size, gap[:0], gap[:0])
    for feature in contacts.features:
        slip, offset = feature.slips(slip, offset, springs, here)
    pressing = contacts.normal_stiffness * (offset - gap)
    closed = on_polygon & (pressing >= -contacts.tension) & ((pressing > 0) | (contacts.tension > 0))
    pressure = np.where(closed, pressing, 0.0)
    pressure, stiffness = contacts.features.pressures(offset - gap, pressure, contacts.normal_stiffness)
    answer = respond(contacts, laws, pressure, size, closed)
    part = np.divide(answer.shear, size, out=np.zeros_like(size), where=size > 0)
    shear = part[:, None] * trial
    c, forces = contacts.candidates, np.zeros_like(position)
    add_forces(c.block_a, c.block_b, swing, arm_a, arm_b, contacts.geometry, pressure, shear, forces)
    return Evaluation(
        position=position,
        place=place,
        gap=gap,
        on_polygon=on_polygon,
        pressure=pressure,
        shear=shear,
        trial=size,
        normal_stiffness=stiffness,
        closed=closed,
        sticking=answer.sticking & ~np.isnan(contacts.old_place[:, 0]),
        strength=answer.strength,
        dshear_dpressure=answer.by_pressure,
        failed=answer.failed,
        forces=forces,
        slip=slip,
    )


def trial_shears(contacts: ContactSet, place: FloatArray) -> FloatArray:
    """Return the shear forces (m, 3) [N] if contacts stuck, at movements against the faces (m, 3)."""
    moved = contacts.along(place - contacts.old_place)
    trial: FloatArray = contacts.old_shear - contacts.shear_stiffness[:, None] * moved
    return np.where(np.isnan(trial), 0.0, trial)


def commit(contacts: ContactSet, at: Evaluation, size: float) -> tuple[PointHistory, int]:
    """Return the history after an accepted step, and the number of contacts that failed in it.

    Intact points that touch without force keep their strength; those that have opened are as new ones.
    """
    broken = (contacts.tension > 0) & ~at.closed
    idle = contacts.within_tolerance & ~at.failed & (at.gap <= contacts.offset + RULES.rounding * size) & ~broken
    stays = at.closed | (idle & at.on_polygon)
    changed = int((at.failed & ~contacts.failed & stays).sum())
    c, kept = contacts.candidates, stays[:, None]
    first = np.where(np.isnan(contacts.first_place), at.place, contacts.first_place)
    slid = slip_path_after(contacts, at)
    opened = contacts.features.opened(contacts.offset, contacts.slip_path, slid)
    history = PointHistory(
        key=contacts.key,
        block_a=c.block_a,
        block_b=c.block_b,
        closed=stays,
        shear=np.where(kept, at.shear, 0.0),
        place=at.place,
        first_place=first,
        offset=np.where(stays, opened, contacts.features.once_open(contacts.offset, contacts.slip_path)),
        failed=at.failed | ~stays,
        mated=contacts.mated & stays,
        slip_path=slid,
        renewed=contacts.renewed,
    )
    return history, changed


def slip_path_after(contacts: ContactSet, at: Evaluation) -> FloatArray:
    """Return how far contacts have slid so far, (m,) [m]: what of their movement is not elastic."""
    moved = contacts.along(at.place - contacts.old_place)
    slides = at.closed & ~at.sticking & ~np.isnan(moved[:, 0]) & (contacts.shear_stiffness > 0)
    elastic = (contacts.old_shear - at.shear)[slides] / contacts.shear_stiffness[slides, None]
    path = contacts.slip_path.copy()
    path[slides] += np.linalg.norm(moved[slides] - elastic, axis=1)
    return path


def worn(contacts: ContactSet, at: Evaluation) -> ContactSet:
    """Return contacts as slip in an accepted step has left them: where strength wore off their shear is cut."""
    closed, slid = at.closed[:, None], slip_path_after(contacts, at)
    return replace(
        contacts,
        old_shear=np.where(closed, at.shear, contacts.old_shear),
        old_place=np.where(closed, at.place, contacts.old_place),
        failed=at.failed,
        slip_path=slid,
        offset=contacts.features.opened(contacts.offset, contacts.slip_path, slid),
    )


def updated(contacts: ContactSet, at: Evaluation, size: float) -> ContactSet:
    """Return the contacts as a search within a step finds them: points that came near have a shear force from here."""
    within_tolerance = at.closed | ((at.gap <= contacts.offset + CONTACT_TOLERANCE * size) & at.on_polygon)
    fresh = within_tolerance & np.isnan(contacts.old_place[:, 0])
    place = np.where(fresh[:, None], at.place, contacts.old_place)
    return replace(contacts, within_tolerance=within_tolerance, old_place=place)


def tangent_stiffness(
    contacts: ContactSet, at: Evaluation, places: IntArray, n_places: int, regularization: float = 0.0
) -> FloatArray:
    """Return the 6 x 6 blocks of the contacts' tangent, regularised as in the plane."""
    anchored = ~np.isnan(contacts.old_place[:, 0])
    normal = np.where(at.closed, 1.0, regularization * contacts.within_tolerance) * at.normal_stiffness
    may_slip = (at.closed | contacts.within_tolerance) & anchored
    left = regularization * may_slip * contacts.shear_stiffness
    slides = at.closed & ~at.sticking & (at.trial > 0)
    size = at.size
    across = np.where(at.sticking, contacts.shear_stiffness, left)
    turning = np.divide(size, at.trial, out=np.zeros_like(size), where=slides) * contacts.shear_stiffness
    across = np.where(slides, np.maximum(turning, left), across)
    along = np.where(slides, left, across)
    opening = np.zeros_like(size)
    if len(at.slip):
        dilating = contacts.features.dilating
        opens, softer = dilating.softening(at, contacts.slip_path, contacts.shear_stiffness)
        rows = dilating.rows[opens]
        normal[rows] *= softer
        opening[rows] = dilating.slope[opens] * normal[rows]
        along = along + at.dshear_dpressure * opening
    coupled = np.where(slides, at.dshear_dpressure * normal, 0.0)
    way = np.divide(at.shear, size[:, None], out=np.zeros_like(at.shear), where=(slides & (size > 0))[:, None])
    swing, _, arm_a, arm_b = contacts.frames(at.position)
    stiffness = np.stack([normal, across, along, coupled, opening], axis=1)
    given = contacts.candidates.block_b, swing, arm_a, arm_b, contacts.geometry
    data: FloatArray = fill_tangent(places, n_places, *given, stiffness, way, at.pressure, at.shear)
    return data


def sticking(contacts: ContactSet, at: Evaluation, closed: BoolArray) -> Evaluation:
    """Return an evaluation as if some contacts (m,) were closed and stuck."""
    return replace(at, closed=closed, sticking=closed, dshear_dpressure=np.zeros_like(at.gap), slip=at.slip[:0])


def elastic_contacts(contacts: ContactSet, at: Evaluation, size: float) -> BoolArray:
    """Return which contacts count in the stiffest possible tangent, (m,): closed ones and those within tolerance."""
    near: BoolArray = contacts.within_tolerance & (at.gap <= contacts.offset + CONTACT_TOLERANCE * size)
    return at.closed | near
