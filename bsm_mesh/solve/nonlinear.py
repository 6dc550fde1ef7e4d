"""The scheme ``continuation``: large displacement, joints that slip and open; results in the final geometry."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.model.model import Model
from bsm_mesh.results.records import ContactForces, ContactStatus, StageResult, StepRecord
from bsm_mesh.results.stress import dyad_of_contacts, stress_of_dyad
from bsm_mesh.solve.continuation import Continuation, Motion
from bsm_mesh.solve.linear import Reporter, support_forces
from bsm_mesh.solve.options import Options


def solve_continuation(
    model: Model,
    options: Options,
    report: Reporter = lambda text: None,
    observer: Callable[[StepRecord], None] = lambda record: None,
) -> tuple[StageResult, str]:
    """Return the stage ``initial`` at rest or in collapse, and the name of the linear solver used."""
    report("continuation")
    motion = Continuation(model, options, observer).run()
    report(f"{motion.status.value}: {motion.reason}")
    return stage_of(model, motion), motion.linear_solver
