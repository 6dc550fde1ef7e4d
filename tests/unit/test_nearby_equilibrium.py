"""The equilibrium near a start: found where there is one, said where not; and what a run is without this method."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.solve.continuation.plan import PLANS
from bsm_mesh.solve.methods import nearby_equilibrium as nearby
from bsm_mesh.solve.methods import newton as newton_method
from bsm_mesh.solve.methods.nearby_equilibrium import NearbyEquilibrium
from bsm_mesh.solve.methods.newton import newton
from bsm_mesh.solve.step.attempt import FEW_CHANGE, Goal, Iterate, Outcome
from bsm_mesh.solve.step.block_system import BlockSystem
from tests.scenes.large import leaning_slope, tilted_courses, tilted_wall
from tests.scenes.models import GAMMA, model_of
from tests.scenes.shapes import rectangle, running_bond, turned
from tests.scenes.steps import begun, still

BASE = rectangle(-4, -1, 8, 0)
AT_REST, GOAL = Iterate(residual=1.0), Goal(max_residual=1e-8, rest=1e-8)


def scene(name):
    """Return polygons and friction of a scene that reaches rest near where it is given."""
    return {
        "column": ([BASE, *(rectangle(0, y, 1, y + 1) for y in range(5))], 35.0),
        "wall": ([BASE, *running_bond(5, 4)], 35.0),
        "tilted wall": ([turned(p, 8.0) for p in (BASE, *running_bond(5, 4))], 35.0),
        "wedge": (
            # a triangle in a notch, which slides down both sides until they carry it
            [
                np.array([(-3, -1), (3, -1), (3, 2), (2, 2), (0, 0), (-2, 2), (-3, 2)]),
                np.array([(-1, 1), (0, 0), (1, 1)]),
            ],
            20.0,
        ),
    }[name]


def without(monkeypatch, name):
    """Take a method from every plan, as the campaign's ``--without`` does."""
    for phase, plan in PLANS.items():
        monkeypatch.setitem(PLANS, phase, tuple(method for method in plan if not method.name.startswith(name)))


@pytest.mark.parametrize("localized", [False, True])
@pytest.mark.parametrize("name", ["column", "wall", "tilted wall", "wedge"])
def test_it_ends_in_equilibrium(name, localized):
    polygons, friction = scene(name)
    found = NearbyEquilibrium(localized=localized).solve(begun(model_of(polygons, friction=friction)), AT_REST, GOAL)
    assert found.outcome is Outcome.SOLVED
    step, at = found.equations.with_regularization(0.0), found.at
    assert step.residual_at(found.position).max_norm < 1e-4
    assert (at.pressure[at.closed] >= 0).all()
    assert (np.abs(at.shear) <= at.strength * (1 + 1e-9))[at.closed].all()
    assert not found.position[0].any()
    assert at.forces[1:, 1].sum() == pytest.approx(GAMMA * step.system.model.blocks.moments.area[1:].sum(), rel=1e-4)
    assert (step.acting_at(found.position) * found.position)[1:].sum() > 0  # weight has done work


def test_it_goes_on_to_rest_whatever_the_step_asks_for(monkeypatch):
    """A step that asks for little got six searches for contacts without success, and began again."""
    polygons, friction = scene("tilted wall")
    searches, gather = [], BlockSystem.gather
    monkeypatch.setattr(BlockSystem, "gather", lambda *given, **more: searches.append(1) or gather(*given, **more))
    step = begun(model_of(polygons, friction=friction))
    searches.clear()
    found = NearbyEquilibrium().solve(step, AT_REST, Goal(max_residual=1e-2, rest=1e-6))
    assert found.outcome is Outcome.SOLVED
    assert found.equations.residual_at(found.position).max_norm < 1e-6
    assert len(searches) <= 3


