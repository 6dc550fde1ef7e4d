"""Blocks that slide far are followed by cycles: they keep their velocity, and what bears on the way is known."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from step_scenes import CONTINUATION, WEIGHT, begun, block_on_a_base

import bsm_mesh as bsm
from bsm_mesh.solve.continuation import strategies
from bsm_mesh.solve.continuation.loop import Continuation, _Taken
from bsm_mesh.solve.continuation.strategies import MAX_PAUSE_FOLLOWED, MovingSteps
from bsm_mesh.solve.continuation.verdict import FREE_MOVE, CollapseCriterion
from bsm_mesh.solve.motion import damped_motion, sliding
from bsm_mesh.solve.motion.damped_motion import DampedMotion
from bsm_mesh.solve.motion.sliding import DAMPING, can_follow_dynamically, follow_dynamically, is_fast
from bsm_mesh.solve.step.attempt import Attempt
from bsm_mesh.solve.step.equations import Step

benchmarks = pytest.importorskip("benchmarks.scenes")
TILT, FRICTION = 50.0, 35.0


@pytest.fixture(autouse=True)
def few_are_many(monkeypatch):
    """Let cycles follow few blocks as well: their motion is known in closed form."""
    monkeypatch.setattr(sliding, "MIN_BLOCKS", 0)


def after(step: Step, found: Attempt) -> Step:
    """Return the next step, from where one has led."""
    there = Step(step.system, step.factors, step.contacts, found.position, step.lam)
    there.velocity = found.velocity
    return there


def test_a_block_gains_the_velocity_that_friction_and_damping_leave_it(monkeypatch):
    """``v^2 = 2 s (1 - damping) (sin - cos tan(friction)) W / m``, over steps that each end after a step length."""
    masses = []
    monkeypatch.setattr(
        DampedMotion, "_mass", lambda *given, mass=DampedMotion._mass: masses.append(mass(*given)) or masses[-1]
    )
    monkeypatch.setattr(sliding, "MAX_TRANSITS", 1e4)
    step = begun(block_on_a_base(TILT))
    for _ in range(4):
        before, found = step.start, follow_dynamically(step, 1e-6)
        assert found.converged
        assert found.contacted_during_step.sum() == 2
        assert 1.0 <= step.movement(found.position - before) / step.system.d < 1.0 + 3 * sliding.AT_ONCE
        step = after(step, found)
        assert is_fast(step)
    angle = np.radians(TILT)
    pull = (1 - DAMPING) * (np.sin(angle) - np.cos(angle) * np.tan(np.radians(FRICTION))) * WEIGHT
    gone, velocity = step.start[1, 0], step.velocity[1, 0]
    assert_allclose(velocity**2, 2 * gone * pull / masses[-1][1, 0], rtol=0.05)


def test_a_step_of_slow_blocks_ends_after_some_cycles_and_one_at_rest_with_none(monkeypatch):
    step, gone = begun(block_on_a_base(TILT)), []
    advance = DampedMotion.advance
    monkeypatch.setattr(
        DampedMotion, "advance", lambda self, count, **keys: gone.append(count) or advance(self, count, **keys)
    )
    found = follow_dynamically(step, 1e-6)
    assert sum(gone) >= sliding.MAX_TRANSITS * np.sqrt(2)
    assert step.movement(found.position - step.start) < step.system.d
    assert not is_fast(after(step, found))
    gone.clear()
    follow_dynamically(after(step, found), 1e9)
    assert not gone


def test_the_initial_residual_is_ramped_once(monkeypatch):
    ramps, begin = [], DampedMotion.__init__
    monkeypatch.setattr(
        DampedMotion,
        "__init__",
        lambda self, step, ramp, damping, **keys: ramps.append(ramp) or begin(self, step, ramp, damping, **keys),
    )
    step = begun(block_on_a_base(TILT))
    follow_dynamically(after(step, follow_dynamically(step, 1e-6)), 1e-6)
    assert ramps == [int(sliding.RAMP_TRANSITS * np.sqrt(2)), 1]


def test_cycles_that_burst_are_no_step(monkeypatch):
    step = begun(block_on_a_base(TILT))

    def bursts(self, *_, **__):
        self.residual = step.residual_at(np.full_like(step.start, np.nan))

    monkeypatch.setattr(DampedMotion, "advance", bursts)
    assert not follow_dynamically(step, 1e-6).converged


def falling_onto_another(gap: float) -> bsm.Model:
    """Return a base, a block on it, and one so far above that."""
    base, lower = [(0, 0), (4, 0), (4, 1), (0, 1)], [(1, 1), (2, 1), (2, 2), (1, 2)]
    upper = [(x, y + 1 + gap) for x, y in lower]
    return block_on_a_base(blocks=bsm.Blocks.from_polygons([base, lower, upper], rock="r"))


@pytest.mark.parametrize("gap", [0.006, 0.015])
def test_a_block_is_met_however_it_is_accelerated(gap):
    """It begins to fall so far above another that it would be there within a hundred cycles."""
    step = begun(falling_onto_another(gap))
    for _ in range(6):
        found = follow_dynamically(step, 1e-6)
        step = after(step, found)
    assert (found.position[2, 1] - found.position[1, 1]) == pytest.approx(-gap, abs=1e-3)


def test_a_block_that_was_slower_is_met_too(monkeypatch):
    """In its first cycle it hardly falls, in the next hundred onto another: as if all contacts had counted."""
    step, ways = begun(falling_onto_another(0.006)), []
    for room in (damped_motion.REACH_MARGIN, np.inf):
        monkeypatch.setattr(damped_motion, "REACH_MARGIN", room)
        motion, margin = DampedMotion(step, 1, DAMPING, lightest=0.5), step.system.d
        motion.advance(1, margin=margin)
        motion.advance(100, margin=margin)
        ways.append(motion.residual.position)
    assert ways[0][2, 1] - ways[0][1, 1] == pytest.approx(-0.006, abs=1e-3)
    assert_array_equal(*ways)


def test_how_long_a_fixed_base_is_changes_nothing():
    """Neither how far blocks may fall in some cycles, nor the masses of those on it."""
    found = []
    for length in (4.0, 400.0):
        polygons = [[(0, 0), (length, 0), (length, 1), (0, 1)], [(1, 1), (2, 1), (2, 2), (1, 2)]]
        step = begun(block_on_a_base(blocks=bsm.Blocks.from_polygons(polygons, rock="r")))
        motion = DampedMotion(step, 1, DAMPING, lightest=0.5)
        motion.advance(1)
        found.append([sliding._cycles_within(0.01, motion, step), *motion.least_mass[1]])
    assert_allclose(*found, rtol=1e-9)


def test_neither_bolts_nor_prescribed_displacements_allow_it():
    wall = benchmarks.bolted_wall(100)
    assert not can_follow_dynamically(begun(wall.model()))
    step = begun(block_on_a_base(TILT))
    assert can_follow_dynamically(step)
    step.supports_move = True
    assert not can_follow_dynamically(step)


def test_few_blocks_are_not_followed(monkeypatch):
    step = begun(block_on_a_base(TILT))
    monkeypatch.setattr(sliding, "MIN_BLOCKS", len(step.start))
    assert can_follow_dynamically(step)
    monkeypatch.setattr(sliding, "MIN_BLOCKS", len(step.start) + 1)
    assert not can_follow_dynamically(step)


def test_a_block_in_contact_during_the_step_does_not_fall():
    """It hops: without contact at the end of every step, but not on the way."""
    step = begun(block_on_a_base())
    up = FREE_MOVE * np.arange(1, 5)[:, None, None] * np.array([[0.0, 0.0, 0.0], [1.0, 0.1, 0.0]])
    for held, falls in ((True, False), (False, True)):
        falling = CollapseCriterion(step.system, step.start, 10.0)
        contacted = np.full(step.contacts.count, held)
        reasons = [falling.check(step.contacts, contacted, step.start + movement)[0] for movement in up]
        assert bool(any(reasons)) is falls


@pytest.mark.parametrize("slid", [True, False])
def test_contacts_during_a_step_decide_which_blocks_fall(monkeypatch, slid):
    run = Continuation(block_on_a_base(), CONTINUATION, lambda *_: None)
    looked = []

    def takes(contacts, anchor, lam, *_, **__):
        step = Step(run.system, run.factors, contacts, anchor, lam)
        contacted = np.ones(contacts.count, dtype=bool)
        during = contacted if slid else None
        return _Taken(Attempt(anchor, step.evaluate(anchor), converged=True, contacted_during_step=during), step)

    monkeypatch.setattr(run, "_first", lambda *_: None)
    monkeypatch.setattr(run, "_solve_step", takes)
    monkeypatch.setattr(
        run.collapse, "check", lambda _, during, __: looked.append(during) or ("seen", np.zeros(0, dtype=np.int32))
    )
    assert run.run().reason == "seen"
    assert looked[0].all() == slid  # where it was given the block touches, and bears nothing yet


def no_solution(step: Step, *_: object, **__: object) -> Attempt:
    return Attempt(step.start, step.evaluate(step.start), converged=False)


@pytest.mark.parametrize(
    ("from_rest", "inner", "failures", "excavated", "ends"),
    [
        (True, 1e-2, 0, False, "unsolved"),  # with the least regularisation there is mostly no solution
        (True, 1e-2, 1, False, "inside"),
        (True, 1e-2, 2, False, "slides"),
        (True, 1e-2, 2, True, "inside"),
        (False, 1e-2, 0, False, "inside"),
        (False, 1e-2, 1, False, "slides"),
        (False, 1e-2, 2, True, "held"),
        (False, 1e-4, 0, False, "inside"),
        (False, 1e-4, 1, False, "slides"),
        (False, 1e-4, 1, True, "inside"),
    ],
)
def test_without_a_solution_by_newtons_method_blocks_are_followed_dynamically(
    monkeypatch, from_rest, inner, failures, excavated, ends
):
    step, tried = begun(block_on_a_base()), []
    step.start = step.start + np.array([[0.0], [1.0]])  # not localized

    def counted(name):
        return lambda step, *_, **__: tried.append(name) or no_solution(step)

    for name in ("regularized_newton", "newton"):
        monkeypatch.setattr(strategies, name, no_solution)
    monkeypatch.setattr(strategies, "damp_to_rest", lambda *_, **__: None)
    for name, called in (
        ("newton_from_interior_point", "inside"),
        ("follow_dynamically", "slides"),
        ("_with_frozen_friction", "held"),
    ):
        monkeypatch.setattr(strategies, name, counted(called))
    MovingSteps(excavated=excavated).solve(step, inner, from_rest=from_rest, failures=failures)
    assert (tried[-1:] or ["unsolved"]) == [ends]


def test_slow_blocks_are_followed_for_more_and_more_steps_until_newtons_method_succeeds(monkeypatch):
    step, tried = begun(block_on_a_base()), []
    step.velocity = np.zeros_like(step.start)
    solves = [False] * 4 + [True] + [False]

    def newtons(step, *_, **__):
        tried.append("newton")
        return Attempt(step.start, step.evaluate(step.start), converged=solves.pop(0))

    monkeypatch.setattr(strategies, "regularized_newton", newtons)
    monkeypatch.setattr(strategies, "follow_dynamically", lambda step, _: tried.append("slide") or no_solution(step))
    moving = MovingSteps(excavated=False)
    while solves:
        moving.solve(step, 1e-2, from_rest=False, failures=0)
    lengths = [len(run) for run in "".join(name[0] for name in tried).split("n")]
    assert lengths == [0, 2, 3, 1 + MAX_PAUSE_FOLLOWED, 1 + MAX_PAUSE_FOLLOWED, 0, 1]


def test_fast_blocks_are_followed_without_a_factorization(monkeypatch):
    step = begun(block_on_a_base(TILT))
    step.velocity = np.full_like(step.start, step.system.d)
    monkeypatch.setattr(strategies, "follow_dynamically", lambda *_: "slid")
    assert MovingSteps(excavated=False).solve(step, 1e-2, from_rest=False, failures=0) == "slid"
    assert step.factors.count == 0


def test_a_slide_that_burst_is_not_repeated(monkeypatch):
    step, tried = begun(block_on_a_base(TILT)), []
    step.velocity = np.full_like(step.start, step.system.d)
    monkeypatch.setattr(strategies, "follow_dynamically", lambda step, _: tried.append("slide") or no_solution(step))
    monkeypatch.setattr(
        strategies,
        "regularized_newton",
        lambda step, *_, **__: tried.append("newton") or Attempt(step.start, step.evaluate(step.start), converged=True),
    )
    moving = MovingSteps(excavated=False)
    for failures in (0, 1):
        moving.solve(step, 1e-2, from_rest=False, failures=failures)
    assert tried == ["slide", "newton"]


def test_blocks_that_came_to_rest_while_they_were_followed_are_confirmed_by_newtons_method(monkeypatch):
    step = begun(block_on_a_base())
    step.velocity = np.full_like(step.start, step.system.d)
    monkeypatch.setattr(strategies, "follow_dynamically", no_solution)
    assert MovingSteps(excavated=False).solve(step, 10.0, from_rest=False, failures=0).converged


def test_a_slope_slides_to_its_verdict_with_few_factorizations():
    """Its set at 40 degrees daylights, with 25 degrees of friction; implicit steps took 2000 factorizations."""
    slope = benchmarks.jointed_slope(400, 25.0, dips=(50.0, -40.0))
    stage = bsm.run(slope.model(), CONTINUATION).stages[-1]
    assert stage.status == "unstable"
    assert "lost all contact" in stage.reason
    assert sum(step.factorizations for step in stage.steps) < 200
    middle = np.array([slope.polygons[block].mean(axis=0) for block in stage.unstable_blocks])
    assert 0 < len(middle) < 60
    assert (middle[:, 1] > 0).all()  # above the toe
