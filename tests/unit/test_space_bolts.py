"""Bolts in space: where they run, their forces and tangent, and what holds a block by hand."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.geometries import three_d
from bsm_mesh.model.bolt_layout import lay_out_bolts, pass_blocks
from bsm_mesh.movements import cross, turned
from bsm_mesh.solve.algebra.block_matrix import whole_pattern
from bsm_mesh.solve.bolts.installed import InstalledBolts
from bsm_mesh.three_d.bolts.kernels import add_bolts, bolt_arrays
from bsm_mesh.three_d.contacts.rotations import moved_by, swings
from tests.scenes.shapes import rectangle

STEEL = {"diameter": 0.025, "yield_strength": 500e6}
DOWEL = {"bearing_stiffness": 1e9, "bearing_strength": 50e6}
JOINT = bsm.Joint("J", normal_stiffness=1e9, shear_stiffness=1e9, law=bsm.MohrCoulomb(friction=30))


def beam(pieces=3):
    """Return a bar of cubes of 1 m along x from the origin."""
    joints = [
        three_d.JointPlane(name="J", dip=90, dip_direction=90, point=(x, 0, 0)) for x in np.arange(1, pieces, 1.0)
    ]
    blocks = bsm.Polyhedra.from_cells(
        three_d.cut_cells(three_d.RockMass(box=((0, 0, 0), (pieces, 1, 1)), joints=joints))
    )
    assert blocks.count == pieces
    return blocks


def model_of(bolts, blocks=None, **given):
    """Return a model of a bar with bolts, its last block held."""
    blocks = beam() if blocks is None else blocks
    held = int(np.argmax(blocks.moments.centroid[:, 0]))
    given = {"supports": [bsm.Fixed(blocks=[held])], **given}
    return bsm.Model(blocks=blocks, rocks=[bsm.Rock("rock", unit_weight=26e3)], joints=[JOINT], bolts=bolts, **given)


def test_nodes_lie_in_the_blocks_that_a_bolt_passes():
    blocks = beam()
    order = np.argsort(blocks.moments.centroid[:, 0])
    bolt = bsm.Bolt(start=(0, 0.2, 0.5), end=(2.5, 0.7, 0.5), **STEEL, **DOWEL)
    layout = lay_out_bolts([bolt], blocks)
    assert layout.block.tolist() == order.tolist()
    part = bolt.length / 2.5  # of the bolt's length over x
    assert_allclose(layout.station, [0, 1.5 * part, bolt.length])
    assert_allclose(layout.point[1], [1.5, 0.5, 0.5])
    assert_allclose(layout.crossing, np.array([1, 2]) * part)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"start": (-0.5, 0.5, 0.5), "end": (2, 0.5, 0.5)}, "has its start in the void, 0.5 m before the rock"),
        ({"start": (0.5, 0.5, 0.5), "end": (4, 0.5, 0.5)}, "has its end in the void, 1 m beyond the rock"),
        ({"start": (0.5, 5, 0.5), "end": (2, 5, 0.5)}, "passes no block"),
        ({"start": (1, 0.2, 0.2), "end": (1, 0.7, 0.7)}, "runs along a face of block .* over 0.707 m"),
        ({"start": (0.5, 0.5), "end": (2, 0.5)}, "start and end need x, y and z in space"),
        ({"start": (0.5, 0.5, 0.5), "end": (2, 0.5, 0.5), "spacing": 2}, "spacing is for the plane"),
        ({"start": (0.5, 0.5, 0.5), "end": (2, 0.5, 0.5), "stage": "none"}, "there is no stage 'none'"),
    ],
)
def test_a_bolt_that_does_not_fit_is_refused(given, said):
    with pytest.raises(bsm.ModelError, match=said):
        model_of([bsm.Bolt(**given, **STEEL)])


def test_coordinates_are_those_of_the_blocks():
    with pytest.raises(bsm.ModelError, match="start has 3 coordinates and end 2"):
        bsm.Bolt(start=(0, 0, 0), end=(1, 1), **STEEL)
    with pytest.raises(bsm.ModelError, match="two numbers"):
        bsm.Bolt(start=(0, 0, 0, 0), end=(1, 1, 1, 1), **STEEL)
    flat = bsm.Blocks.from_polygons([rectangle(0, 0, 1, 1)], rock="rock")
    with pytest.raises(bsm.ModelError, match="x and y only in the plane"):
        pass_blocks([bsm.Bolt(start=(0, 0, 0), end=(1, 1, 1), **STEEL)], flat)


def test_a_bolt_through_cells_of_one_block_has_one_piece():
    """A block of two cells: the face between them is no joint."""
    cut = three_d.cut_cells(
        three_d.RockMass(
            box=((0, 0, 0), (2, 1, 1)), joints=[three_d.JointPlane(name="J", dip=90, dip_direction=90, point=(1, 0, 0))]
        )
    )
    cells = bsm.Polyhedra.from_cells(cut)
    whole = bsm.Polyhedra(
        **{n: getattr(cells, n) for n in ("vertices", "face_vertices", "face_offsets", "face_cells")},
        face_joint=np.full(len(cells.face_joint), -1, np.int32),
        cell_block=np.zeros(2, np.int32),
        rock=np.zeros(1, np.int32),
        rock_names=("rock",),
    )
    passed = pass_blocks([bsm.Bolt(start=(0.2, 0.5, 0.5), end=(1.9, 0.5, 0.6), **STEEL)], whole)
    assert passed.block.tolist() == [0]
    assert_allclose(passed.last - passed.first, np.hypot(1.7, 0.1))


@pytest.mark.parametrize(("height", "above"), [(0.1, True), (-0.1, False)])
def test_a_bolt_beside_a_joint_passes_one_block(height, above):
    """It runs along the dip of a joint of 45 degrees that halves a cube, beside it."""
    joint = three_d.JointPlane(name="J", dip=45, dip_direction=90, point=(0.5, 0.5, 0.5))
    blocks = bsm.Polyhedra.from_cells(three_d.cut_cells(three_d.RockMass(box=((0, 0, 0), (1, 1, 1)), joints=[joint])))
    bolt = bsm.Bolt(start=(0.2, 0.5, 0.8 + height), end=(0.7, 0.5, 0.3 + height), **STEEL)
    passed = pass_blocks([bolt], blocks)
    assert passed.block.tolist() == [
        int(np.argmax(blocks.moments.centroid[:, 2])) if above else int(np.argmin(blocks.moments.centroid[:, 2]))
    ]


BOLTS = {
    "end-anchored": {"kind": "end_anchored", "pretension": 50e3},
    "rigid bond": {"pretension": 20e3},
    "elastic bond": {"bond_stiffness": 1e8, "bond_strength": 60e3, "plate": 80e3},
    "dowel": DOWEL,
    "dowel at its strength": {"bearing_stiffness": 1e9, "bearing_strength": 1e6},
}


@pytest.fixture(params=BOLTS)
def installed(request):
    """Return bolts through three cubes, their position and centroids: apart, turned as a whole, and each a little."""
    ends = ((0.1, 0.3, 0.4), (2.8, 0.6, 0.7)), ((0.2, 0.7, 0.2), (1.9, 0.4, 0.6))
    model = model_of([bsm.Bolt(start=a, end=b, **STEEL, **BOLTS[request.param]) for a, b in ends])
    centroid, turn = model.blocks.moments.centroid, np.full((3, 3), 0.2)
    out = centroid - centroid.mean(axis=0)
    position = np.hstack([turned(1.001 * out, turn) - out, turn])
    position = moved_by(position, 2e-3 * np.random.default_rng(3).normal(size=(3, 6)))
    return InstalledBolts.of(model, np.zeros((3, 6))), position, centroid


def test_forces_of_bolts_balance_themselves(installed):
    bolts, position, centroid = installed
    at = bolts.evaluate(position)
    assert np.abs(at.forces).max() > 1e3
    assert_allclose(at.forces[:, :3].sum(axis=0), 0, atol=1e-9 * np.abs(at.forces).max())
    moments = at.forces[:, 3:] + cross(centroid + position[:, :3], at.forces[:, :3])
    assert_allclose(moments.sum(axis=0), 0, atol=1e-9 * np.abs(at.forces).max())
    on = bolts.on_blocks(at)
    total = np.zeros((3, 3))
    np.add.at(total, on.block, on.force)
    assert_allclose(total, at.forces[:, :3], atol=1e-9 * np.abs(at.forces).max())


def test_the_tangent_is_the_derivative_of_the_forces(installed):
    """About instant axes the derivative of moments has a skew part as well, which no energy has."""
    bolts, position, _ = installed
    pattern = whole_pattern(3, *bolts.pairs)
    data = np.zeros((len(pattern.column), 6, 6))
    bolts.add_tangent(bolts.evaluate(position), bolts.places(pattern), data)
    rows = np.repeat(np.arange(3), np.diff(pattern.row_start))
    tangent = np.zeros((3, 6, 3, 6))
    for row, column, block in zip(rows, pattern.column, data, strict=True):
        tangent[row, :, column] += block
    tangent = tangent.reshape(18, 18)
    assert_allclose(tangent, tangent.T, atol=1e-9 * np.abs(tangent).max())
    numeric, step = np.zeros((18, 18)), 1e-7
    for k in range(18):
        move = np.zeros(18)
        move[k] = step
        ends = [bolts.evaluate(moved_by(position, sign * move.reshape(3, 6))).forces for sign in (1, -1)]
        numeric[:, k] = -(ends[0] - ends[1]).reshape(-1) / (2 * step)
    assert_allclose(tangent, (numeric + numeric.T) / 2, atol=1e-6 * np.abs(tangent).max())


@pytest.mark.heavy
def test_cycles_of_motion_have_the_same_forces(installed):
    bolts, position, _ = installed
    forces = np.zeros((3, 6))
    add_bolts(position[:, :3].copy(), swings(position[:, 3:]), *bolt_arrays(bolts), forces)
    assert_allclose(forces, bolts.evaluate(position).forces, atol=1e-8 * np.abs(forces).max())


def test_what_yields_stays_and_what_is_installed_later_has_no_force(installed):
    bolts, position, _ = installed
    again = bolts.commit(bolts.evaluate(position))
    at, before = again.evaluate(position), bolts.evaluate(position)
    assert_allclose(at.tension, before.tension, rtol=1e-9, atol=1e-3)
    assert_allclose(at.dowels.force, before.dowels.force, rtol=1e-9)
    fresh = replace(bolts, layout=replace(bolts.layout, pretension=np.zeros(2))).install(0, position)
    assert_allclose(fresh.evaluate(position).forces, 0, atol=1e-3)


def hung(bolts, **given):
    """Return a cube of 1 m under a fixed one of 2 m, the joint at z = 0, and the cube's number."""
    joints = [three_d.JointPlane(name="J", dip=0, dip_direction=0, point=(0, 0, 0))]
    rock = three_d.RockMass(box=((0, 0, -1), (1, 1, 2)), joints=joints)
    blocks = bsm.Polyhedra.from_cells(three_d.cut_cells(rock))
    model = model_of(bolts, blocks, supports=[bsm.Fixed(boundary="top")], **given)
    return model, int(np.argmin(blocks.moments.centroid[:, 2]))


