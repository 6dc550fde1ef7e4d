"""The continuum with the model's own joints, by stages: closed forms, and rigid blocks as its limit.

In the rigid limit rock of 1e13 Pa and more takes the place of rigid rock, and interfaces act at the blocks' own contact
points: both methods then solve the same equations, one in three unknowns a block, the other in two a node.
"""

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.converters import solve_continuum
from bsm_mesh.converters.continuum import compare_stages, solve_continuum_stages
from bsm_mesh.converters.continuum.files import write_joints
from bsm_mesh.converters.vtk_files import read_vtu
from bsm_mesh.modelfile.build import load_model_file
from bsm_mesh.solve.zones.elasticity import nominal_constants
from bsm_mesh.solve.zones.mesh import Discretization
from bsm_mesh.solve.zones.stages import Continuum
from tests.scenes.continuum import on_a_slope
from tests.scenes.kirsch import P, Q, cut_by_stages
from tests.scenes.models import LINEAR, model_of
from tests.scenes.shapes import rectangle, square

EXAMPLES = Path(__file__).parents[2] / "examples"
ELASTIC = {"young": 20e9, "poisson": 0.2}
IN_SITU_FORCES, IN_SITU_DISPLACEMENTS = (
    5e-3,
    1e-2,
)  # of the greatest; found 2e-3 and 7e-3 (brittle joints: which point breaks first)
KIRSCH = 1e-2  # of the stress at the wall, 24 blocks along a quarter of it; found 4e-3 with both orders
RIGID = 2e-5  # of a joint's force between three blocks in a column, what rock stiff for rigid leaves; found 8e-6
SAME_FORCES, SAME_DISPLACEMENTS = 5e-4, 2e-3  # found 1e-4 and 1.7e-3 (an arch turns by 1e-4: small displacements)


def pair_forces(contacts, held, count):
    """Return the sum of the contact forces between every pair of blocks, but held ones, as on the second."""
    a, b = contacts.block_a, contacts.block_b
    of_both = {}
    for one, other, force in zip(a, b, contacts.force, strict=True):
        if not (held[one] and held[other]):
            key, sign = (min(one, other), max(one, other)), 1.0 if other > one else -1.0
            of_both[key] = of_both.get(key, 0.0) + sign * force
    return of_both


def distances(blocks, continuum):
    """Return how far displacements and joint forces of a stage lie apart, relative to the blocks' (L2)."""
    held = np.zeros(len(blocks.displacement), dtype=bool)
    held[blocks.supports.block] = True
    ours, theirs = (pair_forces(stage.contacts, held, len(held)) for stage in (blocks, continuum))
    force = np.array([[of.get(key, np.zeros(2)) for key in sorted(ours | theirs)] for of in (ours, theirs)])
    moved = np.array([blocks.displacement[:, :2], continuum.displacement[:, :2]])
    return tuple(np.linalg.norm(x[1] - x[0]) / max(np.linalg.norm(x[0]), 1e-30) for x in (moved, force))


def both(name):
    loaded = load_model_file(EXAMPLES / name, lambda _: None)
    results = bsm.run(loaded.model, loaded.options)
    assert results.status.is_at_rest
    stages = solve_continuum_stages(loaded.model, order=1, joints=True)
    assert all(stage.converged for stage in stages)
    assert [stage.name for stage in stages] == [stage.name for stage in results.stages]
    return zip(results.stages, stages, strict=True)


@pytest.mark.parametrize(
    "name", ["rough_joint/model.toml", "arch/model.toml", "tilted_wall/model.toml", "toppling_column/model.toml"]
)
def test_rigid_limit_from_zero_stress(name):
    for blocks, continuum in both(name):
        displacement, force = distances(blocks, continuum)
        assert displacement < SAME_DISPLACEMENTS
        assert force < SAME_FORCES


@pytest.mark.heavy
@pytest.mark.parametrize("name", ["staged_tunnel/full_face.toml", "staged_tunnel/model.toml"])
def test_rigid_limit_of_a_jointed_tunnel_in_situ(name):
    initial, *others = both(name)
    assert_allclose(initial[1].displacement, 0, atol=1e-9)
    assert distances(*initial)[1] < 1e-6
    for blocks, continuum in others:
        displacement, force = distances(blocks, continuum)
        assert displacement < IN_SITU_DISPLACEMENTS
        assert force < IN_SITU_FORCES
        assert np.linalg.norm(continuum.stress - blocks.stress) < 1e-2 * np.linalg.norm(blocks.stress)


