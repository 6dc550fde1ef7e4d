"""Limit analysis of models of polyhedra: bolts, supports, loads and strength by statics; the command."""

import json
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.converters.vtk_files import read_vtu
from bsm_mesh.solve.limit_analysis import limit_analysis, limit_tilt, strength_limit
from bsm_mesh.three_d.limit.points import LimitPoints
from bsm_mesh.three_d.limit.program import ConeProgram
from bsm_mesh.three_d.limit.strength import ConeStrength
from bsm_mesh.three_d.limit.ties import Ties
from tests.scenes.polyhedra import box, model_in_space, on_incline, prism, rotation, turned
from tests.scenes.rock_3d import rotations_held
from tests.scenes.small_case import Case

EXACT = 1e-5  # of a factor: the search for that of strength ends there
CEILING, CUBE = box((-1, -1, 1), (2, 2, 2)), box((0, 0, 0), (1, 1, 1))
AREA = np.pi * 0.02**2 / 4
WEIGHT = 26e3  # N of a cube
PULL = 60e3  # N: yield force of a bolt
SHARED = [box((0, 0, 1), (1, 1, 2)), CUBE]  # a ceiling with the face of the cube


def bolt(x, y, **keys):
    """Return a bolt from the cube's foot into the ceiling."""
    given = {"kind": "end_anchored", "diameter": 0.02, "yield_strength": PULL / AREA, **keys}
    return bsm.Bolt(start=(x, y, 0.1), end=(x, y, 1.9), **given)


@pytest.mark.parametrize(
    ("keys", "bears"),
    [
        ({}, PULL),
        ({"anchor_capacity": 40e3}, 40e3),
        ({"kind": "grouted", "bond_strength": 30e3}, 27e3),
        ({"kind": "grouted", "bond_strength": 30e3, "plate": 50e3}, 27e3),
        ({"kind": "grouted", "bond_strength": 200e3}, PULL),
    ],
)
def test_a_cube_hangs_on_a_bolt_by_the_least_of_yield_anchorage_and_bond(keys, bears):
    """Bond acts over 0.9 m in the cube, where a plate helps, and over 0.9 m in the ceiling, where none does."""
    model = model_in_space(SHARED, friction=30, bolts=[bolt(0.5, 0.5, **keys)])
    found = limit_analysis(model)
    assert found.admissible == (bears > WEIGHT)
    assert_allclose(found.factor, bears / WEIGHT, rtol=EXACT)
    assert_allclose(found.bolt_force.max(), bears, rtol=EXACT)
    assert_allclose(found.mechanism[1] / np.abs(found.mechanism[1]).max(), [0, 0, -1, 0, 0, 0], atol=1e-6)


def test_a_bolt_off_the_centre_lets_a_cube_turn():
    """The cube turns about the edge at x = 0, against the ceiling: 0.2 m PULL = 0.5 m W factor."""
    found = limit_analysis(model_in_space(SHARED, friction=30, bolts=[bolt(0.2, 0.5)]))
    assert_allclose(found.factor, 0.2 * PULL / (0.5 * WEIGHT), rtol=EXACT)
    both = limit_analysis(model_in_space(SHARED, friction=30, bolts=[bolt(0.2, 0.5), bolt(0.8, 0.5)]))
    assert_allclose(both.factor, 2 * PULL / WEIGHT, rtol=EXACT)


def test_a_dowel_adds_its_shear_to_friction():
    """A cube pushed in any direction over its base: friction of its weight and the dowel's strength."""
    solids = [box((0, 0, -1), (1, 1, 0)), CUBE]
    steel = bsm.Bolt(
        start=(0.5, 0.5, 0.9), end=(0.5, 0.5, -0.9), diameter=0.02, bearing_stiffness=1e9, yield_strength=4e8
    )
    steel = replace(steel, bearing_strength=50e6)
    push = bsm.PointLoad(block=1, point=(0.5, 0.5, 0.0), force=(3e3, 4e3, 0.0))
    model = model_in_space(solids, friction=30, bolts=[steel])
    found = limit_analysis(model, [push])
    assert found.admissible
    tension = steel.yield_force * np.tan(np.radians(30))  # the bolt presses the cube on its base at its yield
    exact = WEIGHT * np.tan(np.radians(30)) + tension + steel.dowel_strength
    assert_allclose(found.factor * 5e3, exact, rtol=1e-3)


