"""Blocks far out of balance are solved apart: they come to rest, and no others move."""

from itertools import pairwise

import numpy as np
import pytest

import bsm_mesh as bsm
from bsm_mesh.solve.continuation import Continuation
from bsm_mesh.solve.local_phase import RINGS, relax_locally
from bsm_mesh.solve.step import Step
from bsm_mesh.solve.strategies import solve_at_once

COURSES, BRICKS, TOLERANCE = 24, 40, 5e-7
BLOCK = 100  # which is pushed


@pytest.fixture(scope="module")
def rest() -> tuple[Step, np.ndarray]:
    """Return the step of a tilted wall and where it is at rest."""
    polygons = [[(-1, -0.5), (BRICKS + 1, -0.5), (BRICKS + 1, 0), (-1, 0)]]
    for c in range(COURSES):
        joints = np.arange(BRICKS + 1.0) if c % 2 == 0 else np.concatenate([[0], np.arange(BRICKS) + 0.5, [BRICKS]])
        polygons += [[(a, c / 2), (b, c / 2), (b, c / 2 + 0.5), (a, c / 2 + 0.5)] for a, b in pairwise(joints)]
    model = bsm.Model(
        blocks=bsm.Blocks.from_polygons(polygons, rock="r"),
        rocks=[bsm.Rock("r", unit_weight=2500 * 9.81)],
        joints=[bsm.Joint("J", 1e10, 1e10, law=bsm.MohrCoulomb(friction=35.0))],
        default_joint="J",
        supports=[bsm.Fixed(blocks=[0])],
        gravity_direction=-85.0,
    )
    run = Continuation(model, bsm.Options(), lambda *_: None)
    contacts = run.moving.gather(run.begin.history, run.moving.start, first=True)
    step = Step(run.moving, run.factors, contacts, run.moving.start, run.least_lam)
    found = solve_at_once(step, TOLERANCE)
    assert found.converged
    return step, found.position


def sizes(step: Step, position: np.ndarray) -> np.ndarray:
    """Return the greatest force out of balance of every block over a brick's weight."""
    forces = step.unbalanced(position, step.evaluate(position).forces)
    return np.abs(step.moving.free(forces, step.supports)).max(axis=1) / step.moving.reference


def test_a_block_out_of_place_comes_to_rest_and_those_far_from_it_stay(rest):
    step, position = rest
    pushed = position.copy()
    pushed[BLOCK, :2] += 2e-6
    before = sizes(step, pushed)
    assert before.max() > 1
    relaxed = relax_locally(step, pushed, TOLERANCE)
    moved = np.flatnonzero((relaxed != pushed).any(axis=1))
    away = np.hypot(*(position - position[BLOCK])[:, :2].T)
    assert len(moved) > 10
    assert away[moved].max() < 1.2 * (RINGS + 2)
    assert sizes(step, relaxed).max() < 0.05 * before.max()


def test_where_most_blocks_are_out_of_balance_nothing_is_solved_apart(rest):
    step, position = rest
    shaken = position + 1e-6 * np.random.default_rng(0).normal(size=position.shape)
    assert relax_locally(step, shaken, TOLERANCE) is shaken


def test_at_rest_nothing_moves(rest):
    step, position = rest
    assert relax_locally(step, position, 1e-3) is position
