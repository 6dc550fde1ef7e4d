"""Subdomain Newton: blocks with a large residual come to rest, and no others move."""

from copy import copy

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.sparse import bsr_array
from step_scenes import BRICKS, wall_at_rest

from bsm_mesh.solve.contacts.forces import tangent_stiffness
from bsm_mesh.solve.contacts.history import History
from bsm_mesh.solve.continuation.stability import instability_rate
from bsm_mesh.solve.methods import regularized_newton as regularized
from bsm_mesh.solve.methods import subdomain_newton as subdomain
from bsm_mesh.solve.methods.newton import chord_method
from bsm_mesh.solve.methods.regularized_newton import regularized_newton
from bsm_mesh.solve.methods.subdomain_newton import OVERLAP_LAYERS, subdomain_newton
from bsm_mesh.solve.step.attempt import Attempt
from bsm_mesh.solve.step.equations import Step
from bsm_mesh.solve.step.subproblem import LocalStep

TOLERANCE = 5e-7
BLOCK = 100  # which is pushed


@pytest.fixture(scope="module")
def rest() -> tuple[Step, np.ndarray]:
    return wall_at_rest(TOLERANCE)


def sizes(step: Step, position: np.ndarray) -> np.ndarray:
    """Return the residual of every block over a brick's weight."""
    forces = step.residual(position, step.evaluate(position).forces)
    return np.abs(step.project(forces)).max(axis=1) / step.system.mean_weight


def test_a_block_out_of_place_comes_to_rest_and_those_far_from_it_stay(rest):
    step, position = rest
    pushed = position.copy()
    pushed[BLOCK, :2] += 2e-6
    before = sizes(step, pushed)
    assert before.max() > 1
    relaxed = subdomain_newton(step, pushed, TOLERANCE)
    moved = np.flatnonzero((relaxed != pushed).any(axis=1))
    away = np.hypot(*(position - position[BLOCK])[:, :2].T)
    assert len(moved) > 10
    assert away[moved].max() < 1.2 * (OVERLAP_LAYERS + 2)
    assert sizes(step, relaxed).max() < 0.05 * before.max()


def test_where_too_many_residuals_are_large_the_cutoff_is_raised(rest):
    step, position = rest
    pushed = position + np.random.default_rng(0).uniform(-2e-8, 2e-8, position.shape)
    pushed[BLOCK, :2] += 2e-6
    before = sizes(step, pushed)
    assert (before > subdomain.RESIDUAL_CUTOFF * before.max()).mean() > subdomain.MAX_BLOCKS
    assert subdomain_newton(step, pushed, TOLERANCE) is pushed
    relaxed = subdomain_newton(step, pushed, TOLERANCE, fewer=True)
    assert sizes(step, relaxed).max() < 0.1 * before.max()
    moved = (relaxed != pushed).any(axis=1)
    assert 10 < moved.sum() < subdomain.MAX_BLOCKS * len(moved)


def test_few_blocks_may_exceed_the_tolerance_where_that_is_accepted(rest, monkeypatch):
    step, position = rest
    pushed = position.copy()
    pushed[BLOCK, :2] += 1e-9
    monkeypatch.setattr(regularized, "subdomain_and_chord_sweep", lambda step, position, *_, **__: position)
    stays = lambda step, at, *_, **__: Attempt(at, step.evaluate(at), converged=False)  # noqa: E731
    monkeypatch.setattr(regularized, "newton", stays)
    assert TOLERANCE < step.residual_at(pushed).max_norm < 3e-3
    assert regularized_newton(step, pushed, TOLERANCE, enough=lambda here: here.max_norm < 3e-3).converged
    assert not regularized_newton(step, pushed, TOLERANCE, enough=lambda here: here.max_norm < TOLERANCE).converged
    assert not regularized_newton(step, pushed, TOLERANCE).converged


