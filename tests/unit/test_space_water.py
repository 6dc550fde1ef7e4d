"""Water on polyhedra: buoyancy of cut and turned blocks, uplift in joints, what a model file says of it."""

import json

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.certificate.certificate import certificate, certificate_arrays
from bsm_mesh.certificate.verify_certificate import check_stage
from bsm_mesh.geometries import three_d
from bsm_mesh.model.water import WATER
from bsm_mesh.three_d.loads.water import WaterOnPolyhedra
from tests.scenes.polyhedra import box, model_in_space, on_incline, rotation, turned
from tests.scenes.rock_3d import planes
from tests.scenes.small_case import Case
from tests.unit.test_space_run import SLOPE

OPTIONS = bsm.Options(threads=1)


def rock(water):
    low, high = (0, 0, 0), (4, 4, 3)
    blocks = bsm.Polyhedra.from_cells(
        three_d.cut_cells(three_d.RockMass(box=(low, high), joints=planes(low, high, 1.2, 3)))
    )
    joints = [bsm.Joint(name, normal_stiffness=1e9, shear_stiffness=1e9) for name in blocks.joint_names]
    return bsm.Model(
        blocks=blocks,
        rocks=[bsm.Rock("rock", unit_weight=26e3)],
        joints=joints,
        supports=[bsm.Fixed(boundary="bottom")],
        water=water,
    )


def test_water_lifts_every_block_by_its_volume():
    """Under an inclined plane along the gradient, with no moment; turned blocks too."""
    model = rock(bsm.Water(plane=bsm.HeadPlane(point=(0, 0, 30), dip=10, dip_direction=60)))
    up = np.array([np.tan(np.radians(10)) * np.sin(np.pi / 3), np.tan(np.radians(10)) * np.cos(np.pi / 3), 1])
    volume = model.blocks.moments.volume
    position = np.zeros((model.blocks.count, 6))
    for turn in ((0, 0, 0), (0.4, -1.1, 0.7)):
        position[:, 3:] = turn
        found, dyad = WaterOnPolyhedra(model.blocks, model.water).on_blocks(position)
        assert_allclose(found[:, :3], WATER * volume[:, None] * up, rtol=1e-9, atol=1e-6)
        assert_allclose(found[:, 3:], 0, atol=1e-6)
        assert np.linalg.eigvalsh(dyad).max() < 0  # pressed from all sides


@pytest.mark.parametrize("depth", [0.2, 0.5, 0.9])
def test_half_in_water_a_block_is_lifted_by_what_is_wet(depth):
    """And where the wet part has its centroid: a plane that is inclined has a wedge of it."""
    model = model_in_space([box((0, 0, 0), (1, 1, 1))])
    plane = bsm.HeadPlane(point=(0.5, 0.5, depth))
    found, _ = WaterOnPolyhedra(model.blocks, bsm.Water(plane=plane)).on_blocks(np.zeros((1, 6)))
    assert_allclose(found, [[0, 0, WATER * depth, 0, 0, 0]], atol=1e-9)
    tilted = bsm.HeadPlane(point=(0, 0, 1), dip=45, dip_direction=90)  # through two edges: half of the cube is wet
    found, _ = WaterOnPolyhedra(model.blocks, bsm.Water(plane=tilted)).on_blocks(np.zeros((1, 6)))
    assert found[0, 2] == pytest.approx(WATER / 2)
    assert found[0, 4] == pytest.approx(WATER / 2 * (1 / 2 - 1 / 3) - WATER / 2 * (1 / 3 - 1 / 2) * -1)


@pytest.mark.heavy
@pytest.mark.parametrize("beyond", [0, 2])
@pytest.mark.parametrize(("share", "status"), [(0.99, "stable"), (1.01, "unstable")])
def test_a_pressure_in_the_joint_lets_a_block_slide(share, status, beyond):
    """At 20 degrees: W sin = (W cos - p A) tan phi; on ground of the block's size, and of more."""
    dip, friction = np.radians(20), np.radians(30)
    limit = 26e3 * (np.cos(dip) - np.sin(dip) / np.tan(friction))
    solids = [box((-beyond, -beyond, -1), (1 + beyond, 1 + beyond, 0)), box((0, 0, 0), (1, 1, 1))]
    water = bsm.Water(joint_pressure={"J1": share * limit})
    model = model_in_space(turned(solids, rotation(0.0, 20)), water=water)
    results = bsm.run(model, OPTIONS)
    assert results.status == status
    stage = results.stages[-1]
    assert stage.joint_water.tolist() == [share * limit]
    if status == "stable":
        lifted = stage.loads[1, :3] - (0, 0, -26e3)
        assert np.linalg.norm(lifted) == pytest.approx(share * limit)
        assert results.check().ok


