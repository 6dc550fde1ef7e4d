"""Contacts that would break on the way to the end of a step, and without which the step has no end.

A joint with cohesion and no pressure bears shear; open, it bears none. Between the two its law jumps, and so does it
where tensile strength is exceeded: the step may have its equilibrium in the jump, where Newton's method cannot find
it. Opened is failed, so such a contact has lost its cohesion.
"""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.solve.step.equations import Balance, Step, moved_by

NEAR = 0.25  # of a correction, within which a contact opens or closes that may be what stops it
WEIGHTY = 0.1  # of the 2-norm out of balance: a smaller jump stops no correction


def break_caught(step: Step, here: Balance, correction: FloatArray) -> bool:
    """Break the contacts in whose jump Newton's method is caught, for the rest of the step; return if there are any.

    By smoothed laws none breaks: what opens or slips on the way may be whole at the end.
    """
    if step.smoothing:
        return False
    caught = breaking(step, here, correction)
    step.break_contacts(caught)
    return bool(caught.size)


def breaking(step: Step, here: Balance, correction: FloatArray) -> IntArray:
    """Return the contacts in whose jump Newton's method is caught, (k,).

    They are intact, open or close at once on the way to the corrected position, and lose much with that.

    Parameters
    ----------
    step : Step
        The equations.
    here : Balance
        Where the blocks are, and what is out of balance there.
    correction : (n, 3) float64 [m, m, rad]
        By what Newton's method would move them.
    """
    contacts, at = step.contacts, here.at
    after = step.evaluate(moved_by(here.position, correction))
    breakable = ~contacts.failed & np.isfinite(contacts.tension)  # unjointed rock never fails
    rows = np.flatnonzero(breakable & (at.bearing != after.bearing))
    stiffness, opening = contacts.normal_stiffness[rows], contacts.tension[rows] / contacts.normal_stiffness[rows]
    near, far = (stiffness * (contacts.offset[rows] + opening - end.gap[rows]) for end in (at, after))
    borne = [np.hypot(end.pressure[rows], end.shear[rows]) for end in (at, after)]
    jump = np.where(at.bearing[rows], borne[0], borne[1]) - np.abs(near)
    return rows[(np.abs(near) <= NEAR * np.abs(near - far)) & (jump > WEIGHTY * here.norm)]