@pytest.mark.parametrize("azimuth", [0, 25])
def test_a_bolted_block_on_an_incline(azimuth):
    """A bolt across the plane presses the block on: tan(phi) (W cos a + T) = F W sin a at its yield."""
    dip, pull = 40, 10e3
    head, tip = (rotation(azimuth, dip) @ np.array(p) for p in ((0.5, 0.5, 0.9), (0.5, 0.5, -0.9)))
    steel = bsm.Bolt(start=tuple(head), end=tuple(tip), kind="end_anchored", diameter=0.02, yield_strength=pull / AREA)
    model = on_incline(dip, azimuth, friction=35, bolts=[steel])
    a = np.radians(dip)
    exact = np.tan(np.radians(35)) * (WEIGHT * np.cos(a) + pull) / (WEIGHT * np.sin(a))
    found = strength_limit(model)
    assert_allclose(found.factor, exact, rtol=1e-4)
    assert found.factor < found.beyond < found.factor * 1.0011
    part = strength_limit(model, bolts=True)
    assert part.factor < found.factor
    assert strength_limit(model, ["J1"]).factor == pytest.approx(found.factor)
    with pytest.raises(bsm.ModelError, match="there is no joint 'J9'"):
        strength_limit(model, ["J9"])


def test_supports_that_hold_a_part_bear_what_they_can():
    """A cube on rollers across x leans on them; without them it slides."""
    blocks = bsm.Polyhedra.from_solids(
        [(c @ rotation(0, 40).T, f) for c, f in (box((0, 0, -1), (1, 1, 0)), CUBE)], rock="granite", joint="J1"
    )
    open_faces = np.flatnonzero((blocks.face_blocks == [1, -1]).all(axis=1))
    across = [f for f in open_faces if abs(_normal(blocks, f) @ rotation(0, 40)[:, 0]) > 0.99]
    model = on_incline(40, friction=30).replace(blocks=replace(blocks, boundaries={"side": np.array(across)}))
    assert not limit_analysis(model).admissible
    held = model.replace(supports=[*model.supports, bsm.NormalRoller(boundary="side")])
    assert limit_analysis(held).admissible


def _normal(blocks, face):
    corners = blocks.vertices[blocks.face_vertices[blocks.face_offsets[face] : blocks.face_offsets[face + 1]]]
    normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
    return normal / np.linalg.norm(normal)


@pytest.mark.parametrize("azimuth", [0.0, 37.0])
@pytest.mark.parametrize(("trend", "steepest"), [(270.0, 20.0 + 25.0), (90.0, 25.0)])
def test_an_edge_bears_by_the_normals_of_both_faces(trend, steepest, azimuth):
    """A block that cannot turn stands with an edge on the edge of another, a wedge of air of 20 degrees between them.

    Pushed towards the wedge it slides along its own face, else along the top of the other block.
    """
    upper = [(0, 0), (0, 1), (-1, 1), (-1, np.tan(np.radians(20.0)))]
    solids = turned([prism([(-1, -1), (0, -1), (0, 0), (-1, 0)]), prism(upper)], rotation(azimuth, 0))
    model = model_in_space(solids, friction=25)
    model = model.replace(supports=[*model.supports, rotations_held(model.blocks, [1])])
    for part, stands in ((0.99, True), (1.01, False)):
        push = part * np.tan(np.radians(steepest))
        assert (
            limit_analysis(model.replace(gravity_horizontal=push, gravity_trend=trend - azimuth)).admissible == stands
        )


@pytest.mark.parametrize(("lifted", "stands"), [(0.0, True), (2.0, False)])
def test_where_edges_cross_a_block_rests(lifted, stands):
    """Two wedges, one upside down across the other: neither has a face that separates them."""
    lower, upper = prism([(-1, -1), (1, -1), (0, 0)]), prism([(0, 0), (1, 1), (-1, 1)])
    across = rotation(90, 0) @ [0, 0.5, 0]
    solids = [lower, *[(corners - across + [0, 0.5, 0], faces) for corners, faces in turned([upper], rotation(90, 0))]]
    model = model_in_space(solids, friction=25, gravity_vertical=lifted)
    model = model.replace(supports=[*model.supports, rotations_held(model.blocks, [1])])
    assert limit_analysis(model).admissible == stands