def test_a_suspended_block_lengthens_its_bolt():
    """P L / (E A): 26 kN on 2.5 m of a bar of 25 mm."""
    bolt = bsm.Bolt(start=(0.5, 0.5, -1), end=(0.5, 0.5, 1.5), kind="end_anchored", **STEEL)
    model, cube = hung([bolt])
    stage = bsm.run(model, bsm.Options(threads=1)).stages[-1]
    assert stage.status == "stable"
    assert_allclose(stage.bolts.axial_force, 26e3)
    assert_allclose(-stage.displacement[cube, 2], 26e3 * 2.5 / (200e9 * np.pi * 0.025**2 / 4), rtol=1e-9)


def test_three_bolts_share_the_weight_by_statics():
    """Heads at x, y: their forces have the resultant 26 kN at the centroid."""
    heads = np.array([(0.3, 0.3), (0.7, 0.3), (0.5, 0.75)])
    bolts = [bsm.Bolt(start=(x, y, -1), end=(x, y, 1.5), kind="end_anchored", **STEEL) for x, y in heads]
    stage = bsm.run(hung(bolts)[0], bsm.Options(threads=1)).stages[-1]
    exact = np.linalg.solve(np.vstack([heads.T, np.ones(3)]), 26e3 * np.array([0.5, 0.5, 1]))
    assert_allclose(stage.bolts.axial_force, exact, rtol=1e-3)  # the cube has turned by 2e-4


