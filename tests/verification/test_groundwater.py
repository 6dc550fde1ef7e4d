"""Water in a tension crack, and from stage to stage; Wang Eqs. 6.1-6.7, slab and dam are cases of the manual."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from tests.scenes.models import LINEAR
from tests.scenes.plane_failure import hoek_and_bray
from tests.scenes.shapes import square
from verification.slopes import statics_of

EXACT = 1e-12
STATICS = 1e-10
WATER = 9810.0


@pytest.mark.parametrize("zw", [3.0, 4.348, 0.0])
@pytest.mark.parametrize("cohesion", [25e3, 0.0])
def test_plane_failure_with_a_tension_crack(zw, cohesion):
    """Hoek and Bray; water triangular in the crack, falling linearly to zero at the toe."""
    case = hoek_and_bray(zw=zw, cohesion=cohesion)
    assert_allclose(statics_of(case), case.factor, rtol=STATICS)


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
