"""Pardiso, SuperLU and dense elimination on the same matrices; what happens to singular ones."""

import re

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import bsm_mesh as bsm
from bsm_mesh.errors import SingularMatrixError
from bsm_mesh.solve.algebra import pardiso
from bsm_mesh.solve.algebra.block_matrix import block_pattern, whole_pattern
from bsm_mesh.solve.algebra.linear_solvers import make_linear_solver
from bsm_mesh.solve.algebra.superlu import SuperLU
from bsm_mesh.solve.linear import readiness
from tests.scenes.models import model_of
from tests.scenes.reference import full_matrix
from tests.scenes.shapes import rectangle

SOLVERS = [
    "superlu",
    pytest.param("pardiso", marks=pytest.mark.skipif(not pardiso.is_available(), reason="mkl is not installed")),
]
RTOL = 1e-9  # condition numbers of 1e3 to 1e5


def random_system(n, links, seed):
    """Return a pattern, its values and the dense matrix of a positive definite matrix."""
    rng = np.random.default_rng(seed)
    a = rng.integers(0, n, links).astype(np.int32)
    b = ((a + rng.integers(1, max(n, 2), links)) % n).astype(np.int32)
    if n == 1:
        a, b = a[:0], b[:0]
    pattern = block_pattern(n, a, b)
    data = np.zeros((len(pattern.column), 3, 3))
    for i in range(n):
        for p in range(pattern.row_start[i], pattern.row_start[i + 1]):
            j = pattern.column[p]
            if i != j:
                data[p] = rng.normal(size=(3, 3))
    full = full_matrix(pattern, data)
    for i in range(n):
        own = rng.normal(size=(3, 3))
        block = own @ own.T + np.eye(3) * (np.abs(full[3 * i : 3 * i + 3]).sum() + 1)
        data[pattern.row_start[i]] = block
        full[3 * i : 3 * i + 3, 3 * i : 3 * i + 3] = block
    return pattern, data, full


def grid(side, whole):
    """Return pattern and values of a square grid: 5 for every block, -1 for its neighbours."""
    number = np.arange(side * side, dtype=np.int32).reshape(side, side)
    a = np.concatenate([number[:, :-1].ravel(), number[:-1].ravel()])
    b = np.concatenate([number[:, 1:].ravel(), number[1:].ravel()])
    pattern = (whole_pattern if whole else block_pattern)(side * side, a, b)
    data = np.repeat(-np.eye(3)[None], len(pattern.column), axis=0)
    data[pattern.diagonal] = 5 * np.eye(3)
    return pattern, data


def positions(pattern):
    """Return a place for every block; on a line, many at the same point, which an ordering has to carry."""
    return np.stack([np.arange(pattern.rows) % 17.0, np.zeros(pattern.rows)], axis=1)


@pytest.mark.parametrize("name", SOLVERS)
@pytest.mark.parametrize("once", [False, True])
@pytest.mark.parametrize(("n", "links"), [(1, 0), (2, 1), (2, 0), (7, 10), (60, 150), (300, 900)])
def test_against_dense(name, n, links, once):
    pattern, data, full = random_system(n, links, seed=n)
    b = np.random.default_rng(0).normal(size=(n, 3))
    solver = make_linear_solver(name, pattern, positions(pattern), once=once)
    assert solver.name == name
    solver.factorize(data)
    assert_allclose(solver.solve(b).reshape(-1), np.linalg.solve(full, b.reshape(-1)), rtol=RTOL, atol=1e-12)
    solver.close()


@pytest.mark.parametrize("name", SOLVERS)
def test_new_values_in_the_same_pattern_and_several_right_sides(name):
    pattern, data, full = random_system(40, 100, seed=4)
    solver = make_linear_solver(name, pattern, positions(pattern), threads=1)
    for factor in (1.0, 3.0):
        solver.factorize(factor * data)
        for seed in (1, 2):
            b = np.random.default_rng(seed).normal(size=(40, 3))
            expected = np.linalg.solve(factor * full, b.reshape(-1))
            assert_allclose(solver.solve(b).reshape(-1), expected, rtol=RTOL, atol=1e-12)
    solver.close()


