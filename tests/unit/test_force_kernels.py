"""Forces and tangent of contacts in a moving frame, against finite differences, statics and a dense matrix."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from bsm_mesh.contact.force_kernels import add_moving_forces, fill_tangent, given_geometry, relative_positions
from bsm_mesh.solve.algebra.block_matrix import constrain, whole_pattern
from tests.scenes.reference import full_matrix

N, M = 5, 14
COUPLING = 0.2  # of the pressure with the movement along the edge, over the normal stiffness
KN, KS, SLOPE = 3.0, 2.0, 0.6


class Scene:
    """Random blocks and contacts, of any rotation and gap; forces as a function of the position alone."""

    def __init__(self, seed, state):
        rng = np.random.default_rng(seed)
        self.state = state
        self.position = np.column_stack([rng.normal(scale=2, size=(N, 2)), rng.uniform(-7, 7, N)])
        self.a = rng.integers(0, N, M).astype(np.int32)
        self.b = ((self.a + rng.integers(1, N, M)) % N).astype(np.int32)
        self.corners = rng.normal(size=(2 * M, 2))
        self.corner, self.edge = np.arange(M, dtype=np.int32), np.arange(M, 2 * M, dtype=np.int32)
        angle = rng.uniform(-np.pi, np.pi, 2 * M)
        self.directions = np.column_stack([np.cos(angle), np.sin(angle)])
        self.kn, self.ks = KN * rng.uniform(0.5, 2, M), KS * rng.uniform(0.5, 2, M)
        self.kn[-1] = self.ks[-1] = 0.0  # an open contact
        gap, coordinate = self.relative(self.position)[:2]
        self.free_gap = gap + rng.uniform(0.2, 1.0, M) * (1.0 if state != "tension" else -1.0)
        self.old = coordinate - rng.normal(size=M)

    def relative(self, position):
        numbers = self.a, self.b, self.corner, self.edge
        given = given_geometry(*numbers, np.zeros((N, 2)), self.corners, self.directions)
        return relative_positions(position, self.a, self.b, given)

    def respond(self, position):
        gap, coordinate, *_ = self.relative(position)
        pressure = -self.kn * (gap - self.free_gap)
        if self.state == "sliding":
            return pressure, SLOPE * np.sign(coordinate - self.old) * pressure
        if self.state == "opening":
            pressure = pressure + COUPLING * self.kn * (coordinate - self.old)
        return pressure, self.ks * (coordinate - self.old)

    def forces(self, position):
        total = np.zeros((N, 3))
        _, _, tangent, arm_a, arm_b = self.relative(position)
        add_moving_forces(self.a, self.b, tangent, arm_a, arm_b, *self.respond(position), total)
        return total

    def tangent(self, pattern):
        _, coordinate, tangent, arm_a, arm_b = self.relative(self.position)
        pressure, shear = self.respond(self.position)
        sign = np.sign(coordinate - self.old)
        by_gap = -SLOPE * sign * self.kn if self.state == "sliding" else np.zeros(M)
        ks = np.zeros(M) if self.state == "sliding" else self.ks
        by_along = COUPLING * self.kn if self.state == "opening" else np.zeros(0)
        return fill_tangent(
            pattern.place, len(pattern.column), tangent, arm_a, arm_b, self.kn, by_gap, ks, pressure, shear, by_along
        )


def differences(function, position, step=1e-5):
    columns = []
    for k in range(position.size):
        moved = [position.copy(), position.copy()]
        for m, sign in zip(moved, (1, -1), strict=True):
            m.reshape(-1)[k] += sign * step
        columns.append((function(moved[0]) - function(moved[1])).reshape(-1) / (2 * step))
    return np.column_stack(columns)


@pytest.mark.parametrize("state", ["sticking", "sliding", "tension", "opening"])
@pytest.mark.parametrize("seed", range(6))
def test_tangent_is_the_derivative_of_minus_the_forces(seed, state):
    scene = Scene(seed, state)
    pattern = whole_pattern(N, scene.a, scene.b)
    found = full_matrix(pattern, scene.tangent(pattern))
    expected = -differences(scene.forces, scene.position)
    assert_allclose(found, expected, rtol=0, atol=1e-8 * np.abs(expected).max())


@pytest.mark.parametrize("seed", range(6))
def test_forces_of_sticking_contacts_are_minus_the_gradient_of_their_energy(seed):
    scene = Scene(seed, "sticking")

    def energy(position):
        gap, coordinate, *_ = scene.relative(position)
        return np.array([(scene.kn * (gap - scene.free_gap) ** 2 + scene.ks * (coordinate - scene.old) ** 2).sum() / 2])

    expected = -differences(energy, scene.position).reshape(N, 3)
    assert_allclose(scene.forces(scene.position), expected, rtol=0, atol=1e-8 * np.abs(expected).max())
    matrix = full_matrix(*(lambda p: (p, scene.tangent(p)))(whole_pattern(N, scene.a, scene.b)))
    assert_allclose(matrix, matrix.T, rtol=0, atol=1e-12 * np.abs(matrix).max())


@pytest.mark.parametrize("state", ["sticking", "sliding", "tension"])
@pytest.mark.parametrize("seed", range(3))
def test_forces_and_moments_about_any_point_sum_to_zero(seed, state):
    scene = Scene(seed, state)
    total = scene.forces(scene.position)
    size = np.abs(total).max()
    assert_allclose(total[:, :2].sum(axis=0), 0, atol=1e-13 * size)
    for point in ((0.0, 0.0), (3.0, -7.0)):
        arm = scene.position[:, :2] - point
        moment = total[:, 2] + arm[:, 0] * total[:, 1] - arm[:, 1] * total[:, 0]
        assert_allclose(moment.sum(), 0, atol=1e-12 * size)


def test_gap_and_coordinate_by_hand():
    """Edge of b from (1, 0) along y turned by 90 degrees about (0, 0): from (0, 1) along -x, outward normal +y."""
    position, centroid = np.array([(0.0, 1.0, np.pi), (0.0, 0.0, np.pi / 2)]), np.array([(5.0, 3.0), (5.0, 1.0)])
    one, zero = np.array([0], np.int32), np.array([1], np.int32)
    corners, directions = np.array([(0.5, 0.75), (1.0, 0.0)]), np.array([(1.0, 0.0), (0.0, 1.0)])
    given = given_geometry(one, zero, np.array([0], np.int32), np.array([1], np.int32), centroid, corners, directions)
    gap, coordinate, tangent, arm_a, arm_b = relative_positions(position, one, zero, given)
    assert_allclose(gap, 1.25)
    assert_allclose(coordinate, 0.5)
    assert_allclose(tangent, [(-1, 0)], atol=1e-15)
    assert_allclose(arm_a, [(-0.5, -0.75)])
    assert_allclose(arm_b, [(-0.5, 2.25)])


def test_forces_do_not_depend_on_the_frame():
    """Turn and shift everything: forces turn along, moments stay, so the invariants of large rotation hold."""
    scene, angle = Scene(0, "sticking"), 2.1
    before = scene.forces(scene.position)
    turn = np.array([(np.cos(angle), -np.sin(angle)), (np.sin(angle), np.cos(angle))])
    moved = np.column_stack([scene.position[:, :2] @ turn.T + (1e3, -2e3), scene.position[:, 2] + angle])
    after = scene.forces(moved)
    assert_allclose(after[:, :2], before[:, :2] @ turn.T, atol=1e-10 * np.abs(before).max())
    assert_allclose(after[:, 2], before[:, 2], atol=1e-10 * np.abs(before).max())


@pytest.mark.parametrize("n", [1, 2, 7, 40])
def test_whole_pattern_against_dense(n):
    rng = np.random.default_rng(n)
    m = 0 if n == 1 else 3 * n
    a = rng.integers(0, n, m).astype(np.int32)
    b = ((a + rng.integers(1, max(n, 2), m)) % n).astype(np.int32)
    pattern = whole_pattern(n, a, b)
    marked = np.zeros((n, n), dtype=int)
    row = np.repeat(np.arange(n), np.diff(pattern.row_start))
    np.add.at(marked, (row, pattern.column), 1)
    expected = np.eye(n, dtype=int)
    expected[a, b] = expected[b, a] = 1
    assert (marked == expected).all()
    for i in range(n):
        assert (np.diff(pattern.column[pattern.row_start[i] : pattern.row_start[i + 1]]) > 0).all()
    assert (pattern.column[pattern.diagonal] == np.arange(n)).all()
    assert (row[pattern.diagonal] == np.arange(n)).all()
    for k, (i, j) in enumerate(((a, a), (a, b), (b, a), (b, b))):
        assert (row[pattern.place[:, k]] == i).all()
        assert (pattern.column[pattern.place[:, k]] == j).all()
    assert not pattern.symmetric


def test_constrain_of_a_whole_matrix_against_dense():
    scene = Scene(1, "sliding")
    pattern = whole_pattern(N, scene.a, scene.b)
    data = scene.tangent(pattern)
    matrix = full_matrix(pattern, data)
    basis = np.stack([np.linalg.qr(np.random.default_rng(k).normal(size=(3, 3)))[0] for k in range(2)])
    number = np.array([-1, 0, -1, 1, -1], dtype=np.int32)
    fixed = np.array([2, 1], dtype=np.int32)
    turn, struck = np.eye(3 * N), np.zeros(3 * N, dtype=bool)
    for block, k in ((1, 0), (3, 1)):
        turn[3 * block : 3 * block + 3, 3 * block : 3 * block + 3] = basis[k]
        struck[3 * block : 3 * block + fixed[k]] = True
    expected = turn.T @ matrix @ turn
    expected[struck], expected[:, struck] = 0, 0
    expected[struck, struck] = 1
    constrain(pattern.row_start, pattern.column, pattern.diagonal, data, number, basis, fixed)
    assert_allclose(full_matrix(pattern, data), expected, atol=1e-12 * np.abs(matrix).max())