@pytest.mark.heavy
@pytest.mark.parametrize(("part", "status"), [(1.002, "stable"), (0.998, "unstable")])
def test_bond_in_the_block_holds_its_weight_or_not(part, status):
    bolt = bsm.Bolt(start=(0.5, 0.5, -1), end=(0.5, 0.5, 1.5), bond_strength=part * 26e3, **STEEL)
    stage = bsm.run(hung([bolt])[0], bsm.Options(threads=1)).stages[-1]
    assert str(stage.status) == status


@pytest.mark.parametrize("part", [1.002, 0.998])
def test_dowels_carry_a_block_beside_a_smooth_joint(part):
    """Half the weight each; ``W / (2 K)`` of shear, ``d^2 sqrt(p s_y / 3)`` at most: then the bars hang as ropes."""
    pressure = 3 * (part * 13e3 / STEEL["diameter"] ** 2) ** 2 / STEEL["yield_strength"]
    ends = [((0.1, y, 0.5), (1.9, y, 0.5)) for y in (0.3, 0.7)]
    bolts = [bsm.Bolt(start=a, end=b, **STEEL, bearing_stiffness=1e9, bearing_strength=pressure) for a, b in ends]
    smooth = bsm.Joint("J", normal_stiffness=1e9, shear_stiffness=1e9, law=bsm.MohrCoulomb(friction=0))
    model = model_of(bolts, beam(2)).replace(joints=[smooth])
    stage = bsm.run(model, bsm.Options(threads=1)).stages[-1]
    shear = stage.bolts.shear_force * stage.bolts.shear_direction[:, 2]  # on the cube, which has the heads
    cube = int(np.argmin(model.blocks.moments.centroid[:, 0]))
    drop = -stage.displacement[cube, 2] + 0.5 * stage.displacement[cube, 4]
    elastic = 13e3 / bolts[0].dowel_stiffness
    assert_allclose(shear, min(part, 1) * 13e3, rtol=2e-4)
    if part > 1:
        assert_allclose(drop, elastic, rtol=1e-3)
    else:
        assert drop > 2 * elastic


