"""Smoothed laws: their derivatives, their limit; and the path that leads from them to the laws."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.model.joint_laws import Elastic
from bsm_mesh.solve.contacts.history import History
from bsm_mesh.solve.contacts.smoothed_forces import Smoothed, drift, typical_smoothing
from bsm_mesh.solve.continuation import first_step as solve_first_step
from bsm_mesh.solve.continuation.acceptance import FEW_MOVE
from bsm_mesh.solve.continuation.loop import Continuation
from bsm_mesh.solve.methods import smoothing_path as path_following
from bsm_mesh.solve.methods.newton import elastic_position, newton
from bsm_mesh.solve.methods.smoothing_path import fitting_smoothing, follow_path
from bsm_mesh.solve.step.attempt import Found
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
    contacts = engine.moving.gather(History.none(), engine.moving.start, first=True)
    return Step(engine.moving, engine.factors, contacts, engine.moving.start, engine.least_lam)


def smoothing_of(step, elastic):
    """Return what a path begins with."""
    return typical_smoothing(step.contacts, elastic, step.moving.mean_weight)


def somewhere(step, seed=0):
    """Return a position at which some contacts press, some are open, and all have slipped a little."""
    rng = np.random.default_rng(seed)
    movement = rng.normal(scale=2e-5, size=step.start.shape)
    return step.start + np.where(step.moving.driven[:, None], 0.0, movement)


@pytest.mark.parametrize("law", LAWS)
def test_the_tangent_and_the_drift_are_the_derivatives_of_the_forces(law):
    step = first_step(slope(law))
    unit = step.moving.mean_weight**2 / np.median(step.contacts.normal_stiffness)
    smoothing, position = 100 * unit, somewhere(step)
    soft = step.smoothed(smoothing)
    at = soft.evaluate(position)
    assert isinstance(at, Smoothed)
    direction = np.where(step.moving.driven[:, None], 0.0, np.random.default_rng(1).normal(size=position.shape))
    ahead, behind = (soft.evaluate(position + part * direction).forces for part in (1e-9, -1e-9))
    row, pattern = np.repeat(np.arange(len(position)), np.diff(step.pattern.row_start)), step.pattern
    change = np.zeros_like(position)
    tangent = soft.tangent(at)
    np.add.at(change, row, np.einsum("kij,kj->ki", tangent, direction[pattern.column]))
    scale = np.abs(change).max()
    assert_allclose(-(ahead - behind) / 2e-9, change, atol=3e-3 * scale)  # the floor of the tangent is a thousandth
    more, less = (step.smoothed(smoothing * (1 + part)).evaluate(position).forces for part in (1e-4, -1e-4))
    by_smoothing = (more - less) / (2e-4 * smoothing)
    assert_allclose(drift(step.contacts, at, 1.0), by_smoothing, atol=1e-6 * np.abs(by_smoothing).max())


def test_without_smoothing_left_the_forces_are_those_of_the_laws():
    step = first_step(slope())
    position = somewhere(step)
    exact, weight = step.evaluate(position).forces, step.moving.mean_weight
    unit = weight**2 / np.median(step.contacts.normal_stiffness)
    apart = [np.abs(step.smoothed(part * unit).evaluate(position).forces - exact).max() for part in (1e-2, 1e-6)]
    assert apart[1] < 1e-2 * weight
    assert apart[0] > 10 * apart[1]


def test_pressure_and_opening_have_the_smoothing_as_their_product():
    step = first_step(slope("cohesion", tension=1e4))
    c, smoothing = step.contacts, 30.0
    at = step.smoothed(smoothing).evaluate(somewhere(step))
    on = at.bearing & np.isfinite(c.tension)
    assert on.sum() > 100
    opening = (at.gap - c.offset + at.pressure / c.normal_stiffness)[on]
    assert_allclose((at.pressure + c.tension)[on] * opening, smoothing, rtol=1e-6)
    assert (np.abs(at.shear) <= at.strength).all()


def test_it_ends_where_newtons_method_could_not():
    step = first_step(slope(n=600))
    elastic = elastic_position(step)
    step.make_room(elastic)
    assert not newton(step, elastic, 5e-7, most=30).converged
    assert follow_path(step, step.start, smoothing_of(step, elastic), 5e-7).converged


def test_it_ends_earlier_where_contacts_are_to_be_updated():
    step = first_step(slope(n=600))
    elastic = elastic_position(step)
    rough = follow_path(step, step.start, smoothing_of(step, elastic), 5e-7, rough=0.1)
    assert not rough.converged
    left = step.balance_at(rough.position)
    assert step.is_scattered(left, 0.1)
    assert left.greatest > path_following.NEAR_END


def test_a_lost_path_is_taken_up_with_a_greater_smoothing(monkeypatch):
    """With a thousandth of the smoothing there is none to begin with; it is raised until there is."""
    step = first_step(benchmarks.leaning_slope(300).model())
    elastic = elastic_position(step)
    step.make_room(elastic)
    little = 1e-3 * smoothing_of(step, elastic)
    assert not follow_path(step, step.start, little, 5e-7).converged, "it is given up where cycles can follow"
    monkeypatch.setattr(path_following, "can_slide", lambda _: False)
    assert follow_path(step, step.start, little, 5e-7).converged
    monkeypatch.setattr(path_following, "MOST_RAISED", 0)
    assert not follow_path(step, step.start, little, 5e-7).converged


def test_the_smoothing_to_begin_with_is_worth_more_than_is_out_of_balance():
    step = first_step(slope(n=300))
    elastic = elastic_position(step)
    here = step.balance_at(elastic)
    smoothing = fitting_smoothing(step, elastic)

    def worth(part):
        return np.linalg.norm(step.free(step.smoothed(part * smoothing).balance_at(elastic).forces - here.forces))

    assert worth(1 / path_following.RAISED) > here.norm > worth(path_following.RAISED**-2)


def test_blocks_that_a_correction_throws_off_come_back_before_it_is_judged(monkeypatch):
    step = first_step(benchmarks.leaning_slope(1000, 30.0).model())
    elastic = elastic_position(step)
    smoothing = smoothing_of(step, elastic)
    monkeypatch.setattr(path_following, "can_slide", lambda _: False)

    def factorizations():
        before = step.factors.count
        follow_path(step, step.start, smoothing, 5e-7, rough=0.01)
        return step.factors.count - before

    few = factorizations()
    monkeypatch.setattr(path_following, "ROUNDS", 0)
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


def test_a_slow_path_ends_where_few_blocks_are_out_of_balance(monkeypatch):
    """Every iteration counts as slow."""
    step = first_step(benchmarks.leaning_slope(1000).model())
    smoothing = smoothing_of(step, elastic_position(step))
    monkeypatch.setattr(path_following, "SLOW", 2.0)
    monkeypatch.setattr(path_following, "MOST_SLOW", 1)
    held = follow_path(step, step.start, smoothing, 5e-7)
    left = step.balance_at(held.position)
    assert not held.converged
    assert step.is_scattered(left, path_following.FEW_LEFT)
    assert left.greatest > path_following.NEAR_END


@pytest.mark.parametrize("was_solved", [False, True])
def test_what_was_solved_before_an_update_is_newtons_first(monkeypatch, was_solved):
    """However much the update puts out of balance: a wall of a million bricks takes 1 factorization, by the path 7."""
    step = first_step(slope(n=300))
    assert not step.is_scattered(step.balance_at(step.start))
    asked = []

    def solver(name):
        def solves(step, position, *_, **__):
            asked.append(name)
            return Found(position, step.evaluate(position), converged=True)

        return solves

    for name in ("softened_newton", "follow_path"):
        monkeypatch.setattr(solve_first_step, name, solver(name))
    solve_first_step.solve_updated(step, step.start, 1e-6, was_solved=was_solved)
    assert asked == ["softened_newton" if was_solved else "follow_path"]


@pytest.mark.parametrize(("excavated", "few"), [(False, 0.0), (True, FEW_MOVE), (True, 0.0)])
def test_what_all_but_few_blocks_rest_in_is_updated_and_then_taken_as_the_first_step(monkeypatch, excavated, few):
    """One block of hundreds is lifted from where all rest, and nothing brings it back: after an excavation it moves."""
    monkeypatch.setattr(solve_first_step, "FEW_MOVE", few)
    step = first_step(slope(n=600))
    elastic = elastic_position(step)
    rest = follow_path(step, step.start, smoothing_of(step, elastic), 5e-7)
    lifted = rest.position.copy()
    lifted[np.flatnonzero(~step.moving.driven)[-1], 1] += 1e-9
    left = step.balance_at(lifted)
    assert left.greatest > 1e-6
    assert step.is_scattered(left)

    updates = []

    def leads_there(step, *_, **keys):
        updates.append("was_solved" in keys)
        return Found(lifted, step.evaluate(lifted), converged=False)

    monkeypatch.setattr(solve_first_step, "solve_at_once", leads_there)
    monkeypatch.setattr(solve_first_step, "solve_updated", leads_there)
    _, found = solve_first_step.first_step(step, 1e-6, excavated=excavated)
    assert found.converged is (few > 0 or not excavated)
    assert any(updates) is not excavated
    assert_allclose(found.position, lifted)


@pytest.mark.parametrize("flies", [False, True])
def test_an_update_that_throws_a_block_away_is_not_taken(monkeypatch, flies):
    """Where it flies nothing touches it, and little beside all others is out of balance."""
    step = first_step(slope(n=600))
    rest = follow_path(step, step.start, smoothing_of(step, elastic_position(step)), 5e-7)
    thrown = rest.position.copy()
    block = np.flatnonzero(~step.moving.driven)[-1]
    thrown[block, 1] += 1e3 * step.moving.d if flies else 1e-9
    monkeypatch.setattr(solve_first_step, "FEW_LEFT", 1.0)
    assert step.is_scattered(step.balance_at(thrown), 1.0)

    def leads_to(position, *, converged):
        return lambda step, *_, **__: Found(position, step.evaluate(position), converged=converged)

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
