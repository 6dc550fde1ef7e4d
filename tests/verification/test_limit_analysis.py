"""Limit analysis: mechanisms, admissible forces, bolts; published limits are cases of the manual (masonry.py)."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.solve.limit.analysis import limit_tilt
from tests.scenes.arch import arch
from tests.scenes.large import sliding_layers
from tests.scenes.models import model_of
from tests.scenes.shapes import rectangle, square

LP = 1e-6  # relative: the linear program is solved to 1e-8 at least, and a few digits


def on_base(polygons, friction, cohesion=0.0, loads=(), base=(-5, -1, 15, 0)):
    law = bsm.MohrCoulomb(friction=friction, cohesion=cohesion)
    return model_of([rectangle(*base), *polygons], law=law, kn=1e10, loads=loads)


def test_mechanism_of_a_thin_arch_has_four_hinges_and_sinks_at_the_crown():
    n = 16
    found = bsm.limit_analysis(arch(n, 0.09))
    assert found.factor == pytest.approx(0, abs=1e-9)
    turn = found.mechanism[:n, 2]
    hinges = np.abs(np.diff(np.concatenate([[0], turn, [0]]))) > 1e-6
    assert 4 <= hinges.sum() <= 5
    work = (found.mechanism[:n, 1] * -1.0).sum()
    assert work > 0


@pytest.mark.heavy
@pytest.mark.parametrize("friction", [10.0, 35.0])
def test_sliding_block_pushed_and_tilted(friction):
    model = on_base([square(0, 0)], friction)
    push = [bsm.PointLoad(block=1, point=(0.0, 0.1), force=(1e3, 0.0))]
    found = bsm.limit_analysis(model, push)
    assert_allclose(found.factor, 25 * np.tan(np.radians(friction)), rtol=LP)
    assert_allclose(found.mechanism[0], 0)
    assert_allclose(found.mechanism[1, 1] / found.mechanism[1, 0], np.tan(np.radians(friction)), rtol=1e-4)
    for clockwise in (False, True):
        assert_allclose(limit_tilt(model, clockwise=clockwise), friction, atol=1e-4)


@pytest.mark.heavy
def test_bolts_of_later_stages_do_not_count():
    """The first stage's bolt, at its yield force, adds its friction and pull to the block's; a later one nothing."""
    friction, force = 20.0, 5e3
    steel = {"start": (0.5, 0.9), "end": (0.5, -0.5), "diameter": 0.02, "yield_strength": force / (np.pi * 0.01**2)}
    model = on_base([square(0, 0)], friction).replace(stages=(bsm.Stage(name="later"),))
    later = model.replace(bolts=(bsm.Bolt(stage="later", **steel),))
    assert_allclose(limit_tilt(later, stage="initial"), friction, atol=1e-4)
    tilt = np.radians(limit_tilt(model.replace(bolts=(bsm.Bolt(**steel),))))
    assert_allclose(np.radians(limit_tilt(later)), tilt, rtol=1e-6)
    weight = 25e3
    assert_allclose(weight * np.sin(tilt), (weight * np.cos(tilt) + force) * np.tan(np.radians(friction)), rtol=1e-5)


def test_forces_returned_are_in_equilibrium_and_within_strength():
    model = arch(20, 0.15, 40.0)
    found = bsm.limit_analysis(model)
    assert found.admissible
    assert found.factor == np.inf
    assert not found.mechanism.any()
    assert (found.normal_force <= 1e-6).all()
    assert (np.abs(found.shear_force) <= -found.normal_force * np.tan(np.radians(40)) + 1e-3).all()
    c = found.contacts
    tangent = c.normal[:, ::-1] * (-1, 1)
    force = found.normal_force[:, None] * c.normal + found.shear_force[:, None] * tangent
    total = model.gravity_forces.copy()
    np.add.at(total, c.block_b, force)
    np.add.at(total, c.block_a, -force)
    assert_allclose(total[:20], 0, atol=1e-5 * model.weights.mean())
    crown = -found.normal_force[(c.block_a == 10) & (c.block_b == 9) | (c.block_a == 9) & (c.block_b == 10)].sum()
    assert 0.08243 <= crown / 25e3 <= 0.10687  # bounds of the crown thrust, t / R = 0.15, N = 20


def test_nothing_to_carry_and_unknown_loads_are_refused():
    weightless = on_base([square(0, 0)], 30).replace(rocks=(bsm.Rock("rock", unit_weight=0),))
    with pytest.raises(bsm.ModelError, match="neither weight nor load"):
        bsm.limit_analysis(weightless)
    with pytest.raises(bsm.ModelError, match="the chosen loads are zero"):
        bsm.limit_analysis(on_base([square(0, 0)], 30), [])


@pytest.mark.parametrize(
    ("strength", "limit"),
    [
        ({"yield_strength": 4e4 / (np.pi * 0.01**2)}, 4e4),
        ({"kind": "end_anchored", "anchor_capacity": 5e4}, 5e4),
        ({"bond_strength": 3e4}, 3e4),  # over the 1 m in the hung block
        ({}, np.inf),
    ],
)
@pytest.mark.parametrize("spacing", [1.0, 2.0])
def test_bolt_that_hangs_a_block(strength, limit, spacing):
    """The factor on the weight of a hung block is the bolt's capacity over that weight."""
    weight = 26e3
    blocks = bsm.Blocks.from_polygons([rectangle(0, 1, 3, 3), rectangle(1, 0, 2, 1)], rock="rock")
    bolt = bsm.Bolt(start=(1.5, 0), end=(1.5, 2.5), diameter=0.02, spacing=spacing, **strength)
    model = model_of(blocks, gamma=weight, law=bsm.Patton(friction=30), bolts=[bolt])
    found = bsm.limit_analysis(model)
    assert found.factor == pytest.approx(limit / spacing / weight, rel=1e-6)
    assert found.admissible == (limit / spacing >= weight)
    if found.admissible and np.isfinite(limit):
        assert_allclose(found.bolt_force, limit, rtol=1e-6)
    assert not bsm.limit_analysis(model.replace(bolts=())).admissible


def test_a_thousand_layers_steeper_than_their_friction_must_move():
    """The simplex method cycled for a minute there, and gave up."""
    limit = bsm.limit_analysis(sliding_layers(1000).model())
    assert not limit.admissible
    assert limit.factor < 1


def test_blocks_that_share_no_face_are_held_by_nothing():
    found = bsm.limit_analysis(on_base([square(0, 3), square(2, 3)], 30))
    assert not found.admissible
    assert found.contacts.count == found.factor == 0
    assert_allclose(found.mechanism[1:], np.tile((0, -1, 0), (2, 1)), atol=1e-9)


def test_a_bolt_within_one_block_bears_nothing():
    bolt = bsm.Bolt(start=(0.5, 0.9), end=(0.5, 0.1), diameter=0.02, bond_strength=2e4)
    model = on_base([square(0, 0)], 30.0).replace(bolts=(bolt,))
    found = bsm.limit_analysis(model, [bsm.PointLoad(block=1, point=(0.0, 0.1), force=(1e3, 0.0))])
    assert_allclose(found.factor, 25 * np.tan(np.radians(30.0)), rtol=LP)
