"""Closed form: 3DEC's sliding block, elastic answer of two corner springs (linear scheme)."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from tests.scenes.models import LINEAR
from tests.scenes.shapes import rectangle, turned

RTOL = 1e-8  # asked for by the case; the system is statically determinate
GAMMA = 2000.0 * 10.0
KN = KS = 10e6
B = 10.0


def block_on_plane(angle, height, *, turn_geometry, wide, base_first=True):
    """Return the stage, and the contact's quantities at the toe and at the heel."""
    base = rectangle(-20, -10, 30, 0) if wide else rectangle(0, -10, B, 0)
    polygons = [base, rectangle(0, 0, B, height)]
    if not base_first:
        polygons.reverse()
    polygons = [turned(p, angle * turn_geometry) for p in polygons]
    model = bsm.Model(
        blocks=bsm.Blocks.from_polygons(polygons, rock=["base", "block"] if base_first else ["block", "base"]),
        rocks=[bsm.Rock("base", unit_weight=0), bsm.Rock("block", unit_weight=GAMMA)],
        joints=[bsm.Joint("J", normal_stiffness=KN, shear_stiffness=KS)],
        default_joint="J",
        supports=[bsm.Fixed(blocks=[0 if base_first else 1])],
        gravity_direction=-90.0 if turn_geometry else -90.0 - angle,
    )
    stage = bsm.run(model, LINEAR).stages[-1]
    down_the_plane = turned(np.array([(-1.0, 0.0)]), angle * turn_geometry)[0]
    toe = np.argsort(-(stage.contacts.point @ down_the_plane))
    return stage, toe, down_the_plane


@pytest.mark.parametrize("base_first", [True, False])
@pytest.mark.parametrize("wide", [True, False])
@pytest.mark.parametrize("turn_geometry", [True, False])
@pytest.mark.parametrize(("angle", "height"), [(40.0, 10.0), (40.0, 5.0), (30.0, 25.0), (0.0, 10.0)])
def test_two_springs(angle, height, turn_geometry, wide, base_first):
    stage, order, down = block_on_plane(angle, height, turn_geometry=turn_geometry, wide=wide, base_first=base_first)
    contacts = stage.contacts
    W, a = GAMMA * B * height, np.radians(angle)
    N, S = W * np.cos(a), W * np.sin(a)
    toe, heel = order
    tilt = S * height / (2 * B)
    assert contacts.point[toe] @ down > contacts.point[heel] @ down
    assert_allclose(-contacts.normal_force[[toe, heel]], [N / 2 + tilt, N / 2 - tilt], rtol=RTOL)
    assert_allclose(np.abs(contacts.shear_force), [S / 2, S / 2], rtol=RTOL, atol=1e-8 * N)
    assert_allclose(-contacts.opening.mean(), N / (KN * B), rtol=RTOL)
    assert_allclose(np.abs(contacts.slip), S / (KS * B), rtol=RTOL, atol=1e-8 * N / KN)
    # signs: the plane pushes the block up the plane and out of it
    block = 1 if base_first else 0
    into = np.where(contacts.block_b == block, 1.0, -1.0)
    force = (into[:, None] * contacts.force).sum(axis=0)
    assert_allclose(force @ down, -S, rtol=RTOL, atol=1e-8 * N)
    out_of_plane = np.array([down[1], -down[0]])
    assert_allclose(force @ out_of_plane, N, rtol=RTOL)
    # rotation: the moment S h/2 on two springs of KN b/2 at b/2 from the middle; towards the toe
    assert_allclose(stage.displacement[block, 2], S * height / 2 / (KN * B**3 / 4), rtol=RTOL, atol=1e-12)
