"""Key blocks with the gravity, the water and the loads of their model, against limit equilibrium."""

import itertools

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.three_d.key_blocks.loads import RockLoads
from tests.scenes.polyhedra import box, model_in_space
from tests.scenes.rock_3d import WEDGES, wedge_factor, wedge_rock
from tests.unit.test_key_blocks import ROCK, ROUNDING, joint, roof


def pushed_by_water(blocks, wedge, level):
    """Return the thrust on a wedge of water that presses below a level, by small triangles of its faces [N]."""
    thrust, parts = np.zeros(3), 200
    u, v = (np.indices((parts, parts)) + 1 / 3) / parts
    points = np.stack([u[u + v < 1], v[u + v < 1]], axis=1)
    points = np.concatenate([points, points[points.sum(axis=1) < 1 - 1 / parts] + 1 / (3 * parts)])
    for face in np.flatnonzero((blocks.face_blocks == wedge).any(axis=1)):
        corners = blocks.vertices[blocks.face_vertices[blocks.face_offsets[face] : blocks.face_offsets[face + 1]]]
        outward = 1.0 if blocks.face_blocks[face, 0] == wedge else -1.0
        for b, c in itertools.pairwise(corners[1:] - corners[0]):
            area = outward * np.cross(b, c) / 2
            heads = np.maximum(level - (corners[0] + points @ np.array([b, c]))[:, 2], 0.0)
            thrust -= 9810 * heads.mean() * area
    return thrust


@pytest.mark.parametrize("name", ["Hoek and Bray", "symmetric", "to the north"])
def test_a_wedge_has_the_gravity_the_water_and_the_loads_of_its_model(name):
    """The factor is that of Hoek & Bray with the earthquake, the thrust of water and the load as one force."""
    first, second, face, top, height, friction, cohesion, unit_weight = WEDGES[name]
    blocks, wedge, volume, areas = wedge_rock(first, second, face, top, height)
    joints = [joint(n, f, c) for n, f, c in zip("AB", friction, cohesion, strict=True)]
    level, way = 0.3 * height, np.radians(face[1])
    point = tuple(blocks.moments.centroid[wedge])
    model = bsm.Model(
        blocks=blocks,
        rocks=[bsm.Rock("rock", unit_weight=unit_weight)],
        joints=joints,
        gravity_horizontal=0.1,
        gravity_vertical=-0.05,
        gravity_trend=face[1],
        water=bsm.Water(plane=bsm.HeadPlane(point=(0, 0, level))),
        loads=[bsm.PointLoad(block=int(wedge), point=point, force=(0, 0, -0.05 * volume * unit_weight))],
    )
    found = bsm.key_blocks(model, free=["slope"])
    row = np.flatnonzero(found.block == wedge)[0]
    force = volume * unit_weight * np.array([0.1 * np.sin(way), 0.1 * np.cos(way), -0.05 - 0.05])
    force = force + pushed_by_water(blocks, wedge, level)
    factor = wedge_factor(first, second, volume, areas, unit_weight, friction, cohesion, force)
    assert_allclose(found.factor[row], factor, rtol=1e-5)
    assert_allclose(found.weight[row], volume * unit_weight, rtol=ROUNDING)
    dry = bsm.key_blocks(model.replace(water=None, loads=()), free=["slope"], gravity=(0, 0, -1))
    assert_allclose(
        dry.factor[row], wedge_factor(first, second, volume, areas, unit_weight, friction, cohesion), rtol=ROUNDING
    )


def test_water_in_a_joint_presses_where_both_blocks_are_there():
    """Of three cubes on each other the middle one is pressed from both sides, and a gone one leaves its neighbours."""
    cubes = [box((0, 0, z), (1, 1, z + 1)) for z in (0, 1, 2)]
    model = model_in_space(cubes).replace(water=bsm.Water(joint_pressure={"J1": 20e3}))
    dry = RockLoads(model.replace(water=None))
    for loads in (RockLoads(model), RockLoads(model.replace(water=None), joint_pressure={"J1": 20e3})):
        for present, lifts in (([1, 1, 1], (-20e3, 0, 20e3)), ([1, 1, 0], (-20e3, 20e3, 0)), ([1, 0, 1], (0, 0, 0))):
            there = np.array(present, dtype=bool)
            pressed = loads.on_blocks(there) - dry.on_blocks(there)
            assert_allclose(pressed[:, 2], lifts, atol=1e-6)


def test_a_pressure_in_the_joints_of_a_roof_adds_to_its_support():
    """Water presses the pyramid down on its foot from four sides; it is given by the model or by name."""
    blocks = roof()
    model = bsm.Model(blocks=blocks, rocks=ROCK, joints=[joint("J1")])
    given = {"excavated": ["cavern"], "free": ["south", "north"]}
    ours = bsm.key_blocks(model.replace(water=bsm.Water(joint_pressure={"J1": 20e3})), **given)
    by_name = bsm.key_blocks(model, **given, joint_pressure={"J1": 20e3})
    assert_allclose(ours.support, by_name.support)
    falls = ours.modes.index("falls")
    assert_allclose(ours.support[falls] - bsm.key_blocks(model, **given).support[falls], 20e3, rtol=1e-6)
