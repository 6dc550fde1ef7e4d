"""Forces of bolts in a moving frame and their tangent, against differences of the forces."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.solve.algebra.block_matrix import block_pattern, whole_pattern
from bsm_mesh.solve.bolts.state import holding_pairs
from tests.scenes.models import installed_bolts, model_of
from tests.scenes.reference import full_matrix
from tests.scenes.shapes import rectangle

BLOCKS = bsm.Blocks.from_polygons([rectangle(i, j, i + 1, j + 1) for j in range(3) for i in range(4)], rock="rock")
START = np.zeros((BLOCKS.count, 3))
LINE = {"start": (0.2, 0.3), "end": (3.9, 2.6), "diameter": 0.025}
BOLTS = {
    "holding": bsm.Bolt(**LINE),
    "slipping": bsm.Bolt(**LINE, bond_strength=3e4, spacing=1.7),
    "yielding": bsm.Bolt(**LINE, yield_strength=1e8),
    "elastic bond": bsm.Bolt(**LINE, bond_stiffness=2e8, bond_strength=1e5, plate=5e4),
    "end-anchored": bsm.Bolt(**LINE, kind="end_anchored", pretension=4e4, spacing=0.7),
    "dowel": bsm.Bolt(**LINE, bond_strength=5e4, bearing_stiffness=1e9, spacing=1.3),
    "dowel gives way": bsm.Bolt(**LINE, yield_strength=3e8, bearing_stiffness=1e10, bearing_strength=2e7),
    "dowel, elastic bond": bsm.Bolt(**LINE, bond_stiffness=2e8, bearing_stiffness=1e9, plate=5e4),
    "anchorage slips": bsm.Bolt(**LINE, kind="end_anchored", pretension=4e4, anchor_capacity=4e4),
}


def displaced(seed, size=2e-3):
    return START + np.random.default_rng(seed).normal(size=START.shape) * size


def dense(installed, at, pattern, **keys):
    """Return the tangent as a full matrix, the upper triangle mirrored."""
    data = np.zeros((len(pattern.column), 3, 3))
    installed.add_tangent(at, installed.places(pattern), data, **keys)
    return full_matrix(pattern, data)


@pytest.mark.parametrize("name", BOLTS)
@pytest.mark.parametrize("seed", range(3))
def test_tangent(name, seed):
    installed = installed_bolts([BOLTS[name]], BLOCKS, START)
    position = displaced(seed)
    at = installed.evaluate(position)
    lower, higher = installed.pairs
    found = dense(installed, at, whole_pattern(BLOCKS.count, lower, higher))
    expected = np.zeros_like(found)
    step = 1e-7
    for k in range(position.size):
        change = np.zeros(position.size)
        change[k] = step
        change = change.reshape(position.shape)
        ahead, behind = (installed.evaluate(position + s * change).forces.reshape(-1) for s in (1, -1))
        expected[:, k] = -(ahead - behind) / (2 * step)
    assert np.abs(expected).max() > 0
    assert ("dowel" in name) == (np.abs(at.dowels.force) > 1).any()
    assert_allclose(found, expected, atol=2e-5 * np.abs(expected).max())
    assert_allclose(dense(installed, at, block_pattern(BLOCKS.count, lower, higher)), found, atol=1e-9 * found.max())


@pytest.mark.parametrize("turn", [0.0, 0.6, 2.2])
@pytest.mark.parametrize("seed", range(3))
def test_tangent_of_a_dowel_far_sheared(seed, turn):
    """By a tenth of the blocks' size: force times second derivatives is as large as stiffness times the first ones."""
    loose = bsm.Bolt(**LINE, bond_strength=1.0, bearing_stiffness=1e9, spacing=1.3)
    installed = installed_bolts([loose], BLOCKS, START)
    position = displaced(seed, 0.1) + np.array([0, 0, turn])
    dowels, at = installed.dowels, installed.evaluate(position).dowels
    lower, higher = installed.pairs
    pattern = whole_pattern(BLOCKS.count, lower, higher)
    data, flat = np.zeros((len(pattern.column), 3, 3)), np.zeros((len(pattern.column), 3, 3))
    dowels.add_tangent(at, installed.alive, installed.places(pattern), data, turning=True)
    dowels.add_tangent(at, installed.alive, installed.places(pattern), flat, turning=False)

    def forces(where):
        total = np.zeros_like(START)
        dowels.add_forces(dowels.evaluate(where, installed.alive), total)
        return total

    step, size = 1e-6, np.abs(data).max()
    for row in range(BLOCKS.count):
        for p in range(pattern.row_start[row], pattern.row_start[row + 1]):
            for axis in range(3):
                change = np.zeros_like(START)
                change[pattern.column[p], axis] = step
                expected = -(forces(position + change) - forces(position - change))[row] / (2 * step)
                assert_allclose(data[p][:, axis], expected, atol=1e-6 * size)
    assert np.abs(data - flat).max() > 0.02 * size  # second derivatives are seen