def test_rigid_limit_under_a_falling_water_table():
    for blocks, continuum in both("falling_table/slow.toml"):
        displacement, force = distances(blocks, continuum)
        assert displacement < 5e-3  # the table's bend within a triangle is integrated by points
        assert force < 2e-3


@pytest.mark.heavy
@pytest.mark.parametrize("fields", [{}, ELASTIC], ids=["rigid", "elastic"])
@pytest.mark.parametrize("friction", [20.0, 35.0])
def test_incline(friction, fields):
    """A block slides at the angle of friction, to a hundredth of a degree."""

    def moved(degrees):
        stage = solve_continuum(on_a_slope(degrees, friction, fields), order=1, joints=True)
        return np.hypot(*stage.displacement[1, :2]) if stage.converged else np.inf

    assert moved(friction - 0.01) < 1e-3
    assert moved(friction + 0.01) == np.inf


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("fields", [{}, ELASTIC], ids=["rigid", "elastic"])
def test_submerged_block(fields, order):
    """Archimedes: under water a joint carries the weight less the water's, and rock the total stress of both."""
    water = bsm.Water(table=[(-5, 3.0), (5, 3.0)], unit_weight=10e3)
    stage = solve_continuum(on_a_slope(0.0, 30.0, fields).replace(water=water), order=order, joints=True)
    assert_allclose(stage.contacts.normal_force.sum(), -(26e3 - 10e3) * 0.4, rtol=1e-6)
    assert_allclose(stage.total_reaction, [0, (26e3 - 10e3) * 5.4], rtol=1e-6, atol=1e-3)
    assert_allclose(stage.stress[1, 1, 1], -10e3 * 2.6 - 26e3 * 0.2, rtol=1e-6)


@pytest.mark.parametrize("joint_pressure", [0.0, 3e3])
def test_water_in_a_joint_lifts_a_dry_block(joint_pressure):
    water = bsm.Water(joint_pressure={"J": joint_pressure})
    stage = solve_continuum(on_a_slope(0.0, 30.0, {}).replace(water=water), order=1, joints=True)
    assert_allclose(stage.contacts.normal_force.sum(), joint_pressure - 26e3 * 0.4, rtol=1e-6)
    assert_allclose(stage.contacts.water_pressure, joint_pressure)


@pytest.mark.heavy
def test_cohesion_and_tensile_strength():
    """A block hangs under a ceiling by the tensile strength of its joint, until its weight is more."""
    shapes = [rectangle(-2, 1, 3, 2), rectangle(0, 0, 1, 1)]

    def hung(weight):
        law = bsm.MohrCoulomb(friction=30.0, cohesion=50e3)
        model = bsm.Model(
            blocks=bsm.Blocks.from_polygons(shapes, rock="rock"),
            rocks=[bsm.Rock("rock", unit_weight=weight)],
            joints=[bsm.Joint("J", normal_stiffness=1e9, shear_stiffness=1e9, law=law, tensile_strength=20e3)],
            default_joint="J",
            supports=[bsm.Fixed(blocks=[0])],
        )
        return solve_continuum(model, order=1, joints=True)

    holds = hung(19.9e3)
    assert holds.converged
    assert_allclose(holds.displacement[1, 1], -19.9e3 / 1e9, rtol=1e-3)
    assert not hung(20.1e3).converged


@pytest.mark.parametrize("order", [1, pytest.param(2, marks=pytest.mark.heavy)])
def test_kirsch_by_stages(order):
    """A hole cut into rock under its in-situ stress: Kirsch's stresses near it, the far field where it was."""
    model, exact, at_wall = cut_by_stages(24)
    count = len(exact)
    initial, final = solve_continuum_stages(model, order=order)
    assert_allclose(initial.stress, np.broadcast_to(np.diag([-Q, -P]), initial.stress.shape), atol=1.0)
    assert_allclose(initial.displacement, 0, atol=1e-12)
    assert_allclose(final.stress[count:], 0)
    off = np.linalg.norm((final.stress[:count] - exact)[at_wall]) / np.linalg.norm(exact[at_wall])
    assert off < KIRSCH


