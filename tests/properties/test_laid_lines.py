"""Lines of joints laid through irregular meshes: all of their length in the rock is joint, and nothing else changes."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from bsm_mesh.converters import read_mesh
from bsm_mesh.converters.meshes.laid_lines import lay_lines
from bsm_mesh.converters.meshes.marks import Marks
from bsm_mesh.model import Blocks
from tests.scenes.mesh_files import FORMATS, SHAPES, write_mesh
from tests.scenes.random_lines import CLOSE, KINDS, faults_of, grouped, random_line

GROUPS = {"*": "rock:a"}


def given_blocks(shape: str, seed: int, folder: Path, size: float = 1.5) -> Blocks:
    path = write_mesh(shape, FORMATS[shape][0], size, seed, folder)
    return grouped(read_mesh(path, groups=GROUPS)[0])


@pytest.mark.usefixtures("read_here")
@pytest.mark.parametrize("shape", SHAPES)
def test_a_line_of_any_kind_is_laid_to_the_last_metre(shape: str, tmp_path: Path) -> None:
    given = given_blocks(shape, 7, tmp_path)
    rng = np.random.default_rng(11)
    for kind in KINDS:
        lines = {"f": [random_line(kind, given, rng)]}
        laid, parent, notes = lay_lines(given, lines)
        assert faults_of(given, laid, lines, on_rim=kind == "rim", close=kind in CLOSE) == [], (kind, lines)
        assert len(parent) == laid.count
        assert not [note for note in notes if "carry another" in note.text]


@pytest.mark.heavy
@pytest.mark.usefixtures("read_here")
@pytest.mark.parametrize("shape", SHAPES)
def test_lines_of_several_joints_cross_anywhere(shape: str, tmp_path: Path) -> None:
    given = given_blocks(shape, 8, tmp_path)
    rng = np.random.default_rng(12)
    kinds = ("through", "inside", "broken", "curve", "short", "nodes", "grazing")
    for _ in range(3):
        lines = {name: [random_line(kind, given, rng) for kind in kinds] for name in ("f", "g")}
        laid, _, _ = lay_lines(given, lines)
        assert faults_of(given, laid, lines, close=True) == [], lines


@pytest.mark.usefixtures("read_here")
@pytest.mark.parametrize("shape", ["triangles", "polygons"])
def test_map_coordinates_and_lines_of_another_world(shape: str, tmp_path: Path) -> None:
    """Far from the origin, and with ends far from the model."""
    given, rng = given_blocks(shape, 9, tmp_path), np.random.default_rng(13)
    there = np.array([512345.0, 4501234.0])
    moved = replace(given, vertices=given.vertices + there)
    for kind in ("through", "inside", "broken", "short", "edge"):
        lines = {"f": [random_line(kind, moved, rng)]}
        assert faults_of(moved, lay_lines(moved, lines)[0], lines, close=True) == [], (kind, lines)
    far = {"f": [np.array([(-1e7, 7.0 - 1e7 / 9), (1e7, 7.0 + 1e7 / 9)])], "g": [np.array([(1e9, 0), (1e9, 9)])]}
    laid, _, _ = lay_lines(given, far)
    near = {"f": [np.array([(-9.0, 6.0), (36.0, 11.0)])]}
    assert laid.joint_names == ("f",)
    assert faults_of(given, laid, near, close=True) == []


@pytest.mark.slow
@pytest.mark.parametrize("number", range(60))
def test_random_lines_over_files_of_many_meshes(number: int, tmp_path: Path) -> None:
    """Sixty meshes, of triangles, quadrilaterals, polygons and jittered grids, in four formats; eleven lines each."""
    shape = SHAPES[number % 4]
    rng = np.random.default_rng(number)
    size = float(rng.choice([3.0, 1.5, 0.8]))
    path = write_mesh(shape, FORMATS[shape][number // 4 % len(FORMATS[shape])], size, number, tmp_path)
    given, _ = read_mesh(path, groups=GROUPS)
    for kind in KINDS:
        lines = {"f": [random_line(kind, given, rng)]}
        laid, _ = read_mesh(path, groups=GROUPS, marks=Marks(lines=lines))
        assert faults_of(given, laid, lines, on_rim=kind == "rim", close=kind in CLOSE) == [], (kind, lines)
