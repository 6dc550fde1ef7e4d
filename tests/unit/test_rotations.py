"""Finite rotations in space: matrices, movements about instant axes, angles beyond a turn; points that blocks carry."""

import numpy as np
from numpy.testing import assert_allclose

from bsm_mesh.movements import angles, carried, distances, turned
from bsm_mesh.three_d.contacts.rotations import moved_by, movement_between, swings, turned_on, turns_of

ROUNDING = 1e-14


def random(seed, size=1.0, count=20):
    return size * np.random.default_rng(seed).normal(size=(count, 6))


def matrices(turn):
    return swings(turn) + np.eye(3)


def test_matrices_are_rotations_about_their_vectors():
    turn = random(0, 2.0)[:, 3:]
    matrix = matrices(turn)
    assert_allclose(np.einsum("kij,klj->kil", matrix, matrix), np.tile(np.eye(3), (20, 1, 1)), atol=ROUNDING)
    assert_allclose(np.linalg.det(matrix), 1)
    assert_allclose(np.einsum("kij,kj->ki", matrix, turn), turn, atol=1e-13)
    assert_allclose(np.trace(matrix, axis1=1, axis2=2), 1 + 2 * np.cos(np.linalg.norm(turn, axis=1)), atol=ROUNDING)


def test_small_rotations_lose_no_digits():
    turn = random(1, 1e-9)[:, 3:]
    swing = swings(turn)
    assert_allclose((swing[:, 2, 1] - swing[:, 1, 2]) / 2, turn[:, 0], rtol=1e-14)
    assert_allclose(turned_on(np.zeros_like(turn), turn), turn, rtol=1e-14)


def test_a_rotation_after_another_is_the_product_of_matrices():
    first, second = random(2)[:, 3:], random(3)[:, 3:]
    assert_allclose(matrices(turned_on(first, second)), matrices(second) @ matrices(first), atol=1e-13)


def test_angles_go_on_beyond_a_turn():
    turn, step = np.zeros((1, 3)), np.array([[0.0, 0.3, 0.4]])
    for _ in range(40):
        turn = turned_on(turn, step)
    assert_allclose(turn, 40 * step, atol=1e-12)


def test_a_movement_keeps_the_instant_axis_in_place():
    """A block that turns about a point by any angle, as its centroid's velocity and turn say at the start."""
    point, turn = np.array([[0.3, -0.2, 0.5]]), np.array([[0.5, 1.2, -0.7]])
    movement = np.hstack([np.cross(turn, -point), turn])
    moved = moved_by(np.zeros((1, 6)), movement)
    assert_allclose(carried(point, moved), 0, atol=ROUNDING)


def test_a_movement_between_positions_is_that_which_leads_there():
    position, other = random(4), random(5)
    reached = moved_by(position, movement_between(position, other))
    assert_allclose(reached[:, :3], other[:, :3], atol=1e-13)
    assert_allclose(matrices(reached[:, 3:]), matrices(other[:, 3:]), atol=1e-13)


def test_a_turn_between_matrices():
    first, step = random(6)[:, 3:], random(7, 0.1)[:, 3:]
    assert_allclose(turns_of(swings(first), swings(turned_on(first, step))), step, atol=1e-13)


def test_points_and_vectors_turn_with_their_blocks():
    movement, arm = random(8), random(9)[:, :3]
    there = np.einsum("kij,kj->ki", matrices(movement[:, 3:]), arm)
    assert_allclose(turned(arm, movement[:, 3:]), there, atol=1e-13)
    assert_allclose(carried(arm, movement), movement[:, :3] + there - arm, atol=1e-13)


def test_lengths_and_angles_of_movements():
    movement = np.array([[1.0, 2.0, 2.0, 0.0, 3.0, 4.0]])
    assert_allclose([distances(movement), angles(movement)], [[3.0], [5.0]])
    assert_allclose([distances(np.array([[3.0, 4.0, -2.0]])), angles(np.array([[3.0, 4.0, -2.0]]))], [[5.0], [2.0]])