@pytest.mark.parametrize(("alone", "together", "rounds"), [(1.0, 1.0, 1), (0.9, 1.0, 3), (1.0, 0.9, 3)])
def test_a_subdomain_is_not_solved_again_where_nothing_has_changed(rest, monkeypatch, alone, together, rounds):
    step, position = rest
    asked = []

    def nearer(position: np.ndarray, at: np.ndarray, part: float) -> np.ndarray:
        return position + part * (at - position)

    def apart(step: Step, at: np.ndarray, *_: float, **__: bool) -> np.ndarray:
        asked.append(at)
        return nearer(position, at, alone)

    def corrected(step: Step, at: np.ndarray, *_: float, **__: bool) -> Attempt:
        return Attempt(there := nearer(position, at, together), step.evaluate(there), converged=False)

    monkeypatch.setattr(regularized, "subdomain_and_chord_sweep", apart)
    monkeypatch.setattr(regularized, "newton", corrected)
    pushed = position.copy()
    pushed[BLOCK, :2] += 1e-9
    regularized_newton(step, pushed, TOLERANCE)
    assert len(asked) == rounds


def test_a_cluster_with_a_growing_residual_is_rejected_alone(rest, monkeypatch):
    step, position = rest
    pushed, other, contacts = position.copy(), BLOCK + 20 * BRICKS, step.contacts
    pushed[[BLOCK, other], :2] += 2e-6
    real, spoiled, broken = subdomain._solve_subdomain, [], []

    def spoil_one(local: LocalStep, *how: float) -> tuple[np.ndarray, bool]:
        found, _ = real(local, *how)
        assert local.clusters == 2
        label = local.cluster[local.blocks[local.block] == other]
        chosen = local.block[local.cluster == label]
        found[chosen, 0] += 1e-4 * np.random.default_rng(0).normal(size=len(chosen))
        spoiled.extend(local.blocks[chosen])
        one_of_each = np.array([np.flatnonzero(local.cluster_of_row == k)[0] for k in range(2)])
        local.fail_contacts(one_of_each)
        broken.append(local.rows[one_of_each[1 - label]])
        return found, False

    monkeypatch.setattr(subdomain, "_solve_subdomain", spoil_one)
    relaxed = subdomain_newton(step, pushed, TOLERANCE)
    moved = (relaxed != pushed).any(axis=1)
    assert moved[BLOCK]
    assert not moved[spoiled].any()
    assert other in spoiled
    before, after = sizes(step, pushed), sizes(step, relaxed)
    assert after[BLOCK] < 0.05 * before[BLOCK]
    assert after[other] == pytest.approx(before[other])
    assert_array_equal(np.flatnonzero(step.contacts.failed & ~contacts.failed), broken[0])
    step.contacts = contacts


def test_more_layers_move_more_blocks(rest):
    step, position = rest
    pushed = position.copy()
    pushed[BLOCK, :2] += 2e-6
    solved = [subdomain_newton(step, pushed, TOLERANCE, layers=k) for k in (2, OVERLAP_LAYERS)]
    moved = [(position != pushed).any(axis=1).sum() for position in solved]
    assert moved[1] > 2 * moved[0] > 0


def test_a_cluster_may_spread_what_it_had_where_that_is_said(rest, monkeypatch):
    step, position = rest
    pushed, spread = position.copy(), position.copy()
    pushed[BLOCK, :2] += 2e-8
    spread[BLOCK, :2] += 1e-7
    monkeypatch.setattr(subdomain, "_solve_subdomain", lambda local, *_: (spread[local.blocks], False))
    assert subdomain_newton(step, pushed, TOLERANCE) is pushed
    assert_allclose(subdomain_newton(step, pushed, TOLERANCE, max_growth=regularized.SPREAD), spread, rtol=0, atol=0)


