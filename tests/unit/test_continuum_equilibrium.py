"""converters.continuum: forces and tangent of joints at points, Newton, and what the continuum refuses."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.converters import solve_continuum
from bsm_mesh.converters.continuum.equilibrium import BALANCED, find_equilibrium
from bsm_mesh.converters.continuum.stages import Continuum, _Run
from tests.scenes.continuum import HEAVY
from tests.scenes.models import framed
from tests.scenes.shapes import grid, rectangle

LAWS = {
    "mohr_coulomb": bsm.MohrCoulomb(friction=30.0, cohesion=20e3),
    "brittle": bsm.MohrCoulomb(friction=30.0, cohesion=20e3, residual_friction=20.0),
    "patton": bsm.Patton(friction=25.0, dilation=10.0, cohesion=5e3, residual_friction=20.0),
}
TANGENT = 1e-5  # of the greatest entry: central differences


def stack(law, tension=0.0, **fields):
    """Return nine blocks on a fixed base."""
    blocks = framed(bsm.Blocks.from_polygons([rectangle(0, -1, 3, 0), *grid(3, 3)], rock="rock"), 3.0, 3.0)
    joint = bsm.Joint("J", normal_stiffness=2e9, shear_stiffness=1e9, law=law, tensile_strength=tension)
    return bsm.Model(
        blocks=blocks, rocks=[HEAVY], joints=[joint], default_joint="J", supports=[bsm.Fixed(blocks=[0])], **fields
    )


def equations(model, order):
    continuum = Continuum(model, order, True)
    run = _Run(continuum, np.tile(np.eye(3) * 30e9, (continuum.mesh.mesh.t.shape[1], 1, 1)))
    return continuum, run.equations(np.ones(model.blocks.count, dtype=bool))


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
        failed=rng.random(len(eq.joints.length)) < 0.3,
    )
    eq = replace(eq, history=history)
    u = 2e-5 * rng.standard_normal(continuum.basis.N)
    state = eq.joints.evaluate(u, history)
    assert (~state.closed).any()
    assert (state.closed & state.sticking).any()
    assert (state.closed & ~state.sticking).any()
    K = eq.joints.tangent(state, history, 0.0)
    for direction in rng.standard_normal((4, len(u))):
        step = 1e-11 * direction
        ahead, behind = (eq.joints.forces(eq.joints.evaluate(u + s, history), history) for s in (step, -step))
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


def test_what_slides_for_ever_is_not_converged_or_far():
    load = bsm.PointLoad(block=9, point=(2.5, 2.5), force=(30e3, 0.0))  # above the weight's friction of 15 kN
    stage = solve_continuum(stack(bsm.MohrCoulomb(friction=30.0), loads=[load]), order=1, joints=True)
    assert not stage.converged or np.abs(stage.displacement).max() > 1.0


class TestRefusals:
    def test_bolts(self):
        bolt = bsm.Bolt(
            start=(0.5, 2.5), end=(0.5, 0.5), kind="end_anchored", diameter=0.02, young=200e9, yield_strength=500e6
        )
        with pytest.raises(bsm.ModelError, match="has no bolts, and the model has 1; compare a model without"):
            solve_continuum(stack(LAWS["patton"], bolts=[bolt]), joints=True)

    def test_fill(self):
        stages = [bsm.Stage(name="out", excavate=(9,)), bsm.Stage(name="back", fill=(9,))]
        with pytest.raises(bsm.ModelError, match="cannot put blocks back, as the model does in stage 'back'"):
            solve_continuum(stack(LAWS["patton"], stages=stages), joints=True)
