"""Lines of thrust: of a row of blocks, and of blocks that reached rest far off."""

from __future__ import annotations

from typing import Any

import numpy as np

import bsm_mesh as bsm
from bsm_mesh.pictures.pictures import figure_of
from tests.scenes.shapes import rectangle


def lines_of_thrust(supports: list[Any]) -> tuple[Any, Any]:
    """Return the axes of the picture of a column with a block that overhangs, and its lines of thrust."""
    from matplotlib.collections import LineCollection

    column = [rectangle(0, 0, 1, 1), rectangle(0, 1, 1, 2), rectangle(0.3, 2, 1.3, 3)]
    model = bsm.Model(
        blocks=bsm.Blocks.from_polygons(column, rock="rock"),
        rocks=[bsm.Rock("rock", unit_weight=25e3)],
        joints=[bsm.Joint("J", normal_stiffness=1e10, shear_stiffness=1e10, law=bsm.MohrCoulomb(friction=30))],
        default_joint="J",
        supports=supports,
    )
    (axes, *_) = figure_of(bsm.run(model), "thrust").axes
    (lines,) = [each for each in axes.collections if isinstance(each, LineCollection) and each.get_array() is not None]
    return axes, lines


def test_a_block_between_two_others_has_one_straight_line_of_thrust() -> None:
    _, lines = lines_of_thrust([bsm.Fixed(blocks=[0])])
    ends = np.array(lines.get_segments())
    turns = ends[np.abs(ends[:, 0, 1] - 1.5) < 1e-3, 0]
    upper, lower = (ends[np.abs(ends[:, 1, 1] - y) < 1e-3, 1][0] for y in (2, 1))
    assert len(turns) == 2
    assert lower[0] < upper[0] - 0.1
    assert np.allclose(turns, (upper + lower) / 2, atol=1e-6)


def test_lines_of_thrust_are_seen_over_blocks_that_reached_rest_far_off() -> None:
    from matplotlib.colors import to_rgba

    moved = [((0.2, 0.5), 0, 2.0), ((0.2, 0.5), 90, 0.0), ((0.8, 0.5), 90, 0.0)]
    supports = [bsm.PrescribedDisplacement(point=at, direction=way, displacement=by) for at, way, by in moved]
    axes, lines = lines_of_thrust(supports)
    (blocks,) = (each for each in axes.collections if np.array_equal(each.get_facecolor()[:1], [to_rgba("#f0b27a")]))
    assert blocks.get_zorder() < lines.get_zorder()