def test_pressure_on_new_faces():
    """A hole filled with the pressure that the rock had there: nothing moves, with joints around it and without."""
    blocks = bsm.Blocks.from_polygons(
        [np.array(rectangle(x, y, x + 1, y + 1)) for y in range(3) for x in range(3)], rock="rock"
    ).with_boundary("all", lambda x, y: (x < 1e-9) | (x > 3 - 1e-9) | (y < 1e-9) | (y > 3 - 1e-9))
    model = bsm.Model(
        blocks=blocks,
        rocks=[bsm.Rock("rock", unit_weight=0, **ELASTIC)],
        joints=[bsm.Joint("J", normal_stiffness=1e9, shear_stiffness=1e9, law=bsm.MohrCoulomb(friction=30.0))],
        supports=[bsm.Fixed(boundary="all")],
        in_situ=bsm.InSitu(stress={"xx": -2e6, "yy": -2e6}),
        stages=[bsm.Stage(name="hole", excavate=(4,), pressure=2e6)],
    )
    for joint in (None, "J"):
        _, final = solve_continuum_stages(model.replace(default_joint=joint), joints=True)
        assert_allclose(final.displacement, 0, atol=1e-9)
        _, final = solve_continuum_stages(
            model.replace(default_joint=joint, stages=[bsm.Stage(name="hole", excavate=(4,))]), joints=True
        )
        assert np.abs(final.displacement).max() > 1e-5


@pytest.mark.parametrize("at_first", [True, False])
def test_no_pressure_acts_where_a_block_came_down(at_first):
    """A stage takes the top block of a column away; a chip at its side fell in that stage, or before.

    The pressure acts on the top only, and the bolt through the chip ends in nothing.
    """
    column = [rectangle(0, y, 1, y + 1) for y in range(3)]
    law = bsm.MohrCoulomb(friction=30.0, cohesion=1e6)
    model = bsm.Model(
        blocks=bsm.Blocks.from_polygons([*column, rectangle(1, 1, 1.2, 1.2)], rock="rock"),
        rocks=[bsm.Rock("rock", unit_weight=25e3, **ELASTIC)],
        joints=[bsm.Joint("J", normal_stiffness=1e9, shear_stiffness=1e9, law=law, tensile_strength=1e6)],
        default_joint="J",
        supports=[bsm.Fixed(blocks=[0])],
        bolts=[bsm.Bolt(start=(0.5, 1.1), end=(1.1, 1.1), diameter=0.02, pretension=50e3)],
        stages=[bsm.Stage(name="top", excavate=[2], pressure=40e3)],
    )
    present = np.array([[1, 1, 1, at_first], [1, 1, 0, 0]], dtype=bool)
    initial, stage = Continuum(model, Discretization(order=1, joints=True), present).solve(nominal_constants(model))
    assert stage.converged
    assert_allclose(stage.bolts.axial_force, 0.0)
    assert bool(initial.bolts.axial_force > 1e3) == at_first
    assert_allclose(-stage.contacts.normal_force.sum(), 25e3 + 40e3, rtol=1e-9)
    assert_allclose(stage.contacts.shear_force.sum(), 0.0, atol=1.0)


def test_what_is_not_released_is_held():
    """With rock and joints elastic, half of the relaxation gives half of the displacement; the rest comes later."""
    loaded = load_model_file(EXAMPLES / "staged_tunnel/full_face.toml", lambda _: None)
    (stage,) = loaded.model.stages
    joints = [bsm.Joint(j.name, normal_stiffness=1e9, shear_stiffness=1e9) for j in loaded.model.joints]
    half = bsm.Stage(name="half", excavate=stage.excavate, relaxation=(0.5,))
    model = loaded.model.replace(joints=joints, stages=[half, bsm.Stage(name="rest")])
    initial, some, whole = solve_continuum_stages(model, order=1, joints=True)
    assert_allclose(some.displacement, whole.displacement / 2, atol=1e-6 * np.abs(whole.displacement).max())
    assert np.abs(whole.displacement).max() > 1e-5
    assert_allclose(initial.displacement, 0, atol=1e-9)