def test_a_sweep_is_judged_after_the_chord_method(rest, monkeypatch):
    step, position = rest
    assert step.factors.ready
    pushed, spread = position.copy(), position.copy()
    pushed[BLOCK, :2] += 2e-8
    spread[BLOCK, :2] += 1e-7
    given = []

    def spreads(step: Step, position: np.ndarray, tolerance: float, **keys) -> np.ndarray:
        given.append(keys)
        return spread

    monkeypatch.setattr(regularized, "subdomain_newton", spreads)
    settled = regularized.subdomain_and_chord_sweep(step, pushed, TOLERANCE, use_interior_point=False)
    assert sizes(step, settled).max() < TOLERANCE
    options = {"layers": OVERLAP_LAYERS, "max_growth": regularized.SPREAD, "fewer": True}
    assert given == [{"use_interior_point": True} | options]


def test_a_sweep_without_gain_is_repeated_with_more_layers(rest, monkeypatch):
    step, position = rest
    pushed = position.copy()
    pushed[BLOCK, :2] += 2e-8
    layers, contacts = [], step.contacts

    def spoils(step: Step, position: np.ndarray, tolerance: float, **keys) -> np.ndarray:
        layers.append(keys["layers"])
        step.fail_contacts(np.array([0]))
        return position + 1e-4 * np.random.default_rng(0).normal(size=position.shape)

    monkeypatch.setattr(regularized, "subdomain_newton", spoils)
    monkeypatch.setattr(regularized, "chord_method", lambda step, position, tolerance: position)
    assert regularized.subdomain_and_chord_sweep(step, pushed, TOLERANCE, use_interior_point=False) is pushed
    assert layers == [OVERLAP_LAYERS, 2 * OVERLAP_LAYERS, 4 * OVERLAP_LAYERS]
    assert step.contacts is contacts  # what broke on the way has not


def test_where_most_residuals_are_large_there_is_no_subdomain(rest):
    step, position = rest
    shaken = position + 1e-6 * np.random.default_rng(0).normal(size=position.shape)
    assert subdomain_newton(step, shaken, TOLERANCE) is shaken


def test_at_rest_nothing_moves(rest):
    step, position = rest
    assert subdomain_newton(step, position, 1e-3) is position


def test_a_subproblem_has_the_equations_of_all_with_the_others_fixed(rest):
    step, position = rest
    moves = np.zeros(len(position), dtype=bool)
    moves[100:160] = moves[420:425] = True
    pushed = position + np.where(moves[:, None], 1e-6, 0.0)
    local = LocalStep(step, moves, pushed)
    here, at_all = pushed[local.blocks], step.evaluate(pushed)
    at, forces = local.evaluate(here), step.residual(pushed, at_all.forces)
    assert_array_equal(local.blocks[local.block], np.flatnonzero(moves))
    assert_array_equal(local.whole(here), pushed)
    assert_allclose(local.residual(here, at.forces)[local.block], forces[moves])
    assert_allclose(local.project(local.residual(here, at.forces)), step.project(forces)[moves])
    tangents = [
        tangent_stiffness(s.contacts, a, s.pattern.place, len(s.pattern.column))
        for s, a in ((local, at), (step, at_all))
    ]
    assert local.factorize(tangents[0], here)
    movement = local.whole(local.solve(forces[local.blocks])) - local.whole(np.zeros_like(here))
    whole = bsr_array((step.complete(tangents[1], pushed), step.pattern.column, step.pattern.row_start)).tocsr()
    unknown = np.flatnonzero(np.repeat(moves, 3))
    wanted = np.linalg.solve(whole[unknown][:, unknown].toarray(), forces.ravel()[unknown])
    assert_allclose(movement.ravel()[unknown], wanted, rtol=1e-8, atol=1e-10 * np.abs(wanted).max())
    assert not movement[~moves].any()
    assert local.clusters == 2
    local.close()


