"""Contact history: state variables of the contacts, committed by an accepted step or restored from before it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.contact.feature import Springs
from bsm_mesh.contact.forces import ContactSet, Evaluation
from bsm_mesh.contact.rules import CONTACT_TOLERANCE, RULES
from bsm_mesh.contact.search import ActiveContacts
from bsm_mesh.contact.state import STATE, ContactState, state_of

LEAST = float(np.finfo(float).tiny)  # pressure of a contact that presses


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class History(ContactState):
    """The contacts that continue from step to step: their state variables, and where they are.

    Attributes
    ----------
    active : ActiveContacts
        Their pairs and positions, sorted by pair.
    shear : (k,) float64 [N/m]
        Shear force.
    tangential : (k,) float64 [m]
        Tangential coordinate of that shear force.
    length : (k,) float64 [m]
        Length that each represents.
    parallel_edges : (k,) int8
        Edges at its corner that this was shared with: the most since it closed.
    joint : (k,) int32
        Number of the joint that it is in; -1 for unjointed rock.
    """

    active: ActiveContacts
    shear: FloatArray
    tangential: FloatArray
    length: FloatArray
    parallel_edges: IntArray
    joint: IntArray

    @classmethod
    def none(cls) -> History:
        """Return the empty history of the start."""
        empty, flags = np.zeros(0), np.zeros(0, bool)
        state: dict[str, Any] = dict.fromkeys(STATE, empty)
        return cls(
            active=ActiveContacts.none(),
            shear=empty,
            tangential=empty,
            length=empty,
            parallel_edges=np.zeros(0, np.int8),
            joint=np.zeros(0, np.int32),
            **state | {"failed": flags, "mated": flags},
        )


def commit(contacts: ContactSet, at: Evaluation, position: FloatArray, size: float) -> tuple[History, int]:
    """Return the history after an accepted step, and the number of contacts that failed in it.

    Intact contacts of the start that touch without force are kept too: they have not lost their strength. Of open ones
    that in-situ stress had closed the offset is kept near where they opened, so that they close there.
    """
    kept, is_open = _kept(contacts, at, size)
    changed = int((at.failed & ~contacts.failed)[kept][~is_open].sum())
    first_tangential = np.where(np.isnan(contacts.first_tangential), at.tangential, contacts.first_tangential)
    state = state_of(contacts, kept) | {name: values[kept] for name, values in _after_step(contacts, at).items()}
    offset = np.where(_still_overlapping(contacts, at)[kept], at.gap[kept], state["offset"])
    state["offset"] = np.where(is_open, contacts.features.once_open(contacts.offset, contacts.slip_path)[kept], offset)
    pressure = np.where(is_open, 0.0, np.maximum(at.pressure[kept], LEAST))
    history = History(
        active=active_contacts(contacts, at, position, kept, pressure),
        shear=at.shear[kept],
        tangential=at.tangential[kept],
        length=contacts.candidates.length[kept],
        parallel_edges=contacts.candidates.parallel_edges[kept],
        joint=contacts.joint[kept],
        **state | {"first_tangential": first_tangential[kept]},
    )
    return history, changed


def further_slip(
    contacts: ContactSet, springs: Springs, slides: BoolArray, shear: FloatArray, tangential: FloatArray
) -> FloatArray:
    """Return the further slip of contacts, (m,) [m]: the movement along the edge that is not elastic.

    Of those that slide (m,), from the start of a step or window to a shear force (m,) [N/m] at a tangential coordinate
    (m,) [m]; without a coordinate before or after it is 0.
    """
    moved = tangential - contacts.old_tangential
    slides = slides & ~np.isnan(moved) & (springs.stiffness > 0)
    elastic = (shear - springs.old_shear)[slides] / springs.stiffness[slides]
    further = np.zeros(contacts.count)
    further[slides] = np.abs(moved[slides] - elastic)
    return further


def _after_step(contacts: ContactSet, at: Evaluation) -> dict[str, Any]:
    """Return the state variables that an accepted step changes, (m,) each."""
    slid = further_slip(contacts, at.springs, at.closed & ~at.sticking, at.shear, at.tangential)
    return contacts.after_slip(slid) | {"failed": at.failed}


def worn(contacts: ContactSet, at: Evaluation) -> ContactSet:
    """Return contacts as slip in an accepted step has left them: where strength wore off their shear is cut."""
    closed = at.closed & ~np.isnan(at.tangential)
    return replace(
        contacts,
        old_shear=np.where(closed, at.shear, contacts.old_shear),
        old_pressure=np.where(closed, at.pressure, contacts.old_pressure),
        old_tangential=np.where(closed, at.tangential, contacts.old_tangential),
        **_after_step(contacts, at),
    )


def restore_history(again: ContactSet, before: ContactSet, at: Evaluation, size: float) -> ContactSet:
    """Return updated contacts with the state variables that continuing ones had before a provisional commit."""
    stay = again.candidates.history >= 0
    source = _kept(before, at, size)[0][again.candidates.history[stay]]
    # Offset and mated are those that the search has found anew.
    names = {"old_shear", "old_pressure", "old_tangential", *STATE}.difference(("offset", "mated"))
    memory = {name: getattr(again, name).copy() for name in names}
    for name in names:
        memory[name][stay] = getattr(before, name)[source]
    memory["failed"][stay] |= again.joint[stay] != before.joint[source]
    # What slip opened in the provisional step it has not yet.
    offset = again.features.opened(again.offset, again.slip_path, memory["slip_path"])
    return replace(again, offset=offset, **memory)


def _kept(contacts: ContactSet, at: Evaluation, size: float) -> tuple[IntArray, BoolArray]:
    """Return the rows of contacts that have a history, (k,), and which of them are open and keep their offset alone.

    These are open no more than two blocks may be apart when they meet. Walls that moved away from each other are as
    given.
    """
    broken = (contacts.tension > 0) & ~at.closed
    idle = contacts.within_tolerance & ~at.failed & (at.gap <= RULES.rounding * size) & ~broken
    lasting = at.closed | idle | _still_overlapping(contacts, at)
    offset = contacts.features.once_open(contacts.offset, contacts.slip_path)
    beside = (offset > 0) & (at.gap <= offset + CONTACT_TOLERANCE * size)
    kept = np.flatnonzero(lasting | beside)
    return kept, ~lasting[kept]


def _still_overlapping(contacts: ContactSet, at: Evaluation) -> BoolArray:
    """Return which contacts started with a penetration and are open now, but still overlap, (m,).

    Without history they could not start again: their penetration would be too large.
    """
    inside: BoolArray = (contacts.candidates.history >= 0) & contacts.failed & ~at.closed & (at.gap < 0)
    return inside & (contacts.offset < 0) & contacts.within_tolerance


def active_contacts(
    contacts: ContactSet, at: Evaluation, position: FloatArray, kept: IntArray, pressure: FloatArray
) -> ActiveContacts:
    """Return the contacts `kept` (k,) with their pressures (k,) [N/m], where they are at a position."""
    c = contacts.candidates
    tangent, arm_a = (vectors[kept] for vectors in contacts.frames(at.position)[:2])
    return ActiveContacts(
        pair=c.pair[kept],
        key=c.key[kept],
        pressure=pressure,
        point=contacts.outlines.placed(position)[c.block_a[kept], :2] + arm_a,
        normal=np.stack([tangent[:, 1], -tangent[:, 0]], axis=1),
    )
