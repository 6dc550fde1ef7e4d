"""Methods near rest, where few blocks or few contacts are the cause of the residual."""

from dataclasses import replace

import numpy as np
import pytest
from step_scenes import CONTINUATION, STIFFNESS, WEIGHT, begun, block_on_a_base

import bsm_mesh as bsm
from bsm_mesh.solve.continuation import strategies
from bsm_mesh.solve.continuation.loop import Continuation
from bsm_mesh.solve.methods import regularized_newton as regularized
from bsm_mesh.solve.motion.damped_motion import DampedMotion
from bsm_mesh.solve.motion.relaxation import DAMPING_TRANSITS, PATIENT_TRANSITS, damp_to_rest, relax
from bsm_mesh.solve.step.attempt import Attempt
from bsm_mesh.solve.step.equations import Residual, Step

benchmarks = pytest.importorskip("benchmarks.scenes")


def moving_step() -> Step:
    """Return one of a block on a base, damped."""
    step = begun(block_on_a_base())
    step.lam = 1 / step.system.d
    return step


def with_residuals(step: Step, forces: list[float]) -> Residual:
    """Return that of as many blocks, each with a force [weights]."""
    size, weight = np.array(forces), 2.0
    greatest, norm = float(size.max()), float(np.linalg.norm(size)) * weight
    return Residual(np.zeros((len(size), 3)), step.residual_at(step.start).evaluate, size, greatest, norm, weight)


@pytest.mark.parametrize(
    ("forces", "few"),
    [
        ([1.0] + 99 * [0.0], True),
        (100 * [1.0], False),
        (100 * [0.02], True),  # little wherever it is
        ([10.0] + 399 * [0.2], False),  # little beside the greatest, but not little
    ],
)
def test_a_residual_is_localized_where_its_rms_is_small_beside_its_maximum(forces, few):
    step = begun(block_on_a_base())
    assert regularized._is_localized(step, with_residuals(step, forces)) is few


@pytest.mark.parametrize(("inner", "is_calmed"), [(1e-4, True), (1e-2, False)])
def test_near_rest_damped_motion_comes_after_newtons_method(monkeypatch, inner, is_calmed):
    step = moving_step()

    def fails(step: Step, position: np.ndarray, *_: float, **__: bool) -> Attempt:
        return Attempt(position, step.evaluate(position), converged=False)

    calmed = Attempt(step.start, step.evaluate(step.start), converged=True)
    monkeypatch.setattr(strategies, "regularized_newton", fails)
    monkeypatch.setattr(strategies, "damp_to_rest", lambda *_, **__: calmed)
    assert (
        strategies.MovingSteps(excavated=False).solve(step, inner, from_rest=False, failures=1) is calmed
    ) is is_calmed


@pytest.mark.parametrize(("moved", "begins"), [(1e-9, ["there", "start"]), (1.0, ["start"])])
@pytest.mark.parametrize("failures", [0, 1])
def test_cycles_begin_where_newtons_method_ended_if_that_is_nearer_to_rest(monkeypatch, moved, begins, failures):
    """In a step that failed before they go on from the start, next to which an equilibrium lies."""
    step = moving_step()
    there, asked = step.start - np.array([0.0, moved, 0.0]), []

    def gives_up(_: Step, position: np.ndarray, inner: float, *, patient: bool = False) -> None:
        asked.append(("start" if position is step.start else "there", inner, patient))

    def fails(step: Step, *_: float, **__: bool) -> Attempt:
        return Attempt(there, step.evaluate(there), converged=False)

    monkeypatch.setattr(strategies, "damp_to_rest", gives_up)
    monkeypatch.setattr(strategies, "regularized_newton", fails)
    strategies.MovingSteps(excavated=False).solve(step, 1e-6, from_rest=False, failures=failures)
    inner = strategies.REST_FACTOR * 1e-6
    assert asked == [(begin, inner, failures > 0 and begin == "start") for begin in begins]


