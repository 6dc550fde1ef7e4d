"""Newton's method on a step: equilibria in closed form, quadratic convergence, and what it says where there is none."""

from types import SimpleNamespace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from bsm_mesh.solve.methods.corrections import chord_method, line_search, newton_correction
from bsm_mesh.solve.methods.newton import ExactNewton, newton
from bsm_mesh.solve.step.attempt import Goal, Iterate, Outcome
from bsm_mesh.solve.step.block_system import moved_by, step_between
from bsm_mesh.solve.step.equations import StepEquations
from tests.scenes.models import GAMMA, model_of
from tests.scenes.shapes import rectangle, running_bond, turned
from tests.scenes.steps import begun

KN = 1e9  # Pa/m, of all joints
TOLERANCE = 1e-9  # residual over the mean weight
EXACT = 1e-6  # relative: blocks of a column settle by 1e-4 of their size, and the exact geometry with them
BASE = rectangle(-4, -1, 8, 0)


def step_of(polygons, turn=0.0, **given):
    """Return the first step of a model without regularisation, so that its solution is the static one."""
    return begun(model_of([turned(p, turn) for p in polygons], kn=KN, **given)).with_regularization(0.0)


def column(count):
    return [BASE, *(rectangle(0, y, 1, y + 1) for y in range(count))]


@pytest.mark.parametrize("exact", [True, False])
@pytest.mark.parametrize(("count", "turn"), [(4, 0.0), (2, 10.0)])
def test_a_column_settles_and_shears_by_the_weight_above_each_joint(count, turn, exact):
    """The joint below block k carries all blocks from it on, across the joint and along it."""
    step = step_of(column(count), turn, friction=60.0)
    found = newton(step, step.elastic_position, TOLERANCE, exact=exact)
    assert found.outcome is Outcome.SOLVED
    assert step.residual_at(found.position).max_norm < TOLERANCE
    at = found.at
    assert at.sticking[at.closed].all()
    candidates, closed = found.contacts.candidates, at.closed
    weight, angle = GAMMA * 1.0, np.radians(turn)
    for k in range(1, count + 1):
        rows = closed & ((candidates.block_a == k) | (candidates.block_b == k))
        rows &= np.minimum(candidates.block_a, candidates.block_b) == k - 1
        above = (count - k + 1) * weight
        assert at.pressure[rows].sum() == pytest.approx(above * np.cos(angle), rel=1e-3)
        assert abs(at.shear[rows].sum()) == pytest.approx(above * np.sin(angle), rel=1e-3, abs=1e-6)
    if turn == 0.0:
        settled = -np.cumsum([(count - k) * weight / KN for k in range(count)])
        assert_allclose(found.position[1:, 1], settled, rtol=EXACT)


@pytest.mark.parametrize("axis", range(3))
def test_a_block_in_the_air_is_held_by_the_regularization_alone(axis):
    """By springs of lam times its weight, those of a turn times the square of the radius of gyration."""
    lam, force = 0.5, 3.0
    step = begun(model_of([BASE, rectangle(0, 5, 2, 6)])).with_regularization(lam)
    assert step.factorize(np.zeros((len(step.pattern.column), 3, 3)), step.start)
    weight, square = GAMMA * 2.0, (2.0**2 + 1.0**2) / 12
    wanted, forces = np.zeros((2, 2, 3))
    forces[1, axis] = force
    wanted[1, axis] = force / (lam * weight * (1.0, 1.0, square)[axis])
    assert_allclose(step.solve(forces), wanted, rtol=1e-12)


def test_the_work_of_the_weight_is_twice_the_energy_of_the_joints():
    """Clapeyron: a wall whose joints stick and stay closed is elastic."""
    step = step_of([BASE, *running_bond(4, 4)], friction=60.0)
    found = newton(step, step.elastic_position, TOLERANCE, exact=True)
    assert found.outcome is Outcome.SOLVED
    at, contacts = found.at, found.contacts
    closed = at.closed
    energy = (at.pressure[closed] ** 2 / contacts.normal_stiffness[closed]).sum() / 2
    energy += (at.shear[closed] ** 2 / contacts.shear_stiffness[closed]).sum() / 2
    work = (step.acting_at(step.start) * found.position)[1:].sum()
    assert work > 0
    assert work == pytest.approx(2 * energy, rel=1e-3)


def test_it_converges_quadratically_near_the_solution():
    """Blocks of a leaning column rotate by finite angles; with the exact tangent errors are squared."""
    step = step_of(column(2), 10.0, friction=60.0)
    rest = newton(step, step.elastic_position, 1e-12, exact=True).position
    moved = rest + np.array([(0, 0, 0), *[(1e-5 * k, 0, -1e-5 * k) for k in (1, 2)]])
    here, errors = step.residual_at(moved), [np.abs(moved - rest).max()]
    for _ in range(2):
        here = line_search(step, here, newton_correction(step, here, 0.0), here.l2_norm)
        errors.append(np.abs(here.position - rest).max())
    assert errors[1] < 1e-3 * errors[0]
    assert errors[2] < 1e-12


