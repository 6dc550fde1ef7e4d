"""Equations of some blocks alone are those of all, the others fixed; the chord method near rest."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.sparse import bsr_array

import bsm_mesh as bsm
from bsm_mesh.contact.history import History
from bsm_mesh.contact.tangents import tangent_stiffness
from bsm_mesh.solve.continuation.stability import falling_mode
from bsm_mesh.solve.methods.corrections import chord_method
from bsm_mesh.solve.methods.newton import newton
from bsm_mesh.solve.step.equations import StepEquations
from bsm_mesh.solve.step.subproblem import SubdomainEquations
from tests.scenes.steps import wall_at_rest

TOLERANCE = 5e-7
BLOCK = 100  # which is pushed


@pytest.fixture(scope="module")
def wall() -> tuple[StepEquations, np.ndarray]:
    return wall_at_rest(TOLERANCE)


@pytest.fixture
def rest(wall) -> tuple[StepEquations, np.ndarray]:
    """Return the wall at rest, with factors of its tangent there, whatever the test before left."""
    step, position = wall
    assert step.factorize(step.tangent(step.evaluate(position), 1e-3), position)
    return wall


def pushed_from(position: np.ndarray, by: float = 2e-6, *blocks: int) -> np.ndarray:
    pushed = position.copy()
    pushed[list(blocks or (BLOCK,)), :2] += by
    return pushed


def sizes(step: StepEquations, position: np.ndarray) -> np.ndarray:
    """Return the residual of every block over a brick's weight."""
    forces = step.residual(position, step.evaluate(position).forces)
    return np.abs(step.project(forces)).max(axis=1) / step.system.mean_weight


def moved_in(before: np.ndarray, after: np.ndarray) -> np.ndarray:
    return (after != before).any(axis=1)


def test_the_equations_are_unchanged_by_what_is_solved_with_them(rest):
    """Also where a method stalls."""
    step, position = rest
    contacts, start = step.contacts, step.start.copy()
    failed, shear = contacts.failed.copy(), contacts.old_shear.copy()
    far = position + 1e-3 * np.random.default_rng(0).normal(size=position.shape)
    for there in (pushed_from(position), far):
        before = there.copy()
        newton(step, there, 1e-13)
        assert_array_equal(there, before)
    assert step.contacts is contacts
    assert_array_equal(contacts.failed, failed)
    assert_array_equal(contacts.old_shear, shear)
    assert_array_equal(step.start, start)


WET = bsm.Water(table=[(0, 6.0), (40, 1.0)])


def symmetric(step: StepEquations, position: np.ndarray) -> StepEquations:
    return step.static_problem_at(position, 1e-3, is_symmetric=True)


def inertial(step: StepEquations, position: np.ndarray) -> StepEquations:
    return step.with_inertia(1e9 * step.mass, position + 1e-7)


@pytest.mark.parametrize(("water", "kind"), [(None, None), (WET, None), (WET, symmetric), (WET, inertial)])
def test_a_subproblem_has_the_equations_of_all_with_the_others_fixed(water, kind):
    step, position = wall_at_rest(TOLERANCE, water=water)
    step = step if kind is None else kind(step, position)
    moves = np.zeros(len(position), dtype=bool)
    moves[100:160] = moves[420:425] = True
    pushed = position + np.where(moves[:, None], 1e-6, 0.0)
    local = SubdomainEquations(step, moves, pushed)
    assert vars(local).keys() >= vars(step).keys()
    here, at_all = pushed[local.blocks], step.evaluate(pushed)
    at, forces = local.evaluate(here), step.residual(pushed, at_all.forces)
    assert_array_equal(local.blocks[local.block], np.flatnonzero(moves))
    assert_array_equal(local.whole(here), pushed)
    assert_allclose(local.residual(here, at.forces)[local.block], forces[moves])
    assert_allclose(local.project(local.residual(here, at.forces)), step.project(forces)[moves])
    if water is not None:
        assert_array_equal(local.load_stiffness(here), step.load_stiffness(pushed)[local.blocks])
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


def test_an_equilibrium_is_judged_by_its_own_contacts_though_a_later_step_had_others(rest):
    step, position = rest
    lifted = pushed_from(position, 100.0)
    contacts = step.system.gather(History.none(), lifted, first=True)
    other = StepEquations(step.system, step.factors, contacts, lifted, step.lam)
    assert len(other.pattern.column) != len(step.pattern.column)
    assert falling_mode(step, position, step.evaluate(position), 1e-6) is None