@pytest.mark.parametrize(
    ("excavated", "part", "failures", "stressed", "inner", "before", "ends"),
    [
        (True, 0.1, 0, 1.0, 1e-2, 0.1, "taken"),
        (True, 0.1, strategies.MAX_FAILURES, 1.0, 1e-2, 0.1, "taken"),
        (True, 0.6, 0, 1.0, 1e-2, 1.0, "shorter"),
        (True, 0.6, strategies.MAX_FAILURES, 1.0, 1e-2, 1.0, "held"),
        (True, 4.0, 0, 50.0, 2e-2, 8.0, "taken"),
        (True, 4.0, 0, 50.0, 2e-2, 5.0, "shorter"),  # they hardly come nearer to balance, and would not ever
        (True, 6.0, 0, 50.0, 2e-2, 20.0, "shorter"),  # more than a tenth of what contacts bear,
        (True, 6.0, 1, 50.0, 2e-2, 20.0, "taken"),  # of which a shorter step may leave more
        (True, 4.0, 1, 50.0, 2e-2, 5.0, "shorter"),
        (True, 20.0, 1, 50.0, 2e-2, 40.0, "shorter"),  # the residual is not localized
        (True, 20.0, strategies.MAX_FAILURES, 50.0, 2e-2, 40.0, "held"),
        (True, 0.6, 0, 50.0, 1e-2, 1.0, "shorter"),  # it lacked no more than its weight: free blocks fall
        (False, 0.1, 0, 1.0, 1e-2, 0.1, "from inside"),
    ],
)
def test_after_an_excavation_a_localized_residual_is_accepted(
    monkeypatch, excavated, part, failures, stressed, inner, before, ends
):
    """One of 800 blocks has a residual below its weight: it moves on from there, or a shorter step is tried at once.

    In stressed rock the residual may be some weights, if it was more before.
    """
    step, tried = moving_step(), []
    step.system.residual_scale = stressed
    began, left = (with_residuals(step, [lacks] + 799 * [0.0]) for lacks in (before, part))
    there = step.start.copy()
    monkeypatch.setattr(Step, "residual_at", lambda _, position: left if position is there else began)

    def fails(step: Step, *_: float, enough=None, **__: bool) -> Attempt:
        return Attempt(there, step.evaluate(there), converged=enough is not None and enough(left))

    def counted(name):
        def solves(step, *_, **__):
            tried.append(name)
            return Attempt(step.start, step.evaluate(step.start), converged=True)

        return solves

    monkeypatch.setattr(strategies, "regularized_newton", fails)
    monkeypatch.setattr(strategies, "newton_from_interior_point", counted("from inside"))
    monkeypatch.setattr(strategies, "_with_frozen_friction", counted("held"))
    found = strategies.MovingSteps(excavated=excavated).solve(step, inner, from_rest=False, failures=failures)
    assert tried == ([ends] if ends in ("held", "from inside") else [])
    assert found.converged is (ends != "shorter")


def test_blocks_that_fall_from_a_roof_leave_the_others_at_rest():
    """Brittle joints fail around a tunnel in 3000 blocks, and two of its roof come down; it took 31 factorizations."""
    scene = benchmarks.blocky_rock(3000)
    stage = bsm.run(scene.model(1.0), CONTINUATION).stages[-1]
    assert stage.status == "unstable"
    assert sum(step.factorizations for step in stage.steps) <= 10
    middle = np.array([scene.polygons[block].mean(axis=0) for block in stage.unstable_blocks])
    assert 0 < len(middle) < 10
    assert (middle[:, 1] > 0.7 * np.hypot(*middle.T)).all()
    assert (np.hypot(*middle.T) < 1.2 * benchmarks.TUNNEL).all()


@pytest.mark.parametrize(("inner", "failures", "is_held"), [(1e-4, 1, True), (1e-4, 0, False), (1e-2, 1, False)])
def test_near_rest_friction_is_frozen_in_a_step_that_failed_before(monkeypatch, inner, failures, is_held):
    step = moving_step()
    held = []

    def fails(step: Step, position: np.ndarray, *_: float, **__: bool) -> Attempt:
        return Attempt(position, step.evaluate(position), converged=False)

    def holds(step: Step, position: np.ndarray, inner: float) -> Attempt:
        held.append(inner)
        return Attempt(position, step.evaluate(position), converged=True)

    monkeypatch.setattr(strategies, "regularized_newton", fails)
    monkeypatch.setattr(strategies, "damp_to_rest", lambda *_, **__: None)
    monkeypatch.setattr(strategies, "_with_frozen_friction", holds)
    monkeypatch.setattr(strategies, "can_follow_dynamically", lambda _: False)
    strategies.MovingSteps(excavated=False).solve(step, inner, from_rest=False, failures=failures)
    assert bool(held) is is_held


