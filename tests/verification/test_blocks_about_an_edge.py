"""Blocks that touch another along an edge alone, once those between them are gone: no block goes through another."""

from itertools import pairwise

import numpy as np
import pytest

import bsm_mesh as bsm
from bsm_mesh.three_d.step.block_system import BlockSystem
from tests.scenes.blocks_about_an_edge import BlocksAboutAnEdge
from tests.scenes.polyhedra import model_in_space, prism, rotation, turned

DEEP = 5e-3  # m: more than a first contact begins with


@pytest.mark.parametrize("azimuth", [pytest.param(130.0, marks=pytest.mark.heavy), 0.0])
@pytest.mark.parametrize("tilt", [pytest.param(-25.0, marks=pytest.mark.heavy), -65.0])
def test_a_cube_above_another_slides_past_its_edge_to_the_steeper_side(tilt, azimuth):
    """Two of four cubes about an edge are excavated. Sides of the lower one dip by 25 and by 65 degrees."""
    squares = [
        np.array([(x, z), (x + 1, z), (x + 1, z + 1), (x, z + 1)]) for x, z in ((-1, -1), (0, 0), (0, -1), (-1, 0))
    ]
    squares = [square @ rotation(0, tilt)[::2, ::2].T for square in squares]
    dig = bsm.Stage("dig", excavate=[2, 3])
    cubes = turned([prism(square) for square in squares], rotation(azimuth, 0))
    stage = bsm.run(model_in_space(cubes, fixed=(0, 2, 3), stages=[dig])).stages[-1]
    assert stage.unstable_blocks.tolist() == [1]
    along = np.array([np.cos(np.radians(azimuth)), np.sin(np.radians(azimuth)), 0.0])
    assert (stage.displacement[1, :3] @ along > 0.05) == (tilt > -45)
    lower, upper = squares[:2]
    scene = BlocksAboutAnEdge(outlines=(lower, upper), held=(True, False), friction=30.0)
    assert scene.depth(stage.displacement[:2], azimuth) < DEEP


@pytest.mark.heavy
def test_a_block_on_an_edge_alone_slides_past_it_as_in_the_plane():
    falls_as_in_the_plane(7)


@pytest.mark.heavy
@pytest.mark.parametrize(
    "seed", [pytest.param(76, id="turns and rests"), pytest.param(19, id="edge over a joint between two blocks")]
)
def test_a_block_on_an_edge_alone_falls_as_in_the_plane(seed):
    falls_as_in_the_plane(seed)


def falls_as_in_the_plane(seed):
    scene = BlocksAboutAnEdge.drawn(seed)
    flat, solid = (bsm.run(model) for model in (scene.model(), scene.in_space()))
    assert solid.status == flat.status
    assert scene.depth(flat.stages[-1].displacement) < DEEP
    assert scene.depth(solid.stages[-1].displacement) < DEEP


@pytest.mark.parametrize("between", [True, False])
def test_blocks_that_share_an_edge_have_contact_there_unless_others_are_between(between):
    """Six wedges of 60 degrees about an edge, or two of them with one between that is gone."""
    ways = np.radians(np.arange(0, 361, 60))
    wedges = [[(0, 0), (np.cos(a), np.sin(a)), (np.cos(b), np.sin(b))] for a, b in pairwise(ways)]
    solids = [prism(wedge) for wedge in (wedges if between else [wedges[0], wedges[2]])]
    touching = BlockSystem(model_in_space(solids)).touching_pairs.tolist()
    assert touching == ([] if between else [[0, 1]])