@pytest.mark.heavy
def test_a_wall_of_thousands_of_bricks_comes_to_rest_in_its_first_step():
    """A step that ended at its own goal, above that of rest, left Newton's method to be begun anew."""
    steps = bsm.run(tilted_wall(5000).model()).stages[0].steps
    assert (steps[0].method, len(steps)) == ("nearby equilibrium", 2)  # the second confirms it


@pytest.mark.heavy
@pytest.mark.parametrize("bricks", [3000, 5000])
def test_few_blocks_are_solved_apart_from_a_large_wall(bricks):
    """A few large residuals kept the tangent of all regularised: corrections of the whole became more with its size."""
    model, found = tilted_wall(bricks).model(), {}
    for sweeps in (False, True):
        step = begun(model)
        attempt = newton(step, step.elastic_position, 1e-6, shrinking=0.7, sweeps=sweeps)
        found[sweeps] = attempt, step.factors.count
    (whole, many), (swept, few) = found[False], found[True]
    assert few < many
    assert swept.outcome is Outcome.SOLVED
    if whole.outcome is Outcome.SOLVED:
        assert_allclose(swept.position, whole.position, rtol=0, atol=1e-8 * np.abs(whole.position).max())


def test_no_blocks_are_solved_apart_where_all_are_out_of_balance():
    """In slopes from zero stress it took up to 100 s in 10 000 blocks, and changed no outcome."""
    model, found = leaning_slope(600, friction=30.0).model(), {}
    for sweeps in (False, True):
        step = begun(model)
        attempt = newton(step, step.elastic_position, 1e-6, shrinking=0.7, sweeps=sweeps)
        found[sweeps] = attempt.position, step.factors.count
    (whole, many), (swept, as_many) = found[False], found[True]
    assert as_many == many
    assert_allclose(swept, whole, rtol=0, atol=0)


def falling(local, tolerance):
    return newton(local, local.start, tolerance, shrinking=newton_method.WORTH_REPEATING)


@pytest.mark.heavy
@pytest.mark.parametrize(("courses", "bricks"), [(80, 12), (100, 16)])
def test_a_heel_on_one_corner_turns_until_the_next_one_touches(courses, bricks, monkeypatch):
    """At its strength the corner holds whatever the brick does: the norm cannot fall before the gap closes."""
    model, found = tilted_courses(courses, bricks, tilt=6.0).model(), []
    for only_falls in (True, False):
        if only_falls:
            monkeypatch.setattr(newton_method, "_solved_apart", falling)
        step = begun(model)
        attempt = newton(step, step.elastic_position, 1e-9, shrinking=0.7, sweeps=True)
        assert attempt.outcome is Outcome.SOLVED
        found.append((attempt.position, step.factors.count))
        monkeypatch.undo()
    (before, many), (position, few) = found
    assert few < many
    assert_allclose(position, before, rtol=0, atol=1e-6 * np.abs(before).max())


def test_few_blocks_alone_need_no_factorization_of_the_whole():
    """In a large model their residual is no part of the rms; six searches for contacts left them as they were."""
    step = begun(tilted_wall(300).model())
    rest = newton(step, step.elastic_position, 1e-8, shrinking=0.7).position
    away, before = rest.copy(), step.factors.count
    away[150, 0] += 1e-7
    start = step.residual_at(away)
    given = {"max_rms": 2 * start.rms, "shrinking": 0.7}
    assert newton(step, away, 1e-6, **given).outcome is Outcome.ACCEPTABLE
    found = newton(step, away, 1e-6, **given, sweeps=True)
    assert found.outcome is Outcome.SOLVED
    assert step.factors.count == before
    assert_allclose(found.position, rest, rtol=0, atol=1e-10)


def test_a_small_block_among_many_at_rest_is_solved_too():
    """The rms residual was low from the start: six searches for contacts left the block as it was."""
    notch, wedge = (shape / 10 for shape in scene("wedge")[0])
    row = [rectangle(x, 0, x + 1, 1) for x in range(2, 402, 2)]
    step = begun(model_of([rectangle(1, -0.1, 402, 0), notch, wedge, *row], friction=20.0, fixed=(0, 1)))
    start, goal = step.residual_at(step.elastic_position), Goal(max_residual=2 * FEW_CHANGE, rest=1e-8)
    assert start.rms < FEW_CHANGE < goal.max_residual < start.max_norm
    found = NearbyEquilibrium().solve(step, AT_REST, goal)
    assert found.outcome is Outcome.SOLVED
    assert found.equations.residual_at(found.position).max_norm < goal.max_residual


