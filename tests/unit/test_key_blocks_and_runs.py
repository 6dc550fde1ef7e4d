"""Key blocks beside proofs and runs of the same rock."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.geometries import Normal, three_d
from bsm_mesh.three_d.blocks.materials import Materials
from bsm_mesh.three_d.limit.rock_mass import analyse_rock
from tests.scenes.rock_3d import alone, tunnel_rock
from tests.unit.test_key_blocks import joint

ROUNDING = 1e-9  # of factors
ROCK = [bsm.Rock("rock", unit_weight=26e3)]


def random_tunnel(seed):
    """Return rock in three random sets round a tunnel of random trend."""
    generator = np.random.default_rng(seed)
    sets = [
        three_d.JointSet(name=f"J{k}", dip=dip, dip_direction=direction, spacing=Normal(2.2, 0.5))
        for k, (dip, direction) in enumerate(
            zip(generator.uniform(15, 90, 3), generator.uniform(0, 360, 3), strict=True)
        )
    ]
    profile = [(-2.5, -2), (2.5, -2), (2.5, 1), (0, 2.5), (-2.5, 1)]
    body = three_d.prism(profile, trend=float(generator.uniform(0, 360)))
    opening = three_d.Opening(body=body, boundary="tunnel")
    rock = three_d.RockMass(box=((-7, -7, -6), (7, 7, 6)), joints=sets, bodies=[opening], seed=seed)
    return bsm.Polyhedra.from_cells(three_d.cut_cells(rock))


@pytest.mark.slow
def test_where_rock_is_proved_to_move_block_theory_names_a_block_that_moves():
    """Limit analysis knows all blocks together; its mechanism begins at a block that block theory finds."""
    proved = 0
    for seed in range(30):
        blocks = random_tunnel(seed)
        joints = [joint(f"J{k}", 20.0) for k in range(3)]
        found = bsm.key_blocks(blocks, rocks=ROCK, joints=joints, free=["tunnel"])
        materials = Materials.checked(blocks, ROCK, joints, None)
        sides = [name for name in blocks.boundaries if name != "tunnel"]
        if len(blocks.boundary_blocks(*sides)) == blocks.count:
            continue
        answer = analyse_rock(blocks, materials, np.ones(blocks.count, dtype=bool), free=["tunnel"])
        if not answer.admissible:
            speed = np.linalg.norm(answer.witness.velocity[:, :3], axis=1)
            assert np.isin(np.flatnonzero(speed > 0.01), found.block[found.unstable]).any()
            proved += answer.witness.proves
    assert proved >= 3


@pytest.mark.slow
def test_blocks_that_a_run_moves_are_named_by_block_theory():
    blocks = bsm.Polyhedra.from_cells(three_d.cut_cells(tunnel_rock(2.5)))
    held = blocks.boundary_blocks(*(name for name in blocks.boundaries if name != "tunnel"))
    joints = [joint(f"J{k}") for k in (1, 2, 3)]
    model = bsm.Model(blocks=blocks, rocks=ROCK, joints=joints, supports=[bsm.Fixed(blocks=tuple(held.tolist()))])
    found, moved = bsm.key_blocks(model, free=["tunnel"]), bsm.run(model).unstable_blocks
    assert moved.size
    assert np.isin(moved, found.block[found.unstable]).all()


@pytest.mark.slow
def test_a_block_that_turns_needs_more_friction_than_block_theory_says():
    """The forces of block theory leave a moment of a third of a metre times its weight: one of 0.6 m across.

    All other blocks are fixed. Against sliding alone its factor is 1.02.
    """
    blocks = bsm.Polyhedra.from_cells(three_d.cut_cells(tunnel_rock(2.0, seed=20)))
    joints = [joint(f"J{k}", 29.2) for k in (1, 2, 3)]
    number = int(np.argmin(np.linalg.norm(blocks.moments.centroid - [3.361, 6.206, 2.489], axis=1)))
    others = tuple(b for b in range(blocks.count) if b != number)
    model = bsm.Model(blocks=blocks, rocks=ROCK, joints=joints, supports=[bsm.Fixed(blocks=others)])
    found, results = bsm.key_blocks(model, free=["tunnel"]), bsm.run(model, bsm.Options(threads=1))
    (row,) = np.flatnonzero(found.block == number)
    assert found.removable[row]
    assert_allclose(found.factor[row], 1.02, atol=5e-3)
    assert results.unstable_blocks.tolist() == [number]
    assert np.linalg.norm(results.stages[0].displacement[number, 3:]) > 0.1  # radians


@pytest.mark.slow
def test_a_block_that_cannot_turn_moves_alone_where_block_theory_says():
    """Its neighbours are fixed, and there is no stress but that of its weight: the premises of block theory."""
    blocks = bsm.Polyhedra.from_cells(three_d.cut_cells(tunnel_rock(3.0, seed=1)))
    model = bsm.Model(blocks=blocks, rocks=ROCK, joints=[joint(f"J{k}", 20.0) for k in (1, 2, 3)])
    found, there = bsm.key_blocks(model, free=["tunnel"]), np.ones(blocks.count, dtype=bool)
    rows = np.flatnonzero(found.removable & ~found.sliver)
    options = bsm.Options(threads=1, falls=bsm.Falls(ignore_below=0))
    moves = [
        bool(len(bsm.run(alone(model, block, there, turns=False), options).unstable_blocks))
        for block in found.block[rows].tolist()
    ]
    assert moves == found.unstable[rows].tolist()
    assert 0 < sum(moves) < len(moves)


@pytest.mark.heavy
def test_a_block_that_falls_behind_another_is_named_in_the_second_round():
    """The roof of a cavern has two layers: the upper cube falls after the lower one."""
    levels = [three_d.JointPlane(name="J", dip=0, dip_direction=0, point=(0, 0, z)) for z in (1.0, 2.0)]
    walls = [
        three_d.JointPlane(name="J", dip=90, dip_direction=direction, point=(x, y, 0))
        for direction, x, y in ((90, 1, 0), (90, 2, 0), (0, 0, 1), (0, 0, 2))
    ]
    rock = three_d.RockMass(box=((0, 0, 0), (3, 3, 3)), joints=[*levels, *walls])
    blocks = bsm.Polyhedra.from_cells(three_d.cut_cells(rock))
    sides = [name for name in blocks.boundaries if name != "bottom"]
    supports = [bsm.Fixed(boundary=name) for name in sides]
    model = bsm.Model(blocks=blocks, rocks=ROCK, joints=[joint("J")], supports=supports)
    options = bsm.Options(threads=1, falls=bsm.Falls(on_fall="remove"))
    fallen = [fall.block for fall in bsm.run(model, options).stages[-1].falls]
    found = bsm.key_blocks(model, free=["bottom"], rounds=9)
    rounds = dict(zip(found.block.tolist(), found.round.tolist(), strict=True))
    assert sorted(rounds[block] for block in fallen) == [1, 2]
