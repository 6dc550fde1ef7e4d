"""Results and model files that older versions of the program wrote are read, and tell the same."""

from __future__ import annotations

import json
import zipfile
from pathlib import Path

import numpy as np
import pytest

import bsm_mesh as bsm
from bsm_mesh.folder import older_results
from bsm_mesh.folder.summary import SCHEMA_VERSION
from bsm_mesh.results.records import Status
from tests.scenes.small_case import Case

STORED = Path(__file__).parents[1] / "stored"
SAME = 1e-5  # of the greatest: two states of equilibrium within the tolerance of the solver
RUNS = {"model": Status.STABLE, "linear": Status.NO_VERDICT}
VERSIONS = [*older_results.NEXT, SCHEMA_VERSION]


def unpacked(version: int, folder: Path) -> Path:
    with zipfile.ZipFile(STORED / f"results_schema_{version}.zip") as archive:
        archive.extractall(folder)
    return folder


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("name", RUNS)
def test_what_was_written_is_read(tmp_path: Path, version: int, name: str) -> None:
    folder = unpacked(version, tmp_path) / "out" / name
    told = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    assert told["schema_version"] == version
    results = bsm.Results.load(folder)
    assert results.status is RUNS[name]
    assert results.blocks.joint_names == ("J1",)
    assert results.blocks.rock_names == ("gneiss",)
    for stage, said in zip(results.stages, told["stages"], strict=True):
        assert stage.name == said["name"]
        assert stage.status is RUNS[name]
        assert stage.bolts.names == ("B",)
        np.testing.assert_allclose(stage.max_displacement, said["max_displacement"])
        np.testing.assert_allclose(stage.water[:, :2].sum(axis=0), said["total_water"])
        assert len(stage.water_table) == 1
        assert len(stage.contacts.length) == said["contacts"]
    assert results.check().ok


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("name", RUNS)
def test_a_model_file_of_then_gives_what_it_gave(tmp_path: Path, version: int, name: str) -> None:
    folder = unpacked(version, tmp_path)
    before = bsm.Results.load(folder / "out" / name)
    after = bsm.run(folder / "out" / name / "model.toml", output=tmp_path / "again")  # its mesh is two folders above
    for old, new in zip(before.stages, after.stages, strict=True):
        most = np.abs(old.displacement).max()
        np.testing.assert_allclose(new.displacement, old.displacement, rtol=0, atol=SAME * most)
        assert new.status is old.status


@pytest.mark.slow
@pytest.mark.usefixtures("drawn_here")
def test_what_an_older_one_does_not_say_is_not_known(case: Case) -> None:
    unpacked(3, case.folder)
    results = bsm.Results.load(case.folder / "out" / "model")
    assert np.isnan(results.stages[0].water_gradient).all()
    assert case.run("plot", "out/model", "--only", "joints_state").code == 0
    case.refuses("verify", "out/model", says=["schema version 3", "run its model.toml again"])
    assert case.run("report", "out/model").code == 2  # it states what certificates show


def test_a_changed_summary_of_an_older_version_is_refused(case: Case) -> None:
    unpacked(3, case.folder)
    path = case.folder / "out" / "linear" / "summary.json"
    case.write("out/linear/summary.json", path.read_text(encoding="utf-8").replace('"blocks": 4', '"blocks": 5', 1))
    case.refuses("plot", "out/linear", says=["was changed after the run"])


def test_every_version_between_has_a_step() -> None:
    oldest = min(older_results.NEXT)
    assert sorted(older_results.NEXT) == list(range(oldest, SCHEMA_VERSION))
    assert all((STORED / f"results_schema_{version}.zip").is_file() for version in VERSIONS)
