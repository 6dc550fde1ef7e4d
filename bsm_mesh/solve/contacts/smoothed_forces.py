"""Contacts whose laws are rounded off by a smoothing: their forces at a position, and the tangents of those.

The laws have a corner where a contact opens and another where it slips. Rounded off, every contact bears a little, the
forces follow smoothly from the position, and thousands of contacts may change their minds between two positions
without Newton's method going round in circles (Chen and Mangasarian 1996, smoothing functions for complementarity).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.model.joint_laws import JointLaw
from bsm_mesh.solve.contacts.force_kernels import add_moving_forces, fill_tangent
from bsm_mesh.solve.contacts.forces import Evaluation, MovingContacts, may_bear, slipping
from bsm_mesh.solve.contacts.smoothed_kernels import smooth_pressures, smooth_shears

LEAST_STIFFNESS = 1e-3  # of its own, in the tangent: what a touching contact keeps, or blocks that bear nothing fly off
BEARING = 1e-6  # of the mean weight: less is rounding where blocks have not moved yet


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Smoothed(Evaluation):
    """Contact forces by smoothed laws; `rates` (5, m) are their derivatives, as `smooth_shears` returns them."""

    rates: FloatArray


def typical_smoothing(contacts: MovingContacts, elastic: FloatArray, weight: float) -> float:
    """Return the median of pressure squared over stiffness at a position: what to begin with [N].

    Parameters
    ----------
    contacts : MovingContacts
        The contacts.
    elastic : (n, 3) float64
        A position at which pressures have about the size that they have at the solution.
    weight : float [N/m]
        The mean weight: what counts where no contact bears.
    """
    stiffness = contacts.normal_stiffness
    pressure = stiffness * np.maximum(contacts.offset - contacts.relative_positions(elastic)[0], 0.0)
    pressing = pressure > BEARING * weight
    if pressing.any():
        return float(np.median(pressure[pressing] ** 2 / stiffness[pressing]))
    return weight**2 / float(np.median(stiffness)) if contacts.count else 1.0


def evaluate_smoothed(
    contacts: MovingContacts, laws: tuple[JointLaw, ...], position: FloatArray, smoothing: float
) -> Smoothed:
    """Return the contact forces on the blocks at a position (n, 3) by laws with a smoothing [N].

    Contacts do not break: who would have opened or slipped in the end does so when the laws are exact again.
    """
    c = contacts.candidates
    gap, tangential, *frames = contacts.relative_positions(position)
    normal, shearing, tension = contacts.normal_stiffness, contacts.shear_stiffness, contacts.tension
    pressure, bearing = smooth_pressures(
        gap, tangential, contacts.offset, c.edge_length, contacts.reach, normal, tension, smoothing
    )
    if len(contacts.opposing) or len(contacts.entering):
        bearing &= may_bear(contacts, position, gap, frames[0])
    pressure[~bearing] = 0.0
    answer = slipping(contacts, laws, pressure)
    trial = contacts.old_shear + shearing * (tangential - contacts.old_tangential)
    shear, rates = smooth_shears(
        bearing, pressure, trial, answer.strength, answer.by_pressure, normal, shearing, tension, smoothing
    )
    forces = np.zeros((len(position), 3))
    add_moving_forces(c.block_a, c.block_b, *frames, pressure, shear, forces)
    return Smoothed(
        position=position,
        gap=gap,
        tangential=tangential,
        pressure=pressure,
        shear=shear,
        bearing=bearing,
        sticking=bearing & (np.abs(shear) < answer.strength),
        strength=answer.strength,
        by_pressure=answer.by_pressure,
        failed=contacts.failed,
        forces=forces,
        rates=rates,
    )


def smoothed_tangent(contacts: MovingContacts, at: Smoothed, places: IntArray, n_places: int) -> FloatArray:
    """Return the blocks of the tangent, every touching contact with a little of its stiffness at least."""
    least = LEAST_STIFFNESS * contacts.touching
    normal = np.maximum(at.rates[0], least * contacts.normal_stiffness)
    anchored = ~np.isnan(contacts.old_tangential)
    shear = np.maximum(at.rates[2], least * anchored * contacts.shear_stiffness)
    frames = contacts.frames(at.position)
    data: FloatArray = fill_tangent(places, n_places, *frames, normal, at.rates[1], shear, at.pressure, at.shear)
    return data


def drift(contacts: MovingContacts, at: Smoothed, change: float) -> FloatArray:
    """Return by what the forces on the blocks change with the smoothing, to first order, (n, 3)."""
    c, forces = contacts.candidates, np.zeros_like(at.forces)
    pressure, shear = change * at.rates[3], change * at.rates[4]
    add_moving_forces(c.block_a, c.block_b, *contacts.frames(at.position), pressure, shear, forces)
    return forces
