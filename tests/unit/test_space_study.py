"""Numbers of a model file of three dimensions that vary: in a study, and up to the limit of a key."""

from __future__ import annotations

import json

import numpy as np
import pytest

import bsm_mesh as bsm
from bsm_mesh.modelfile.variation import Variation
from bsm_mesh.studies.table import StudyTable
from tests.scenes.small_case import Case
from tests.unit.test_space_run import SLOPE

STUDY = """
model = "slope.toml"
sampling = "grid"

[vary]
"joint.J1.friction" = { values = [29.9, 30.1] }
"joint_plane.J1.dip" = { values = [29.8, 30] }
"""


@pytest.fixture
def slope(case: Case) -> Case:
    case.write("slope.toml", SLOPE.partition("[[stage]]")[0])
    return case


@pytest.mark.slow
def test_a_block_slides_below_the_friction_of_its_dip_in_a_study(slope: Case) -> None:
    slope.write("study.toml", STUDY)
    outcome = slope.run("study", "study.toml", "--processes", "1")
    assert outcome.code == 0, outcome.err
    table = StudyTable.read(slope.folder / "out/study/study.parquet")
    friction, dip = table.numbers("joint.J1.friction"), table.numbers("joint_plane.J1.dip")
    assert table.count == 4
    assert (table.has_status("unstable") == (friction < dip)).all()
    assert "unstable_area" not in table.columns
    down = table.numbers("unstable_volume")
    assert down == pytest.approx(np.where(friction < dip, 6.0 + 2.0, 0.0))  # the lid lies on the block that slides
    assert (slope.folder / "out/study/pictures/model.png").is_file()


@pytest.mark.slow
def test_the_limit_of_a_key_is_that_of_statics(slope: Case) -> None:
    """With a horizontal part k of its weight towards the dip, the block slides at dip + atan(k) = friction."""
    command = ("safety", "slope.toml", "--vary", "gravity.horizontal", "0", "0.3", "--tolerance", "0.01", "--json")
    told = json.loads(slope.run(*command).out)
    exact = np.tan(np.radians(35 - 30))
    assert told["stable"] <= exact <= told["unstable"]
    assert told["unstable"] - told["stable"] <= 0.011 * 0.3


def test_rock_is_cut_anew_where_a_value_changes_it_and_only_there(slope: Case) -> None:
    variation = Variation(slope.folder / "slope.toml")
    blocks = variation.model({}).model.blocks
    assert variation.model({"joint.J1.friction": 20, "gravity.vertical": 0.1}).model.blocks is blocks
    steeper = variation.model({"joint_plane.J1.dip": 40}).model.blocks
    assert steeper.moments.bulk.sum() == pytest.approx(blocks.moments.bulk.sum())
    assert steeper.moments.centroid[1, 0] != pytest.approx(blocks.moments.centroid[1, 0])
    moved = variation.model({"excavation.lid.to": 1.0, "excavation.lid.from": -1.0}).model.blocks
    assert moved is not blocks


def test_a_water_plane_rises(slope: Case) -> None:
    text = (slope.folder / "slope.toml").read_text(encoding="utf-8")
    slope.write("wet.toml", text + "[water]\nplane = { point = [0, 0, 1] }\n")
    water = Variation(slope.folder / "wet.toml").model({"water.rise": 0.5}).model.water
    assert water is not None
    assert water.plane is not None
    assert water.plane.point == (0, 0, 1.5)


@pytest.mark.parametrize(
    ("key", "words"),
    [
        ("tilt.left", "are for the plane; in space vary gravity.horizontal, with its trend"),
        ("water.rise", r"the model has no water table; give \[water\] plane"),
        ("joint_plane.J1.dipp", "did you mean 'dip'"),
    ],
)
def test_what_cannot_vary_is_refused(slope: Case, key: str, words: str) -> None:
    with pytest.raises(bsm.ModelError, match=words):
        Variation(slope.folder / "slope.toml").check([key])


def test_scatter_from_face_to_face_is_refused(slope: Case) -> None:
    slope.write("study.toml", STUDY + '[scatter]\n"joint.J1.friction" = { deviation = 2 }\n')
    slope.refuses("study", "study.toml", says=["strength from face to face is for the plane"])
