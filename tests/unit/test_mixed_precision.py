"""Pardiso's factors in single precision: how good their solutions are, and what happens where they do not do."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.sparse import bsr_array

from bsm_mesh.errors import SingularMatrixError
from bsm_mesh.solve.algebra import pardiso
from bsm_mesh.solve.algebra.block_matrix import whole_pattern
from bsm_mesh.solve.algebra.linear_solvers import make_linear_solver
from bsm_mesh.solve.algebra.mixed_precision import ACCURACY, MixedPrecisionPardiso

pytestmark = pytest.mark.skipif(not pardiso.is_available(), reason="mkl is not installed")
SPRING = 1e10


def chain(n, softest, friction=0.3):
    """Return pattern, values and matrix of blocks in a row on springs; `softest` couples the first to the ground."""
    pattern = whole_pattern(n, np.arange(n - 1, dtype=np.int32), np.arange(1, n, dtype=np.int32))
    data = np.zeros((len(pattern.column), 3, 3))
    spring = SPRING * np.array([[1.0, friction, 0], [0, 0.5, 0], [0, 0, 0.2]])
    for sign, places in zip((1, -1, -1, 1), pattern.place.T, strict=True):
        np.add.at(data, places, sign * spring)
    data[pattern.diagonal[0]] += softest * np.eye(3)
    return pattern, data, bsr_array((data, pattern.column, pattern.row_start))


def test_a_solution_is_as_accurate_as_promised():
    pattern, data, matrix = chain(400, SPRING)
    force = np.random.default_rng(0).normal(size=(400, 3)) * 1e4
    solver = MixedPrecisionPardiso(pattern)
    solver.factorize(data)
    left = force.ravel() - matrix @ solver.solve(force).ravel()
    root = np.sqrt(matrix.diagonal())
    assert np.abs(left / root).max() <= ACCURACY * np.abs(force.ravel() / root).max()
    assert_allclose(solver.solve(np.zeros((400, 3))), 0.0)
    solver.close()


@pytest.mark.parametrize("size", [1e-30, 1e30])
def test_forces_of_any_size(size):
    pattern, data, matrix = chain(50, SPRING)
    force = np.ones((50, 3))
    solver = MixedPrecisionPardiso(pattern)
    solver.factorize(data)
    exact = np.linalg.solve(matrix.toarray(), force.ravel())
    assert_allclose(solver.solve(size * force).ravel(), size * exact, rtol=1e-2)
    solver.close()


def test_what_single_precision_cannot_hold_is_solved_in_double():
    pattern, data, matrix = chain(50, 1e-8 * SPRING)
    force = np.ones((50, 3))
    solver = MixedPrecisionPardiso(pattern)
    solver.factorize(data)
    assert_allclose(matrix @ solver.solve(force).ravel(), force.ravel(), rtol=1e-4)
    solver.close()


def test_a_singular_matrix_noticed_late_is_no_crash(monkeypatch):
    def singular(solver, data):
        raise SingularMatrixError("no pivot")

    pattern, data, _ = chain(50, 1e-8 * SPRING)
    solver = MixedPrecisionPardiso(pattern)
    solver.factorize(data)
    monkeypatch.setattr(pardiso.Pardiso, "factorize", singular)
    assert np.isnan(solver.solve(np.ones((50, 3)))).all()


def test_large_systems_of_corrections_take_it():
    for rows, kind in ((pardiso.LARGE, MixedPrecisionPardiso), (pardiso.LARGE - 1, pardiso.Pardiso)):
        pattern, data, _ = chain(rows, SPRING)
        solver = make_linear_solver("pardiso", pattern, np.zeros((rows, 2)), corrections=True)
        assert type(solver) is kind
        solver.factorize(data)
        assert np.isfinite(solver.solve(np.ones((rows, 3)))).all()
        solver.close()


@pytest.mark.parametrize(("lacks", "single"), [(0.2, True), (0.7, False)])
def test_refinement_goes_on_while_each_leaves_less_than_half(monkeypatch, lacks, single):
    """Factors whose solutions lack a fifth need six refinements; those that lack more are made again in double."""
    pattern, data, matrix = chain(50, SPRING)
    force, real, count = np.ones((50, 3)), MixedPrecisionPardiso._solved, []

    def poor(self, right_side):
        count.append(1)
        return (1 - lacks) * real(self, right_side)

    monkeypatch.setattr(MixedPrecisionPardiso, "_solved", poor)
    solver = MixedPrecisionPardiso(pattern)
    solver.factorize(data)
    assert_allclose(matrix @ solver.solve(force).ravel(), force.ravel(), rtol=1e-3)
    assert solver.single == single
    assert (len(count) == 6) == single
    solver.close()
