"""Strategies of a step: from rest, with frozen friction, with contacts updated within the first one."""

import weakref
from dataclasses import replace
from functools import partial
from itertools import pairwise

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_equal
from step_scenes import CONTINUATION, block_on_a_base

import bsm_mesh as bsm
from bsm_mesh.solve.contacts.history import commit, restore_history
from bsm_mesh.solve.continuation import first_step, strategies
from bsm_mesh.solve.continuation.loop import FIRST_LAM, MIN_LAM, Continuation
from bsm_mesh.solve.continuation.strategies import MAX_FAILURES, MovingSteps
from bsm_mesh.solve.methods import regularized_newton as regularized
from bsm_mesh.solve.methods.newton import elastic_position, newton
from bsm_mesh.solve.motion import sliding
from bsm_mesh.solve.step.attempt import Attempt
from bsm_mesh.solve.step.equations import MAX_MOVEMENT, Step

FRICTION = 35.0


def begin_on_a_base(tilt: float = 0.0) -> Continuation:
    """Return the continuation of a square metre on a base, tilted [degrees] in that gravity is."""
    return Continuation(block_on_a_base(tilt), CONTINUATION, lambda *_: None)


def pressed_and_pushed(step: Step, down: float, aside: float) -> np.ndarray:
    """Return the position with the block moved [m]."""
    return step.anchor + np.array([[0.0, 0.0, 0.0], [aside, -down, 0.0]])


def test_frozen_strength_does_not_follow_the_pressure():
    run = begin_on_a_base()
    contacts = run.system.gather(run.begin.history, run.system.start, first=True)
    step = Step(run.system, run.factors, contacts, run.system.start, 1.0)
    at = step.evaluate(pressed_and_pushed(step, 1e-5, 1e-3))
    held = step.with_frozen_friction(at.pressure)
    strength = np.tan(np.radians(FRICTION)) * at.pressure[at.closed]
    for down in (1e-5, 3e-5, -1e-5):  # the last is off the base: the held friction still acts in this step
        again = held.evaluate(pressed_and_pushed(step, down, 1e-3))
        assert_allclose(np.abs(again.shear[at.closed]), strength, rtol=1e-12)
        assert_allclose(again.pressure.sum(), max(0.0, 1e9 * down), rtol=1e-9)
        assert not again.dshear_dpressure.any()
    assert step.frozen_pressure is None


def sliding_step(tilt: float, part: float) -> Step:
    """Return a step of a block that slides, its pressure where the step begins being `part` of what it will be."""
    run = begin_on_a_base(tilt)
    contacts = run.system.gather(run.begin.history, run.system.start, first=True)
    anchor = run.system.start.copy()
    anchor[1, 1] -= part * 26e3 * np.cos(np.radians(tilt)) / 1e9
    return Step(run.system, run.factors, contacts, anchor, 1.0 / run.system.d)


def without_newton(*, coupled_only: bool):
    """Return Newton's method as it is where it never converges."""

    def fails(step: Step, position: np.ndarray, *given, **options) -> Attempt:
        if step.frozen_pressure is not None and coupled_only:
            return newton(step, position, *given, **options)
        return Attempt(position, step.evaluate(position), converged=False)

    return fails


@pytest.mark.parametrize(("coupled_only", "within"), [(True, 1e-6), (False, strategies.SWITCH_RESIDUAL)])
def test_a_moving_step_that_fails_has_friction_that_lags_by_a_step(monkeypatch, coupled_only, within):
    """Of a sliding block: ``sin(tilt) - tan(friction) p / W = lam u``, the pressure p that at the end or the beginning.

    So it is where bolts forbid cycles. With strengths held Newton's method may fail as well: then what it should polish
    is taken as it is.
    """
    tilt, part = 40.0, 0.5
    step = sliding_step(tilt, part)
    down, aside = np.cos(np.radians(tilt)), np.sin(np.radians(tilt))

    def moved(found: Attempt) -> float:
        assert found.converged
        return float((found.position - step.anchor)[1, 0] * step.lam)

    slope = np.tan(np.radians(FRICTION))
    monkeypatch.setattr(strategies, "can_follow_dynamically", lambda _: False)
    moving = MovingSteps(excavated=False)
    coupled = moving.solve(step, 1e-7, from_rest=False, failures=MAX_FAILURES)
    assert_allclose(coupled.at.pressure.sum() / 26e3, down, rtol=1e-3)  # it has settled less, by lam
    assert_allclose(moved(coupled), aside - slope * coupled.at.pressure.sum() / 26e3, atol=1e-6)
    for module in (strategies, regularized):
        monkeypatch.setattr(module, "newton", without_newton(coupled_only=coupled_only))
    assert not moving.solve(step, 1e-3, from_rest=False, failures=MAX_FAILURES - 1).converged, "shorter steps first"
    for failures in (MAX_FAILURES, MAX_FAILURES, 0):  # the second failure holds the strengths for two steps
        held = moving.solve(step, 1e-3, from_rest=False, failures=failures)
        assert_allclose(moved(held), aside - part * slope * down, atol=within)
    assert not moving.solve(step, 1e-3, from_rest=False, failures=0).converged
    assert not moving.solve(step, 1e-3, from_rest=True, failures=MAX_FAILURES).converged, "not from rest"


