"""Subdomain corrections after an excavation move the influence region alone, where it is small."""

from copy import copy
from dataclasses import replace

import numpy as np
import pytest
from step_scenes import BRICKS, begun, block_on_a_base, wall_at_rest

from bsm_mesh.solve.continuation import first_step, strategies
from bsm_mesh.solve.continuation.acceptance import Acceptance
from bsm_mesh.solve.methods import regularized_newton as regularized
from bsm_mesh.solve.methods import subdomain_newton as subdomain
from bsm_mesh.solve.methods.newton import newton
from bsm_mesh.solve.methods.regularized_newton import regularized_newton
from bsm_mesh.solve.methods.subdomain_newton import is_local_disturbance, subdomain_correction
from bsm_mesh.solve.step.attempt import Attempt
from bsm_mesh.solve.step.equations import Step

TOLERANCE, BLOCK, OVERLAP_LAYERS = 5e-7, 10 * BRICKS, 5


@pytest.fixture(scope="module")
def rest() -> tuple[Step, np.ndarray]:
    return wall_at_rest(TOLERANCE)


@pytest.fixture
def near(monkeypatch) -> None:
    """Let fewer blocks around the worst count as far around: those of a small wall are few of all then."""
    monkeypatch.setattr(subdomain, "INFLUENCE_LAYERS", OVERLAP_LAYERS)


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


def test_a_subdomain_correction_moves_only_the_influence_region(rest, near):
    step, position = rest
    pushed, factorized = pushed_from(position), step.factors.count
    found = subdomain_correction(step, pushed, TOLERANCE)
    assert found is not None
    moved = np.flatnonzero((found.position != pushed).any(axis=1))
    away = np.hypot(*(step.system.outlines.centroid - step.system.outlines.centroid[BLOCK]).T)
    assert away[moved].max() < 1.2 * (OVERLAP_LAYERS + 2)
    assert step.factors.count == factorized
    whole = newton(step, pushed, TOLERANCE, regularized=True, max_iterations=1).position
    lack, together = (step.residual_at(there).l2_norm for there in (found.position, whole))
    assert lack == pytest.approx(together, rel=0.1)
    assert lack < 0.5 * step.residual_at(pushed).l2_norm
    assert np.abs(found.position - whole).max() < 0.05 * np.abs(whole - pushed).max()


def test_a_correction_ends_where_that_is_at_rest(rest, near):
    step, position = rest
    found, pushed = subdomain_correction(step, position, TOLERANCE), position.copy()
    assert found is None, "no block is to move"
    pushed[BLOCK, :2] += 2e-8
    found = subdomain_correction(step, pushed, 0.1)
    assert found is not None
    assert found.converged


def test_where_the_influence_region_is_large_all_blocks_are_corrected(rest, monkeypatch):
    step, position = rest
    pushed, factorized = pushed_from(position), step.factors.count
    monkeypatch.setattr(subdomain, "INFLUENCE_LAYERS", 4 * OVERLAP_LAYERS)
    monkeypatch.setattr(regularized, "subdomain_and_chord_sweep", lambda step, position, *_, **__: position)
    assert subdomain_correction(step, pushed, TOLERANCE) is None
    regularized_newton(step, pushed, TOLERANCE, subdomain_corrections=True)
    assert step.factors.count > factorized


@pytest.mark.parametrize("subdomain_corrections", [False, True])
def test_corrections_are_of_all_blocks_unless_that_is_said(rest, near, monkeypatch, subdomain_corrections):
    step, position = rest
    asked = []

    def corrected(step: Step, at: np.ndarray, *_: float, **__: bool) -> Attempt:
        asked.append(len(at) < len(position))
        return Attempt(at, step.evaluate(at), converged=True)

    monkeypatch.setattr(regularized, "subdomain_and_chord_sweep", lambda step, position, *_, **__: position)
    monkeypatch.setattr(regularized, "newton", corrected)
    monkeypatch.setattr(subdomain, "newton", corrected)
    regularized_newton(step, pushed_from(position), TOLERANCE, subdomain_corrections=subdomain_corrections)
    assert asked[0] is subdomain_corrections


def test_failures_in_a_subdomain_correction_are_those_of_the_step(rest, near, monkeypatch):
    step, position = rest
    contacts, broken = step.contacts, []

    def breaks(local: Step, at: np.ndarray, *_: float, **__: bool) -> Attempt:
        local.fail_contacts(np.array([3]))
        broken.append(local.rows[3])
        return Attempt(at, local.evaluate(at), converged=False)

    monkeypatch.setattr(subdomain, "newton", breaks)
    subdomain_correction(step, pushed_from(position), TOLERANCE)
    assert np.flatnonzero(step.contacts.failed & ~contacts.failed).tolist() == broken
    step.contacts = contacts


