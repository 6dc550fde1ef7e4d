"""Brittle failure within a step: contacts at a strength drop are released.

A joint with cohesion carries shear at zero pressure; open, it carries none. Its law is discontinuous there, and where
the tensile strength is exceeded: the residual may have no root, and Newton's method stalls at the jump. An opened
contact has failed, so releasing it takes its cohesion and tensile strength.
"""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.solve.step.equations import Residual, Step, moved_by

NEAR = 0.25  # part of a correction, within which a contact must open or close to be released
WEIGHTY = 0.1  # jump of its force over the 2-norm of the residual: a smaller one does not stall the iteration


def release_brittle_contacts(step: Step, here: Residual, correction: FloatArray) -> bool:
    """Release the contacts at a strength drop for the rest of the step; return whether there are any.

    By smoothed laws none is released: contacts that open or slip on the path may be intact at the end.
    """
    if step.mu:
        return False
    released = contacts_at_strength_drop(step, here, correction)
    step.fail_contacts(released)
    return bool(released.size)


def contacts_at_strength_drop(step: Step, here: Residual, correction: FloatArray) -> IntArray:
    """Return the contacts at whose strength drop Newton's method stalls, (k,).

    They are intact, open or close early on the way to the corrected position, and their force drops much with that.

    Parameters
    ----------
    step : Step
        The equations.
    here : Balance
        The residual at the current position.
    correction : (n, 3) float64 [m, m, rad]
        Newton correction there.
    """
    contacts, at = step.contacts, here.at
    after = step.evaluate(moved_by(here.position, correction))
    breakable = ~contacts.failed & np.isfinite(contacts.tension)  # unjointed rock never fails
    rows = np.flatnonzero(breakable & (at.closed != after.closed))
    stiffness, opening = contacts.normal_stiffness[rows], contacts.tension[rows] / contacts.normal_stiffness[rows]
    near, far = (stiffness * (contacts.offset[rows] + opening - end.gap[rows]) for end in (at, after))
    force = [np.hypot(end.pressure[rows], end.shear[rows]) for end in (at, after)]
    jump = np.where(at.closed[rows], force[0], force[1]) - np.abs(near)
    return rows[(np.abs(near) <= NEAR * np.abs(near - far)) & (jump > WEIGHTY * here.l2_norm)]
