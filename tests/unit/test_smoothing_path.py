"""Smoothed laws: derivatives and limit; and the smoothing path to the exact laws."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.model.joint_laws import Elastic
from bsm_mesh.solve.contacts.history import History
from bsm_mesh.solve.contacts.smoothed_forces import Smoothed, dforces_dmu, typical_mu
from bsm_mesh.solve.continuation import first_step as solve_first_step
from bsm_mesh.solve.continuation.acceptance import FEW_MOVE
from bsm_mesh.solve.continuation.loop import Continuation
from bsm_mesh.solve.methods import smoothing_path
from bsm_mesh.solve.methods.newton import elastic_position, newton
from bsm_mesh.solve.methods.smoothing_path import follow_path, initial_mu
from bsm_mesh.solve.step.attempt import Attempt
from bsm_mesh.solve.step.equations import Step

benchmarks = pytest.importorskip("benchmarks.scenes")

LAWS = {
    "friction": bsm.MohrCoulomb(friction=35),
    "cohesion": bsm.Patton(friction=30, dilation=5, cohesion=2e4),
    "elastic": Elastic(),
}


def slope(law=None, n=150, friction=40.0, tension=0.0):
    """Return a jointed slope of about n blocks from zero stress."""
    model = benchmarks.jointed_slope(n, friction).model()
    if law is None:
        return model
    joint = replace(model.joints[0], law=LAWS[law], tensile_strength=tension)
    return model.replace(joints=(joint,))


def first_step(model):
    """Return the step that looks for equilibrium at once."""
    engine = Continuation(model, bsm.Options(scheme="continuation"), lambda *record: None)
    contacts = engine.system.gather(History.none(), engine.system.start, first=True)
    return Step(engine.system, engine.factors, contacts, engine.system.start, engine.min_lam)


def smoothing_of(step, elastic):
    """Return what a path begins with."""
    return typical_mu(step.contacts, elastic, step.system.mean_weight)


def somewhere(step, seed=0):
    """Return a position at which some contacts press, some are open, and all have slipped a little."""
    rng = np.random.default_rng(seed)
    movement = rng.normal(scale=2e-5, size=step.start.shape)
    return step.start + np.where(step.system.prescribed_blocks[:, None], 0.0, movement)


@pytest.mark.parametrize("law", LAWS)
def test_the_tangent_and_the_derivative_by_mu_are_those_of_the_forces(law):
    step = first_step(slope(law))
    unit = step.system.mean_weight**2 / np.median(step.contacts.normal_stiffness)
    smoothing, position = 100 * unit, somewhere(step)
    soft = step.smoothed(smoothing)
    at = soft.evaluate(position)
    assert isinstance(at, Smoothed)
    direction = np.random.default_rng(1).normal(size=position.shape)
    direction[step.system.prescribed_blocks] = 0.0
    ahead, behind = (soft.evaluate(position + part * direction).forces for part in (1e-9, -1e-9))
    row, pattern = np.repeat(np.arange(len(position)), np.diff(step.pattern.row_start)), step.pattern
    change = np.zeros_like(position)
    tangent = soft.tangent(at)
    np.add.at(change, row, np.einsum("kij,kj->ki", tangent, direction[pattern.column]))
    scale = np.abs(change).max()
    assert_allclose(-(ahead - behind) / 2e-9, change, atol=3e-3 * scale)  # the floor of the tangent is a thousandth
    more, less = (step.smoothed(smoothing * (1 + part)).evaluate(position).forces for part in (1e-4, -1e-4))
    by_smoothing = (more - less) / (2e-4 * smoothing)
    assert_allclose(dforces_dmu(step.contacts, at, 1.0), by_smoothing, atol=1e-6 * np.abs(by_smoothing).max())


def test_with_mu_going_to_zero_the_forces_are_those_of_the_exact_laws():
    step = first_step(slope())
    position = somewhere(step)
    exact, weight = step.evaluate(position).forces, step.system.mean_weight
    unit = weight**2 / np.median(step.contacts.normal_stiffness)
    apart = [np.abs(step.smoothed(part * unit).evaluate(position).forces - exact).max() for part in (1e-2, 1e-6)]
    assert apart[1] < 1e-2 * weight
    assert apart[0] > 10 * apart[1]


def test_pressure_and_opening_have_mu_as_their_product():
    step = first_step(slope("cohesion", tension=1e4))
    c, smoothing = step.contacts, 30.0
    at = step.smoothed(smoothing).evaluate(somewhere(step))
    on = at.closed & np.isfinite(c.tension)
    assert on.sum() > 100
    opening = (at.gap - c.offset + at.pressure / c.normal_stiffness)[on]
    assert_allclose((at.pressure + c.tension)[on] * opening, smoothing, rtol=1e-6)
    assert (np.abs(at.shear) <= at.strength).all()


def test_it_ends_where_newtons_method_could_not():
    step = first_step(slope(n=600))
    elastic = elastic_position(step)
    step.allow_elastic_settlement(elastic)
    assert not newton(step, elastic, 5e-7, max_iterations=30).converged
    assert follow_path(step, step.start, smoothing_of(step, elastic), 5e-7).converged


def test_it_ends_earlier_where_contacts_are_to_be_updated():
    step = first_step(slope(n=600))
    elastic = elastic_position(step)
    rough = follow_path(step, step.start, smoothing_of(step, elastic), 5e-7, rough=0.1)
    assert not rough.converged
    left = step.residual_at(rough.position)
    assert step.is_localized(left, 0.1)
    assert left.max_norm > smoothing_path.NEAR_END


def test_a_lost_path_restarts_with_a_greater_mu(monkeypatch):
    """With a thousandth of the smoothing there is none to begin with; it is raised until there is."""
    step = first_step(benchmarks.leaning_slope(300).model())
    elastic = elastic_position(step)
    step.allow_elastic_settlement(elastic)
    little = 1e-3 * smoothing_of(step, elastic)
    assert not follow_path(step, step.start, little, 5e-7).converged, "it is given up where cycles can follow"
    monkeypatch.setattr(smoothing_path, "can_follow_dynamically", lambda _: False)
    assert follow_path(step, step.start, little, 5e-7).converged
    monkeypatch.setattr(smoothing_path, "MAX_RAISED", 0)
    assert not follow_path(step, step.start, little, 5e-7).converged


def test_the_initial_mu_changes_forces_by_more_than_the_residual():
    step = first_step(slope(n=300))
    elastic = elastic_position(step)
    here = step.residual_at(elastic)
    smoothing = initial_mu(step, elastic)

    def worth(part):
        return np.linalg.norm(step.project(step.smoothed(part * smoothing).residual_at(elastic).forces - here.forces))

    assert worth(1 / smoothing_path.RAISED) > here.l2_norm > worth(smoothing_path.RAISED**-2)


def test_blocks_that_a_correction_throws_off_come_back_before_it_is_judged(monkeypatch):
    step = first_step(benchmarks.leaning_slope(1000, 30.0).model())
    elastic = elastic_position(step)
    smoothing = smoothing_of(step, elastic)
    monkeypatch.setattr(smoothing_path, "can_follow_dynamically", lambda _: False)

    def factorizations():
        before = step.factors.count
        follow_path(step, step.start, smoothing, 5e-7, rough=0.01)
        return step.factors.count - before

    few = factorizations()
    monkeypatch.setattr(smoothing_path, "ROUNDS", 0)
    assert few < 0.7 * factorizations()


def test_contacts_are_updated_on_the_way_where_blocks_settle_far(monkeypatch):
    """A soft slope settles by nearly three step lengths, and corners pass the ends of edges."""
    model = benchmarks.leaning_slope(1000).model()
    model = model.replace(joints=(replace(model.joints[0], normal_stiffness=1e8, shear_stiffness=1e8),))
    solved, solve = [], solve_first_step.solve_updated

    def counted(*given, was_solved, **keys):
        solved.append(was_solved)
        return solve(*given, was_solved=was_solved, **keys)

    monkeypatch.setattr(solve_first_step, "solve_updated", counted)
    stage = bsm.run(model).stages[-1]
    assert stage.status == "stable"
    assert len(stage.steps) == 2
    assert not solved[0]
    solved.clear()
    monkeypatch.setattr(solve_first_step, "ROUGH", 0.0)
    assert bsm.run(model).stages[-1].status == "stable"
    assert solved[0]


def test_a_slow_path_ends_with_a_localized_residual(monkeypatch):
    """Every iteration counts as slow."""
    step = first_step(benchmarks.leaning_slope(1000).model())
    smoothing = smoothing_of(step, elastic_position(step))
    monkeypatch.setattr(smoothing_path, "SLOW", 2.0)
    monkeypatch.setattr(smoothing_path, "MAX_SLOW", 1)
    held = follow_path(step, step.start, smoothing, 5e-7)
    left = step.residual_at(held.position)
    assert not held.converged
    assert step.is_localized(left, smoothing_path.FEW_LEFT)
    assert left.max_norm > smoothing_path.NEAR_END


@pytest.mark.parametrize("was_solved", [False, True])
def test_what_was_solved_before_an_update_is_newtons_first(monkeypatch, was_solved):
    """However large the residual after the update: a wall of a million bricks takes 1 factorization, by the path 7."""
    step = first_step(slope(n=300))
    assert not step.is_localized(step.residual_at(step.start))
    asked = []

    def solver(name):
        def solves(step, position, *_, **__):
            asked.append(name)
            return Attempt(position, step.evaluate(position), converged=True)

        return solves

    for name in ("regularized_newton", "follow_path"):
        monkeypatch.setattr(solve_first_step, name, solver(name))
    solve_first_step.solve_updated(step, step.start, 1e-6, was_solved=was_solved)
    assert asked == ["regularized_newton" if was_solved else "follow_path"]


@pytest.mark.parametrize(("excavated", "few"), [(False, 0.0), (True, FEW_MOVE), (True, 0.0)])
def test_what_all_but_few_blocks_rest_in_is_updated_and_then_taken_as_the_first_step(monkeypatch, excavated, few):
    """One block of hundreds is lifted from where all rest, and nothing brings it back: after an excavation it moves."""
    monkeypatch.setattr(solve_first_step, "FEW_MOVE", few)
    step = first_step(slope(n=600))
    elastic = elastic_position(step)
    rest = follow_path(step, step.start, smoothing_of(step, elastic), 5e-7)
    lifted = rest.position.copy()
    lifted[np.flatnonzero(~step.system.prescribed_blocks)[-1], 1] += 1e-9
    left = step.residual_at(lifted)
    assert left.max_norm > 1e-6
    assert step.is_localized(left)

    updates = []

    def leads_there(step, *_, **keys):
        updates.append("was_solved" in keys)
        return Attempt(lifted, step.evaluate(lifted), converged=False)

    monkeypatch.setattr(solve_first_step, "solve_at_once", leads_there)
    monkeypatch.setattr(solve_first_step, "solve_updated", leads_there)
    _, found = solve_first_step.first_step(step, 1e-6, excavated=excavated)
    assert found.converged is (few > 0 or not excavated)
    assert any(updates) is not excavated
    assert_allclose(found.position, lifted)


@pytest.mark.parametrize("flies", [False, True])
def test_an_update_that_throws_a_block_away_is_not_taken(monkeypatch, flies):
    """Where it flies nothing touches it, and it has the only residual."""
    step = first_step(slope(n=600))
    rest = follow_path(step, step.start, smoothing_of(step, elastic_position(step)), 5e-7)
    thrown = rest.position.copy()
    block = np.flatnonzero(~step.system.prescribed_blocks)[-1]
    thrown[block, 1] += 1e3 * step.system.d if flies else 1e-9
    monkeypatch.setattr(solve_first_step, "FEW_LEFT", 1.0)
    assert step.is_localized(step.residual_at(thrown), 1.0)

    def leads_to(position, *, converged):
        return lambda step, *_, **__: Attempt(position, step.evaluate(position), converged=converged)

    monkeypatch.setattr(solve_first_step, "solve_at_once", leads_to(rest.position, converged=True))
    monkeypatch.setattr(solve_first_step, "solve_updated", leads_to(thrown, converged=False))
    _, found = solve_first_step.first_step(step, 1e-6, excavated=False)
    assert_allclose(found.position, rest.position if flies else thrown, atol=1e-8)


@pytest.mark.parametrize(
    ("slope", "friction"), [(benchmarks.jointed_slope, 40.0), (benchmarks.leaning_slope, 35.0)], ids=["out", "in"]
)
@pytest.mark.parametrize("k0", [None, 1.0])
def test_slopes_rest_in_a_step_from_either_start(slope, friction, k0):
    """One whose columns lean out over the face (it took three steps, 138 factorizations), one whose columns lean in."""
    results = bsm.run(slope(1000, friction).model(k0))
    stage = results.stages[-1]
    assert stage.status == "stable"
    assert len(stage.steps) == 2
    assert sum(step.factorizations for step in stage.steps) < 45
    assert results.check().ok