@pytest.mark.heavy
@pytest.mark.parametrize(("bricks", "apart"), [(300, False), (5000, True)])
def test_blocks_are_solved_apart_in_large_models_only(bricks, apart, monkeypatch):
    asked, solve = [], nearby.newton
    monkeypatch.setattr(nearby, "newton", lambda *given, **more: asked.append(more["sweeps"]) or solve(*given, **more))
    NearbyEquilibrium().solve(begun(tilted_wall(bricks).model()), AT_REST, GOAL)
    assert set(asked) == {apart}


def test_a_block_that_must_slide_has_none_nearby():
    model = model_of([turned(p, 45.0) for p in (BASE, rectangle(0, 0, 1, 1))], friction=25.0)
    assert NearbyEquilibrium().solve(begun(model), AT_REST, GOAL).outcome is Outcome.STALLED


def test_what_is_at_rest_is_not_moved():
    step = begun(model_of([BASE, rectangle(0, 0, 1, 1)], gamma=0.0))
    found = NearbyEquilibrium().solve(step, AT_REST, GOAL)
    assert found.outcome is Outcome.SOLVED
    assert_allclose(found.position, step.start, atol=0)


def test_it_is_for_blocks_at_rest():
    step = begun(model_of([BASE, rectangle(0, 0, 1, 1)]))
    assert NearbyEquilibrium().applies(step, AT_REST, GOAL)
    assert not NearbyEquilibrium().applies(step, Iterate(residual=1.0, velocity=still(2)), GOAL)


@pytest.mark.parametrize("name", ["column", "tilted wall", "wedge"])
def test_without_it_a_run_ends_in_the_same_verdict_and_place(monkeypatch, name):
    polygons, friction = scene(name)
    model, options = model_of(polygons, friction=friction), bsm.Options(scheme="continuation")
    wanted = bsm.run(model, options)
    without(monkeypatch, "nearby equilibrium")
    found = bsm.run(model, options)
    assert "nearby equilibrium" in {step.method for step in wanted.stages[0].steps}
    assert "nearby equilibrium" not in {step.method for step in found.stages[0].steps}
    assert found.status == wanted.status == "stable"
    assert found.check().ok
    assert wanted.check().ok
    size = np.abs(wanted.stages[0].displacement).max()
    assert_allclose(found.stages[0].displacement, wanted.stages[0].displacement, rtol=0, atol=0.2 * size)
    assert sum(s.factorizations for s in wanted.stages[0].steps) < 40


@pytest.mark.heavy
def test_after_an_excavation_the_verdict_is_the_same_without_it(monkeypatch):
    """A wall loses a brick of its second course; what is above it bridges the gap."""
    bricks = running_bond(5, 4)
    hole = tuple(map(tuple, bricks[6].tolist()))
    stages = [bsm.Stage(name="whole"), bsm.Stage(name="without", excavate=(hole,))]
    model = model_of([BASE, *bricks], stages=stages)
    wanted = bsm.run(model, bsm.Options(scheme="continuation"))
    without(monkeypatch, "nearby equilibrium")
    found = bsm.run(model, bsm.Options(scheme="continuation"))
    assert {stage.status for stage in (*found.stages, *wanted.stages)} == {"stable"}
    assert "nearby equilibrium by subdomains" in {step.method for step in wanted.stages[-1].steps}
    assert found.check().ok
    size = np.abs(wanted.stages[-1].displacement).max()
    assert_allclose(found.stages[-1].displacement, wanted.stages[-1].displacement, rtol=0, atol=0.3 * size)