def test_near_rest_the_chord_method_is_enough(rest):
    """All blocks a little out of place: the last factors, of a regularised tangent, bring them back."""
    step, position = rest
    shaken = position + 1e-9 * np.random.default_rng(0).normal(size=position.shape)
    assert step.residual_at(shaken).max_norm > 1e3 * TOLERANCE
    before = step.factors.count
    found = chord_method(step, shaken, TOLERANCE)
    assert step.residual_at(found).max_norm < TOLERANCE
    assert step.factors.count == before
    far = position + 1e-4 * np.random.default_rng(0).normal(size=position.shape)
    assert step.residual_at(chord_method(step, far, TOLERANCE)).l2_norm <= step.residual_at(far).l2_norm


def test_a_block_out_of_place_near_rest_takes_no_factorization_of_the_whole(rest, monkeypatch):
    step, position = rest
    pushed = position.copy()
    pushed[BLOCK, :2] += 2e-6
    before = step.factors.count
    found = regularized_newton(step, pushed, TOLERANCE)
    assert found.converged
    assert step.factors.count == before
    monkeypatch.setattr(regularized, "MAX_ROUNDS", 0)
    found = regularized_newton(step, pushed, TOLERANCE)
    assert found.converged
    assert step.factors.count > before


def test_a_subdomain_without_a_solution_by_newtons_method_goes_to_the_interior_point_method(rest, monkeypatch):
    """A brick is pushed into its neighbours, and Newton's method has no iterations."""
    step, position = rest
    pushed = position.copy()
    pushed[BLOCK] += [2e-4, 1e-4, 1e-3]
    monkeypatch.setattr(subdomain, "MAX_ITERATIONS", 0)
    stays = subdomain_newton(step, pushed, TOLERANCE)
    assert sizes(step, stays).max() == sizes(step, pushed).max()
    monkeypatch.setattr(
        subdomain, "newton", lambda local, near, *_, **__: Attempt(near, local.evaluate(near), converged=True)
    )
    relaxed = subdomain_newton(step, pushed, TOLERANCE, use_interior_point=True)
    assert sizes(step, relaxed).max() < 0.1 * sizes(step, pushed).max()


def test_an_equilibrium_is_judged_by_its_own_contacts_though_a_later_step_had_others(rest, monkeypatch):
    step, position = rest
    lifted = position.copy()
    lifted[BLOCK, 1] += 100.0
    contacts = step.system.gather(History.none(), lifted, first=True)
    other = Step(step.system, step.factors, contacts, lifted, step.lam)
    assert len(other.pattern.column) != len(step.pattern.column)
    assert instability_rate(step, position, step.evaluate(position), 1e-6) == 0.0
    Step(step.system, step.factors, contacts, lifted, step.lam)
    monkeypatch.setattr(step.factors, "is_positive_definite", lambda _: False)  # then power iteration says the same
    assert instability_rate(step, position, step.evaluate(position), 1e-6) == 0.0


@pytest.mark.parametrize(
    ("jams", "pushed_by", "asked"), [(True, 2e-6, 1), (False, 2e-6, 2), (True, 5e-9, 2)], ids=["jams", "ends", "near"]
)
def test_the_interior_point_method_is_not_tried_again_after_it_stalled_far_from_equilibrium(
    rest, monkeypatch, jams, pushed_by, asked
):
    step, position = copy(rest[0]), rest[1]
    pushed, calls = position.copy(), []
    pushed[BLOCK, :2] += pushed_by

    def use_interior_point(local: LocalStep, elastic: np.ndarray, *_: float) -> np.ndarray | None:
        calls.append(elastic)
        return None if jams else elastic

    monkeypatch.setattr(subdomain, "interior_point", use_interior_point)
    monkeypatch.setattr(subdomain._ClusterSearch, "relax", lambda search, _: (search.local.start, np.inf))
    monkeypatch.setattr(regularized, "MAX_ROUNDS", 1)
    for _ in range(2):
        regularized.subdomain_and_chord_sweep(step, pushed, TOLERANCE, use_interior_point=True)
    assert len(calls) == asked
    step.rebase(step.contacts, position)
    regularized.subdomain_and_chord_sweep(step, pushed, TOLERANCE, use_interior_point=True)
    assert len(calls) == asked + 1
