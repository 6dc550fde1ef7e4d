"""How joints are used: the length that is in contact, slips, or is open."""

from __future__ import annotations

from dataclasses import dataclass

from bsm_mesh.arrays import BoolArray
from bsm_mesh.results.records import ContactStatus, Results, StageResult

NO_JOINT = "faces without a joint"


@dataclass(frozen=True, slots=True, kw_only=True)
class JointState:
    """How a joint is used.

    Attributes
    ----------
    joint : str
        Its name.
    length : float [m]
        Length of its faces in contact.
    slipping, opened : float [m]
        Length of them that is at its strength, and that has opened.
    """

    joint: str
    length: float
    slipping: float
    opened: float


def joint_states(results: Results, stage: StageResult) -> tuple[JointState, ...]:
    """Return how every joint is used at the end of a stage; faces without a joint come last."""
    contacts = stage.contacts

    def length(chosen: BoolArray) -> float:
        return float(contacts.length[chosen].sum())

    states = []
    for number in [*range(len(results.joint_names)), -1]:
        mine = contacts.joint == number
        if mine.any():
            name = results.joint_names[number] if number >= 0 else NO_JOINT
            slipping, opened = (mine & (contacts.status == s) for s in (ContactStatus.SLIPPING, ContactStatus.OPEN))
            states.append(JointState(joint=name, length=length(mine), slipping=length(slipping), opened=length(opened)))
    return tuple(states)