def test_a_cube_on_a_part_of_a_table_slides_at_the_friction():
    table = box((-2, -2, -1), (2, 2, 0))
    model = model_in_space([table, CUBE], friction=30, gravity_horizontal=0.3)
    assert_allclose(strength_limit(model).factor, np.tan(np.radians(30)) / 0.3, rtol=1e-4)


def test_a_support_that_holds_a_rotation_bears_the_moment():
    """A cube beside a smooth wall hangs on a bar 0.2 m off its centroid: the bar bears W, the other one 0.2 m W."""
    blocks = bsm.Polyhedra.from_solids([box((-1, 0, 0), (0, 1, 1)), CUBE], rock="granite", joint="J1")
    points = LimitPoints.of(blocks.contact_polygons)
    aside = np.array([[0.5, 0.7, 0.5]])
    bars = Ties(
        block=np.array([1, 1]),
        column=np.array([0, 1]),
        point=np.repeat(aside, 2, axis=0),
        direction=np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]),
        turns=np.array([False, True]),
        bars=2,
        first_node=np.zeros(0, np.int32),
        yield_force=np.zeros(0),
        capacity=np.zeros(0),
        dowel=np.zeros(0),
    )
    program = ConeProgram(blocks.moments, points, np.array([True, False]), bars)
    smooth = ConeStrength.coulomb(points.area, friction=0.0)
    loads = np.array([np.zeros(6), [0, 0, -WEIGHT, 0, 0, 0]])
    found = program.balance(loads, smooth)
    assert found.value < 1e-6
    assert_allclose(found.ties, [WEIGHT, -0.2 * WEIGHT], rtol=1e-5)  # the bar's force turns the cube about +x
    turning = np.array([np.zeros(6), [0, 0, 0, 3.0, 0, 0]])
    assert_allclose(program.tie_rates(turning), [-3.0 * 0.2, -3.0])  # of the point up, and the turn


def test_the_strength_of_chosen_joints_alone_is_reduced():
    """Two cubes on another, the upper one pushed by H: it slides at tan(35) W = F H, both at tan(30) 2 W = F H."""
    push = bsm.PointLoad(block=2, point=(0.5, 0.5, 1.0), force=(0.5 * WEIGHT, 0, 0))
    model = model_in_space([box((0, 0, -1), (1, 1, 0)), CUBE, box((0, 0, 1), (1, 1, 2))], loads=[push])
    polygons, joint = model.blocks.contact_polygons, model.blocks.face_joint.copy()
    joint[polygons.face[(polygons.block_a == 2) | (polygons.block_b == 2)]] = 1
    upper = replace(model.joints[0], name="J2", law=bsm.MohrCoulomb(friction=35))
    blocks = replace(model.blocks, face_joint=joint, joint_names=("J1", "J2"))
    model = model.replace(blocks=blocks, joints=[*model.joints, upper])
    lower, one = 4 * np.tan(np.radians(30)), 2 * np.tan(np.radians(35))
    assert_allclose(strength_limit(model, ["J1"]).factor, lower, rtol=1e-4)
    assert_allclose(strength_limit(model, ["J2"]).factor, one, rtol=1e-4)
    assert_allclose(strength_limit(model).factor, one, rtol=1e-4)


def test_stages_and_bolts_of_later_ones():
    """The cube's pillar is excavated; the bolt that a later stage installs is not there."""
    solids = [box((0, 0, 1), (1, 1, 2)), CUBE, box((0, 0, -1), (1, 1, 0))]
    digs, bolts = bsm.Stage(name="dug", excavate=[2]), bsm.Stage(name="bolted")
    for stages, at_rest in (([bolts, digs], True), ([digs, bolts], False)):
        later = [bolt(0.5, 0.5, stage="bolted")]
        model = model_in_space(solids, fixed=(0, 2), bolts=later, stages=stages)
        assert limit_analysis(model, stage="initial").admissible
        assert limit_analysis(model, stage="dug").admissible == at_rest
        assert limit_analysis(model).admissible