@pytest.mark.parametrize("name", SOLVERS)
def test_two_solvers_at_once_do_not_mix(name):
    first, second = random_system(20, 40, seed=1), random_system(25, 60, seed=2)
    solvers = [make_linear_solver(name, s[0], positions(s[0])) for s in (first, second)]
    for solver, s in zip(solvers, (first, second), strict=True):
        solver.factorize(s[1])
    for solver, (pattern, _, full) in zip(solvers, (first, second), strict=True):
        b = np.ones((pattern.rows, 3))
        assert_allclose(solver.solve(b).reshape(-1), np.linalg.solve(full, b.reshape(-1)), rtol=RTOL)
        solver.close()


@pytest.mark.parametrize("name", SOLVERS)
@pytest.mark.parametrize("lift", [1e-6, -1e-6])
def test_a_matrix_that_is_not_positive_definite_is_found_out_when_asked_for(name, lift):
    """Its lowest eigenvalue a millionth of the highest off zero, to one side or the other."""
    pattern, data, full = random_system(60, 150, seed=5)
    values = np.linalg.eigvalsh(full)
    data[pattern.diagonal] += (lift * values[-1] - values[0]) * np.eye(3)
    solver = make_linear_solver(name, pattern, positions(pattern), once=True, definite=True)
    if lift > 0:
        solver.factorize(data)
    else:
        with pytest.raises(SingularMatrixError):
            solver.factorize(data)
    solver.close()


@pytest.mark.parametrize("name", SOLVERS)
def test_a_singular_matrix_raises(name):
    pattern, data, _ = random_system(5, 6, seed=3)
    data = np.zeros_like(data)
    solver = make_linear_solver(name, pattern, positions(pattern))
    with pytest.raises(SingularMatrixError):
        solver.factorize(data)
    solver.close()


@pytest.mark.parametrize("name", SOLVERS)
def test_closing_twice_does_no_harm(name):
    pattern, data, _ = random_system(5, 6, seed=3)
    solver = make_linear_solver(name, pattern, positions(pattern))
    solver.factorize(data)
    solver.close()
    solver.close()


def test_unknown_name():
    pattern = random_system(2, 1, seed=0)[0]
    with pytest.raises(
        bsm.ModelError, match=re.escape("linear_solver: 'superlou' is unknown; did you mean 'superlu'?")
    ):
        make_linear_solver("superlou", pattern, positions(pattern))


def test_auto_says_what_it_took(monkeypatch):
    pattern = random_system(2, 1, seed=0)[0]
    assert make_linear_solver("auto", pattern, positions(pattern)).name == (
        "pardiso" if pardiso.is_available() else "superlu"
    )
    monkeypatch.setattr(pardiso, "is_available", lambda: False)
    assert isinstance(make_linear_solver("auto", pattern, positions(pattern)), SuperLU)


def test_pardiso_that_is_not_there(monkeypatch):
    monkeypatch.setattr(pardiso, "_library", lambda: None)
    with pytest.raises(bsm.ModelError, match=re.escape("needs the package mkl (x86-64)")):
        make_linear_solver("pardiso", random_system(2, 1, seed=0)[0], np.zeros((2, 2)))


@pytest.mark.parametrize("threads", [0, 1, 2])
@pytest.mark.skipif(not pardiso.is_available(), reason="mkl is not installed")
def test_threads_change_nothing_but_the_time(threads):
    pattern, data, full = random_system(300, 900, seed=9)
    solver = make_linear_solver("pardiso", pattern, positions(pattern), threads)
    solver.factorize(data)
    b = np.ones((300, 3))
    assert_allclose(solver.solve(b).reshape(-1), np.linalg.solve(full, b.reshape(-1)), rtol=RTOL)
    solver.close()


