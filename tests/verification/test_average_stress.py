"""Wang Appendix B: the average stress of a block from the forces on it, against exact fields.

A linear stress field in equilibrium with the weight has its value at the centroid as its average over the block, and
its tractions are linear along each edge: two forces an edge carry them exactly (Eq. B.18).
"""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from tests.scenes.models import LINEAR
from tests.scenes.shapes import grid, turned

RTOL = 1e-11  # sums of a dozen products
GAMMA = 26e3
SHAPES = {
    "triangle": [(0, 0), (3, 0.5), (1, 2)],
    "quad": [(0, 0), (2, -0.3), (2.5, 1.4), (-0.2, 1)],
    "l": [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)],
    "seven": [(np.cos(a), 0.6 * np.sin(a)) for a in np.linspace(0, 2 * np.pi, 8)[:-1]],
}


def field(x, y):
    """Return a stress field with div s = (0, gamma): in equilibrium with the weight."""
    xx = -2e6 + 3e5 * x - 1e5 * y
    xy = 4e5 + 2e5 * x - 3e5 * y  # d(xx)/dx + d(xy)/dy = 0
    yy = -5e6 + 1e5 * x + (GAMMA - 2e5) * y  # d(xy)/dx + d(yy)/dy = gamma
    return np.moveaxis(np.array([(xx, xy), (xy, yy)]), (0, 1), (-2, -1))


@pytest.mark.parametrize("degrees", [0.0, 50.0])
@pytest.mark.parametrize("shape", SHAPES)
def test_a_linear_field(shape, degrees):
    outline = turned(np.array(SHAPES[shape]), degrees, (1.5, -0.5))
    blocks = bsm.Blocks.from_polygons([outline], rock="r")
    n = len(outline)
    along = blocks.edge_vectors
    normal = np.stack([along[:, 1], -along[:, 0]], axis=1) / np.hypot(*along.T)[:, None]
    ends = np.stack([blocks.vertices, blocks.vertices[blocks.following]], axis=1)
    traction = np.einsum("eaij,ej->eai", field(ends[..., 0], ends[..., 1]), normal)
    blocks = bsm.Blocks(
        **{k: getattr(blocks, k) for k in ("vertices", "offsets", "nodes", "rock", "rock_names", "edge_joint")},
        boundaries={"outline": np.arange(n)},
    )
    model = bsm.Model(
        blocks=blocks,
        rocks=[bsm.Rock("r", unit_weight=GAMMA)],
        supports=[bsm.Fixed(blocks=[0])],
        loads=[bsm.EdgeTractions(boundary="outline", values=traction)],
    )
    stage = bsm.run(model, LINEAR).stages[-1]
    assert_allclose(stage.reactions, 0, atol=1e-9 * 5e6)  # the field is in equilibrium
    assert_allclose(stage.stress[0], field(*blocks.moments.centroid[0]), rtol=RTOL, atol=RTOL * 5e6)


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
