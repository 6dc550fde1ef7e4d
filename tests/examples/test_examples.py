"""Every model file of the examples runs, and gives the verdict and the number of its README."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from bsm_mesh.app.cli import cli
from converters.vtk_files import read_pvd, read_vtu

pytest.importorskip("gmsh")

EXAMPLES = Path(__file__).parents[2] / "examples"
# model file: verdict, unstable blocks, least and greatest max_displacement [m], whether statics admits the start
EXPECTED: dict[str, tuple[str, list[int] | None, float, float, bool]] = {
    "02_pushed_block/model.toml": ("stable", [], 0.4999, 0.5001, False),
    "02_pushed_block/apart.toml": ("unstable", [1], 1.0, 2.5, False),
    "03_stratified_slope/dip_24_5.toml": ("stable", [], 0.0, 1e-5, True),
    "03_stratified_slope/dip_25_5.toml": ("stable", [], 2.9999, 3.0001, False),
    "03_stratified_slope/model.toml": ("stable", [], 2.9999, 3.0001, False),
    "03_stratified_slope/mohr_coulomb.toml": ("stable", [], 0.0, 1e-5, True),
    "incline/model.toml": ("stable", [], 0.039, 0.041, True),
    "incline/slides.toml": ("unstable", [1], 10.0, 20.0, False),
    "incline/topples.toml": ("unstable", [1], 10.0, 20.0, False),
    "incline/slides_and_topples.toml": ("unstable", [1], 10.0, 20.0, False),
    "arch/model.toml": ("stable", [], 0.0, 1e-4, True),
    "arch/thin.toml": ("unstable", None, 0.1, 2.0, False),
    "toppling_column/model.toml": ("stable", [], 0.0, 1e-4, True),
    "toppling_column/steeper.toml": ("unstable", [2, 3, 4], 6.0, 6.5, False),
    "tilted_wall/model.toml": ("stable", [], 7.6e-5, 7.8e-5, True),
    "tilted_wall/tilt_27.toml": ("stable", [], 1.7e-3, 1.9e-3, True),
    "tilted_wall/tilt_28.toml": ("unstable", None, 0.25, 0.5, True),
    "tilted_wall/tilt_30.toml": ("unstable", None, 0.25, 0.5, False),
}


def told(*arguments: object) -> dict[str, object]:
    outcome = CliRunner().invoke(cli, [str(a) for a in arguments] + ["--json"])
    assert outcome.exit_code == 0, outcome.output
    answer: dict[str, object] = json.loads(outcome.stdout)
    return answer


def test_every_model_file_is_here() -> None:
    there = {file.relative_to(EXAMPLES).as_posix() for file in EXAMPLES.glob("*/*.toml")}
    missing = set(EXPECTED) - there
    assert not missing
    assert {name.partition("/")[0] for name in EXPECTED} <= {name.partition("/")[0] for name in there}
    for folder in {name.partition("/")[0] for name in EXPECTED}:
        assert {name for name in there if name.startswith(f"{folder}/")} <= set(EXPECTED)


@pytest.mark.parametrize("name", EXPECTED)
def test_verdict_and_number(name: str, tmp_path: Path) -> None:
    status, unstable, least, greatest, admissible = EXPECTED[name]
    answer = told("run", EXAMPLES / name, "-o", tmp_path / "run")
    assert answer["status"] == status
    assert unstable is None or answer["unstable_blocks"] == unstable
    assert least <= answer["stages"][-1]["max_displacement"] <= greatest
    assert told("limit", EXAMPLES / name, "-o", tmp_path / "limit")["admissible"] is admissible


@pytest.mark.parametrize("name", EXPECTED)
def test_the_readme_names_the_file(name: str) -> None:
    folder, _, file = name.partition("/")
    text = (EXAMPLES / folder / "README.md").read_text(encoding="utf-8")
    assert f"bsm-mesh run examples/{name}" in text
    assert f"| {file} |" in text


def test_stratified_slope_on_its_way(tmp_path: Path) -> None:
    """Wang Fig. 4.21: layer 2 has reached the bottom, layer 1 is sliding over it."""
    told("run", EXAMPLES / "03_stratified_slope/model.toml", "-o", tmp_path)
    moved = [
        np.linalg.norm(read_vtu(file).cell_data["displacement"], axis=1)
        for _, file in read_pvd(tmp_path / "blocks.pvd")
    ]
    lower, upper = np.array(moved)[:, 3:9].T, np.array(moved)[:, 9:].T
    between = (np.abs(lower - 2.0) < 1e-2).all(axis=0) & (upper > 2.2).all(axis=0) & (upper < 2.8).all(axis=0)
    assert between.any()


def test_pushed_block_factor_of_the_force(tmp_path: Path) -> None:
    answer = told("limit", EXAMPLES / "02_pushed_block/model.toml", "--load", 1, "-o", tmp_path)
    assert answer["factor"] == pytest.approx(26e3 * math.tan(math.radians(30)) / 30e3, rel=1e-6)


def test_column_topples_at_the_angle_of_statics(tmp_path: Path) -> None:
    answer = told("limit", EXAMPLES / "toppling_column/model.toml", "--tilt", "right", "-o", tmp_path)
    assert answer["tilt"] == pytest.approx(math.degrees(math.atan(1 / 8)) - 7.025, abs=1e-3)


def test_greatest_tilt_of_the_wall(tmp_path: Path) -> None:
    answer = told("limit", EXAMPLES / "tilted_wall/model.toml", "--tilt", "right", "-o", tmp_path)
    assert answer["tilt"] == pytest.approx(24.11, abs=0.01)