def test_a_first_step_with_hardly_any_movement_has_the_friction_of_closed_contacts(monkeypatch):
    tilt = 40.0
    step = sliding_step(tilt, 0.0)
    step.lam = 2 * strategies.CRAWLING / step.system.d
    monkeypatch.setattr(strategies, "newton", without_newton(coupled_only=True))
    monkeypatch.setattr(strategies, "can_follow_dynamically", lambda _: False)
    found = MovingSteps(excavated=False).solve(step, 1e-3, from_rest=True, failures=0)
    assert found.converged
    closed = step.evaluate(elastic_position(step)).pressure.sum() / 26e3
    assert_allclose(closed, np.cos(np.radians(tilt)), rtol=0.05)
    driving = np.sin(np.radians(tilt)) - np.tan(np.radians(FRICTION)) * closed
    assert_allclose((found.position - step.anchor)[1, 0] * step.lam, driving, atol=1e-3)


def test_a_step_from_rest_begins_with_contacts_within_tolerance_closed():
    """They bear nothing yet: with the tangent as it is, only the regularisation would resist."""
    run = begin_on_a_base()
    contacts = run.system.gather(run.begin.history, run.system.start, first=True)
    step = Step(run.system, run.factors, contacts, run.system.start, FIRST_LAM / run.system.d)
    found = MovingSteps(excavated=False).solve(step, 1e-3, from_rest=True, failures=0)
    assert found.converged
    assert run.factors.count == 1
    assert_allclose(found.position[1, 1] - step.anchor[1, 1], -26e3 / 1e9, rtol=1e-3)


def test_updated_contacts_remember_where_they_began_to_slide():
    run = begin_on_a_base()
    contacts = run.system.gather(run.begin.history, run.system.start, first=True)
    step = Step(run.system, run.factors, contacts, run.system.start, 1.0)
    moved = pressed_and_pushed(step, 2.6e-5, 1e-3)
    at, size = step.evaluate(moved), run.system.outlines.size
    history, _ = commit(contacts, at, moved, size)
    committed = run.system.gather(history, moved, first=False)
    recalled = restore_history(committed, contacts, at, size)
    for again, anchored in ((committed, at.tangential), (recalled, contacts.old_tangential)):
        old = again.old_tangential[again.within_tolerance]
        assert_allclose(np.sort(old), np.sort(anchored[at.closed]), atol=1e-12)
        assert_allclose(run.system.evaluate(again, moved).forces, at.forces, atol=1e-6 * 26e3)
    assert not recalled.old_shear.any()
    assert committed.old_shear.any()


def leaning_wall() -> bsm.Model:
    """Return a wall in running bond in which many contacts slip."""
    courses, bricks = 8, 12
    polygons = [[(-1, -0.5), (bricks + 1, -0.5), (bricks + 1, 0), (-1, 0)]]
    for c in range(courses):
        joints = np.arange(bricks + 1.0) if c % 2 == 0 else np.concatenate([[0], np.arange(bricks) + 0.5, [bricks]])
        y = 0.5 * c
        polygons += [[(a, y), (b, y), (b, y + 0.5), (a, y + 0.5)] for a, b in pairwise(joints)]
    return bsm.Model(
        blocks=bsm.Blocks.from_polygons(polygons, rock="r"),
        rocks=[bsm.Rock("r", unit_weight=2500 * 9.81)],
        joints=[bsm.Joint("J", 1e8, 1e8, law=bsm.MohrCoulomb(friction=FRICTION))],
        default_joint="J",
        supports=[bsm.Fixed(blocks=[0])],
        gravity_direction=-85.0,
    )