@pytest.mark.heavy
@pytest.mark.skipif(not pardiso.is_available(), reason="mkl is not installed")
@pytest.mark.parametrize("single", [False, True])
def test_corrections_are_the_same_to_the_last_digit_whatever_the_threads(single):
    """Where many contacts slip, the last digit of a correction decides on which way Newton's method takes."""
    pattern, data = grid(150, whole=True)
    data[pattern.diagonal] += np.random.default_rng(1).uniform(0, 0.5, (pattern.rows, 3, 3))
    right, found = np.random.default_rng(3).normal(size=(pattern.rows, 3)), []
    for threads in (1, 2, 2):
        solver = pardiso.Pardiso(pattern, threads, single=single)
        solver.factorize(data)
        found.append(solver.solve(right))
        solver.close()
    assert_array_equal(found[1], found[0])
    assert_array_equal(found[2], found[0])


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"linear_solver": "pardso"}, "solver: linear_solver = 'pardso' is unknown; did you mean 'pardiso'?"),
        ({"scheme": "linaer"}, "solver: scheme = 'linaer' is unknown; did you mean 'linear'?"),
        ({"tolerance": 0}, "solver: tolerance = 0 must be 1e-12 to 1e-4; with a greater one"),
        ({"sliding_stiffness": 0}, "solver: sliding_stiffness = 0 must be above 0"),
        ({"sliding_stiffness": 1.1}, "solver: sliding_stiffness = 1.1 must be above 0 and at most 1"),
        ({"threads": -1}, "solver: threads = -1 must be a whole number, 0 to 4096"),
        ({"threads": 1.5}, "solver: threads = 1.5 must be a whole number"),
    ],
)
def test_options(options, message):
    with pytest.raises(bsm.ModelError, match=re.escape(message)):
        bsm.Options(**options)


@pytest.mark.parametrize("name", SOLVERS)
@pytest.mark.parametrize("whole", [False, True])
def test_enough_blocks_for_all_threads(name, whole):
    """Pardiso dies where the number of threads changes from factorization to solution."""
    side = 80  # more blocks than are left to one thread
    pattern, data = grid(side, whole)
    number = np.arange(pattern.rows)
    right = np.random.default_rng(3).normal(size=(side * side, 3))
    solver = make_linear_solver(name, pattern, np.stack([number % side, number // side], 1) * 1.0)
    for _ in range(3):
        solver.factorize(data)
        x = solver.solve(right)
    x = x.reshape(side, side, 3)
    product = 5 * x
    for to, come in ((np.s_[1:], np.s_[:-1]), (np.s_[:, 1:], np.s_[:, :-1])):
        product[to] -= x[come]
        product[come] -= x[to]
    assert_allclose(product.reshape(-1, 3), right, atol=1e-12)
    solver.close()


@pytest.mark.parametrize(
    ("solver", "installed", "large", "machine", "advised"),
    [
        ("auto", False, 3, "x86_64", True),
        ("auto", False, 4, "x86_64", False),
        ("auto", True, 3, "x86_64", False),
        ("superlu", False, 3, "x86_64", False),
        ("auto", False, 3, "aarch64", False),
    ],
)
def test_a_large_model_without_pardiso_is_advised_to_install_it(
    solver, installed, large, machine, advised, monkeypatch
):
    monkeypatch.setattr(pardiso, "is_available", lambda: installed)
    monkeypatch.setattr(pardiso, "LARGE", large)
    monkeypatch.setattr("platform.machine", lambda: machine)
    base, *bricks = rectangle(-1, -1, 2, 0), rectangle(0, 0, 1, 1), rectangle(0, 1, 1, 2)
    monkeypatch.setattr(readiness, "solver_faults", lambda options: ())  # whatever is installed here
    notes = readiness.make_ready(model_of([base, *bricks]), bsm.Options(linear_solver=solver)).notes
    assert any("pip install mkl" in note for note in notes) == advised
