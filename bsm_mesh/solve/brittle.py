"""Contacts that would break on the way to the end of a step, and without which the step has no end.

A joint with cohesion and no pressure bears shear; open, it bears none. Between the two its law jumps, and so does it
where tensile strength is exceeded: the step may have its equilibrium in the jump, where Newton's method cannot find
it. Opened is failed, so such a contact has lost its cohesion.
"""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.solve.moving import Evaluation
from bsm_mesh.solve.step import Step, moved_by

NEAR = 0.25  # of a correction, within which a contact opens or closes that may be what stops it
WEIGHTY = 0.1  # of the 2-norm out of balance: a smaller jump stops no correction


def breaking(step: Step, position: FloatArray, at: Evaluation, forces: FloatArray, correction: FloatArray) -> IntArray:
    """Return the contacts in whose jump Newton's method is caught, (k,).

    They are intact, open or close at once on the way to the corrected position, and lose much with that.

    Parameters
    ----------
    step : Step
        The equations.
    position, correction : (n, 3) float64 [m, m, rad]
        Where the blocks are, and where Newton's method would move them.
    at : Evaluation
        The contact forces there.
    forces : (n, 3) float64 [N/m, N/m, N]
        Forces out of balance there.
    """
    contacts = step.contacts
    after = step.evaluate(moved_by(position, correction))
    rows = np.flatnonzero(~contacts.failed & (at.bearing != after.bearing))
    stiffness, opening = contacts.normal_stiffness[rows], contacts.tension[rows] / contacts.normal_stiffness[rows]
    here, there = (stiffness * (contacts.offset[rows] + opening - end.gap[rows]) for end in (at, after))
    borne = [np.hypot(end.pressure[rows], end.shear[rows]) for end in (at, after)]
    jump = np.where(at.bearing[rows], borne[0], borne[1]) - np.abs(here)
    _, norm = step.sizes(forces, 1.0)
    return rows[(np.abs(here) <= NEAR * np.abs(here - there)) & (jump > WEIGHTY * norm)]