def test_a_start_with_a_small_residual_is_solved_to_the_tolerance():
    run = begin_on_a_base()
    nearly = run.system.start.copy()
    nearly[1, 1] -= (1 - 5e-4) * 26e3 / 1e9
    taken = run._first(partial(run.system.gather, run.begin.history, run.system.start, first=True), nearly)
    assert taken.found.converged
    assert run.system.static_residual(taken.step.contacts, taken.found.position) < 1e-6


def test_a_wall_rests_after_one_step_and_its_confirmation():
    """Where thousands of contacts slip, the lengths they share change by the slip: the first step takes that in."""
    stage = bsm.run(leaning_wall(), CONTINUATION).stages[0]
    assert stage.status == "stable"
    first, second = stage.steps
    assert first.slipping_contacts > 20
    assert second.factorizations == 0


def test_contacts_updated_within_the_first_step_have_no_history_yet():
    """What slides still remembers where it began to: committed on the way it would begin anew."""
    seen = []
    run = Continuation(leaning_wall(), CONTINUATION, lambda record, motion: seen.append(motion()))
    run.run()
    first, second = (motion.contacts for motion in seen)
    assert (first.candidates.history >= 0).any(), "they were updated"
    assert not first.old_shear.any()
    assert second.old_shear.any()


def test_the_contacts_of_the_start_are_not_kept(monkeypatch):
    """Of a million bricks they take 0.7 GB, while those of the last update and of the next are needed."""
    run = Continuation(leaning_wall(), CONTINUATION, lambda record, motion: None)
    gather, gathered, alive = run.system.gather, [], []

    def watched(*given, **keys):
        alive.append(sum(reference() is not None for reference in gathered))
        found = gather(*given, **keys)
        gathered.append(weakref.ref(found.offset))
        return found

    monkeypatch.setattr(run.system, "gather", watched)
    monkeypatch.setattr(first_step, "CONFIRMED", 0.0)  # so that one update more is made than is needed
    run.run()
    assert len(alive) > 3
    assert max(alive) == 1


def test_forces_at_a_former_position_are_evaluated_again():
    run = begin_on_a_base()
    contacts = run.system.gather(run.begin.history, run.system.start, first=True)
    step = Step(run.system, run.factors, contacts, run.system.start, 1.0)
    balance = step.residual_at(pressed_and_pushed(step, 1e-5, 0.0))
    at = balance.at
    assert balance.at is at
    for down in (2e-5, 3e-5):
        step.residual_at(pressed_and_pushed(step, down, 0.0))
    assert balance.at is not at
    assert_equal(balance.at.pressure, at.pressure)


def column(count: int, stiffness: float) -> bsm.Results:
    """Return the equilibrium of blocks half a metre high, one on the other; wide enough not to buckle."""
    polygons = [[(-1, -1), (5, -1), (5, 0), (-1, 0)]]
    polygons += [[(0, k / 2), (4, k / 2), (4, (k + 1) / 2), (0, (k + 1) / 2)] for k in range(count)]
    model = bsm.Model(
        blocks=bsm.Blocks.from_polygons(polygons, rock="r"),
        rocks=[bsm.Rock("r", unit_weight=26e3)],
        joints=[bsm.Joint("J", stiffness, stiffness, law=bsm.MohrCoulomb(friction=FRICTION))],
        default_joint="J",
        supports=[bsm.Fixed(blocks=[0])],
    )
    return bsm.run(model, CONTINUATION)


def test_common_settlement_takes_one_step(monkeypatch):
    """A column sinks at its top by the sum of what lies on its joints over their stiffness: twelve step lengths."""
    count, stiffness = 80, 5e7
    settlement = 13e3 * count * (count + 1) / 2 / stiffness
    stage = column(count, stiffness).stages[-1]
    assert stage.status == "stable"
    assert_allclose(-stage.displacement[-1, 1], settlement, rtol=1e-9)
    assert len(stage.steps) == 2
    assert stage.steps[0].residual < 1e-8  # the least regularisation, anchored at the start, would bear 1.2e-6
    monkeypatch.setattr(Step, "allow_elastic_settlement", lambda step, elastic: None)
    slow = column(count, stiffness).stages[-1]
    assert_allclose(-slow.displacement[-1, 1], settlement, rtol=1e-6)
    assert len(slow.steps) > 5


