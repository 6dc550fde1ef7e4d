"""Joint laws: how much shear a contact carries under its pressure, and its memory.

Laws take and return the magnitude of the shear force; its direction, a sign in the plane, stays with the contact.

A law is one small frozen class with `respond`: old state in; shear, tangent and new state out, vectorised over
contacts. It sees numbers, not the model. Evaluating it changes nothing; only an accepted step keeps a new state.
That is all that any scheme asks of a law. Limit analysis asks for `StraightLaw.strength_lines` besides. A law that has
`reduced(factor)` too is asked for itself at another strength; of one without, all shear forces are divided
(`bsm_mesh.model.strength`). One that has a `wear_length` receives how far its contacts have slid; one with `remembers`
receives the state variables of that name (`bsm_mesh/contact/state.py`).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Protocol, runtime_checkable

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray

BEYOND_STRENGTH = 1e300  # N/m: trial shear of what slips for certain; times a factor still a number


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class JointResponse:
    """Response of a joint law.

    Attributes
    ----------
    shear : (m,) float64 [N/m]
        Magnitude of the shear force; it acts in the direction of the trial one.
    by_pressure : (m,) float64
        Derivative of the magnitude by the pressure; 0 while sticking.
    strength : (m,) float64 [N/m]
        Greatest shear force at this pressure; infinite where there is no limit.
    sticking : (m,) bool
        Whether the shear force is the trial one.
    failed : (m,) bool
        New state: fallen to the residual strength. Stays true.
    """

    shear: FloatArray
    by_pressure: FloatArray
    strength: FloatArray
    sticking: BoolArray
    failed: BoolArray


class JointLaw(Protocol):
    """A law for the shear force of contacts, as every scheme uses it."""

    def respond(
        self, pressure: FloatArray, trial_shear: FloatArray, length: FloatArray, failed: BoolArray
    ) -> JointResponse:
        """Return the response of contacts.

        Contacts that do not touch have neither pressure nor trial shear: these must leave their state as it is.

        Parameters
        ----------
        pressure : (m,) float64 [N/m]
            Normal force, compression positive; negative where the contact carries tension.
        trial_shear : (m,) float64 [N/m]
            Magnitude of the shear force if the contact stuck, not negative.
        length : (m,) float64 [m]
            Length that each contact represents.
        failed : (m,) bool
            Old state.
        """


class WearingLaw(JointLaw, Protocol):
    """A law whose strength wears off with slip: its contacts remember how far they have slid.

    Attributes
    ----------
    wear_length : float or None [m]
        Slip over which strength changes markedly; None: it does not wear. Blocks that are followed slide by no more
        than an eighth of it and of their slip before laws are asked again.
    """

    @property
    def wear_length(self) -> float | None:
        """Slip over which strength changes markedly [m]; None: it does not wear."""

    def respond(
        self,
        pressure: FloatArray,
        trial_shear: FloatArray,
        length: FloatArray,
        failed: BoolArray,
        slip_path: FloatArray | None = None,
    ) -> JointResponse:
        """Return the response of contacts that have slid `slip_path` (m,) [m] so far, not at all where it is None.

        Within a step the strength is that at its start; how far a contact has slid is kept with the accepted step.
        """


def wear_length_of(law: JointLaw) -> float | None:
    """Return over which slip a law's strength changes markedly [m]; None: not with slip."""
    found: float | None = getattr(law, "wear_length", None)
    return found


def remembered_by(law: JointLaw) -> tuple[str, ...]:
    """Return the state variables of contacts that `respond` takes after `failed`, in its order.

    A law names them in `remembers`; of one without, strength wears with how far contacts have slid, or not at all.
    """
    wears = ("slip_path",) if wear_length_of(law) is not None else ()
    names: tuple[str, ...] = getattr(law, "remembers", wears)
    return names


def memory_of(law: JointLaw, contacts: Any, rows: Any = slice(None)) -> tuple[Any, ...]:
    """Return the state variables of some contacts (k,) that `respond` takes: `failed`, then those that it names."""
    return tuple(getattr(contacts, name)[rows] for name in ("failed", *remembered_by(law)))


def handed_on(law: JointLaw, wrapper: JointLaw, failed: BoolArray, memory: tuple[Any, ...]) -> tuple[Any, ...]:
    """Return the state variables that a law takes, from those of the law around it; zeros for the others."""
    known = dict(zip(remembered_by(wrapper), memory, strict=False))
    return (failed, *(known.get(name, np.zeros(len(failed))) for name in remembered_by(law)))


@runtime_checkable
class StraightLaw(JointLaw, Protocol):
    """A law whose strength is bounded by straight lines, with the further methods for limit analysis."""

    def strength_lines(self, length: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return slope [-] and intercept [N/m] of k lines for contacts that have not failed, (m, k) each.

        The shear strength at a pressure p is the least of ``intercept + slope * p``. A curved strength has tangents,
        which lie above it, and lines through points that follow each other, which lie below it between them.

        Parameters
        ----------
        length : (m,) float64 [m]
            Length that each contact represents.
        """


@runtime_checkable
class ReducibleLaw(JointLaw, Protocol):
    """A law that knows itself at another strength."""

    def reduced(self, factor: float) -> JointLaw:
        """Return the law with the tangent of every friction angle, and every cohesion, divided by a factor.

        Parameters
        ----------
        factor : float
            More than 1 weakens, less strengthens.
        """


def signed(answer: JointResponse, trial: FloatArray) -> JointResponse:
    """Return a law's answer with the signs of the trial shears (m,) in the plane: laws know magnitudes."""
    way = np.copysign(1.0, trial)
    return replace(answer, shear=way * answer.shear, by_pressure=way * answer.by_pressure)


def cut_to_strength(trial: FloatArray, strength: FloatArray, slope: FloatArray, failed: BoolArray) -> JointResponse:
    """Return the magnitude of the trial shear cut to the strength (return mapping)."""
    sticking = trial <= strength
    return JointResponse(
        shear=np.where(sticking, trial, strength),
        by_pressure=np.where(sticking, 0.0, slope),
        strength=strength,
        sticking=sticking,
        failed=failed,
    )
