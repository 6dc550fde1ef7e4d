"""Tangents of the contact forces: consistent, regularised, and elastic."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.contact.feature import Tangent
from bsm_mesh.contact.force_kernels import fill_tangent
from bsm_mesh.contact.forces import ContactSet, Evaluation
from bsm_mesh.contact.rules import CONTACT_TOLERANCE


def tangent_stiffness(
    contacts: ContactSet, at: Evaluation, places: IntArray, n_places: int, regularization: float = 0.0
) -> FloatArray:
    """Return the 3 x 3 blocks of the contacts' tangent, regularised.

    A part `regularization` of their stiffness is left to open contacts, and in shear to slipping ones; the residual
    stays exact. Where thousands of contacts change, the exact tangent is nearly singular for blocks with few closed
    contacts, and corrections have to be shortened.
    """
    anchored = ~np.isnan(contacts.old_tangential)
    normal = np.where(at.closed, 1.0, regularization * contacts.within_tolerance) * at.normal_stiffness
    may_slip = (at.closed | contacts.within_tolerance) & anchored
    shear = np.where(at.sticking, 1.0, regularization * may_slip) * at.springs.stiffness
    by_gap = -at.dshear_dpressure * at.normal_stiffness * at.closed
    if len(at.springs.trial_by_closure):
        by_gap -= np.where(at.closed & at.sticking, at.springs.trial_by_closure, 0.0)
    found = Tangent(normal, by_gap, shear, at.gap[:0])
    for feature in contacts.features:
        found = feature.tangent(found, at, contacts.slip_path)
    *by, by_along = found
    frames = contacts.frames(at.position)
    data: FloatArray = fill_tangent(places, n_places, *frames, *by, at.pressure, at.shear, by_along)
    return data


def first_tangent(contacts: ContactSet, at: Evaluation, places: IntArray, n_places: int) -> FloatArray:
    """Return the elastic tangent of a step from rest: every contact within tolerance closed and sticking."""
    all_closed = contacts.within_tolerance
    return tangent_stiffness(contacts, _sticking(contacts, at, all_closed), places, n_places)


def elastic_tangent(contacts: ContactSet, at: Evaluation, places: IntArray, n_places: int, size: float) -> FloatArray:
    """Return the stiffest possible tangent: every contact that is closed or within tolerance closed and sticking."""
    all_closed = elastic_contacts(contacts, at, size)
    return tangent_stiffness(contacts, _sticking(contacts, at, all_closed), places, n_places)


def _sticking(contacts: ContactSet, at: Evaluation, closed: BoolArray) -> Evaluation:
    """Return an evaluation as if some contacts (m,) were closed and stuck; with their stiffness as it is."""
    none, springs = np.zeros_like(at.gap), at.springs
    stiffness = np.where(at.closed, springs.stiffness, contacts.shear_stiffness)  # of what is open at the reference
    springs = springs._replace(stiffness=stiffness, trial_by_closure=none[:0])
    return replace(at, closed=closed, sticking=closed, dshear_dpressure=none, springs=springs, slip=none[:0])


def elastic_contacts(contacts: ContactSet, at: Evaluation, size: float) -> BoolArray:
    """Return which contacts count in the stiffest possible tangent, (m,): closed ones and those within tolerance."""
    near: BoolArray = contacts.within_tolerance & (at.gap <= CONTACT_TOLERANCE * size)
    return at.closed | near
