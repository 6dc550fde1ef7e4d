"""Models of which tests take single steps."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

import bsm_mesh as bsm
from bsm_mesh.contact.history import History
from bsm_mesh.solve.continuation.loop import Continuation
from bsm_mesh.solve.methods.nearby_equilibrium import NearbyEquilibrium
from bsm_mesh.solve.step.attempt import Goal, Iterate, Outcome
from bsm_mesh.solve.step.equations import StepEquations
from tests.scenes.large import tilted_courses

COURSES, BRICKS = 24, 40  # of the wall


def begun(model: bsm.Model, *, threads: int = 0) -> StepEquations:
    """Return the first step from zero stress."""
    engine = Continuation(model, bsm.Options(threads=threads), lambda *_: None)
    contacts = engine.system.gather(History.none(), engine.system.start, first=True)
    return StepEquations(engine.system, engine.factors, contacts, engine.system.start, engine.min_lam)


def still(count: int, **moving: Sequence[float]) -> np.ndarray:
    """Return velocities (count, 3) that are zero but for the blocks b1, b2, ..."""
    velocity = np.zeros((count, 3))
    for name, given in moving.items():
        velocity[int(name[1:])] = given
    return velocity


def wall_at_rest(tolerance: float, water: bsm.Water | None = None) -> tuple[StepEquations, np.ndarray]:
    """Return the step of a tilted wall and where it is at rest (n, 3), with factors of its tangent there."""
    step = begun(tilted_courses(COURSES, BRICKS).model().replace(water=water))
    found = NearbyEquilibrium().solve(step, Iterate(residual=1.0), Goal(max_residual=tolerance, rest=tolerance))
    assert found.outcome is Outcome.SOLVED
    step = found.equations
    assert step.factorize(step.tangent(found.at, 1e-3), found.position)
    return step, found.position