def test_contacts_bear_the_weight_under_water():
    model = model_in_space([box((0, 0, -1), (1, 1, 0)), box((0, 0, 0), (1, 1, 1))])
    stage = bsm.run(model.replace(water=bsm.Water(plane=bsm.HeadPlane(point=(0, 0, 3)))), OPTIONS).stages[-1]
    assert_allclose(stage.contacts.normal_force.sum(), -(26e3 - WATER), rtol=1e-9)
    assert_allclose(stage.water[:, 2], WATER, rtol=1e-12)
    mean = -WATER * (2.5 - stage.displacement[1, 2])  # it settles a little
    assert_allclose(stage.stress[1, 0, 0], mean, rtol=1e-9)
    assert_allclose(stage.stress[1] - stage.stress_effective[1], mean * np.eye(3), atol=1e-3)


@pytest.mark.heavy
def test_a_model_file_has_water_and_stages_change_it(case: Case) -> None:
    text = (
        SLOPE
        + """water = {plane = {point = [0, 0, "2.5 m"]}}

[water]
joint_pressure = {J1 = "2 kPa"}
"""
    )
    case.write("slope.toml", text)
    told = json.loads(case.run("run", "slope.toml", "--json", "-o", "out").out)
    assert told["stages"][0]["joint_water"] == {"J1": 2000}
    assert told["stages"][1]["total_water"] == pytest.approx([0, 0, 10 * WATER], abs=1e-6)
    assert case.run("verify", "out").code == 0
    assert bsm.load(case.folder / "out/model.toml") == bsm.load(case.folder / "slope.toml")
    case.write("slope.toml", text.replace("J1 =", "J2 ="))
    case.refuses("run", "slope.toml", says=["water: joint_pressure: there is no joint 'J2'; did you mean 'J1'?"])


@pytest.mark.heavy
def test_the_certificate_follows_the_water() -> None:
    """Rock cut at random, half in the water of an inclined plane, one joint under a pressure of its own."""
    water = bsm.Water(plane=bsm.HeadPlane(point=(2, 2, 1.4), dip=12, dip_direction=200), joint_pressure={"J2": 5e3})
    model = rock(water).replace(stages=[bsm.Stage(name="less", excavate=[3, 20])])
    results = bsm.run(model, OPTIONS)
    told = certificate(results)
    for stage, said in zip(results.stages, told["stages"], strict=True):
        arrays = {key: np.array(values) for key, values in certificate_arrays(results, stage).items()}
        assert np.abs(stage.water).max() > 1e3
        assert check_stage(told, said, arrays)[1] == []
        for name, change in (("water_plane", (0.01, 0, 0, 0)), ("water_face_pressure", 50.0)):
            changed = {key: np.array(values) for key, values in arrays.items()}
            changed[name] = changed[name] + change
            assert "the water presses on block" in "; ".join(check_stage(told, said, changed)[1])


@pytest.mark.parametrize("dip", [0, 12, 45])
def test_the_check_follows_a_plane_of_water_through_corners(dip: float) -> None:
    """Corners of the fixed block lie in the plane: neither wet nor dry."""
    plane = bsm.HeadPlane(point=(0, 0, 0), dip=dip, dip_direction=90)
    model = model_in_space([box((0, 0, -1), (1, 1, 0)), box((0, 0, 0), (1, 1, 1))], water=bsm.Water(plane=plane))
    results = bsm.run(model, OPTIONS)
    wet = 1 - np.tan(np.radians(dip)) / 2  # volume of the fixed block below the plane
    assert_allclose(results.stages[0].water[0, 2], WATER * wet, rtol=1e-9)
    told = certificate(results)
    arrays = {key: np.array(values) for key, values in certificate_arrays(results, results.stages[0]).items()}
    assert check_stage(told, told["stages"][0], arrays)[1] == []


def test_planes_of_head_are_for_polyhedra_and_tables_for_the_plane():
    water = bsm.Water(plane=bsm.HeadPlane(point=(0, 0, 1)))
    blocks = bsm.Blocks.from_polygons([[(0, 0), (1, 0), (1, 1), (0, 1)]], rock="r")
    with pytest.raises(bsm.ModelError, match="plane is for polyhedra; in the plane give table"):
        bsm.Model(blocks=blocks, rocks=[bsm.Rock("r", unit_weight=26e3)], water=water)
    with pytest.raises(bsm.ModelError, match="water: table is for the plane; give plane"):
        on_incline(0).replace(water=bsm.Water(table=[(0, 1)]))
    with pytest.raises(bsm.ModelError, match="must be three numbers"):
        bsm.HeadPlane(point=(0, 1))


