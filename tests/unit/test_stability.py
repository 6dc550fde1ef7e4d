"""Stability of an equilibrium: the mode that leaves an unstable one, compared with dense eigenvectors."""

import numpy as np
import pytest
from scipy.linalg import eigh
from scipy.sparse import bsr_array

from bsm_mesh.contact.tangents import elastic_tangent
from bsm_mesh.model.options import Options
from bsm_mesh.solve.continuation.acceptance import Acceptance
from bsm_mesh.solve.continuation.plan import Phase
from bsm_mesh.solve.continuation.stability import NEUTRAL, falling_mode
from bsm_mesh.solve.methods.nearby_equilibrium import NearbyEquilibrium
from bsm_mesh.solve.step.attempt import Attempt, Goal, Iterate, Outcome
from tests.scenes.models import model_of
from tests.scenes.shapes import rectangle
from tests.scenes.steps import begun

TOLERANCE = 1e-6
BASE = rectangle(-20, -1, 20, 0)


def on_its_corner(x: float, half: float) -> np.ndarray:
    """Return a square that is on a corner, with half its diagonal [m]."""
    return np.array([(x, 0.0), (x + half, half), (x, 2 * half), (x - half, half)])


def at_equilibrium(*polygons):
    step = begun(model_of([BASE, *polygons]))
    found = NearbyEquilibrium().solve(step, Iterate(residual=1.0), Goal(max_residual=TOLERANCE, rest=TOLERANCE))
    assert found.outcome is Outcome.SOLVED
    return found.equations, found.position, found.at


def dense_modes(step, position, at):
    """Return the eigenvalues and modes of K x = w M x of the blocks that no support holds, in rising order."""
    static = step.static_problem_at(position, 0.0)
    pattern, size = static.pattern, static.system.outlines.size
    data = static.complete(elastic_tangent(static.contacts, at, pattern.place, len(pattern.column), size), position)
    matrix = bsr_array((data, pattern.column, pattern.row_start)).toarray()
    free = np.repeat(~static.system.prescribed_blocks, 3)
    mass = np.diag(static.system.mass.ravel()[free])
    values, vectors = eigh(matrix[np.ix_(free, free)], mass)
    modes = np.zeros((len(values), len(free)))
    modes[:, free] = vectors.T
    return values, modes.reshape(len(values), -1, 3)


@pytest.mark.parametrize("others", [0, 12])
def test_blocks_leave_an_unstable_equilibrium_by_its_lowest_mode(others):
    """Two squares on their corners, of which the smaller falls faster; others beside them stand."""
    standing = [rectangle(x, 0, x + 1, 1) for x in np.arange(4, 4 + others)]
    step, position, at = at_equilibrium(on_its_corner(-6.0, 1.0), on_its_corner(0.0, 0.9), *standing)
    values, modes = dense_modes(step, position, at)
    assert values[0] < values[1] < -NEUTRAL / step.system.outlines.size < values[2]
    found = falling_mode(step, position, at, TOLERANCE)
    assert found is not None
    lowest = modes[0] / step.movement(modes[0])
    assert step.movement(found) == pytest.approx(1.0)
    way = np.sign((found * lowest).sum())
    assert step.movement(found - way * lowest) < 0.05


def test_blocks_that_stand_on_faces_stay():
    assert falling_mode(*at_equilibrium(rectangle(0, 0, 1, 1), rectangle(3, 0, 4, 2)), TOLERANCE) is None


@pytest.mark.parametrize("moving", [False, True])
def test_moving_blocks_do_not_stop_in_an_unstable_equilibrium(moving):
    """At rest a square on its corner is pushed, as it would fall; one that moves does not end its step there."""
    step, position, _ = at_equilibrium(on_its_corner(0.0, 1.0))
    acceptance = Acceptance(step.system, Options(), intact=True)
    attempt = Attempt(equations=step, position=position, outcome=Outcome.SOLVED)
    ended = acceptance.accepted(attempt, Phase.NEAR_REST, moving=moving, quiet=False)
    if moving:
        assert ended is None
    else:
        assert ended.velocity is not None
        assert step.movement(ended.position - position) > 0