def nearly_at_rest() -> Step:
    """Return a step of a slope in which hundreds of contacts slide, blocks a little off where they rest."""
    rest = relax(begun(benchmarks.leaning_slope(1000, friction=32.0).model()), 5e-7)
    off = 1e-3 * WEIGHT / STIFFNESS * np.random.default_rng(1).normal(size=rest.start.shape)
    off[rest.supports.block] = 0.0
    return Step(rest.system, rest.factors, rest.contacts, rest.start + off, rest.lam)


def test_what_is_nearly_at_rest_comes_to_rest_in_a_few_cycles():
    step = nearly_at_rest()
    before, contacts = step.residual_at(step.start), step.contacts
    found = damp_to_rest(step, step.start, 0.1 * before.max_norm)
    assert found.converged
    assert step.residual_at(found.position).max_norm < 0.1 * before.max_norm
    assert step.contacts is not contacts  # with what slipped on the way
    assert step.contacts.candidates is contacts.candidates
    at = step.evaluate(found.position)
    assert (np.abs(at.shear) <= at.strength * (1 + 1e-12)).all()


def test_cycles_begin_where_they_are_told_to():
    step = nearly_at_rest()
    there = damp_to_rest(step, step.start, 0.1 * step.residual_at(step.start).max_norm).position
    again = nearly_at_rest()
    goal = 0.5 * again.residual_at(there).max_norm
    found = damp_to_rest(again, there, goal)
    assert again.residual_at(found.position).max_norm < goal
    moved = [np.abs(found.position - position).max() for position in (there, again.start)]
    assert moved[0] < 0.5 * moved[1]


@pytest.mark.parametrize("patient", [False, True])
def test_with_patience_cycles_go_on_for_as_long_as_they_lead_nearer_to_rest(patient):
    step = nearly_at_rest()
    found = damp_to_rest(step, step.start, 1e-3 * step.residual_at(step.start).max_norm, patient=patient)
    assert (found is not None) is patient


@pytest.mark.parametrize(("patient", "most"), [(False, DAMPING_TRANSITS), (True, PATIENT_TRANSITS)])
def test_cycles_end_where_they_do_not_lead_nearer_to_rest(monkeypatch, patient, most):
    """A block that falls, one of two."""
    step = begun(block_on_a_base())
    step.contacts = replace(step.contacts, within_tolerance=np.zeros_like(step.contacts.within_tolerance))
    up = step.start + np.array([[0.0, 0.0, 0.0], [0.0, 0.01, 0.0]])
    cycles, advance = [], DampedMotion.advance
    monkeypatch.setattr(DampedMotion, "advance", lambda self, count: cycles.append(count) or advance(self, count))
    assert damp_to_rest(step, up, 1e-6, patient=patient) is None
    assert sum(cycles) == np.ceil(most * np.sqrt(2))


def test_what_does_not_is_left_as_it_is():
    step = nearly_at_rest()
    contacts = step.contacts
    assert damp_to_rest(step, step.start, 1e-15) is None
    assert step.contacts is contacts


@pytest.mark.filterwarnings("error")
def test_cycles_that_burst_end_at_once(monkeypatch):
    step = nearly_at_rest()
    went_on, advance = [], DampedMotion.advance

    def bursts(cycles, count):
        went_on.append(count)
        advance(cycles, count)
        cycles.residual = replace(cycles.residual, l2_norm=np.inf, max_norm=np.nan)

    monkeypatch.setattr(DampedMotion, "advance", bursts)
    assert damp_to_rest(step, step.start, 1e-15) is None
    assert len(went_on) == 1


def test_tolerances_of_steps_are_relative_to_the_weight_of_a_block():
    """Contacts bear twenty times that at the start."""
    run = Continuation(block_on_a_base(), CONTINUATION, lambda *_: None)
    run.system.residual_scale = 20.0
    run.begin = replace(run.begin, intact=False)
    assert run.tolerance == pytest.approx(20.0 * CONTINUATION.tolerance, rel=1e-12)
    assert run._step_tolerance(0.0) == pytest.approx(10.0 * CONTINUATION.tolerance, rel=1e-12)
    assert run._moving_lam(0.01) * run.system.d == pytest.approx(0.2)
    assert run._moving_lam(0.1) * run.system.d == pytest.approx(1.0)
