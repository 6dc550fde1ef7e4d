"""The uncertain slope: a run's verdict is that of the formula, and so the probability of failure.

Plane failure with a tension crack (Wyllie and Mah): FS = [cA + (W cos p - U - V sin p) tan phi] / (W sin p + V cos p).
"""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

import bsm_mesh as bsm
from bsm_mesh.model.polygons import polygon_moments
from bsm_mesh.studies.statistics import fails
from bsm_mesh.studies.table import StudyTable

pytest.importorskip("gmsh")

EXAMPLE = Path(__file__).parents[2] / "examples" / "uncertain_slope"
CRACK, TOP, CREST = (10.928, 7.652), (10.928, 12.0), (6.928, 12.0)
WATER, ROCK = 9810.0, 26e3


def factor(table: StudyTable) -> np.ndarray:
    area = polygon_moments(np.array([(0.0, 0.0), CRACK, TOP, CREST]), np.array([0, 4])).area[0]
    length, dip = np.hypot(*CRACK), np.arctan2(CRACK[1], CRACK[0])
    depth = table.numbers("water.table.2.2") - CRACK[1]
    thrust, uplift = WATER * depth**2 / 2, WATER * depth * length / 2
    normal = ROCK * area * np.cos(dip) - uplift - thrust * np.sin(dip)
    resisting = table.numbers("joint.bedding.cohesion") * length + normal * np.tan(
        np.radians(table.numbers("joint.bedding.friction"))
    )
    return resisting / (ROCK * area * np.sin(dip) + thrust * np.cos(dip))


@pytest.mark.slow
def test_the_study_says_what_the_formula_says(tmp_path: Path) -> None:
    for name in ("model.toml", "slope.py"):
        shutil.copy(EXAMPLE / name, tmp_path / name)
    text = (EXAMPLE / "study.toml").read_text(encoding="utf-8")
    assert "runs = 400" in text
    (tmp_path / "study.toml").write_text(text.replace("runs = 400", "runs = 60"))
    done = bsm.study(tmp_path / "study.toml")
    np.testing.assert_array_equal(fails(done.table), factor(done.table) < 1)
    told = done.summary["failure"]
    assert told["interval"][0] < 0.3572 < told["interval"][1]  # of four million draws of the formula
    assert next(effect["key"] for effect in done.summary["effects"]) == "water.table.2.2"
    assert json.loads((done.folder / "summary.json").read_text(encoding="utf-8")) == json.loads(
        json.dumps(done.summary)
    )


def test_the_readme_names_the_commands() -> None:
    text = (EXAMPLE / "README.md").read_text(encoding="utf-8")
    assert "bsm-mesh study examples/uncertain_slope/study.toml" in text
    assert "0.3575" in text
