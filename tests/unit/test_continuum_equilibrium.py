"""converters.continuum: forces and tangent of joints at points, Newton, and what the continuum refuses."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import scipy.sparse as sp
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.converters import solve_continuum
from bsm_mesh.converters.continuum import solve_continuum_stages
from bsm_mesh.modelfile.build import load_model_file
from bsm_mesh.results.records import ContactStatus
from bsm_mesh.solve.zones.elasticity import nominal_constants
from bsm_mesh.solve.zones.equilibrium import BALANCED
from bsm_mesh.solve.zones.mesh import Discretization
from bsm_mesh.solve.zones.newton import find_equilibrium
from bsm_mesh.solve.zones.stage_run import StageRun
from bsm_mesh.solve.zones.stages import Continuum
from tests.scenes.continuum import HEAVY
from tests.scenes.models import framed, model_of
from tests.scenes.shapes import grid, rectangle, square

LAWS = {
    "mohr_coulomb": bsm.MohrCoulomb(friction=30.0, cohesion=20e3),
    "brittle": bsm.MohrCoulomb(friction=30.0, cohesion=20e3, residual_friction=20.0),
    "patton": bsm.Patton(friction=25.0, dilation=10.0, cohesion=5e3, residual_friction=20.0),
    "dilating": bsm.MohrCoulomb(friction=30.0, cohesion=20e3),
    "stiffening": bsm.MohrCoulomb(friction=30.0, cohesion=20e3),
    "dilating, stiffening": bsm.MohrCoulomb(friction=30.0, cohesion=20e3),
}
TANGENT = 1e-5  # of the greatest entry: central differences


def stack(law, tension=0.0, **fields):
    """Return nine blocks on a fixed base."""
    blocks = framed(bsm.Blocks.from_polygons([rectangle(0, -1, 3, 0), *grid(3, 3)], rock="rock"), 3.0, 3.0)
    joint = bsm.Joint("J", normal_stiffness=2e9, shear_stiffness=1e9, law=law, tensile_strength=tension)
    if law is LAWS["dilating"] or law is LAWS["dilating, stiffening"]:
        joint = replace(joint, dilation_angle=20.0, dilation_slip=2e-5)
    if law is LAWS["stiffening"] or law is LAWS["dilating, stiffening"]:
        joint = replace(joint, shear_stiffness_exponent=0.7, reference_stress=2e4)
    return bsm.Model(
        blocks=blocks, rocks=[HEAVY], joints=[joint], default_joint="J", supports=[bsm.Fixed(blocks=[0])], **fields
    )


def equations(model, order):
    continuum = Continuum(model, Discretization(order=order, joints=True))
    run = StageRun(continuum, np.tile(np.eye(3) * 30e9, (continuum.mesh.mesh.t.shape[1], 1, 1)))
    there = np.ones(model.blocks.count, dtype=bool)
    return continuum, run.equations(there, run.loads_on(there))


@pytest.mark.parametrize("points", ["ends", "gauss"])
@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("name", LAWS)
def test_tangent_is_the_derivative(name, order, points):
    """At a displacement under which points stick, slip and part: central differences of the internal forces."""
    rng = np.random.default_rng(7)
    continuum, eq = equations(stack(LAWS[name], 5e3, contact_points=points), order)
    history = replace(
        eq.history,
        initial_pressure=rng.uniform(0, 5e4, len(eq.joints.length)),
        pressure=rng.uniform(0, 5e4, len(eq.joints.length)),
        shear=rng.uniform(-1e3, 1e3, len(eq.joints.length)),
        failed=rng.random(len(eq.joints.length)) < 0.3,
    )
    eq = replace(eq, history=history)
    u = 2e-5 * rng.standard_normal(continuum.basis.N)
    state = eq.joints.evaluate(u, history)
    assert (~state.closed).any()
    assert (state.closed & state.sticking).any()
    assert (state.closed & ~state.sticking).any()
    K, free = eq.tangents.at(eq.joints.stiffness(state, history, 0.0), rock=0.0), eq.free.free

    def forces(at):
        return eq.joints.forces(at, eq.joints.evaluate(at, history), history)

    for direction in rng.standard_normal((4, len(free))):
        step = np.zeros_like(u)
        step[free] = 1e-11 * direction
        ahead, behind = (forces(u + s)[free] for s in (step, -step))
        assert_allclose((ahead - behind) / 2e-11, K @ direction, atol=TANGENT * np.abs(K @ direction).max())


def test_friction_bounds_shear_and_no_tension_is_carried():
    law = bsm.MohrCoulomb(friction=30.0)
    load = bsm.PointLoad(block=9, point=(2.5, 2.5), force=(8e3, 0.0))
    stage = solve_continuum(stack(law, loads=[load]), order=1, joints=True)
    c = stage.contacts
    assert stage.converged
    assert (c.normal_force <= 0).all()
    assert (np.abs(c.shear_force) <= np.tan(np.radians(30)) * -c.normal_force * (1 + 1e-9)).all()
    assert (c.normal_force == 0).any()
    assert_allclose(stage.total_reaction, [-8e3, 26e3 * 12], rtol=1e-6)


@pytest.mark.parametrize("order", [1, 2])
def test_equilibrium_at_every_free_node(order):
    _, eq = equations(stack(bsm.MohrCoulomb(friction=30.0)), order)
    at, found = find_equilibrium(eq, np.zeros(len(eq.load)))
    assert found
    assert np.abs(at.left).max() <= 2 * BALANCED * at.scale


def test_a_wall_just_before_it_slides():
    """Tilted by 27 degrees it is stable, by 28 its blocks fall: half of the points are open or slip."""
    path = Path(__file__).parents[2] / "examples/tilted_wall/tilt_27.toml"
    stage = solve_continuum(load_model_file(path, lambda _: None).model, order=1, joints=True)
    assert stage.converged
    assert np.abs(stage.displacement[:, :2]).max() < 5e-3
    pressure, shear = -stage.contacts.normal_force, np.abs(stage.contacts.shear_force)
    assert (shear <= np.tan(np.radians(35.0)) * pressure + 1e-6 * pressure.max()).all()
    assert_allclose(stage.total_reaction, -stage.total_load, rtol=1e-6)
    assert (stage.contacts.status != ContactStatus.STICKING).mean() > 0.4


@pytest.mark.heavy
def test_what_slides_for_ever_is_not_converged():
    load = bsm.PointLoad(block=9, point=(2.5, 2.5), force=(30e3, 0.0))  # above the weight's friction of 15 kN
    stage = solve_continuum(stack(bsm.MohrCoulomb(friction=30.0), loads=[load]), order=1, joints=True)
    assert not stage.converged


@pytest.mark.parametrize(("stiffness", "stays"), [(1e9, True), (1e4, False)])
def test_balance_far_away_is_no_equilibrium(stiffness, stays):
    """A block of 26 kN on a joint of so many newtons a metre goes down by metres: small displacements know no end."""
    model = stack(bsm.MohrCoulomb(friction=30.0))
    joints = [replace(joint, normal_stiffness=stiffness, shear_stiffness=stiffness) for joint in model.joints]
    stage = solve_continuum(model.replace(joints=joints), order=1, joints=True)
    assert np.isfinite(stage.displacement).all()
    assert stage.converged == stays


def test_rounding_hides_no_imbalance():
    """Metres away stiff rock may leave more to rounding than is out of balance: that shows no equilibrium."""
    _, eq = equations(stack(bsm.MohrCoulomb(friction=30.0)), 1)
    at, _ = find_equilibrium(eq, np.zeros(len(eq.load)))
    far = replace(at, left=at.left + 1e-3 * at.scale, rounding=0.1 * at.scale)
    assert at.is_balanced
    assert not far.is_balanced


STAGES = (
    bsm.Stage(name="out", excavate=(8, 9)),
    bsm.Stage(name="back", fill=(8, 9)),
    bsm.Stage(name="quake", gravity=(0.2, 0.0)),
    bsm.Stage(name="weak", strength={"J": 0.3}),
)


def test_blocks_put_back_gravity_and_strength_of_stages():
    """As rigid blocks: what is put back lies where it was given, unstressed, and counts its movement from there."""
    model = stack(bsm.MohrCoulomb(friction=35.0), stages=STAGES)
    sides = [bsm.Roller(boundary=side, direction=0) for side in ("left", "right")]
    model = model.replace(supports=[*model.supports, *sides], rocks=[bsm.Rock("rock", unit_weight=26e3)])
    ours, theirs = bsm.run(model).stages, solve_continuum_stages(model, order=1, joints=True)
    assert len(theirs) == len(ours) == 5
    for one, other in zip(ours, theirs, strict=True):
        assert_allclose(other.displacement, one.displacement, rtol=2e-3, atol=2e-8)
        assert_allclose(other.stress[1:], one.stress[1:], atol=100.0)  # the base is held as a whole
    assert np.abs(theirs[3].displacement[8:, 0]).max() > 1e-6


def test_rock_put_back_without_joints_has_no_stress_but_its_own():
    """A column of rock: half of it taken off and put back carries its weight, and nothing of what was before."""
    blocks = framed(bsm.Blocks.from_polygons([rectangle(0, 0, 1, 1), rectangle(0, 1, 1, 2)], rock="rock"), 1.0, 2.0)
    model = bsm.Model(
        blocks=blocks,
        rocks=[bsm.Rock("rock", unit_weight=26e3, young=50e9, poisson=0.0)],
        supports=[bsm.Fixed(boundary="bottom")],
        in_situ=bsm.InSitu(stress={"xx": -1e6, "yy": (-52e3, 0.0, 26e3)}),
        stages=(bsm.Stage(name="out", excavate=(1,)), bsm.Stage(name="back", fill=(1,))),
    )
    _, out, back = solve_continuum_stages(model)
    assert_allclose(out.stress[0, 1, 1], -13e3, rtol=1e-6)
    assert_allclose(back.stress[:, 1, 1], [-39e3, -13e3], rtol=1e-6)
    assert_allclose(back.stress[1, 0, 0], 0.0, atol=1e4)  # the in-situ 1 MPa went with the rock
    assert_allclose(back.displacement[1, 1], -26e3 / 50e9 - 26e3 / 50e9 / 3, rtol=1e-3)


def test_equations_of_one_pattern_are_solved_in_one_order():
    """Later factorizations take the first's ordering; the last, of another pattern, its own."""
    _, eq = equations(stack(bsm.MohrCoulomb(friction=30.0)), 1)
    free, none = eq.free, np.zeros(len(eq.load))
    elastic = eq.joints.elastic_stiffness(eq.history)
    less = elastic._replace(shear=0.3 * elastic.shear, cross=0.1 * elastic.shear)
    same = [eq.tangents.at(stiffness) for stiffness in (elastic, less, elastic, less)]
    for A in (*same, 2 * sp.tril(eq.elastic(eq.at(none, free.none)), format="csc")):
        u, _ = free.solve(A, eq.load, none)
        assert_allclose(A @ u[free.free], eq.load[free.free], atol=1e-9 * np.abs(eq.load).max())


