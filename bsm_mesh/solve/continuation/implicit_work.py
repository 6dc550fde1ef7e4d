"""Dashpots of contacts in an implicit time step, and the work of its forces."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray
from bsm_mesh.contact.forces import ContactSet, Evaluation
from bsm_mesh.contact.history import further_slip
from bsm_mesh.solve.motion.shaking_memory import SUMS
from bsm_mesh.solve.step.system import System


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Instant:
    """The state at the begin or the end of a time step.

    Attributes
    ----------
    position, velocity : (n, 3) float64 [m, m, rad], [m/s, m/s, rad/s]
        Of the blocks; relative to the base.
    contacts : ContactSet
        With their failures so far.
    at : Evaluation
        Their forces without dashpots.
    dashpots : (n, 3) float64 [N/m, N/m, N]
        Forces of contacts' dashpots on the blocks.
    push : (n, 3) float64 [N/m, N/m, N]
        Mean force of the base's acceleration in the time step.
    length : float [s]
        Of the time step.
    """

    position: FloatArray
    velocity: FloatArray
    contacts: ContactSet
    at: Evaluation
    dashpots: FloatArray
    push: FloatArray
    length: float


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class StepWork:
    """The work of a time step.

    Attributes
    ----------
    sums : (7,) float64 [N]
        By `SUMS`.
    slip : (m,) float64 [N]
        What slip took at every contact.
    """

    sums: FloatArray
    slip: FloatArray

    @property
    def balance(self) -> float:
        """Energy [N] that must be found as movement or in springs of contacts."""
        return float(self.sums[0] + self.sums[1] - self.sums[2:].sum())


def restless_contact(ends: tuple[Instant, Instant]) -> int | None:
    """Return the contact whose force changed most in a time step, among those that open, close, stick or slip there.

    The change is that of the energy of its springs; None without contacts.
    """
    now, then = (one.at for one in ends)
    contacts = ends[1].contacts
    change = np.zeros(contacts.count)
    for name, stiffness in (("pressure", contacts.normal_stiffness), ("shear", contacts.shear_stiffness)):
        change += np.nan_to_num(getattr(then, name) - getattr(now, name)) ** 2 / np.where(stiffness > 0, stiffness, 1.0)
    switches = (now.closed != then.closed) | (now.sticking != then.sticking)
    return int((change * switches if switches.any() else change).argmax()) if len(change) else None


def damped_contacts(contacts: ContactSet, at: Evaluation, dashpot: FloatArray, length: float) -> ContactSet:
    """Return contacts with dashpots across and along the face in a time step.

    A dashpot c and a spring k over a time step h are one spring ``k + c / h`` from another gap at zero pressure. Along
    the face the ratio c / k is the same. Contacts that are open at the begin have none: they begin in an impact.

    Parameters
    ----------
    contacts : ContactSet
        At the begin, with linear springs.
    at : Evaluation
        Their forces there.
    dashpot : (m,) float64 [N s/m2]
        Across the face.
    length : float [s]
        Of the time step.
    """
    stiffness = contacts.normal_stiffness
    lag = np.where(at.closed & (stiffness > 0), dashpot / np.where(stiffness > 0, stiffness, 1.0) / length, 0.0)
    return replace(
        contacts,
        normal_stiffness=stiffness * (1 + lag),
        shear_stiffness=contacts.shear_stiffness * (1 + lag),
        offset=np.where(lag > 0, (contacts.offset + lag * at.gap) / (1 + lag), contacts.offset),
    )


def failed_contacts(contacts: ContactSet, failing: BoolArray) -> ContactSet:
    """Return contacts of which some more (m,) have failed."""
    left = np.where(contacts.mated, np.minimum(contacts.tension, contacts.residual_tension), 0.0)
    tension = np.where(failing, left, contacts.tension)
    return replace(contacts, failed=contacts.failed | failing, tension=tension)


def work_of(system: System, ends: tuple[Instant, Instant], drag: FloatArray) -> StepWork:
    """Return the work of a time step between two instants.

    Forces that act all the time do work by the trapezoidal rule, as the integrator takes them. Slip does that of the
    strengths at both ends, not of the shear forces. Where a contact sticks for a part of the time step, the difference
    is found in the balance.

    Parameters
    ----------
    system : System
        The blocks.
    ends : Instant, Instant
        Begin and end.
    drag : (n, 3) float64 [kg/(m s), kg/(m s), kg m/s]
        Of mass damping: force over velocity.
    """
    now, then = ends
    moved, mean = then.position - now.position, (now.velocity + then.velocity) / 2
    found = dict.fromkeys(SUMS, 0.0)
    found["input"] = float((then.push * moved).sum())
    found["loads"] = float(((system.loads_at(now.position) + system.loads_at(then.position)) * moved).sum()) / 2
    if len(system.bolts.alive):
        forces = [system.bolts.evaluate(one.position).forces for one in ends]
        found["bolts"] = -float(((forces[0] + forces[1]) * moved).sum()) / 2
    slip = _slip_work(then.contacts, now.at, then.at)
    found["slip"] = float(slip.sum())
    found["dashpots"] = -float(((now.dashpots + then.dashpots) * moved).sum()) / 2
    found["mass_damping"] = then.length * float((drag * mean**2).sum())
    return StepWork(sums=np.array([found[name] for name in SUMS]), slip=slip)


def _slip_work(contacts: ContactSet, now: Evaluation, then: Evaluation) -> FloatArray:
    """Return what slip, softer springs and broken bonds take of every contact in a time step, (m,) [N]."""
    slides = then.closed & ~then.sticking
    further = further_slip(contacts, then.springs, slides, then.shear, then.tangential)
    work: FloatArray = (np.where(now.closed, now.strength, then.strength) + then.strength) / 2 * further
    before, after = now.springs.stiffness, then.springs.stiffness
    opened = now.closed & ~then.closed & (before > 0)
    moved = np.nan_to_num(then.tangential - now.tangential)
    # The strength falls to nothing as a contact opens; its shear force does work on the way.
    work[opened] += now.shear[opened] ** 2 / (2 * before[opened]) + (now.shear * moved)[opened] / 2
    broken = now.closed & ~then.closed & (now.pressure < 0)
    work[broken] += now.pressure[broken] ** 2 / (2 * contacts.normal_stiffness[broken])
    softer = now.closed & then.closed & (before != after) & (before > 0) & (after > 0)
    if softer.any():  # shear springs grow and shrink with the pressure
        shear, left = now.shear[softer], then.springs.old_shear[softer]
        work[softer] += shear**2 / (2 * before[softer]) - left**2 / (2 * after[softer])
        work[softer] += (shear - left) / 2 * moved[softer]
    slip_path = contacts.after_slip(further)["slip_path"]
    opening = contacts.features.opened(contacts.offset, contacts.slip_path, slip_path) - contacts.offset
    work -= (now.pressure + then.pressure) / 2 * opening
    return work
