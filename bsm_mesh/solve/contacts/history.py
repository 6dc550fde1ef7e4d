"""What contacts remember of accepted steps: committed by a step, or recalled from before it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.contact.search import ActiveContacts
from bsm_mesh.solve.contacts.forces import Evaluation, MovingContacts

IDLE = 1e-6  # of the block size: an intact contact open by less has not been parted


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class History:
    """What contacts that bear force carry from step to step.

    Attributes
    ----------
    active : ActiveContacts
        Who they are and where, sorted by pair.
    shear : (k,) float64 [N/m]
        Shear force.
    tangential : (k,) float64 [m]
        Coordinate along the edge at which it had that shear force.
    first_tangential : (k,) float64 [m]
        Coordinate at which it first touched.
    offset : (k,) float64 [m]
        Gap at which the contact bears nothing.
    failed : (k,) bool
        Asperities sheared off, cohesion and tension lost; true for contacts that arose after the start.
    """

    active: ActiveContacts
    shear: FloatArray
    tangential: FloatArray
    first_tangential: FloatArray
    offset: FloatArray
    failed: BoolArray

    @classmethod
    def none(cls) -> History:
        """Return the empty history of the start."""
        empty = np.zeros(0)
        return cls(
            active=ActiveContacts.none(),
            shear=empty,
            tangential=empty,
            first_tangential=empty,
            offset=empty,
            failed=np.zeros(0, bool),
        )


def commit(contacts: MovingContacts, at: Evaluation, position: FloatArray, size: float) -> tuple[History, int]:
    """Return what the accepted step leaves, and how many contacts changed their state for good.

    Intact contacts of the start that touch without bearing anything are kept too: they have not lost their strength.
    """
    kept = _kept(contacts, at, size)
    changed = int((at.failed & ~contacts.failed)[kept].sum())
    first_tangential = np.where(np.isnan(contacts.first_tangential), at.tangential, contacts.first_tangential)
    history = History(
        active=_active(contacts, at, position, kept),
        shear=at.shear[kept],
        tangential=at.tangential[kept],
        first_tangential=first_tangential[kept],
        offset=np.where(_still_inside(contacts, at), at.gap, contacts.offset)[kept],
        failed=at.failed[kept],
    )
    return history, changed


def recall(again: MovingContacts, before: MovingContacts, at: Evaluation, size: float) -> MovingContacts:
    """Return contacts gathered from a commit that is taken back, with what those that stay remembered before it."""
    stay = again.candidates.history >= 0
    source = _kept(before, at, size)[again.candidates.history[stay]]
    names = ("old_shear", "old_tangential", "first_tangential", "failed")
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
    tangent, arm_a = (vectors[kept] for vectors in contacts.frames(at.position)[:2])
    return ActiveContacts(
        pair=c.pair[kept],
        key=c.key[kept],
        pressure=np.maximum(at.pressure[kept], np.finfo(float).tiny),
        point=contacts.outlines.placed(position)[c.block_a[kept], :2] + arm_a,
        normal=np.stack([tangent[:, 1], -tangent[:, 0]], axis=1),
    )
