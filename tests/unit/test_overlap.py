"""Blocks that lie over each other are named; blocks that touch are not."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest

from bsm_mesh.errors import ModelError
from bsm_mesh.merged_points import merge_points
from bsm_mesh.model.blocks import MERGE_TOLERANCE, Blocks
from bsm_mesh.model.overlap import Overlaps, find_overlaps

Outline = list[tuple[float, float]]


def rectangle(x: float, y: float, width: float, height: float) -> Outline:
    return [(x, y), (x + width, y), (x + width, y + height), (x, y + height)]


def overlaps(*outlines: Outline, move: npt.ArrayLike = (0.0, 0.0), turn: float = 0.0) -> Overlaps:
    rotation = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    vertices = np.concatenate([np.array(o) @ rotation.T + move for o in outlines])
    offsets = np.cumsum([0, *map(len, outlines)]).astype(np.int32)
    return find_overlaps(vertices, offsets, merge_points(vertices, MERGE_TOLERANCE))


def test_blocks_made_of_overlapping_polygons_are_refused() -> None:
    with pytest.raises(ModelError, match=r"blocks 0 and 1 overlap by 1 m2 near \(1.5, 1.5\); remove one"):
        Blocks.from_polygons([rectangle(0, 0, 2, 2), rectangle(1, 1, 2, 2)], rock="granite")


@pytest.mark.parametrize(
    ("other", "area"),
    [
        (rectangle(1, 1, 2, 2), 1.0),  # edges cross
        (rectangle(0.5, 0.5, 1, 1), 1.0),  # one inside the other
        (rectangle(0.5, 0, 1, 2), 2.0),  # ends on the other's edges, no edge crosses
        (rectangle(0, 0, 1, 2), 2.0),  # an edge used twice in one direction
        (rectangle(0, 0, 2, 2), 4.0),  # the same twice
        ([(0, 0), (2, 0), (1, 3)], 3 - 1 / 3),  # an edge in the same direction; the tip (1/9 of 3) lies outside
    ],
)
@pytest.mark.parametrize("turn", [0.0, 0.3])
def test_two_blocks_that_share_area_are_found(other: Outline, area: float, turn: float) -> None:
    found = overlaps(rectangle(0, 0, 2, 2), rectangle(5, 5, 1, 1), other, turn=turn, move=(100, -30))
    assert found.pairs.tolist() == [[0, 2]]
    np.testing.assert_allclose(found.area, [area], rtol=1e-9)
    assert "blocks 0 and 2 overlap" in found.faults()[0]


def test_faults_use_the_readers_numbers() -> None:
    found = overlaps(rectangle(0, 0, 2, 2), rectangle(1, 1, 2, 2))
    assert "elements 70 and 80 overlap by 1 m2 near (1.5, 1.5)" in found.faults(np.array([70, 80]), "elements")[0]


@pytest.mark.parametrize("turn", [0.0, 0.1, 1.0])
def test_a_corner_in_the_middle_of_a_neighbours_edge_is_no_overlap(turn: float) -> None:
    bricks = [rectangle(i + 0.37 * (j % 2), j, 1, 1) for j in range(8) for i in range(8)]
    assert len(overlaps(*bricks, turn=turn, move=(4e5, 5e6)).pairs) == 0


def test_a_block_hidden_among_inner_blocks_is_found() -> None:
    grid = [rectangle(i, j, 1, 1) for j in range(9) for i in range(9)]
    found = overlaps(*grid, rectangle(3.75, 4.25, 0.5, 0.5))
    assert found.pairs.tolist() == [[39, 81], [40, 81]]


def test_a_block_in_a_hole_of_the_others_is_no_overlap() -> None:
    ring = [rectangle(i, j, 1, 1) for j in range(3) for i in range(3) if (i, j) != (1, 1)]
    assert len(overlaps(*ring, rectangle(1.2, 1.2, 0.5, 0.5)).pairs) == 0


def test_a_block_of_another_scale_is_found() -> None:
    assert overlaps(rectangle(0, 0, 1000, 1000), rectangle(400, 400, 0.01, 0.01)).pairs.tolist() == [[0, 1]]


def test_triangles_that_differ_by_rounding_share_nothing() -> None:
    """A corner that one of them has four units in the last place away: GEOS gave a whole triangle as shared area."""
    corner = "0x1.f8d194d53933dp-1", "0x1.a922d48a490f8p-4"
    one = [corner, ("0x1.a44f8b1c5484cp-1", "0x1.969aecb9f8585p-3"), ("0x1.a4d9d7bae8842p-1", "0x1.079eabb163860p-7")]
    other = [
        corner,
        ("0x1.a4d9d7bae8842p-1", "0x1.079eabb163864p-7"),
        ("0x1.f93a92021032dp-1", "-0x1.6375d4d495dd0p-4"),
    ]
    vertices = np.array([[float.fromhex(c) for c in point] for point in one + other])
    found = find_overlaps(vertices, np.array([0, 3, 6], dtype=np.int32), np.arange(6, dtype=np.int32))
    assert len(found.area) == 0
