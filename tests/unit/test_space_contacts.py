"""Forces of contact points in space: balance, strength, tangent by differences, what a step leaves."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from tests.scenes.polyhedra import model_in_space, on_incline
from tests.scenes.space_steps import SOLIDS, assert_tangent, step_of, turned_and_moved


@pytest.mark.parametrize(
    "law", [bsm.MohrCoulomb(friction=30, cohesion=1e3), bsm.BartonBandis(jrc=8, jcs=6e7, residual_friction=28)]
)
def test_the_tangent_is_the_derivative_of_the_forces(law):
    """Of contacts that stick, slide and are open, blocks turned by a third of a radian."""
    step = step_of(model_in_space(SOLIDS, law=law, kn=1e7, ks=3e6))
    position = turned_and_moved(step.system, 5, 2e-3)
    at = step.evaluate(position)
    states = at.closed & at.sticking, at.closed & ~at.sticking, ~at.closed
    assert all(state.any() for state in states)
    assert_tangent(step, position)


def test_forces_balance_and_do_not_exceed_strength():
    step = step_of(model_in_space(SOLIDS, friction=30, kn=1e7, ks=1e7))
    position = turned_and_moved(step.system, 1, 2e-3)
    at = step.evaluate(position)
    moment = at.forces[:, 3:] + np.cross(step.system.placed(position), at.forces[:, :3])
    assert_allclose(at.forces[:, :3].sum(axis=0), 0, atol=1e-9 * np.abs(at.forces).max())
    assert_allclose(moment.sum(axis=0), 0, atol=1e-9 * np.abs(at.forces).max())
    assert (at.size <= at.strength * (1 + 1e-12)).all()
    assert_allclose(at.size[~at.sticking & at.closed], at.strength[~at.sticking & at.closed])


def test_moving_the_whole_model_changes_no_force():
    step = step_of(model_in_space(SOLIDS))
    still = turned_and_moved(step.system, 0, 0.0)
    assert_allclose(step.evaluate(still).forces, 0, atol=1e-6)  # of 1e9 N/m times rounding


def test_what_has_opened_has_lost_cohesion():
    step = step_of(on_incline(0, cohesion=1e6))
    lifted = step.start.copy()
    lifted[1, 2] = 1e-3
    history, _ = step.system.commit(step.contacts, step.evaluate(lifted), lifted)
    assert not history.closed.any()
    again = step.system.gather(history, step.start, first=False)
    pressed = step.start.copy()
    pressed[1, :3] = 1e-2, 0, -1e-5
    at = step.system.evaluate(again, pressed)
    assert_allclose(at.size, at.pressure * np.tan(np.radians(30)))


def test_points_that_slide_off_their_face_bear_nothing():
    step = step_of(on_incline(0))
    pushed = step.start.copy()
    pushed[1, :3] = 0.8, 0, -1e-5
    assert not step.evaluate(pushed).closed.any()


def test_explicit_motion_ends_where_newton_does():
    """A cube set down on a plane of 10 degrees: displacements to the residual that ends the motion."""
    from bsm_mesh.solve.motion.dynamic_relaxation import RelaxToRest
    from bsm_mesh.solve.step.attempt import Goal, Iterate

    model = on_incline(10, azimuth=30)
    step = step_of(model)
    attempt = RelaxToRest().solve(step, Iterate(residual=1.0), Goal(max_residual=1e-6, rest=1e-6))
    exact = bsm.run(model, bsm.Options(threads=1)).stages[0].displacement
    assert attempt.may_end
    assert_allclose(attempt.position, exact, atol=0.03 * np.abs(exact).max())
