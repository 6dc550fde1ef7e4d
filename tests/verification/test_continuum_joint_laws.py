"""The laws of the literature in the continuum's interfaces: closed forms, and the blocks beside it."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.converters.continuum import solve_continuum_stages
from tests.scenes.models import model_of
from tests.scenes.shapes import rectangle

ELASTIC = 2e-3  # rock of 1e13 Pa takes the place of rigid rock


def both(model):
    """Return the displacement of every block (n, 2) by the blocks, and by the continuum with interfaces."""
    results = bsm.run(model)
    assert results.status == "stable"
    (stage,) = solve_continuum_stages(model, order=1, joints=True)
    assert stage.converged
    return results.stages[0].displacement[:, :2], stage.displacement[:, :2]


@pytest.mark.parametrize("stress", [1e5, 2e6, 1e7])
def test_a_joint_closes_by_the_hyperbola(stress):
    kn, limit = 10e9, 2e-4
    joint = bsm.Joint("J", kn, 1e9, law=bsm.MohrCoulomb(friction=30), max_closure=limit)
    blocks = bsm.Blocks.from_polygons([rectangle(0, -1, 1, 0), rectangle(0, 0, 1, 1)], rock="r")
    model = model_of(blocks, gamma=stress, joint=joint)
    for moved in both(model):
        assert_allclose(-moved[1, 1], stress * limit / (kn * limit + stress), rtol=ELASTIC)


@pytest.mark.parametrize("k", [pytest.param(1.2e7, marks=pytest.mark.heavy), 6e7])
def test_a_softening_joint_comes_to_rest_where_its_neighbour_takes_over(k):
    """T = strength(s) + k u for a block that presses on its neighbour by a joint of the stiffness k."""
    softening, ks = 2e-3, 2e9
    soft = bsm.MohrCoulomb(friction=40, residual_friction=20, softening_slip=softening)
    strong = bsm.MohrCoulomb(friction=40, cohesion=1e6)
    polygons = [rectangle(-1, -1, 6, 0), rectangle(0, 0, 2, 1), rectangle(2, 0, 4, 1)]
    blocks = bsm.Blocks.from_polygons(polygons, rock="r")
    numbers = np.full(len(blocks.vertices), -1, dtype=np.int32)
    numbers[[4, 8, 7, 9]] = 0, 1, 2, 2  # bottoms; left sides; right sides
    numbers[[5, 11]] = 2, 2
    blocks = replace(blocks, edge_joint=numbers, joint_names=("soft", "strong", "cross"))
    model = bsm.Model(
        blocks=blocks,
        rocks=[bsm.Rock("r", unit_weight=25e3)],
        joints=[
            bsm.Joint("soft", 1e11, ks / 2, law=soft),
            bsm.Joint("strong", 1e11, 1e11, law=strong),
            bsm.Joint("cross", k, k, law=bsm.MohrCoulomb(friction=0)),
        ],
        supports=[bsm.Fixed(blocks=[0])],
        gravity_direction=-45.0,
    )
    push = pressed = 25e3 * 2 * np.sqrt(0.5)
    peak, left = pressed * np.tan(np.radians([40, 20]))
    fall = (peak - left) / softening
    slip = (push - peak - k * peak / ks) / (k - fall - k * fall / ks)
    expected = slip + (peak - fall * slip) / ks
    for moved in both(model):
        assert_allclose(moved[1, 0], expected, rtol=0.02)


@pytest.mark.parametrize("last", [1e-3, 1.0])
def test_a_dilating_joint_between_walls_holds_the_block_that_slides_out(last):
    """A block between two held ones slips under its weight until both joints' pressure carries it.

    Half its weight W is mu (P + kn t x), with the slip x, the slope t of dilation and the field's pressure P; the shear
    springs give by as much as they carry.
    """
    kn, ks, angle, weight, field = 1e9, 4e8, 5.0, 25e3, 1e3
    joint = bsm.Joint("J", kn, ks, law=bsm.MohrCoulomb(friction=35), dilation_angle=angle, dilation_slip=last)
    polygons = [rectangle(-1, 0, 0, 1), rectangle(0, 0, 1, 1), rectangle(1, 0, 2, 1)]
    model = bsm.Model(
        blocks=bsm.Blocks.from_polygons(polygons, rock="r"),
        rocks=[bsm.Rock("r", unit_weight=weight)],
        joints=[joint],
        default_joint="J",
        supports=[bsm.Fixed(blocks=[0, 2])],
        in_situ=bsm.InSitu(stress={"xx": -field, "yy": 0.0, "xy": 0.0}, method="direct"),
    )
    mu, t = np.tan(np.radians([35, angle]))
    slip = (weight / 2 / mu - field) / (kn * t)
    expected = slip + weight / 2 / ks
    assert slip < 1e-3
    for moved in both(model):
        assert_allclose(-moved[1, 1], expected, rtol=ELASTIC)