@pytest.mark.parametrize(
    ("keys", "bears"), [({"kind": "grouted", "bond_strength": 30e3, "plate": 50e3}, 27e3), ({}, 0.0)]
)
def test_excavation_cuts_a_bolt(keys, bears):
    """A bolt begins in the cube's pillar. Bond in 0.9 m of ceiling is left of it, and nothing without its anchorage."""
    solids = [box((0, 0, 1), (1, 1, 2)), CUBE, box((0, 0, -1), (1, 1, 0))]
    long = replace(bolt(0.5, 0.5, **keys), start=(0.5, 0.5, -0.5))
    model = model_in_space(solids, fixed=(0, 2), bolts=[long], stages=[bsm.Stage(name="dug", excavate=[2])])
    found = limit_analysis(model)
    assert found.admissible == (bears > WEIGHT)
    assert_allclose(found.factor, bears / WEIGHT, rtol=EXACT, atol=EXACT)
    assert_allclose(found.bolt_force.max(initial=0.0), bears, rtol=EXACT)


@pytest.mark.heavy
def test_a_fall_with_bolts_is_proved():
    stage = bsm.run(model_in_space(SHARED, bolts=[bolt(0.5, 0.5, yield_strength=20e3 / AREA)])).stages[-1]
    assert stage.status == "unstable"
    assert "inadmissible: no forces within strength balance the loads" in stage.proof.text


def test_the_tilt_is_for_the_plane():
    with pytest.raises(bsm.ModelError, match="tilt"):
        limit_tilt(on_incline(10))


@pytest.mark.heavy
def test_the_command(case: Case) -> None:
    case.run("new", "roof", "roof")
    outcome = case.run("limit", "roof/model.toml")
    assert outcome.code == 0
    said = " ".join(outcome.out.split())
    assert "admissible: forces within strength exist" in said
    told = json.loads(case.run("limit", "roof/model.toml", "--stage", "cavern", "--strength", "--bolts", "--json").out)
    assert told["admissible"]
    assert told["factor"] > 1
    grid = read_vtu(case.folder / "roof/out/model/limit.vtu")
    assert np.abs(grid.point_data["velocity"]).max() > 0.5
    case.refuses("limit", "roof/model.toml", "--tilt", "left", says=["--tilt is for the plane"])


def test_the_strength_of_rock_faces_is_divided_where_it_is_asked_for() -> None:
    """A cube grown together with its base by cohesion alone, and pushed: c A / H."""
    solids = [box((0, 0, -1), (1, 1, 0)), CUBE]
    rock = bsm.Rock("granite", unit_weight=26e3, young=10e9, poisson=0.2, cohesion=50e3, friction=0.0)
    push = bsm.PointLoad(block=1, point=(0.5, 0.5, 0.0), force=(6e3, 8e3, 0.0))
    blocks = bsm.Polyhedra.from_solids(solids, rock="granite")
    model = bsm.Model(blocks=blocks, rocks=[rock], supports=[bsm.Fixed(blocks=[0])], loads=[push])
    assert_allclose(strength_limit(model).factor, 5, rtol=1e-4)
    assert strength_limit(model, rocks=False).factor == np.inf


@pytest.mark.parametrize("cohesion", [0.0, 1e3, 10e3])
def test_joints_without_friction(cohesion: float) -> None:
    """A cube on a plane at 10 degrees: factor c A / (W sin dip)."""
    model = on_incline(10, friction=0.0, cohesion=cohesion)
    exact = cohesion / (WEIGHT * np.sin(np.radians(10)))
    found = limit_analysis(model)
    assert found.admissible == (exact > 1)
    assert_allclose(found.factor, exact, rtol=EXACT, atol=1e-9)
    assert_allclose(strength_limit(model).factor, exact, rtol=EXACT)
    assert 0 < strength_limit(model).beyond <= max(exact, 1e-3) * (1 + 1e-3)


def test_a_block_that_nothing_touches_is_inadmissible() -> None:
    model = model_in_space([*SHARED, box((0, 0, -3), (1, 1, -2))], fixed=(0, 1))
    found = limit_analysis(model)
    assert not found.admissible
    assert "this geometry must move" in found.text
    assert found.mechanism[2, 2] < 0
    assert not found.mechanism[:2].any()
    assert strength_limit(model).factor == 0


def test_a_cube_hangs_on_a_bolt_across_a_gap() -> None:
    """Nothing but the bolt holds it: without strength enough there are no forces at all."""
    model = model_in_space([box((0, 0, 1.05), (1, 1, 2)), CUBE], bolts=[bolt(0.5, 0.5)])
    assert_allclose(limit_analysis(model).factor, PULL / WEIGHT, rtol=EXACT)
    assert_allclose(strength_limit(model, bolts=True).factor, PULL / WEIGHT, rtol=EXACT)
    assert strength_limit(model).factor == np.inf
