"""Histories of polyhedra: points, extensometers, blocks and joints, recorded, written, read back and drawn."""

from __future__ import annotations

import csv

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.results import Results
from bsm_mesh.space import polyhedra_at
from tests.scenes.small_case import Case
from tests.unit.test_space_run import SLOPE

HISTORIES = """
[[history]]
name = "top"
point = [1.5, 1, 2.4]

[[history]]
name = "over the joint"
line = [[1, 1, 0.5], [1, 1, 2], [1.5, 1, 2]]

[[history]]
name = "block"
block = 0

[[history]]
name = "J1"
joint = "J1"
"""
HALF = "[gravity]\nhorizontal = 0.05\ntrend = 90\n"


@pytest.fixture
def slope(case: Case) -> Case:
    case.write("slope.toml", (SLOPE + HALF + HISTORIES).replace("over the joint", "over_the_joint"))
    return case


@pytest.mark.heavy
def test_they_are_those_of_the_blocks_that_move(slope: Case) -> None:
    assert slope.run("run", "slope.toml").code == 0
    results = Results.load(slope.folder / "out/slope")
    blocks, stage = results.blocks, results.stages[-1]
    top, line, block, joint = (results.histories[name] for name in ("top", "over_the_joint", "block", "J1"))
    assert top.recorded.quantities == ("u", "v", "w")
    assert block.recorded.quantities == ("u", "v", "w", "rotation")
    moved = stage.displacement[0]
    assert_allclose(block.values[-1, :3], moved[:3])
    assert block["rotation"][-1] == pytest.approx(np.degrees(np.linalg.norm(moved[3:])))
    arm = np.array([1.5, 1, 2.4]) - blocks.moments.centroid[0]
    assert_allclose(top.values[-1], moved[:3] + np.cross(moved[3:], arm), rtol=1e-3, atol=1e-9)
    assert top["u"][-1] > 0 > top["w"][-1]  # east and down
    turn = np.cross(moved[3:], np.array([1, 1, 2]) - blocks.moments.centroid[0])
    assert line["extension_1"][-1] == pytest.approx(moved[2] + turn[2], rel=1e-3)  # the lower block is held
    assert joint["slip"][-1] == pytest.approx(results.stages[-1].contacts.slip.max(), rel=0.2)
    with (slope.folder / "out/slope/history_top.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert float(rows[-1]["w [m]"]) == top["w"][-1]
    assert results.histories["top"].values.shape == (len(rows), 3)


@pytest.mark.heavy
def test_they_are_drawn(slope: Case, drawn_here: None) -> None:
    slope.run("run", "slope.toml")
    only = [word for name in ("histories", "model", "extensometers", "points", "profiles") for word in ("--only", name)]
    assert slope.run("plot", "out/slope", *only).code == 0
    drawn = {path.name for path in (slope.folder / "out/slope/pictures").glob("*.png")}
    assert {"histories.png", "model.png", "extensometers.png", "points.png"} <= drawn
    assert "profiles.png" not in drawn


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        (
            "point = [1.5, 1, 2.4]",
            "point = [1.5, 1, 9]",
            "the point (1.5, 1, 9) lies in no block; the blocks reach from",
        ),
        ("block = 0", "block = 3", "there is no block 3; blocks are numbered 0 to 2"),
        ('joint = "J1"\n', 'joint = "J2"\n', "there is no joint 'J2'"),
        ("point = [1.5, 1, 2.4]", "point = [1.5, 1]", "point"),
        ("block = 0", 'block = 0\nmeasured = ["a.csv"]', "unknown key 'measured'"),
    ],
)
def test_what_cannot_be_recorded_is_refused(slope: Case, old: str, new: str, words: str) -> None:
    text = (slope.folder / "slope.toml").read_text(encoding="utf-8")
    head, name, tail = text.partition("[[history]]")
    slope.write("slope.toml", head + name + tail.replace(old, new, 1))
    slope.refuses("run", "slope.toml", says=[words])


def test_points_of_the_other_dimension_are_refused(slope: Case) -> None:
    model = bsm.load(slope.folder / "slope.toml")
    with pytest.raises(bsm.ModelError, match="a point of this model has 3 coordinates"):
        model.replace(histories=[bsm.History(name="p", point=(1, 1))])
    measured = bsm.Beside(quantity="u", value=0.001, source="survey")
    with pytest.raises(bsm.ModelError, match="measured is for the plane"):
        model.replace(histories=[bsm.History(name="p", point=(1, 1, 1), measured=(measured,))])


def test_a_point_on_a_face_is_in_both_blocks(slope: Case) -> None:
    blocks = bsm.load(slope.folder / "slope.toml").blocks
    assert len(polyhedra_at(blocks, np.array([1.0, 1.0, 1.0]))) == 2  # on the joint
    assert len(polyhedra_at(blocks, np.array([1.0, 1.0, 0.2]))) == 1
    assert len(polyhedra_at(blocks, np.array([1.0, 1.0, 3.1]))) == 0