def test_relative_movement_gets_no_settlement_allowance():
    run = begin_on_a_base()
    contacts = run.system.gather(run.begin.history, run.system.start, first=True)
    step = Step(run.system, run.factors, contacts, run.system.start, run.min_lam)
    far = 3 * MAX_MOVEMENT * run.system.d
    step.allow_elastic_settlement(step.start + np.array([[0.0, 0.0, 0.0], [far, 0.0, 0.0]]))
    assert step.settlement_allowance == 0
    assert not step.within_search_range(step.start + np.array([[0.0, 0.0, 0.0], [far, 0.0, 0.0]]))
    together = step.start + np.array([[far, 0.0, 0.0], [far, 0.0, 0.0]])
    step.allow_elastic_settlement(together)
    assert_allclose(step.settlement_allowance, far)
    assert step.within_search_range(together)
    assert not step.within_search_range(step.start + np.array([[0.0, 0.0, 0.0], [far, 0.0, 0.0]]))


@pytest.mark.parametrize(("tolerance", "scattered"), [(1e-3, [0.0, 9e-4]), (5e-7, [])])
@pytest.mark.parametrize("stressed", [False, True])
def test_newtons_method_is_given_time_from_zero_stress_and_few_blocks_until_contacts_are_updated(
    monkeypatch, stressed, tolerance, scattered
):
    run = begin_on_a_base()
    contacts = run.system.gather(run.begin.history, run.system.start, first=True)
    if stressed:
        rows = np.zeros(contacts.count, np.int32)
        contacts = replace(contacts, candidates=replace(contacts.candidates, history=rows))
    step = Step(run.system, run.factors, contacts, run.system.start, run.min_lam)
    given = []

    def newton_ends(step: Step, position: np.ndarray, tolerance: float, **keys) -> Attempt:
        here = step.residual_at(position)
        weights = here.weight * np.sqrt(len(position))
        enough = [part for part in (0.0, 9e-4, 1.1e-3) if keys["enough"](replace(here, l2_norm=part * weights))]
        given.append((keys["shrinking"], enough))
        return Attempt(position, step.evaluate(position), converged=True)

    monkeypatch.setattr(first_step, "regularized_newton", newton_ends)
    first_step.solve_at_once(step, tolerance)
    assert given == [(regularized.SHRINKING if stressed else regularized.WORTHWHILE, scattered)]


@pytest.mark.parametrize(("few", "use_interior_point"), [(10.0, False), (0.0, True)])
def test_after_an_excavation_a_localized_residual_needs_no_interior_point_method(monkeypatch, few, use_interior_point):
    run = begin_on_a_base()
    contacts = run.system.gather(run.begin.history, run.system.start, first=True)
    rows = np.zeros(contacts.count, np.int32)  # stressed before
    contacts = replace(contacts, candidates=replace(contacts.candidates, history=rows))
    step = Step(run.system, run.factors, contacts, run.system.start, run.min_lam)
    nowhere = Attempt(step.start, step.evaluate(step.start), converged=False)
    asked = []
    monkeypatch.setattr(first_step, "FEW_MOVE", few)
    monkeypatch.setattr(first_step, "regularized_newton", lambda *_, **__: nowhere)
    monkeypatch.setattr(first_step, "newton_from_interior_point", lambda *_: asked.append("inside") or nowhere)
    assert first_step.solve_at_once(step, 1e-3, excavated=True) is nowhere
    assert bool(asked) is use_interior_point


@pytest.mark.parametrize(
    ("intact", "from_rest", "slid", "expected"),
    [
        (False, False, False, [0.4, 1.6]),
        (True, False, False, [MIN_LAM, FIRST_LAM]),
        (True, False, True, [0.4, 1.6]),
        (True, True, False, [MIN_LAM, 0.4]),
        (False, True, False, [MIN_LAM, 0.4]),
    ],
)
def test_where_blocks_move_a_step_lets_a_free_one_move_by_a_step_length(monkeypatch, intact, from_rest, slid, expected):
    """Its residual is its weight, .4 of the mean of both blocks: ``lam d = .4``; a failed step is shorter."""
    monkeypatch.setattr(sliding, "MIN_BLOCKS", 0)
    run = begin_on_a_base()
    run.begin = replace(run.begin, intact=intact)
    contacts = run.system.gather(run.begin.history, run.system.start, first=True)
    velocity = np.zeros_like(run.system.start) if slid else None
    tried = []

    def ends_the_second_time(step: Step, inner: float, **_: object) -> Attempt:
        assert step.velocity is velocity
        tried.append(step.lam * run.system.d)
        return Attempt(step.start, step.evaluate(step.start), converged=len(tried) > 1)

    monkeypatch.setattr(run.movement, "solve", ends_the_second_time)
    run._solve_step(contacts, run.system.start, run.min_lam, velocity, from_rest=from_rest, quiet=True)
    assert_allclose(tried, expected, rtol=1e-3)
