"""The stiffness matrix: its pattern and values against dense sums, its symmetry and its null space."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import bsm_mesh as bsm
from bsm_mesh.contact.table import initial_contacts
from bsm_mesh.solve.algebra.block_matrix import block_pattern, constrain, fill_stiffness, upper_triangle, whole_pattern
from tests.scenes.reference import dense_solution, full_matrix
from tests.scenes.shapes import grid, running_bond, turned

STIFFNESS = (3e8, 1e8)
SCENES = {"grid": grid(3, 3), "bond": running_bond(4, 3), "turned": [turned(p, 23) for p in running_bond(4, 3)]}


def assembled(polygons):
    blocks = bsm.Blocks.from_polygons(polygons, rock="r")
    model = bsm.Model(
        blocks=blocks, rocks=[bsm.Rock("r", unit_weight=0)], joints=[bsm.Joint("J", *STIFFNESS)], default_joint="J"
    )
    c = initial_contacts(model)
    pattern = block_pattern(blocks.count, c.block_a, c.block_b)
    data = fill_stiffness(
        pattern.row_start, c.block_a, c.block_b, pattern.place, len(pattern.column),
        c.point, c.normal, c.normal_stiffness, c.shear_stiffness, blocks.moments.centroid,
    )  # fmt: skip
    return model, pattern, data


@pytest.mark.parametrize("name", SCENES)
def test_values_against_dense_sums(name):
    model, pattern, data = assembled(SCENES[name])
    expected = dense_solution(SCENES[name], STIFFNESS, np.zeros((model.blocks.count, 3)), [(0, (0, 0), 0, 0)]).K
    assert_allclose(full_matrix(pattern, data), expected, rtol=0, atol=1e-12 * expected.max())


@pytest.mark.parametrize("name", SCENES)
def test_symmetric_and_positive_semi_definite_with_three_rigid_motions(name):
    model, pattern, data = assembled(SCENES[name])
    K = full_matrix(pattern, data)
    assert_allclose(K, K.T, rtol=0, atol=1e-15 * K.max())
    values = np.linalg.eigvalsh(K)
    assert values[0] > -1e-10 * values[-1]
    assert (values < 1e-10 * values[-1]).sum() == 3
    x, y = model.blocks.moments.centroid.T
    one, zero = np.ones_like(x), np.zeros_like(x)
    for motion in ((one, zero, zero), (zero, one, zero), (-y, x, one)):
        assert_allclose(K @ np.stack(motion, axis=1).reshape(-1), 0, atol=1e-10 * K.max())


def test_pattern_of_random_pairs():
    rng = np.random.default_rng(3)
    n = 30
    a = rng.integers(0, n, 200).astype(np.int32)
    b = ((a + rng.integers(1, n, 200)) % n).astype(np.int32)
    pattern = block_pattern(n, a, b)
    expected = sorted(
        {(min(i, j), max(i, j)) for i, j in zip(a.tolist(), b.tolist(), strict=True)} | {(i, i) for i in range(n)}
    )
    row = np.repeat(np.arange(n), np.diff(pattern.row_start))
    assert list(zip(row.tolist(), pattern.column.tolist(), strict=True)) == expected
    assert_array_equal(row[pattern.place], np.minimum(a, b))
    assert_array_equal(pattern.column[pattern.place], np.maximum(a, b))
    assert_array_equal(pattern.column[pattern.row_start[:-1]], np.arange(n))


def test_pattern_without_contacts_is_the_diagonal():
    none = np.zeros(0, dtype=np.int32)
    pattern = block_pattern(3, none, none)
    assert pattern.column.tolist() == [0, 1, 2]
    assert pattern.row_start.tolist() == [0, 1, 2, 3]


def test_an_open_contact_keeps_its_place():
    a, b = np.array([0, 1], np.int32), np.array([1, 2], np.int32)
    pattern = block_pattern(3, a, b)
    zero, one = np.zeros(2), np.ones(2)
    data = fill_stiffness(
        pattern.row_start, a, b, pattern.place, len(pattern.column),
        np.zeros((2, 2)), np.array([[1.0, 0]] * 2), np.array([0.0, 5.0]), zero * one, np.zeros((3, 2)),
    )  # fmt: skip
    assert len(data) == 5
    assert_array_equal(data[pattern.place[0]], 0)
    assert data[pattern.place[1], 0, 0] == -5


def test_constrain_is_a_change_of_axes():
    """T^T K T with the held rows and columns struck out, compared with dense products."""
    from bsm_mesh.solve.algebra.constraints import build_constraints

    polygons = [turned(p, 23) for p in grid(3, 3)]
    model, pattern, data = assembled(polygons)
    supports = [
        bsm.Roller(point=tuple(polygons[0][0]), direction=40),
        bsm.Fixed(point=tuple(polygons[2][1])),
        bsm.Fixed(blocks=[7]),
    ]
    support = build_constraints(model.replace(supports=supports))
    assert sorted(support.constrained.tolist()) == [1, 2, 3]
    T = np.eye(3 * model.blocks.count)
    struck = np.zeros(3 * model.blocks.count, dtype=bool)
    for row, block in enumerate(support.block):
        T[3 * block : 3 * block + 3, 3 * block : 3 * block + 3] = support.basis[row]
        struck[3 * block : 3 * block + support.constrained[row]] = True
    expected = T.T @ full_matrix(pattern, data) @ T
    expected[struck] = 0
    expected[:, struck] = 0
    expected[struck, struck] = 1
    axes = support.number, support.basis, support.constrained
    constrain(pattern.row_start, pattern.column, pattern.diagonal, data, *axes)
    assert_allclose(full_matrix(pattern, data), expected, rtol=0, atol=1e-12 * expected.max())


def test_frames_do_not_matter_for_the_trace():
    """Turning the model leaves the invariants of K unchanged."""
    traces = [np.trace(full_matrix(*assembled([turned(p, a) for p in grid(2, 2)])[1:])) for a in (0, 17, 90)]
    assert_allclose(traces, traces[0], rtol=1e-12)


def test_the_upper_triangle_of_a_whole_pattern_is_that_of_the_same_pairs():
    rng = np.random.default_rng(7)
    a = rng.integers(0, 40, 90).astype(np.int32)
    b = ((a + rng.integers(1, 40, 90)) % 40).astype(np.int32)
    whole, expected = whole_pattern(40, a, b), block_pattern(40, a, b)
    upper, chosen = upper_triangle(whole)
    row = np.repeat(np.arange(40), np.diff(whole.row_start))
    assert_array_equal(chosen, row <= whole.column)
    for name in ("row_start", "column", "diagonal", "place"):
        assert_array_equal(getattr(upper, name), getattr(expected, name))
    assert upper.symmetric
