"""What a method made of a step."""

from __future__ import annotations

from dataclasses import dataclass

from bsm_mesh.arrays import BoolArray, FloatArray
from bsm_mesh.solve.contacts.forces import Evaluation


@dataclass(frozen=True, eq=False, slots=True)
class Found:
    """A position, its contact forces, and whether they solve the step's equations, or may end it.

    Where cycles follow the blocks, `velocity` (n, 3) [m, m, rad] is how far they move in one, and `bore` (m,) tells
    which contacts bore at any time of the step.
    """

    position: FloatArray
    at: Evaluation
    converged: bool
    velocity: FloatArray | None = None
    bore: BoolArray | None = None
