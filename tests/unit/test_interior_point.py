"""Multipliers of linear programs are exact to rounding, those of bounds that are hardly met too."""

import clarabel
import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.sparse import csc_array, csr_array

import bsm_mesh as bsm
from bsm_mesh.solve.limit.conic import Answer, _infeasibility, solve_conic
from bsm_mesh.solve.limit.interior_point import minimise
from bsm_mesh.solve.limit.multipliers import _refined
from tests.scenes.models import model_of

EXACT = 1e-13  # over the greatest multiplier: rounding alone


def program(seed, unknowns=60, balances=20, bounds=90):
    """Return a program with its optimum: cost, balance, right, bounded, bound, and multipliers of all rows.

    Forty of the bounds are met, with multipliers from 1 down to 1e-8, and others hardly met.
    """
    generator = np.random.default_rng(seed)
    balance, bounded = generator.normal(size=(balances, unknowns)), generator.normal(size=(bounds, unknowns))
    x, met = generator.normal(size=unknowns), np.arange(bounds) < unknowns - balances
    slack = np.where(met, 0.0, 10.0 ** generator.uniform(-3, 1, bounds))
    of_bounds = np.where(met, 10.0 ** generator.uniform(-8, 0, bounds), 0.0)
    of_balance = generator.normal(size=balances)
    cost = -(balance.T @ of_balance + bounded.T @ of_bounds)
    return cost, balance, balance @ x, bounded, bounded @ x + slack, np.concatenate([of_balance, of_bounds])


@pytest.mark.parametrize("seed", range(5))
def test_small_multipliers(seed):
    cost, balance, right, bounded, bound, exact = program(seed)
    # The least t with cost x <= t: as in limit analysis one column has a cost.
    rows = np.block([[bounded, np.zeros((len(bound), 1))], [cost, -1.0]])
    found = minimise(
        np.append(np.zeros(len(cost)), 1.0),
        csr_array(np.column_stack([balance, np.zeros(len(right))])),
        right,
        csr_array(rows),
        np.append(bound, 0.0),
    )
    assert found.answer is Answer.SOLVED
    assert_allclose(np.concatenate([found.of_balance, found.of_bounds[:-1]]), exact, atol=1e-6)
    assert found.loose.max() <= EXACT * np.abs(exact).max()
    assert_allclose(found.proved, found.x[-1], rtol=1e-8)


@pytest.mark.parametrize("seed", range(5))
def test_multipliers_that_prove_that_there_is_no_solution(seed):
    """Half planes all round that leave out a ball: their multipliers vanish in every column."""
    bounded = np.random.default_rng(seed).normal(size=(60, 20))
    none = np.zeros(0)
    found = minimise(np.zeros(20), csr_array((0, 20)), none, csr_array(bounded), np.full(60, -1.0))
    assert found.answer is Answer.INFEASIBLE
    assert found.of_bounds.sum() > 0.5
    assert found.proved > 0.5
    assert found.loose.max() <= EXACT * found.of_bounds.max()


@pytest.mark.parametrize("seed", range(5))
def test_a_program_of_the_change_makes_multipliers_exact(seed):
    """The bounds that are met are not known, as where forces are many times the loads."""
    cost, balance, right, bounded, bound, exact = program(seed)
    met = exact[len(right) :] > 0
    x = np.linalg.solve(np.vstack([balance, bounded[met]]), np.concatenate([right, bound[met]]))
    slack = np.concatenate([np.zeros(len(right)), np.maximum(bound - bounded @ x, 1e-9)])
    off = exact + np.random.default_rng(seed).normal(scale=1e-6, size=len(exact))
    off[len(right) :] = np.maximum(off[len(right) :], 1e-12)
    rows = csc_array(np.vstack([balance, bounded]))
    found = _refined(off, slack, cost, rows, len(right))
    assert np.abs(rows.T @ off + cost).max() > 1e-6
    assert np.abs(rows.T @ found + cost).max() <= EXACT * np.abs(exact).max()
    assert found[len(right) :].min() >= -EXACT
    assert_allclose(-found @ np.concatenate([right, bound]), cost @ x, rtol=1e-6)


def on_a_plane(load):
    """Return a block on a level plane as a program: matrix, right-hand side and cones of its pressure and shears.

    Unknowns are the pressure N and the shears along x and y. Equilibrium takes N = 1 and the shear along x = `load`;
    the pressure is at most 2, and friction .5: (N / 2, shears) lies in the cone.
    """
    rows = [[1.0, 0, 0], [0, 1.0, 0], [1.0, 0, 0], [-0.5, 0, 0], [0, -1.0, 0], [0, 0, -1.0]]
    cones = [clarabel.ZeroConeT(2), clarabel.NonnegativeConeT(1), clarabel.SecondOrderConeT(3)]
    return csc_array(np.array(rows)), np.array([1.0, load, 2.0, 0.0, 0.0, 0.0]), cones


@pytest.mark.parametrize("load", [0.51, 0.6, 3.0])
def test_the_least_part_of_the_loads_that_has_to_go_proves_that_there_is_no_solution(load):
    matrix, right, cones = on_a_plane(load)
    z = _infeasibility(matrix, right, cones).z
    assert_allclose(matrix.T @ z, 0.0, atol=1e-8)
    assert right @ z == pytest.approx(-1.0)
    assert z[2] >= -1e-8
    assert z[3] >= np.hypot(z[4], z[5]) - 1e-8
    assert solve_conic(np.zeros(3), matrix, right, cones)[0] is Answer.INFEASIBLE


def test_where_there_is_a_solution_nothing_has_to_go():
    assert _infeasibility(*on_a_plane(0.49)) is None


def test_stones_on_their_corners_have_an_answer():
    """Each stone rests on one point, so no strength balances it: the program has no solution, and is not given up."""
    stones = [
        [(-6.8, -1), (6.8, -1), (6.8, 0), (-6.8, 0)],
        [(-0.286, 0.836), (-0.187, 0.246), (0.115, 0), (0.844, 0.16), (0.92, 0.783), (0.62, 1.132), (-0.075, 1.123)],
        [(-1.297, 1.061), (-1.625, 0.742), (-1.318, 0), (-1.097, 0.096), (-0.921, 0.945)],
        [(-0.696, 2.203), (-0.415, 1.229), (-0.047, 1.124), (0.367, 2.127), (0.021, 2.441)],
        [(0.12, 3.151), (-0.378, 3.797), (-1.142, 3.306), (-1.249, 2.955), (-0.916, 2.168), (-0.139, 2.388)],
    ]
    model = model_of([np.array(stone) for stone in stones], gamma=26e3, friction=50, kn=5e8, ks=5e7)
    assert not bsm.limit_analysis(model).admissible
