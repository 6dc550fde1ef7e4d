"""Blocks in space that touch with edges and corners alone: weight, levers, friction, and blocks that fall."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.contact.rules import RULES
from bsm_mesh.model.supports import Bars
from tests.scenes.dropped_blocks import judged
from tests.scenes.polyhedra import box, model_in_space, prism, rotation

OPTIONS = bsm.Options(threads=1)
HALF, KN, WEIGHT = 0.5, 1e9, 26e3  # m, Pa/m, N/m3: half the diagonal of a square bar; as in `model_in_space`
TABLE = box((-3, -3, -1), (3, 3, 0))
BALANCE = 1e-6  # of a weight
ARM = 1e-3  # of a weight: bars turn by settlements of 0.1 mm
EDGES = {"upper": -HALF, "lower": HALF}  # height of a bar's axis: that edge lies at zero


def bar(edge, length, azimuth, at=(0.0, 0.0), gap=0.0):
    """Return a square bar on its edge, its axis at an azimuth from x [degrees] over a point, its edge at a height."""
    corners, faces = prism([(0, -HALF), (HALF, 0), (0, HALF), (-HALF, 0)], length)
    corners = (corners - (0, length / 2, 0)) @ rotation(azimuth - 90, 0).T
    return corners + np.array([*at, EDGES[edge] + gap]), faces


def outcome(solids, held, *, fixed=(0,), **more):
    """Return the stage of solids of which the last cannot turn about some axes (k, 3), and that block's weight."""
    model = model_in_space(solids, fixed=fixed, kn=KN, ks=KN, **more)
    last, held = len(solids) - 1, np.array(held, float)
    bars = Bars(
        block=np.full(len(held), last, np.int32),
        point=np.tile(model.blocks.moments.centroid[last], (len(held), 1)),
        direction=held,
        holds_rotation=np.ones(len(held), bool),
        value=np.zeros(len(held)),
        support=np.zeros(len(held), np.int32),
        edge=np.full(len(held), -1, np.int32),
    )
    stage = bsm.run(model.replace(supports=[*model.supports, bars]), OPTIONS).stages[0]
    return stage, WEIGHT * model.blocks.moments.volume


@pytest.mark.parametrize("gap", [0.0, 1e-3])
@pytest.mark.parametrize(("azimuth", "pairs"), [(90, 4), (60, 4), (30, 2)])
def test_an_edge_carries_a_bar_that_crosses_it(azimuth, pairs, gap):
    """It settles by its weight over the stiffness of a twentieth of its size squared for every pair of faces."""
    stage, weight = outcome([bar("upper", 2, 0), bar("lower", 2, azimuth, (0.4, 0.0), gap)], np.eye(3))
    assert stage.status == "stable"
    assert_allclose(stage.reactions[0, :3], [0, 0, weight.sum()], atol=BALANCE * weight[1])
    area = RULES.corner_share * (weight[1] / WEIGHT) ** (2 / 3)
    assert_allclose(-stage.displacement[1, 2], gap + weight[1] / (pairs * KN * area), rtol=1e-5)


@pytest.mark.parametrize(
    ("share", "status"), [(0.99, "stable"), pytest.param(1.01, "unstable", marks=pytest.mark.heavy)]
)
def test_it_slides_on_the_edge_at_the_friction_angle(share, status):
    pull = share * np.tan(np.radians(30))
    stage, _ = outcome([bar("upper", 2, 0), bar("lower", 2, 90)], np.eye(3), gravity_horizontal=pull)
    assert stage.status == status


@pytest.mark.parametrize("off", [0.0, 0.2, 0.35])
def test_two_edges_share_the_weight_by_the_lever(off):
    """A bar over two edges 1 m apart, its centre off the middle: it may turn about all axes but its own."""
    supports = [bar("upper", 2, 90, (x, 0.0)) for x in (-0.5, 0.5)]
    stage, weight = outcome([*supports, bar("lower", 3, 0, (off, 0.0))], [(1, 0, 0)], fixed=(0, 1))
    assert stage.status == "stable"
    own = stage.reactions[:2, 2] - weight[:2]
    assert_allclose(own / weight[2], [0.5 - off, 0.5 + off], atol=ARM)


def on_its_corner():
    """Return a cube on its lowest corner, its centre above it."""
    up = np.ones(3) / np.sqrt(3)
    across = np.cross(up, (0, 0, 1)) / np.linalg.norm(np.cross(up, (0, 0, 1)))
    corners, faces = box((-0.5,) * 3, (0.5,) * 3)
    return corners @ np.array([across, np.cross(up, across), up]).T + (0, 0, np.sqrt(0.75)), faces


@pytest.mark.parametrize("solid", [bar("lower", 2, 90), on_its_corner()], ids=["edge", "corner"])
def test_a_block_begins_on_an_edge_or_a_corner(solid):
    stage, weight = outcome([TABLE, solid], np.eye(3))
    assert stage.status == "stable"
    assert_allclose(stage.reactions[0, 2], weight.sum(), atol=BALANCE * weight[1])


@pytest.mark.heavy
@pytest.mark.parametrize("seed", [2, 9, 28, 33])
def test_blocks_that_fall_on_each_other_do_not_overlap(seed):
    """With edges and corners first; each of these passed into another by 4 % to 47 % of its volume."""
    assert judged(seed)["worst"] < 0.01
