"""The folder of a study: what other studies, models, code or hands left there is noticed, and never replaced."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

import bsm_mesh as bsm
import bsm_mesh.commands.study as app_study
from bsm_mesh.folder.study_folder import RUNS
from tests.scenes.small_case import LOAD, MODEL, Case
from tests.scenes.square_mesh import msh
from tests.scenes.studies import RUNS_OF_STUDY, STUDY, write_study

HOLDS = "mean = 60, deviation = 4, lower = 50, upper = 70"  # friction by which every run is stable, which is quick
FEW = STUDY.replace(f"runs = {RUNS_OF_STUDY}", "runs = 2").replace(
    "mean = 30, deviation = 4, lower = 20, upper = 40", HOLDS
)


@pytest.fixture(scope="module")
def few_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of a study of two runs, without pictures."""
    folder = tmp_path_factory.mktemp("few")
    file = write_study(folder, FEW)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(app_study, "draw_study", lambda *given, **named: [])
        return bsm.study(file, processes=1).folder


@pytest.fixture
def study(case: Case) -> Case:
    write_study(case.folder, FEW)
    return case


@pytest.fixture
def few(study: Case, few_folder: Path) -> Case:
    """Return that study with its runs done."""
    shutil.copytree(few_folder, study.folder / "out/study")
    return study


def test_another_study_in_the_same_folder_is_refused(few: Case) -> None:
    study = few
    study.write("study.toml", FEW.replace("runs = 2", "runs = 3"))
    study.refuses("study", "study.toml", "-q", says=["out/study holds the runs of another study", "-o, or remove"])
    study.write("study.toml", FEW)
    study.write("model.toml", MODEL.replace(LOAD, "").replace("10 GPa", "11 GPa"))
    study.refuses("study", "study.toml", "-q", says=["the model file was changed"])
    study.write("model.toml", MODEL.replace(LOAD, ""))
    study.write("mesh.msh", msh([(0.5, 0.0), *[(x, y) for y in range(3) for x in range(3)][1:]]))
    study.refuses("study", "study.toml", "-q", says=["the model's mesh"])


def test_changed_answers_and_changed_code_are_noticed(few: Case, monkeypatch: pytest.MonkeyPatch) -> None:
    journal = few.folder / "out/study" / RUNS
    before = journal.read_text()
    journal.write_text(before.replace('"max_displacement": ', '"max_displacement": 1', 1))
    few.refuses("study", "study.toml", "-q", says=["line 2 is not as this study wrote it", "are done again"])
    journal.write_text(before)
    monkeypatch.setattr(app_study, "code_digest", lambda: "0")
    few.refuses("study", "study.toml", "-q", says=["they were done by another state of bsm-mesh"])
    assert journal.read_text() == before


def test_what_is_of_no_study_is_never_replaced(study: Case) -> None:
    study.write("mine/notes.txt", "mine")
    study.refuses("study", "study.toml", "-o", "mine", "-q", says=["mine holds files that no study wrote (notes.txt)"])
    study.refuses("study", "study.toml", "-o", "mine/notes.txt", "-q", says=["is not a folder"])
