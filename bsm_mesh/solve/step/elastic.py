"""The elastic solution of a step: every contact within tolerance closed and sticking."""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.solve.contacts.forces import first_tangent
from bsm_mesh.solve.step.equations import StepEquations, moved_by


def elastic_position(step: StepEquations) -> FloatArray:
    """Return the elastic solution of the step: every contact within tolerance closed and sticking, (n, 3).

    No line search: the laws may be far from satisfied there.
    """
    at = step.evaluate(step.start)
    forces = step.residual(step.start, at.forces)
    data = first_tangent(step.contacts, at, step.pattern.place, len(step.pattern.column))
    if not step.factorize(data, step.start):
        return step.start
    movement = step.solve(forces)
    return moved_by(step.start, movement) if np.isfinite(movement).all() else step.start
