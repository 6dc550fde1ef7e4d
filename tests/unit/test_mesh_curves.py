"""Edges on the curves of a mesh, conforming or not."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from bsm_mesh.converters import MeshReport, NoteKind, convert_mesh
from bsm_mesh.model import Blocks

# One square of side 2 below, two of side 1 above: a corner in the middle of the edge y = 0.
POINTS = [(0, -2), (2, -2), (2, 0), (0, 0), (1, 0), (2, 1), (1, 1), (0, 1)]
POINTS += [(0.5, 0), (0.3, -1), (1.5, -1), (5, 5), (6, 5)]  # corners of no block
QUADS = [(0, 1, 2, 3), (3, 4, 6, 7), (4, 2, 5, 6)]
LONG, LEFT, RIGHT = 2, 4, 8  # edges of the three blocks on y = 0


def convert(lines: Any, name: str = "joint:J", turn: float = 0.0) -> tuple[Blocks, MeshReport]:
    rotation = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    points = np.array(POINTS) @ rotation.T + (100.0, 200.0)
    sets = {"rock:r": [[0, 1, 2], []], name: [[], range(len(lines))]}
    return convert_mesh(points, [("quad", QUADS), ("line", lines)], sets)


@pytest.mark.parametrize("turn", [0.0, 0.7])
@pytest.mark.parametrize(
    ("lines", "edges"),
    [
        ([(3, 2)], [LONG, LEFT, RIGHT]),  # a long piece along short edges
        ([(4, 3), (4, 2)], [LONG, LEFT, RIGHT]),  # short pieces along a long edge
        ([(3, 4)], [LONG, LEFT]),  # half of the long edge is enough
        ([(3, 8), (8, 4), (4, 2)], [LONG, LEFT, RIGHT]),  # pieces shorter than any edge
        ([(1, 2)], [1]),
    ],
)
def test_pieces_are_found_where_corners_lie_in_the_middle_of_edges(lines: Any, edges: list[int], turn: float) -> None:
    blocks, report = convert(lines, turn=turn)
    assert np.flatnonzero(blocks.edge_joint == 0).tolist() == edges
    assert report.count(NoteKind.LOOSE) == 0


def test_less_than_half_of_an_edge_is_not_enough() -> None:
    blocks, report = convert([(3, 8)])
    assert np.flatnonzero(blocks.edge_joint == 0).tolist() == [LEFT]
    assert report.count(NoteKind.LOOSE) == 0


def test_pieces_that_bound_no_block_are_counted_with_their_place() -> None:
    blocks, report = convert([(9, 10), (11, 12), (3, 2), (0, 2)])
    assert report.about(NoteKind.LOST) == {"joint:J": 2}
    assert report.notes[-2].text.startswith(
        "4.03 of 6.03 m of 'joint:J' run through blocks and divide none (near (100.9, "
    )
    assert report.about(NoteKind.LOOSE) == {"joint:J": 1}
    assert "(near (105.5, 205))" in report.notes[-1].text
    assert np.flatnonzero(blocks.edge_joint == 0).tolist() == [LONG, LEFT, RIGHT]


def test_a_curve_on_no_edge_is_no_joint() -> None:
    blocks, report = convert([(9, 10)])
    assert blocks.joint_names == ()
    assert report.about(NoteKind.LOOSE) == {"joint:J": 1}


def test_repeated_pieces_count_once() -> None:
    blocks, report = convert([(9, 10), (10, 9), (3, 8), (8, 3)])
    assert report.about(NoteKind.LOOSE) == {"joint:J": 1}
    assert np.flatnonzero(blocks.edge_joint == 0).tolist() == [LEFT]


def test_a_boundary_inside_the_rock_has_both_sides() -> None:
    blocks, report = convert([(4, 6), (6, 5)], "boundary:wall")
    assert blocks.boundaries["wall"].tolist() == [5, 10, 11]
    assert report.about(NoteKind.INTERIOR) == {"boundary:wall": 2}


def test_a_piece_between_the_ends_of_an_edge_goes_before_one_that_only_runs_along_it() -> None:
    sets = {"rock:r": [[0, 1, 2], []], "joint:J": [[], [0]], "joint:K": [[], [1]]}
    blocks, _ = convert_mesh(POINTS, [("quad", QUADS), ("line", [(3, 4), (3, 2)])], sets)
    joints = [(*blocks.joint_names, "")[k] for k in blocks.edge_joint[[LONG, LEFT, RIGHT]]]
    assert joints == ["K", "J", "K"]
