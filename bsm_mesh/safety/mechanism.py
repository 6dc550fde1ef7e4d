"""What fails: blocks, and the joints that slip or open on the way."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bsm_mesh.arrays import BoolArray, IntArray
from bsm_mesh.results.records import ContactStatus, Results
from bsm_mesh.safety.driver import Found

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


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Mechanism:
    """How a model fails.

    Attributes
    ----------
    value : float
        The value at which it was seen.
    blocks : (k,) int32
        Blocks that fail.
    area : float [m2]
        Their area.
    part : float
        Their part of the area of all blocks.
    centre : (float, float) [m]
        Their common centroid, where they were given.
    joints : tuple of JointState
        How the joints are used just before, at the last stable value; none where no value was stable.
    """

    value: float
    blocks: IntArray
    area: float
    part: float
    centre: tuple[float, float]
    joints: tuple[JointState, ...]


def mechanism_of(found: Found) -> Mechanism | None:
    """Return what fails at the first unstable value."""
    value = found.bracket.unstable
    if value is None or value not in found.states:
        return None
    trial = next(trial for trial in found.trials if trial.value == value)
    results, last = found.states[value], found.states.get(found.bracket.stable or 0.0)
    stage, moments = results.stages[-1], results.blocks.moments
    area = moments.area[trial.blocks]
    centre = np.average(moments.centroid[trial.blocks], axis=0, weights=area) if len(area) else np.zeros(2)
    return Mechanism(
        value=value,
        blocks=trial.blocks,
        area=float(area.sum()),
        part=float(area.sum() / moments.area[stage.present].sum()),
        centre=(float(centre[0]), float(centre[1])),
        joints=() if last is None else joint_states(last),
    )


def joint_states(results: Results) -> tuple[JointState, ...]:
    """Return how every joint is used at the end of the last stage; faces without a joint come last."""
    contacts = results.stages[-1].contacts

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