@pytest.mark.parametrize("side", [2, 0.5])
@pytest.mark.parametrize("top", [0.0, 0.3])
def test_water_of_a_joint_presses_on_parts_of_faces_too(side, top):
    """A cube on a table, of 4 x 4 m or of its own size, carries its weight less the uplift: the joint's alone there.

    Its lower part is in water that has nothing to press on from below.
    """
    table = box((-side, -side, -1), (side, side, 0))
    plane = bsm.HeadPlane(point=(0, 0, top))
    water = bsm.Water(plane=plane, joint_pressure={"J1": 10e3})
    model = model_in_space([table, box((-0.5, -0.5, 0), (0.5, 0.5, 1))], fixed=[0], water=water)
    results = bsm.run(model, OPTIONS)
    assert_allclose(results.stages[0].displacement[1, 2], -(26e3 - 10e3) / 1e9, rtol=1e-4)
    drained = model.replace(water=bsm.Water(plane=plane, joint_pressure={"J1": 0.0}))
    assert_allclose(bsm.run(drained, OPTIONS).stages[0].displacement[1, 2], -26e3 / 1e9, rtol=1e-4)
    assert results.check().ok


def test_on_a_part_of_a_face_water_presses_as_on_a_face_of_its_own():
    """An inclined plane of head through it; the smaller face is shared with a block of its size instead."""
    water = bsm.Water(plane=bsm.HeadPlane(point=(0.1, 0, 0.1), dip=35, dip_direction=70), joint_pressure={"J1": 4e3})
    position, found = np.zeros((2, 6)), []
    position[1] = (0.01, -0.02, 0.03, 0.1, -0.2, 0.05)
    for side in (3, 0.5):
        cube = box((-0.5, -0.5, 0), (0.5, 0.5, 1))
        model = model_in_space([box((-side, -side, -2), (side, side, 0)), cube], water=water)
        found.append(WaterOnPolyhedra(model.blocks, water, "J1").on_blocks(position))
    assert_allclose(found[0][0][1], found[1][0][1], rtol=1e-9, atol=1e-6)
    assert_allclose(found[0][1][1], found[1][1][1], rtol=1e-9, atol=1e-6)
    assert np.abs(found[0][0][1, 3:]).max() > 100


def test_water_on_parts_of_faces_is_in_the_certificate_and_in_stages():
    """A wall of shifted courses; blocks of the first course are taken away, and numbers change."""
    bricks = [box((k - 0.3 * row, 0, row), (k + 1 - 0.3 * row, 1, row + 1)) for row in range(3) for k in range(3)]
    water = bsm.Water(plane=bsm.HeadPlane(point=(0, 0, 0.8), dip=5, dip_direction=90), joint_pressure={"J1": 3e3})
    model = model_in_space(bricks, fixed=[0, 1, 2], water=water, stages=[bsm.Stage(name="less", excavate=[0])])
    results = bsm.run(model, OPTIONS)
    told = certificate(results)
    for stage, said in zip(results.stages, told["stages"], strict=True):
        arrays = {key: np.array(values) for key, values in certificate_arrays(results, stage).items()}
        assert check_stage(told, said, arrays)[1] == []
        assert len(arrays["water_part_block"]) == (10 if stage is results.stages[0] else 8)
        for name, change in (("water_part_pressure", 50.0), ("water_part_corner", 0.01)):
            changed = {key: np.array(values) for key, values in arrays.items()}
            changed[name] = changed[name] + change
            assert "the water presses on block" in "; ".join(check_stage(told, said, changed)[1])


def test_in_situ_stress_on_parts_of_faces_is_effective():
    """A column under its own weight, on ground wider than it: nothing moves when the water in its joint is there."""
    column = [box((-2, -2, -1), (2, 2, 0)), box((-0.5, -0.5, 0), (0.5, 0.5, 1))]
    water, field = bsm.Water(joint_pressure={"J1": 10e3}), bsm.InSitu(surface=1.0, k0=0.0)
    stage = bsm.run(model_in_space(column, water=water, in_situ=field), OPTIONS).stages[0]
    assert_allclose(stage.displacement[1], 0, atol=1e-12)
    assert_allclose(stage.contacts.normal_force.sum(), -(26e3 - 10e3), rtol=1e-9)


def test_edges_over_edges_have_no_area_for_water():
    """A cube that stands on an edge, and one beside its table."""
    cube = np.array(box((-0.5, -0.5, -0.5), (0.5, 0.5, 0.5))[0])
    c = np.sqrt(0.5)
    turned = cube @ np.array([[1, 0, 0], [0, c, -c], [0, c, c]]).T + (0, 0, c)
    faces = box((0, 0, 0), (1, 1, 1))[1]
    water = bsm.Water(joint_pressure={"J1": 10e3})
    model = model_in_space([box((-2, -2, -1), (2, 2, 0)), (turned, faces)], fixed=[0], water=water)
    found, _ = WaterOnPolyhedra(model.blocks, water, "J1").on_blocks(np.zeros((2, 6)))
    assert_allclose(found, 0)
