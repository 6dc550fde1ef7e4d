"""Contact forces at a position by smoothed laws, and their tangent.

The exact laws have a kink at opening and another at slip. Smoothed by mu, every contact carries a little pressure,
forces are differentiable, and thousands of contacts may change state between two positions without cycling of Newton's
method (Chen and Mangasarian 1996, smoothing functions for complementarity).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.model.joint_laws import JointLaw
from bsm_mesh.solve.contacts.force_kernels import add_moving_forces, fill_tangent
from bsm_mesh.solve.contacts.forces import ContactSet, Evaluation, resolve_corner_corner, slipping
from bsm_mesh.solve.contacts.smoothed_kernels import smooth_pressures, smooth_shears

MIN_STIFFNESS = 1e-3  # of its own, kept in the tangent by a contact within tolerance: unloaded blocks would fly off
MIN_PRESSURE = 1e-6  # over the mean weight: less is rounding before any movement


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Smoothed(Evaluation):
    """Contact forces by smoothed laws; `rates` (5, m) are their derivatives, as `smooth_shears` returns them."""

    rates: FloatArray


def typical_mu(contacts: ContactSet, elastic: FloatArray, weight: float) -> float:
    """Return the median of pressure squared over stiffness at a position: the scale of mu [N].

    Parameters
    ----------
    contacts : MovingContacts
        The contacts.
    elastic : (n, 3) float64
        A position at which pressures have about the size of those at the solution.
    weight : float [N/m]
        The mean weight, used where no contact is closed.
    """
    stiffness = contacts.normal_stiffness
    pressure = stiffness * np.maximum(contacts.offset - contacts.relative_positions(elastic)[0], 0.0)
    pressing = pressure > MIN_PRESSURE * weight
    if pressing.any():
        return float(np.median(pressure[pressing] ** 2 / stiffness[pressing]))
    return weight**2 / float(np.median(stiffness)) if contacts.count else 1.0


def evaluate_smoothed(contacts: ContactSet, laws: tuple[JointLaw, ...], position: FloatArray, mu: float) -> Smoothed:
    """Return the contact forces on the blocks at a position (n, 3) by laws smoothed by mu [N].

    No contact fails: those that open or slip in the end do so by the exact laws.
    """
    c = contacts.candidates
    gap, tangential, *frames = contacts.relative_positions(position)
    normal, shearing, tension = contacts.normal_stiffness, contacts.shear_stiffness, contacts.tension
    pressure, closed = smooth_pressures(
        gap, tangential, contacts.offset, c.edge_length, contacts.edge_overhang, normal, tension, mu
    )
    if len(contacts.opposing) or len(contacts.entering):
        closed &= resolve_corner_corner(contacts, position, gap, frames[0])
    pressure[~closed] = 0.0
    answer = slipping(contacts, laws, pressure)
    trial = contacts.old_shear + shearing * (tangential - contacts.old_tangential)
    shear, rates = smooth_shears(
        closed, pressure, trial, answer.strength, answer.by_pressure, normal, shearing, tension, mu
    )
    forces = np.zeros((len(position), 3))
    add_moving_forces(c.block_a, c.block_b, *frames, pressure, shear, forces)
    return Smoothed(
        position=position,
        gap=gap,
        tangential=tangential,
        pressure=pressure,
        shear=shear,
        closed=closed,
        sticking=closed & (np.abs(shear) < answer.strength),
        strength=answer.strength,
        dshear_dpressure=answer.by_pressure,
        failed=contacts.failed,
        forces=forces,
        rates=rates,
    )


def smoothed_tangent(contacts: ContactSet, at: Smoothed, places: IntArray, n_places: int) -> FloatArray:
    """Return the 3 x 3 blocks of the tangent, with a minimum stiffness of every contact within tolerance."""
    least = MIN_STIFFNESS * contacts.within_tolerance
    normal = np.maximum(at.rates[0], least * contacts.normal_stiffness)
    anchored = ~np.isnan(contacts.old_tangential)
    shear = np.maximum(at.rates[2], least * anchored * contacts.shear_stiffness)
    frames = contacts.frames(at.position)
    data: FloatArray = fill_tangent(places, n_places, *frames, normal, at.rates[1], shear, at.pressure, at.shear)
    return data


def dforces_dmu(contacts: ContactSet, at: Smoothed, change: float) -> FloatArray:
    """Return the first-order change of the forces on the blocks with a change of mu, (n, 3)."""
    c, forces = contacts.candidates, np.zeros_like(at.forces)
    pressure, shear = change * at.rates[3], change * at.rates[4]
    add_moving_forces(c.block_a, c.block_b, *contacts.frames(at.position), pressure, shear, forces)
    return forces
