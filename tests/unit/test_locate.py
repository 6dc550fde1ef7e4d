"""Which blocks are at points: many points at once as one by one."""

import numpy as np
from numpy.testing import assert_array_equal

from bsm_mesh.model.blocks import Blocks
from bsm_mesh.model.locate import blocks_at, pairs_at
from tests.scenes.shapes import rectangle

GRID = Blocks.from_polygons([rectangle(x, y, x + 1, y + 1) for y in range(3) for x in range(3)], rock="rock")


def test_corners_edges_insides_and_what_is_outside():
    points = [(1.0, 1.0), (1.5, 1.0), (2.5, 2.5), (5.0, 5.0), (0.0, 0.5)]
    row, block = pairs_at(GRID, points)
    assert [block[row == k].tolist() for k in range(len(points))] == [[0, 1, 3, 4], [1, 4], [8], [], [0]]
    for k, point in enumerate(points):
        assert_array_equal(block[row == k], blocks_at(GRID, point))


def test_a_block_of_which_the_point_is_in_the_extent_only_is_not_there():
    triangle = Blocks.from_polygons([[(0, 0), (1, 0), (0, 1)]], rock="rock")
    assert blocks_at(triangle, (0.4, 0.4)).tolist() == [0]
    assert blocks_at(triangle, (0.6, 0.6)).tolist() == []


def test_where_points_are_looked_for_nowhere_none_is_found():
    row, block = pairs_at(GRID, np.zeros((0, 2)))
    assert len(row) == len(block) == 0