@pytest.mark.parametrize("friction", [20.0, 44.0])
def test_where_friction_does_not_hold_it_stalls_without_making_the_residual_worse(friction):
    step = begun(model_of([turned(p, 45.0) for p in (BASE, rectangle(0, 0, 1, 1))], friction=friction, kn=KN))
    step = step.with_regularization(1e-9)
    start = step.residual_at(step.elastic_position)
    found = newton(step, start.position, TOLERANCE, exact=True)
    assert found.outcome is Outcome.STALLED
    assert step.residual_at(found.position).l2_norm <= start.l2_norm


def test_a_block_that_nothing_holds_is_not_said_to_rest():
    step = step_of([BASE, rectangle(0, 3, 1, 4)])
    found = newton(step, step.start, TOLERANCE, exact=True)
    assert found.outcome in (Outcome.SINGULAR, Outcome.STALLED)
    assert step.residual_at(found.position).max_norm > 0.1


def test_the_elastic_solution_sticks_whatever_the_friction():
    """Weight along the slope over the shear stiffness of the face, though friction carries a half of it."""
    slope = 30.0
    step = step_of([BASE, rectangle(0, 0, 1, 1)], slope, friction=15.0)
    moved = turned(step.elastic_position[1:, :2], -slope)[0]
    assert_allclose(moved[1], -GAMMA * np.cos(np.radians(slope)) / KN, rtol=1e-4)  # exact rotation
    # Along the slope it shears, and leans on its two corners: as much again at its centroid.
    assert_allclose(moved[0], -2 * GAMMA * np.sin(np.radians(slope)) / KN, rtol=1e-4)


def test_chord_iterations_reach_rounding_with_the_factors_there_are():
    step = step_of([BASE, *running_bond(4, 4)], friction=60.0)
    rest = newton(step, step.elastic_position, 1e-4, exact=True)
    assert rest.outcome is Outcome.SOLVED
    pushed, factorized = rest.position.copy(), step.factors.count
    pushed[3, 0] += 1e-9
    polished = chord_method(step, pushed, 0.0)
    assert step.factors.count == factorized
    before, after = (step.residual_at(position).max_norm for position in (pushed, polished))
    assert after < 1e-7 < 1e-5 < before


def test_chord_iterations_end_at_the_tolerance_and_never_make_it_worse():
    step = step_of([BASE, *running_bond(4, 4)], friction=60.0)
    rest = newton(step, step.elastic_position, 1e-9, exact=True).position
    assert_allclose(chord_method(step, rest, 1e-6), rest, atol=0)
    far = rest.copy()
    far[5] += (0.02, 0.05, 0.1)  # its contacts are open there
    assert step.residual_at(chord_method(step, far, 0.0)).max_norm <= step.residual_at(far).max_norm


def test_the_method_of_a_step_is_for_goals_near_rest():
    step = step_of(column(2))
    method, at = ExactNewton(), Iterate(residual=1.0)
    assert method.applies(step, at, Goal(max_residual=1e-4, rest=1e-6))
    assert not method.applies(step, at, Goal(max_residual=1e-2, rest=1e-6))
    near = newton(step, step.elastic_position, 1e-3, exact=True).position + 1e-7 * np.array(
        [(0, 0, 0), *2 * [(1, -1, 1)]]
    )
    begins = StepEquations(step.system, step.factors, step.contacts, near, 0.0)
    assert begins.residual_at(begins.start).max_norm > 1e-4
    found = method.solve(begins, at, Goal(max_residual=1e-8, rest=1e-8))
    assert found.outcome is Outcome.SOLVED
    assert begins.residual_at(found.position).max_norm < 1e-8


class Creeping:
    """A block whose residual falls to nine tenths a correction, and to nothing in the last of `count`."""

    supports_move, max_movement = False, np.inf

    def __init__(self, count: int) -> None:
        self.count = count

    def residual_at(self, position, weight=None):
        made = round(float(position[0, 0]))
        left = 0.9**made if made < self.count else 0.0
        return SimpleNamespace(
            position=position, forces=None, at=None, weight=1.0, max_norm=left, l2_norm=left, rms=left
        )

    def tangent(self, at, regularization):
        return None

    def factorize(self, data, position):
        return True

    def solve(self, forces):
        return np.array([[1.0, 0.0, 0.0]])

    def movement(self, correction):
        return 1.0

    def moved_by(self, position, movement):
        return moved_by(position, movement)


@pytest.mark.parametrize(
    ("count", "exact", "outcome"), [(10, True, "solved"), (10, False, "stalled"), (14, True, "stalled")]
)
def test_the_exact_method_makes_twelve_corrections_though_they_bring_little(count, exact, outcome):
    """Seen: a bolted arch whose bond slips, without a verdict where the exact method ended with the regularised one."""
    found = newton(Creeping(count), np.zeros((1, 3)), 1e-6, exact=exact)
    assert found.outcome == outcome


def test_a_step_between_positions_is_that_which_leads_there():
    position, other = np.random.default_rng(0).normal(size=(2, 9, 3))
    assert_allclose(moved_by(position, step_between(position, other)), other, atol=1e-14)
