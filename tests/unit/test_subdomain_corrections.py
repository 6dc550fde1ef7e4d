"""Corrections after an excavation move the blocks around the worst ones alone, where those are few of all."""

from copy import copy
from dataclasses import replace

import numpy as np
import pytest
from step_scenes import BRICKS, begun, block_on_a_base, wall_at_rest

from bsm_mesh.solve.continuation import first_step, strategies
from bsm_mesh.solve.continuation.acceptance import Leftover
from bsm_mesh.solve.methods import regularized_newton as softened
from bsm_mesh.solve.methods import subdomain_newton as local_phase
from bsm_mesh.solve.methods.newton import newton
from bsm_mesh.solve.methods.regularized_newton import softened_newton
from bsm_mesh.solve.methods.subdomain_newton import begins_with_few, correct_locally
from bsm_mesh.solve.step.attempt import Found
from bsm_mesh.solve.step.equations import Step

TOLERANCE, BLOCK, RINGS = 5e-7, 10 * BRICKS, 5


@pytest.fixture(scope="module")
def rest() -> tuple[Step, np.ndarray]:
    return wall_at_rest(TOLERANCE)


@pytest.fixture
def near(monkeypatch) -> None:
    """Let fewer blocks around the worst count as far around: those of a small wall are few of all then."""
    monkeypatch.setattr(local_phase, "AROUND", RINGS)


def pushed_from(position: np.ndarray) -> np.ndarray:
    pushed = position.copy()
    pushed[BLOCK, :2] += 2e-6
    return pushed


def stressed_and_pushed(rest: tuple[Step, np.ndarray]) -> Step:
    """Return a step that begins with a block out of place, its contacts stressed before."""
    step = copy(rest[0])
    step.start = pushed_from(rest[1])
    rows = np.zeros(step.contacts.count, np.int32)
    step.contacts = replace(step.contacts, candidates=replace(step.contacts.candidates, history=rows))
    return step


def test_a_correction_moves_only_blocks_around_the_worst(rest, near):
    step, position = rest
    pushed, factorized = pushed_from(position), step.factors.count
    found = correct_locally(step, pushed, TOLERANCE)
    assert found is not None
    moved = np.flatnonzero((found.position != pushed).any(axis=1))
    away = np.hypot(*(step.moving.outlines.centroid - step.moving.outlines.centroid[BLOCK]).T)
    assert away[moved].max() < 1.2 * (RINGS + 2)
    assert step.factors.count == factorized
    whole = newton(step, pushed, TOLERANCE, softened=True, most=1).position
    lack, together = (step.balance_at(there).norm for there in (found.position, whole))
    assert lack == pytest.approx(together, rel=0.1)
    assert lack < 0.5 * step.balance_at(pushed).norm
    assert np.abs(found.position - whole).max() < 0.05 * np.abs(whole - pushed).max()


def test_a_correction_ends_where_that_is_at_rest(rest, near):
    step, position = rest
    found, pushed = correct_locally(step, position, TOLERANCE), position.copy()
    assert found is None, "no block is to move"
    pushed[BLOCK, :2] += 2e-8
    found = correct_locally(step, pushed, 0.1)
    assert found is not None
    assert found.converged


def test_where_blocks_around_the_worst_are_not_few_all_are_corrected(rest, monkeypatch):
    step, position = rest
    pushed, factorized = pushed_from(position), step.factors.count
    monkeypatch.setattr(local_phase, "AROUND", 4 * RINGS)
    monkeypatch.setattr(softened, "_settled", lambda step, position, *_, **__: position)
    assert correct_locally(step, pushed, TOLERANCE) is None
    softened_newton(step, pushed, TOLERANCE, locally=True)
    assert step.factors.count > factorized


@pytest.mark.parametrize("locally", [False, True])
def test_corrections_are_of_all_blocks_unless_that_is_said(rest, near, monkeypatch, locally):
    step, position = rest
    asked = []

    def corrected(step: Step, at: np.ndarray, *_: float, **__: bool) -> Found:
        asked.append(len(at) < len(position))
        return Found(at, step.evaluate(at), converged=True)

    monkeypatch.setattr(softened, "_settled", lambda step, position, *_, **__: position)
    monkeypatch.setattr(softened, "newton", corrected)
    monkeypatch.setattr(local_phase, "newton", corrected)
    softened_newton(step, pushed_from(position), TOLERANCE, locally=locally)
    assert asked[0] is locally


