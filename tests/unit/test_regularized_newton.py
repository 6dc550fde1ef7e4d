"""Newton's method with a regularised tangent: it ends where the exact one does, and from further away."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from bsm_mesh.solve.methods.corrections import line_search, newton_correction, tangent_regularization
from bsm_mesh.solve.methods.newton import RegularizedNewton, newton
from bsm_mesh.solve.step.attempt import Goal, Iterate, Outcome
from tests.scenes.models import model_of
from tests.scenes.shapes import rectangle, running_bond, turned
from tests.scenes.steps import begun

TOLERANCE = 1e-8  # residual over the mean weight
BASE = rectangle(-4, -1, 8, 0)


def wall(turn=0.0, friction=35.0):
    return begun(model_of([turned(p, turn) for p in (BASE, *running_bond(6, 4))], friction=friction))


@pytest.mark.parametrize("turn", [0.0, 6.0])
def test_it_ends_in_the_equilibrium_of_the_exact_tangent(turn):
    step = wall(turn)
    start = step.elastic_position
    found, exact = newton(step, start, TOLERANCE), step.residual_at(start)
    for _ in range(40):
        if exact.max_norm >= TOLERANCE:
            exact = line_search(step, exact, newton_correction(step, exact, 0.0), exact.l2_norm)
    assert found.outcome is Outcome.SOLVED
    assert exact.max_norm < TOLERANCE
    assert step.residual_at(found.position).max_norm < TOLERANCE
    assert_allclose(found.position, exact.position, rtol=0, atol=1e-6 * np.abs(exact.position).max())


def test_it_carries_a_block_whose_contacts_are_open_back_to_rest():
    """Lifted off its base, where the exact tangent has nothing but the step's regularisation."""
    step = begun(model_of([BASE, rectangle(0, 0, 1, 1)]))
    lifted = step.start.copy()
    lifted[1, 1] = 1e-4
    found = newton(step.with_regularization(0.0), lifted, TOLERANCE)
    assert found.outcome is Outcome.SOLVED
    assert_allclose(found.position[1, 1], -25e3 / 1e9, rtol=1e-6)


def test_where_there_is_no_equilibrium_it_stalls_early():
    step = begun(model_of([turned(p, 50.0) for p in (BASE, rectangle(0, 0, 1, 1))], friction=30.0))
    before = step.factors.count
    found = newton(step, step.elastic_position, TOLERANCE)
    assert found.outcome is Outcome.STALLED
    assert step.factors.count - before < 15


def test_it_may_end_where_few_blocks_are_left():
    """The rms residual that is asked for is reached; the maximum norm is not."""
    step = wall()
    rest = newton(step, step.elastic_position, TOLERANCE).position
    pushed = rest.copy()
    pushed[9, 1] -= 1e-6
    residual = step.residual_at(pushed)
    assert residual.max_norm > 10 * residual.rms / 5
    found = newton(step, pushed, TOLERANCE, max_rms=2 * residual.rms)
    assert found.outcome is Outcome.ACCEPTABLE
    assert_allclose(found.position, pushed, atol=0)
    assert newton(step, pushed, TOLERANCE, max_rms=residual.rms / 1e3).position[9, 1] > pushed[9, 1]


def test_the_regularisation_goes_with_the_residual_and_has_an_upper_bound():
    assert 0.0 < tangent_regularization(0.0) < 1e-15, "no singular matrix at a residual of exactly zero"
    assert tangent_regularization(0.5) == pytest.approx(0.5 * tangent_regularization(1.0))
    assert tangent_regularization(50.0) == tangent_regularization(1.0) < 1.0


def test_the_method_of_a_step_begins_where_the_step_does():
    step, at = wall(), Iterate(residual=1.0)
    goal = Goal(max_residual=TOLERANCE, rest=TOLERANCE)
    method = RegularizedNewton()
    assert method.applies(step, at, goal)
    found = method.solve(step, at, goal)
    assert found.outcome is Outcome.SOLVED
    assert step.residual_at(found.position).max_norm < TOLERANCE
    at_once = begun(model_of([BASE, rectangle(0, 0, 1, 1)], gamma=0.0))
    assert_allclose(method.solve(at_once, at, goal).position, at_once.start, atol=0)
