"""Faces of blocks in space that meet at an angle: where they have contact beside flat contacts, and where not."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.three_d.contacts.surfaces import Surfaces
from tests.scenes.polyhedra import CELL_ARRAYS, prism, rotation, turned


@pytest.mark.parametrize("turn", [0, 40])
def test_a_face_that_lies_flat_has_no_more_contacts_over_the_edge_beside_it(turn):
    """The base is one block of two cells: one has the incline, the other the side. The block is a third over the edge.

    Its lower face faces the side too. Cohesion there held blocks that slide off an incline.
    """
    outlines = [(0, -1), (1, -1), (0, 0)], [(1, -1), (1, 0.7), (0, 0)], [(0, 0), (1, 0.7), (0.7, 1.2), (-0.3, 0.5)]
    x = rotation(20, turn)
    cells = bsm.Polyhedra.from_solids(turned([prism(outline, depth=0.5) for outline in outlines], x), rock="rock")
    arrays = {name: getattr(cells, name) for name in CELL_ARRAYS}
    blocks = bsm.Polyhedra(**arrays, cell_block=np.array([0, 0, 1], np.int32), rock=np.zeros(2, np.int32))
    position = np.zeros((2, 6))
    position[1, :3] = x @ (-1 / 3, 0, -0.7 / 3)
    free = np.array([False, True])
    found = Surfaces(blocks=blocks, rule="both").polygons(position, free, ~free, band=0.05, narrow=5e-3)
    assert found.area.sum() == pytest.approx(2 / 3 * np.hypot(1, 0.7) * 0.5)


BESIDE = [
    [(0, -1), (1, -1), (1, 0), (0, 0)],
    [(1, -1), (4, -1), (4, -0.5), (1, -0.5)],
    [(2.5, -0.5), (3.5, -0.5), (3, 0)],
]
ABOVE = [[(0, -1), (4, -1), (4, 0), (0, 0)], [(2, 0), (3, 0), (3, 2), (2, 2)], [(0, 1.5), (2, 1.5), (2, 2), (0, 2)]]
RIDGES = {
    "beside": ([*BESIDE, [(0, 0), (4, 0), (4, 1), (0, 1)]], (3, 0)),
    "above": ([*ABOVE, [(0.2, 1.5), (0.5, 1), (0.8, 1.5)], [(0, 0), (1, 0), (1, 1), (0, 1)]], (0.5, 1)),
}


@pytest.mark.parametrize("ridge", RIDGES)
def test_a_ridge_bears_too_where_the_same_blocks_touch_flat_elsewhere(ridge):
    """A plate lies on a step and on a ridge of its base at the same height; a box stands under a ridge of its base."""
    outlines, (x, y) = RIDGES[ridge]
    cells = bsm.Polyhedra.from_solids([prism(outline, depth=0.5) for outline in outlines], rock="rock")
    arrays = {name: getattr(cells, name) for name in CELL_ARRAYS}
    of = np.arange(len(outlines)) == len(outlines) - 1
    blocks = bsm.Polyhedra(**arrays, cell_block=of.astype(np.int32), rock=np.zeros(2, np.int32))
    free = np.array([False, True])
    found = Surfaces(blocks=blocks, rule="ends").polygons(np.zeros((2, 6)), free, ~free, band=0.05, narrow=5e-3)
    found = found.some(found.found_gap < 5e-3)
    place = found.geometry[:, :3] + blocks.moments.centroid[found.block_a]
    on_ridge = (np.abs(place[:, [0, 2]] - (x, y)) < 1e-9).all(axis=1)
    assert on_ridge.any()
    assert_allclose(place[~on_ridge, 2], 0, atol=1e-9)
    assert (place[~on_ridge, 0] <= 1).all()
