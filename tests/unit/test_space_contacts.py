"""Forces of contact points in space: balance, strength, tangent by differences, what a step leaves."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.movements import turned as turned_by
from bsm_mesh.solve.continuation.loop import Continuation
from bsm_mesh.solve.step.equations import StepEquations
from bsm_mesh.three_d.contacts.history import PointHistory
from tests.scenes.polyhedra import box, model_in_space, on_incline

TANGENT = 1e-8  # of the greatest entry: differences of forces with steps of 1e-7
TILT = np.array([0.2, -0.3, 0.15])  # rad: of the whole model, so that frames differ from the axes
SOLIDS = [
    box((0, 0, -1), (1, 1, 0)),
    box((0, 0, 0), (1, 1, 1)),
    box((1, 0, 0), (2, 1, 1)),
    box((0, 0, 1), (1, 1, 2)),
]


def step_of(model):
    """Return the equations of the first step."""
    engine = Continuation(model, bsm.Options(threads=1), lambda *_: None)
    contacts = engine.system.gather(PointHistory.none(), engine.system.start, first=True)
    return StepEquations(engine.system, engine.factors, contacts, engine.system.start, 0.0)


def turned_and_moved(system, seed, size):
    """Return the whole model turned by `TILT`, its blocks moved by random small movements."""
    turn = np.tile(TILT, (len(system.start), 1))
    position = np.hstack([turned_by(system.centroid, turn) - system.centroid, turn])
    return system.moved_by(position, size * np.random.default_rng(seed).normal(size=position.shape))


def whole_matrix(pattern, data):
    count = pattern.rows
    found, row = np.zeros((count, 6, count, 6)), np.repeat(np.arange(count), np.diff(pattern.row_start))
    for place, (i, j) in enumerate(zip(row, pattern.column, strict=True)):
        found[i, :, j] += data[place]
    return found.reshape(6 * count, 6 * count)


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
    found = whole_matrix(step.pattern, step.tangent(at))
    size, exact = 1e-7, np.zeros_like(found)
    for k in range(len(exact)):
        change = np.zeros_like(position)
        change.flat[k] = size
        ahead, behind = (step.evaluate(step.moved_by(position, sign * change)).forces for sign in (1, -1))
        exact[:, k] = -(ahead - behind).ravel() / (2 * size)
    assert_allclose(found, exact, atol=TANGENT * np.abs(exact).max())


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