def test_what_breaks_in_a_correction_is_broken_in_the_step(rest, near, monkeypatch):
    step, position = rest
    contacts, broken = step.contacts, []

    def breaks(local: Step, at: np.ndarray, *_: float, **__: bool) -> Found:
        local.break_contacts(np.array([3]))
        broken.append(local.rows[3])
        return Found(at, local.evaluate(at), converged=False)

    monkeypatch.setattr(local_phase, "newton", breaks)
    correct_locally(step, pushed_from(position), TOLERANCE)
    assert np.flatnonzero(step.contacts.failed & ~contacts.failed).tolist() == broken
    step.contacts = contacts


@pytest.mark.parametrize("excavated", [False, True])
def test_after_an_excavation_few_blocks_are_corrected_alone(monkeypatch, excavated):
    """In the first step as in those to come."""
    step, given = begun(block_on_a_base()), []
    rows = np.zeros(step.contacts.count, np.int32)  # stressed before
    step.contacts = replace(step.contacts, candidates=replace(step.contacts.candidates, history=rows))

    def ends(step: Step, position: np.ndarray, *_: float, **keys: bool) -> Found:
        given.append(keys["locally"])
        return Found(position, step.evaluate(position), converged=True)

    monkeypatch.setattr(first_step, "softened_newton", ends)
    monkeypatch.setattr(strategies, "softened_newton", ends)
    first_step.solve_at_once(step, TOLERANCE, excavated=excavated)
    first_step.solve_updated(step, step.start, TOLERANCE, excavated=excavated)
    strategies.MovingSteps(excavated=excavated).solve(step, 1e-2, from_rest=False, failures=0)
    assert given == 3 * [excavated]


@pytest.mark.parametrize(("little", "near"), [(True, True), (False, True), (True, False)])
def test_where_few_blocks_are_free_the_first_step_may_leave_what_a_moving_one_may(rest, monkeypatch, little, near):
    """It is not solved any further, nor with contacts that are updated."""
    step, factorized, corrections = stressed_and_pushed(rest), rest[0].factors.count, []

    def corrected(*given) -> Found | None:
        corrections.append(given)
        return correct_locally(*given)

    monkeypatch.setattr(local_phase, "AROUND", RINGS)
    monkeypatch.setattr(softened, "correct_locally", corrected)
    monkeypatch.setattr(Leftover, "is_little", lambda *_: little)
    monkeypatch.setattr(Step, "takes", lambda *_: near)
    taken, found = first_step.first_step(step, TOLERANCE, excavated=True)
    assert taken is step
    assert found.converged is (little and near)
    assert step.factors.count == factorized + 1
    assert bool(corrections) is not little


@pytest.mark.parametrize(("excavated", "stressed"), [(True, True), (False, True), (True, False)])
def test_only_an_excavation_in_stressed_rock_sets_few_blocks_free(rest, near, monkeypatch, excavated, stressed):
    step = stressed_and_pushed(rest) if stressed else copy(rest[0])
    step.start = pushed_from(rest[1])
    solved, asked = Found(rest[1], rest[0].evaluate(rest[1]), converged=True), []
    monkeypatch.setattr(first_step, "_begun_with_few", lambda *_: asked.append("few") or solved)
    monkeypatch.setattr(first_step, "solve_at_once", lambda *_, **__: asked.append("all") or solved)
    first_step.first_step(step, TOLERANCE, excavated=excavated)
    assert asked == ["few" if excavated and stressed else "all"]


@pytest.mark.parametrize(("around", "few"), [(RINGS, True), (4 * RINGS, False)])
def test_where_an_excavation_sets_few_free_the_others_are_not_solved_from_inside(rest, monkeypatch, around, few):
    """What the first step leaves, moving steps take up as they do later: next to where they begin."""
    step = stressed_and_pushed(rest)
    nowhere, asked = Found(step.start, step.evaluate(step.start), converged=False), []

    def leads_nowhere(name: str, *, solves: bool = False):
        return lambda *_, **__: asked.append(name) or replace(nowhere, converged=solves)

    monkeypatch.setattr(local_phase, "AROUND", around)
    assert begins_with_few(step, TOLERANCE) is few
    monkeypatch.setattr(first_step, "softened_newton", leads_nowhere("next to start"))
    monkeypatch.setattr(first_step, "from_inside", leads_nowhere("inside"))
    assert not first_step.first_step(step, TOLERANCE, excavated=True)[1].converged
    assert asked == (["next to start"] if few else ["next to start", "inside"])
    asked.clear()
    monkeypatch.setattr(strategies, "softened_newton", leads_nowhere("next to start", solves=True))
    monkeypatch.setattr(strategies, "newton", leads_nowhere("with closed contacts", solves=True))
    assert strategies.MovingSteps(excavated=True).solve(step, 1.0, from_rest=True, failures=0).converged
    assert asked == (["next to start"] if few else ["with closed contacts"])
