"""Wang Appendix B: the average stress of a block from the forces on it; linear fields are in the manual."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from tests.scenes.models import LINEAR
from tests.scenes.shapes import grid

RTOL = 1e-11  # sums of a dozen products
GAMMA = 26e3


@pytest.mark.parametrize("points", ["ends", "gauss"])
@pytest.mark.parametrize("choice", ["wang", "homogeneous"])
def test_weight_between_rollers(choice, points):
    """K0 = 0 for squares without a Poisson effect: s_yy = -gamma depth in every block, the rest zero."""
    rows = 8
    blocks = bsm.Blocks.from_polygons(grid(5, rows), rock="r")
    blocks = blocks.with_boundary("bottom", lambda x, y: y < 1e-9)
    blocks = blocks.with_boundary("sides", lambda x, y: (x < 1e-9) | (x > 5 - 1e-9))
    model = bsm.Model(
        blocks=blocks,
        rocks=[bsm.Rock("r", unit_weight=GAMMA, young=1e9, poisson=0.25, stiffness=choice)],
        supports=[bsm.NormalRoller(boundary="bottom"), bsm.NormalRoller(boundary="sides")],
        contact_points=points,
    )
    stage = bsm.run(model, LINEAR).stages[-1]
    depth = rows - blocks.moments.centroid[:, 1]
    assert_allclose(stage.stress[:, 1, 1], -GAMMA * depth, rtol=1e-9)
    assert_allclose(stage.stress[:, 0], 0, atol=1e-9 * GAMMA)
    assert_allclose(stage.stress[:, 0, 1], stage.stress[:, 1, 0])


def test_loads_and_supports_count_as_contacts_do():
    """A block squeezed between a load and a roller carries the load over its width."""
    blocks = bsm.Blocks.from_polygons([np.array([(0, 0), (2, 0), (2, 3), (0, 3)], dtype=float)], rock="r")
    blocks = blocks.with_boundary("bottom", lambda x, y: y < 1e-9).with_boundary("top", lambda x, y: y > 3 - 1e-9)
    model = bsm.Model(
        blocks=blocks,
        rocks=[bsm.Rock("r", unit_weight=0)],
        supports=[bsm.Fixed(boundary="bottom")],
        loads=[bsm.Pressure(boundary="top", pressure=7e5)],
    )
    stage = bsm.run(model, LINEAR).stages[-1]
    assert_allclose(stage.stress[0], [(0, 0), (0, -7e5)], rtol=RTOL, atol=1e-6)
    assert_allclose(stage.supports.reaction.sum(axis=0), (0, 2 * 7e5), rtol=RTOL, atol=1e-6)