@pytest.mark.parametrize("excavated", [False, True])
def test_after_an_excavation_few_blocks_are_corrected_alone(monkeypatch, excavated):
    """In the first step as in those to come."""
    step, given = begun(block_on_a_base()), []
    rows = np.zeros(step.contacts.count, np.int32)  # stressed before
    step.contacts = replace(step.contacts, candidates=replace(step.contacts.candidates, history=rows))

    def ends(step: Step, position: np.ndarray, *_: float, **keys: bool) -> Attempt:
        given.append(keys["subdomain_corrections"])
        return Attempt(position, step.evaluate(position), converged=True)

    monkeypatch.setattr(first_step, "regularized_newton", ends)
    monkeypatch.setattr(strategies, "regularized_newton", ends)
    first_step.solve_at_once(step, TOLERANCE, excavated=excavated)
    first_step.solve_updated(step, step.start, TOLERANCE, excavated=excavated)
    strategies.MovingSteps(excavated=excavated).solve(step, 1e-2, from_rest=False, failures=0)
    assert given == 3 * [excavated]


@pytest.mark.parametrize(("little", "near"), [(True, True), (False, True), (True, False)])
def test_at_a_local_failure_the_first_step_may_end_with_the_residual_of_a_moving_one(rest, monkeypatch, little, near):
    """It is not solved any further, nor with contacts that are updated."""
    step, factorized, corrections = stressed_and_pushed(rest), rest[0].factors.count, []

    def corrected(*given) -> Attempt | None:
        corrections.append(given)
        return subdomain_correction(*given)

    monkeypatch.setattr(subdomain, "INFLUENCE_LAYERS", OVERLAP_LAYERS)
    monkeypatch.setattr(regularized, "subdomain_correction", corrected)
    monkeypatch.setattr(Acceptance, "accepts", lambda *_: little)
    monkeypatch.setattr(Step, "within_search_range", lambda *_: near)
    taken, found = first_step.first_step(step, TOLERANCE, excavated=True)
    assert taken is step
    assert found.converged is (little and near)
    assert step.factors.count == factorized + 1
    assert bool(corrections) is not little


@pytest.mark.parametrize(("excavated", "stressed"), [(True, True), (False, True), (True, False)])
def test_only_an_excavation_in_stressed_rock_sets_few_blocks_free(rest, near, monkeypatch, excavated, stressed):
    step = stressed_and_pushed(rest) if stressed else copy(rest[0])
    step.start = pushed_from(rest[1])
    solved, asked = Attempt(rest[1], rest[0].evaluate(rest[1]), converged=True), []
    monkeypatch.setattr(first_step, "_start_local_failure", lambda *_: asked.append("few") or solved)
    monkeypatch.setattr(first_step, "solve_at_once", lambda *_, **__: asked.append("all") or solved)
    first_step.first_step(step, TOLERANCE, excavated=excavated)
    assert asked == ["few" if excavated and stressed else "all"]


@pytest.mark.parametrize(("around", "few"), [(OVERLAP_LAYERS, True), (4 * OVERLAP_LAYERS, False)])
def test_a_local_failure_needs_no_interior_point_method(rest, monkeypatch, around, few):
    """What the first step leaves, moving steps take up as they do later: next to where they begin."""
    step = stressed_and_pushed(rest)
    nowhere, asked = Attempt(step.start, step.evaluate(step.start), converged=False), []

    def leads_nowhere(name: str, *, solves: bool = False):
        return lambda *_, **__: asked.append(name) or replace(nowhere, converged=solves)

    monkeypatch.setattr(subdomain, "INFLUENCE_LAYERS", around)
    assert is_local_disturbance(step, TOLERANCE) is few
    monkeypatch.setattr(first_step, "regularized_newton", leads_nowhere("next to start"))
    monkeypatch.setattr(first_step, "newton_from_interior_point", leads_nowhere("use_interior_point"))
    assert not first_step.first_step(step, TOLERANCE, excavated=True)[1].converged
    assert asked == (["next to start"] if few else ["next to start", "use_interior_point"])
    asked.clear()
    monkeypatch.setattr(strategies, "regularized_newton", leads_nowhere("next to start", solves=True))
    monkeypatch.setattr(strategies, "newton", leads_nowhere("with closed contacts", solves=True))
    assert strategies.MovingSteps(excavated=True).solve(step, 1.0, from_rest=True, failures=0).converged
    assert asked == (["next to start"] if few else ["with closed contacts"])