@pytest.mark.parametrize("name", BOLTS)
def test_evaluating_changes_nothing_and_committing_no_force(name):
    installed = installed_bolts([BOLTS[name]], BLOCKS, START)
    position = displaced(7)
    first, again = installed.evaluate(position), installed.evaluate(position)
    assert_allclose(first.tension, again.tension, rtol=0)
    after = installed.commit(first).evaluate(position)
    assert_allclose(after.tension, first.tension, atol=1e-7 * max(first.tension.max(), 1))
    assert_allclose(after.slip, first.slip, atol=1e-12)
    assert_allclose(after.dowels.force, first.dowels.force, atol=1e-6)


@pytest.mark.parametrize("name", BOLTS)
def test_rigid_motion_of_everything_changes_no_tension(name):
    installed = installed_bolts([BOLTS[name]], BLOCKS, START)
    position = displaced(3)
    angle = 0.7
    turn = np.array([(np.cos(angle), -np.sin(angle)), (np.sin(angle), np.cos(angle))])
    centroid = BLOCKS.moments.centroid
    placed = (centroid + position[:, :2]) @ turn.T + (3, -8)
    turned = np.column_stack([placed - centroid, position[:, 2] + angle])
    here, there = installed.evaluate(position), installed.evaluate(turned)
    assert_allclose(there.tension, here.tension, atol=1e-6)
    assert_allclose(there.dowels.force, here.dowels.force, atol=1e-6)
    assert_allclose(there.forces[:, :2], here.forces[:, :2] @ turn.T, atol=1e-6)
    assert_allclose(there.forces[:, 2], here.forces[:, 2], atol=1e-6)


def test_cut_bolt_works_on_in_its_parts():
    """Without the third of five blocks, two parts of two nodes are left; bonds at the cut hold as before."""
    row = bsm.Blocks.from_polygons([rectangle(i, 0, i + 1, 1) for i in range(5)], rock="rock")
    start = np.zeros((5, 3))
    bolt = bsm.Bolt(start=(0, 0.5), end=(5, 0.5), diameter=0.02)
    installed = installed_bolts([bolt], row, start)
    cut = installed.without(np.array([False, False, True, False, False]))
    moved = start + np.outer(np.arange(5.0), [1e-4, 0, 0])
    whole, parts = installed.evaluate(moved), cut.evaluate(moved)
    assert_allclose(parts.tension, whole.tension * [1, 0, 0, 1])
    assert parts.forces[2].tolist() == [0, 0, 0]
    assert_allclose(parts.bond_force, whole.tension[0] * np.array([1, -1, 0, 1, -1]))


def test_held_blocks_are_those_a_bolt_can_still_hold():
    row = bsm.Blocks.from_polygons([rectangle(i, 0, i + 1, 1) for i in range(3)], rock="rock")
    start = np.zeros((3, 3))
    bolt = bsm.Bolt(start=(0, 0.5), end=(3, 0.5), diameter=0.02, bond_strength=1e4)
    installed = installed_bolts([bolt], row, start)

    def held(opening):
        moved = start + np.array([(0, 0, 0), (0, 0, 0), (opening, 0, 0)])
        near, far = holding_pairs(installed, installed.evaluate(moved))
        return np.union1d(near, far)

    assert held(0.0).tolist() == []
    assert held(1e-5).tolist() == [1, 2]
    assert held(1e-2).tolist() == []


def test_bolt_in_one_block_bears_nothing():
    bolts = [bsm.Bolt(start=(0.1, 0.1), end=(0.9, 0.8), diameter=0.02), BOLTS["holding"]]
    installed = installed_bolts(bolts, BLOCKS, START)
    alone = installed_bolts(bolts[1:], BLOCKS, START)
    position = displaced(5)
    assert_allclose(installed.evaluate(position).forces, alone.evaluate(position).forces)


def test_a_bolt_within_one_block_holds_nothing_and_hinders_nothing():
    blocks = [rectangle(-3, -1, 6, 0), rectangle(0, 0, 2, 2)]
    bolt = bsm.Bolt(start=(0.5, 1.9), end=(0.5, 1.0), diameter=0.025)
    stage = bsm.run(model_of(blocks).replace(bolts=[bolt])).stages[-1]
    assert stage.status == "stable"
