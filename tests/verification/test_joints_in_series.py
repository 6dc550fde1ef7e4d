"""Closed form: ten joints in series under the weight of ten blocks."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from tests.scenes.models import LINEAR
from tests.scenes.shapes import grid, turned

RTOL = 1e-8  # asked for by the case; the system is statically determinate
N, H, GAMMA, KN = 10, 1.0, 25e3, 1e9


@pytest.mark.parametrize("points", ["ends", "gauss"])
@pytest.mark.parametrize("degrees", [0.0, 37.0])
def test_closures_and_settlement(degrees, points):
    polygons = [turned(p, degrees) for p in grid([0, 1], np.arange(-1.0, N + 1))]
    model = bsm.Model(
        blocks=bsm.Blocks.from_polygons(polygons, rock="rigid"),
        rocks=[bsm.Rock("rigid", unit_weight=GAMMA)],
        joints=[bsm.Joint("J", normal_stiffness=KN, shear_stiffness=KN)],
        default_joint="J",
        supports=[bsm.Fixed(blocks=[0])],
        gravity_direction=degrees - 90.0,
        contact_points=points,
    )
    stage = bsm.run(model, LINEAR).stages[-1]
    joint = np.arange(1, N + 1)
    closure = (N - joint + 1) * H * GAMMA / KN
    below = np.minimum(stage.contacts.block_a, stage.contacts.block_b)  # joint k is above block k - 1
    assert_allclose(-stage.contacts.opening, closure[below], rtol=RTOL)
    assert_allclose(stage.contacts.slip, 0, atol=1e-8 * closure[-1])
    settlement = np.hypot(*stage.displacement[-1, :2])
    assert_allclose(settlement, GAMMA * H * N * (N + 1) / (2 * KN), rtol=RTOL)
    assert_allclose(stage.total_reaction, -stage.total_load, atol=1e-12 * N * GAMMA)
    # the mean vertical stress of a block is the load above its middle
    up = turned(np.array([(0.0, 1.0)]), degrees)[0]
    normal = np.einsum("i,nij,j->n", up, stage.stress, up)[1:]
    assert_allclose(normal, -GAMMA * (N - joint + 0.5) * H, rtol=RTOL)
