"""What is corrected on the way from elements to outlines."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from bsm_mesh.converters import MeshReport, NoteKind, convert_mesh
from bsm_mesh.errors import ModelError
from bsm_mesh.model import Blocks

SQUARE = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]


def convert(points: Any, *cells: tuple[str, Any], **options: Any) -> tuple[Blocks, MeshReport]:
    return convert_mesh(points, cells, options.pop("sets", None), groups={"*": "rock:r"}, **options)


@pytest.mark.parametrize(
    ("kind", "width", "corners"),
    [
        ("triangle", 3, 3),
        ("triangle6", 6, 3),
        ("triangle7", 7, 3),
        ("triangle10", 10, 3),
        ("VTK_LAGRANGE_TRIANGLE", 15, 3),
        ("quad", 4, 4),
        ("quad8", 8, 4),
        ("quad9", 9, 4),
        ("polygon", 5, 5),
        ("polygon7", 7, 7),
        ("quadratic_polygon", 10, 5),
    ],
)
def test_every_surface_type_is_reduced_to_its_corners(kind: str, width: int, corners: int) -> None:
    angle = 2 * np.pi * np.arange(width) / corners
    points = np.stack([np.cos(angle), np.sin(angle)], axis=1)  # corners first; the others lie anywhere
    blocks, report = convert(points, (kind, [np.arange(width)]))
    np.testing.assert_allclose(blocks.vertices, points[:corners])
    assert report.count(NoteKind.REDUCED) == (1 if width > corners else 0)
    assert report.count(NoteKind.UNUSED) == 0


def test_a_pixel_is_a_square() -> None:
    blocks, _ = convert([(0, 0), (1, 0), (0, 1), (1, 1)], ("pixel", [(0, 1, 2, 3)]))
    np.testing.assert_allclose(blocks.vertices, SQUARE)


def test_doubled_nodes_along_a_joint_become_one_and_lines_on_either_side_are_found() -> None:
    # Two squares with nodes of their own along x = 1; the line elements use the left nodes, then the right ones.
    points = [(0, 0), (1, 0), (1, 1), (0, 1), (1, 0), (2, 0), (2, 1), (1, 1 + 1e-10), (9, 9)]
    cells = (("quad", [(0, 1, 2, 3), (4, 5, 6, 7)]), ("line", [(1, 2), (7, 4)]))
    for line in (0, 1):
        blocks, report = convert(points, *cells, sets={"joint:J": [None, [line]]})
        assert blocks.nodes.max() == 5
        assert np.flatnonzero(blocks.edge_joint == 0).tolist() == [1, 7]
        assert report.count(NoteKind.MERGED) == 2
        assert report.count(NoteKind.UNUSED) == 1
    apart, _ = convert(points, *cells, merge_tolerance=0.0)
    assert apart.nodes.max() == 6  # equal coordinates are one point at any tolerance


def test_interface_elements_of_no_thickness_become_pieces_of_their_joint() -> None:
    points = [(0, 0), (1, 0), (1, 1), (0, 1), (1, 0), (2, 0), (2, 1), (1, 1)]
    cells = ("quad", [(0, 1, 2, 3), (4, 5, 6, 7), (1, 4, 7, 2)])
    blocks, report = convert(points, cells, sets={"joint:J": [[2]]})
    assert blocks.count == 2
    assert np.flatnonzero(blocks.edge_joint == 0).tolist() == [1, 7]
    assert report.count(NoteKind.INTERFACE) == 1
    assert report.count(NoteKind.NO_ROCK) == 0


def test_corners_that_coincide_and_elements_without_area() -> None:
    points = [*SQUARE, (1, 1), (0.5, 0), (2, 0), (2, 1)]
    quads = [(0, 1, 2, 4), (1, 6, 7, 2)]
    triangles = [(0, 2, 3), (0, 5, 1), (2, 4, 2)]
    blocks, report = convert(points, ("quad", quads), ("triangle", triangles))
    assert np.diff(blocks.offsets).tolist() == [3, 4, 3]
    assert report.count(NoteKind.CORNERS) == 1
    assert report.count(NoteKind.FLAT) == 2
    assert any("(elements 3, 4, near" in note.text for note in report.notes)


def test_clockwise_elements_are_turned_and_repeated_ones_taken_once() -> None:
    blocks, report = convert(SQUARE, ("triangle", [(0, 2, 1), (0, 2, 3), (1, 2, 0)]))
    np.testing.assert_allclose(blocks.moments.area, [0.5, 0.5])
    assert report.count(NoteKind.FLIPPED) == 1
    assert report.count(NoteKind.JOINED) == 1


def test_an_element_given_once_for_each_of_its_groups_is_one_block_in_both() -> None:
    cells = ("triangle", [(0, 1, 2), (0, 2, 3), (1, 2, 0)])
    blocks, _ = convert_mesh(SQUARE, [cells], {"rock:a": [[0, 1]], "excavation:1": [[2]]})
    assert blocks.count == 2
    assert blocks.excavations["1"].tolist() == [0]
    with pytest.raises(ModelError, match="in 'rock:a' and in 'rock:b'"):
        convert_mesh(SQUARE, [cells], {"rock:a": [[0, 1]], "rock:b": [[2]]})


@pytest.mark.parametrize(("columns", "note"), [((0, 1), 0), ((0, 2), 1), ((1, 2), 1)], ids=["xy", "xz", "yz"])
def test_the_plane_of_the_mesh(columns: tuple[int, int], note: int) -> None:
    points = np.full((4, 3), 7.0)
    points[:, columns] = SQUARE
    blocks, report = convert(points, ("quad", [(0, 1, 2, 3)]))
    np.testing.assert_allclose(blocks.vertices, SQUARE)
    assert report.count(NoteKind.PLANE) == note


def test_units() -> None:
    blocks, _ = convert(SQUARE, ("quad", [(0, 1, 2, 3)]), unit_scale=1e-3)
    np.testing.assert_allclose(blocks.vertices, np.array(SQUARE) * 1e-3)


TILTED = [(0, 0, 0), (1, 0, 1), (1, 1, 1), (0, 1, 0)]


@pytest.mark.parametrize(
    ("points", "cells", "options", "message"),
    [
        (TILTED, ("quad", [(0, 1, 2, 3)]), {}, "tilted to the axes"),
        ([*TILTED[:3], (0, 1, 5)], ("quad", [(0, 1, 2, 3)]), {}, "is not plane"),
        (TILTED, ("tetra", [(0, 1, 2, 3)]), {}, "three-dimensional mesh .1 tetra elements."),
        ([*SQUARE[:3], (np.nan, 1)], ("quad", [(0, 1, 2, 3)]), {}, "no numbers below 1e.12 .counted from 0: 3"),
        ([*SQUARE[:3], (1e300, 1)], ("quad", [(0, 1, 2, 3)]), {}, "no numbers below 1e.12 .counted from 0: 3"),
        (SQUARE, ("line", [(0, 1)]), {}, "no surface elements .*elements found: 1 line"),
        (SQUARE, ("quad", [(0, 1, 2, 4)]), {}, "nodes that are not in the file"),
        (SQUARE, ("quad", [(0, 1, 2, -1)]), {}, "nodes that are not in the file"),
        (SQUARE, ("polygon", [(0, 1, 2), (0, 1, 2, 3)]), {}, "a block of their own"),
        (SQUARE, ("triangle", [(0, 1, 1)]), {}, "none of the 1 surface elements has an area"),
        (SQUARE, ("quad", [(0, 1, 2, 3)]), {"unit_scale": np.nan}, "above 0 m"),
        (SQUARE, ("quad", [(0, 1, 2, 3)]), {"unit_scale": -1.0}, "above 0 m"),
        (SQUARE, ("quad", [(0, 1, 2, 3)]), {"merge_tolerance": -1.0}, "must be 0 m or more"),
        (SQUARE, ("triangle", [(0, 1, 2), (0, 1, 3)]), {}, "elements 0 and 1 overlap by 0.25 m2 near"),
        ([(0, 0), (2, 2), (2, 0), (0, 1)], ("quad", [(0, 1, 2, 3)]), {}, "crosses or touches itself"),
        ([1, 2, 3], ("quad", [(0, 1, 2, 3)]), {}, "coordinates are needed"),
    ],
)
def test_a_mesh_that_cannot_be_used_is_one_clear_error(points: Any, cells: Any, options: Any, message: str) -> None:
    with pytest.raises(ModelError, match=message):
        convert(points, cells, **options)
