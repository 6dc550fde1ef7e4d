"""Water in a tension crack, and from stage to stage; Wang Eqs. 6.1-6.7, slab and dam are cases of the manual."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from tests.scenes.models import LINEAR, model_of
from tests.scenes.shapes import square

EXACT = 1e-12
STATICS = 1e-10
WATER = 9810.0
TOE, CREST, TOP, CRACK = np.array([(0, 0), (6.928, 12), (10.928, 12), (10.928, 7.652)])
ROCK_BELOW = np.array([(0, 0), CRACK, (CRACK[0], -8.0), (0.0, -8.0)])
GAMMA, COHESION, PHI = 26e3, 25e3, 37.0
JOINT = bsm.Joint("J", normal_stiffness=1e10, shear_stiffness=1e9)


def area(corners):
    x, y = np.asarray(corners, dtype=float).T
    return (x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2


def on_rock(block, rock_below, water, unit_weight=GAMMA, **more):
    """Return the linear stage of a block on fixed rock, and the sums of effective normal and shear force between."""
    model = model_of([rock_below, block], gamma=unit_weight, joint=JOINT, water=water, **more)
    results = bsm.run(model, LINEAR)
    assert results.check().ok
    contacts = results.stages[-1].contacts
    return results.stages[-1], -contacts.normal_force.sum(), contacts.shear_force.sum()


@pytest.mark.parametrize("zw", [3.0, 4.348, 0.0])
@pytest.mark.parametrize("cohesion", [COHESION, 0.0])
def test_plane_failure_with_a_tension_crack(zw, cohesion):
    """Hoek and Bray; water triangular in the crack, falling linearly to zero at the toe."""
    block = np.array([TOE, CRACK, TOP, CREST])
    p = np.arctan2(CRACK[1] - TOE[1], CRACK[0] - TOE[0])
    base = np.hypot(*(CRACK - TOE))
    water = bsm.Water(table=[(0, 0), (CRACK[0], CRACK[1] + zw)]) if zw else None
    _, normal, shear = on_rock(block, ROCK_BELOW, water)
    W, V, U = GAMMA * area(block), WATER * zw**2 / 2, WATER * zw * base / 2
    tan_phi = np.tan(np.radians(PHI))
    expected = (cohesion * base + (W * np.cos(p) - U - V * np.sin(p)) * tan_phi) / (W * np.sin(p) + V * np.cos(p))
    assert_allclose((cohesion * base + normal * tan_phi) / abs(shear), expected, rtol=STATICS)


@pytest.mark.heavy
def test_water_falls_from_stage_to_stage():
    model = bsm.Model(
        blocks=bsm.Blocks.from_polygons([square(0, 0)], rock="rock"),
        rocks=[bsm.Rock("rock", unit_weight=26e3)],
        supports=[bsm.Fixed(blocks=[0])],
        water=bsm.Water(table=[(0, 1.0)]),
        stages=[
            bsm.Stage(name="half", water=bsm.Water(table=[(0, 0.5)])),
            bsm.Stage(name="as before"),
            bsm.Stage(name="drained", water=bsm.Water()),
        ],
    )
    for options in (LINEAR, bsm.Options(scheme="continuation")):
        lift = [stage.water[0, 1] for stage in bsm.run(model, options).stages]
        assert_allclose(lift, WATER * np.array([1.0, 0.5, 0.5, 0.0]), rtol=EXACT, atol=1e-9)