def test_a_bolt_of_a_stage_takes_what_comes_after_it():
    """A cube on a pillar is bolted, and the pillar excavated: no force before, the weight after."""
    joints = [three_d.JointPlane(name="J", dip=0, dip_direction=0, point=(0, 0, z)) for z in (-1, 0)]
    rock = three_d.RockMass(box=((0, 0, -2), (1, 1, 2)), joints=joints)
    blocks = bsm.Polyhedra.from_cells(three_d.cut_cells(rock))
    pillar = int(np.argmin(blocks.moments.centroid[:, 2]))
    bolt = bsm.Bolt(start=(0.5, 0.5, -1), end=(0.5, 0.5, 1.5), kind="end_anchored", stage="bolted", **STEEL, name="B1")
    stages = [bsm.Stage(name="bolted"), bsm.Stage(name="pillar", excavate=[pillar])]
    held = [bsm.Fixed(boundary="top"), bsm.Fixed(boundary="bottom")]
    results = bsm.run(model_of([bolt], blocks, supports=held, stages=stages), bsm.Options(threads=1))
    assert [str(stage.status) for stage in results.stages] == ["stable"] * 3
    assert_allclose([stage.bolts.axial_force[0] for stage in results.stages], [0, 0, 26e3], atol=1e-3)
    assert results.check().faults == ()
