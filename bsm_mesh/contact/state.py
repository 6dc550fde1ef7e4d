"""State variables of contacts: an accepted step hands them to the next, a stage to the stage after it.

A new one is a field here, and `model/law_faults.py` lists it. Steps, windows of explicit motion, stages, subdomains
and checkpoints carry every field; a law that depends on it names it in `remembers` (`model/joint_laws/law.py`). Points
in space and in zones have histories of their own (`three_d/contacts/history.py`, `solve/zones/joint_history.py`).
"""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray

_Value = TypeVar("_Value", bound=np.generic)
ARISES = "arises"  # metadata of a field: its value in a contact that arises; without, `gather_contacts` works it out


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class ContactState:
    """State variables of contacts, one row each.

    Attributes
    ----------
    offset : (m,) float64 [m]
        Gap at zero pressure.
    first_tangential : (m,) float64 [m]
        Tangential coordinate at first contact; nan: not closed yet.
    failed : (m,) bool
        Asperities sheared off, cohesion and tension lost; true for contacts that arose after the start.
    mated : (m,) bool
        Closed since the start: the joint's walls fit together, and it closes by its hyperbola.
    slip_path : (m,) float64 [m]
        How far each has slid since it closed, back and forth, elastic part apart.
    """

    offset: FloatArray
    first_tangential: FloatArray
    failed: BoolArray
    mated: BoolArray
    slip_path: FloatArray = field(metadata={ARISES: 0.0})

    def after_slip(self, further: FloatArray) -> dict[str, FloatArray]:
        """Return the state variables that slip changes, after a further slip of contacts (m,) [m]."""
        return {"slip_path": self.slip_path + further}


STATE = tuple(each.name for each in fields(ContactState))


def state_of(contacts: ContactState, rows: IntArray) -> dict[str, Any]:
    """Return all state variables of some contacts (k,)."""
    return {name: getattr(contacts, name)[rows] for name in STATE}


def remembered(kept: NDArray[_Value], source: IntArray, arising: NDArray[_Value]) -> NDArray[_Value]:
    """Return a state variable of contacts (m,): that of row `source` of the history, below 0 as contacts arise."""
    known = source >= 0
    if not known.any():  # zeros that nothing is written to take no memory
        return arising
    found = arising.copy()
    found[known] = kept[source[known]]
    return found


def plainly_remembered(history: ContactState, source: IntArray) -> dict[str, Any]:
    """Return the state variables of contacts (m,) that arise with one value, whatever the contact."""
    arising = {each.name: each.metadata[ARISES] for each in fields(ContactState) if ARISES in each.metadata}
    return {
        name: remembered(getattr(history, name), source, np.full(len(source), value)) for name, value in arising.items()
    }