@pytest.mark.parametrize("order", [1, 2])
def test_a_joint_that_ends_at_an_excavation(order):
    """Two blocks side by side, their joint up to rock on top: with that gone they are apart to the tip.

    As the same two blocks alone, under what the excavation takes off their tops.
    """
    lower = np.array([(0, 0), (1, 0), (2, 0), (2, 2), (0, 2)])  # a fan of triangles in both models
    shapes = [lower, lower + np.array([2, 0]), rectangle(0, 2, 4, 3)]
    model = bsm.Model(
        blocks=bsm.Blocks.from_polygons(shapes, rock="rock")
        .with_boundary("bottom", lambda x, y: y < 1e-9)
        .with_boundary("top", lambda x, y: y > 3 - 1e-9)
        .with_joint("J", lambda x, y: np.abs(x - 2) < 1e-9),
        rocks=[bsm.Rock("rock", unit_weight=0, **ELASTIC)],
        joints=[bsm.Joint("J", normal_stiffness=1e8, shear_stiffness=1e8)],
        supports=[bsm.Fixed(boundary="bottom")],
        loads=[bsm.InSituTraction(boundary="top")],
        in_situ=bsm.InSitu(stress={"xx": 0.0, "yy": (-3e6, 1e6, 0.0)}),
        stages=[bsm.Stage(name="top", excavate=(2,))],
    )
    _, staged = solve_continuum_stages(model, order=order, joints=True)
    blocks = (
        bsm.Blocks.from_polygons(shapes[:2], rock="rock")
        .with_boundary("bottom", lambda x, y: y < 1e-9)
        .with_boundary("top", lambda x, y: y > 2 - 1e-9)
        .with_joint("J", lambda x, y: np.abs(x - 2) < 1e-9)
    )
    pull = bsm.Pressure(boundary="top", pressure=(-3e6, 1e6, 0.0))
    alone = solve_continuum(
        model.replace(blocks=blocks, in_situ=None, stages=(), loads=[pull]), order=order, joints=True
    )
    assert_allclose(staged.displacement[:2], alone.displacement, atol=1e-9 * np.abs(alone.displacement).max())


def test_same_scheme_same_answer():
    """Without strength limits the linear scheme is the rigid limit of elastic joints."""
    loaded = load_model_file(EXAMPLES / "tilted_wall/model.toml", lambda _: None)
    joints = [bsm.Joint(j.name, normal_stiffness=1e9, shear_stiffness=5e8) for j in loaded.model.joints]
    model = loaded.model.replace(joints=joints)
    ours = bsm.run(model, LINEAR).stages[-1]
    displacement, force = distances(ours, solve_continuum(model, order=1, joints=True))
    assert displacement < SAME_DISPLACEMENTS
    assert force < SAME_FORCES


def test_opening_and_slip_of_both(tmp_path):
    """A block that slides on its joint and lifts off at one side: rigid in both, the same at every point."""
    tipped = bsm.PointLoad(block=1, point=(0.0, 0.3), force=(2.5e3, 0.0))
    model = on_a_slope(0.0, 35.0, {}).replace(loads=[tipped])
    (stage,) = compare_stages(model, bsm.run(model, bsm.Options(tolerance=1e-9)), refine=False)
    compared = stage.comparison
    points = compared.nominal.contacts
    assert np.abs(points.slip).max() > 1e-6
    assert np.ptp(points.opening) > 1e-6
    assert [error.name for error in compared.movement_errors] == ["opening of joints", "slip of joints"]
    assert max(error.l2 for error in compared.movement_errors) < SAME_DISPLACEMENTS
    assert compared.where(compared.movement_errors[0]) == "blocks 0 and 1"
    write_joints(compared, tmp_path / "joints.vtu")
    data = read_vtu(tmp_path / "joints.vtu").cell_data
    for name in ("opening", "slip"):
        assert_allclose(data[f"{name}_fem"], getattr(points, name))
        assert_allclose(data[f"{name}_difference"], data[name] - data[f"{name}_fem"])


@pytest.mark.parametrize("limit", [None, 5e-4])
def test_in_situ_a_joint_that_opened_closes_where_it_opened(limit):
    """A block between two others is pushed off the lower one and let go, or pushed back beyond where it was.

    What opened carries K times its overlap since: its walls fit together no more.
    """
    p0, stiffness = 1e5, 1e9
    loads = [bsm.PointLoad(block=1, point=(0.5, 1.5), force=(0.0, force)) for force in (3 * p0, -3 * p0, -2 * p0)]
    stages = [bsm.Stage(name=name, loads=[load]) for name, load in zip(("push", "let go", "back"), loads, strict=True)]
    model = model_of([square(0, 0), square(0, 1), square(0, 2)], fixed=(0, 2), gamma=0.0)
    joint = bsm.Joint("J", stiffness, stiffness, law=bsm.MohrCoulomb(friction=35.0), max_closure=limit)
    model = model.replace(joints=[joint], in_situ=bsm.InSitu(stress={"yy": -p0}), stages=stages)
    closed = 1 / (stiffness / p0 + (1 / limit if limit else 0.0))  # under p0

    def upper(u):
        overlap = max(closed + u, 0.0)
        return stiffness * overlap / (1 - (overlap / limit if limit else 0.0))

    for found, off in ((solve_continuum_stages(model, joints=True), RIGID), (bsm.run(model).stages, 1e-9)):
        for stage, load in zip(found[-2:], (0.0, 2 * p0), strict=True):
            u = stage.displacement[1, 1]
            assert_allclose(upper(u) + load, stiffness * max(closed - u, 0.0), rtol=off)
