"""The result of a method applied to a step."""

from __future__ import annotations

from dataclasses import dataclass

from bsm_mesh.arrays import BoolArray, FloatArray
from bsm_mesh.solve.contacts.forces import Evaluation


@dataclass(frozen=True, eq=False, slots=True)
class Attempt:
    """A trial solution of a step: position, contact forces, and whether the step may end with it.

    After explicit motion, `velocity` (n, 3) [m, m, rad] is the movement in a cycle, and `contacted_during_step` (m,)
    tells which contacts were closed at any time of the step.
    """

    position: FloatArray
    at: Evaluation
    converged: bool
    velocity: FloatArray | None = None
    contacted_during_step: BoolArray | None = None