def test_a_start_at_the_blocks_finds_the_equilibrium_near_them():
    """A block glued between two others is pushed off the lower one.

    Glue that held holds, F = 2 K u; glue that broke carries nothing, F = K u. Both are equilibria.
    """
    stiffness, push = 1e9, 1e5
    joint = bsm.Joint("J", stiffness, stiffness, law=bsm.MohrCoulomb(friction=30.0, cohesion=1e6), tensile_strength=8e4)
    loads = [bsm.PointLoad(block=1, point=(0.5, 1.5), force=(0.0, push))]
    model = model_of([square(0, 0), square(0, 1), square(0, 2)], fixed=(0, 2), gamma=0.0, loads=loads)
    model = model.replace(joints=[joint])
    continuum = Continuum(model, Discretization(order=1, joints=True))
    for moved, expected in ((0.0, 0.5), (0.5, 0.5), (1.2, 1.0)):
        position = np.array([(0, 0, 0), (0, moved * push / stiffness, 0), (0, 0, 0)])
        (stage,) = continuum.solve(nominal_constants(continuum.model), near=[position])
        assert stage.converged
        assert_allclose(stage.displacement[1, 1], expected * push / stiffness, rtol=1e-3)


@pytest.mark.parametrize("seed", range(4))
def test_equilibrium_is_found_from_blocks_that_slipped_past_it(seed):
    """By up to a millimetre: friction is the same on the way back, until a block sticks within micrometres."""
    continuum, given = equations(stack(bsm.MohrCoulomb(friction=30.0)), 1)
    rng, dofs, block = np.random.default_rng(seed), continuum.basis.element_dofs, continuum.mesh.block
    slipped = rng.normal(0, 10 ** rng.uniform(-4, -3), continuum.model.blocks.count)
    slipped[0] = 0.0
    u = np.zeros(continuum.basis.N)
    u[dofs[::2]] = slipped[block]
    assert find_equilibrium(given, u)[1]
