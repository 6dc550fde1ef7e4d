"""Folders whose names are no text, and what fails once a stage is solved: nothing is solved without success."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import numpy as np
import pytest

import bsm_mesh as bsm
from bsm_mesh.converters import result_files
from bsm_mesh.errors import ModelError
from bsm_mesh.folder import storage
from bsm_mesh.folder.added_files import AddedFiles
from bsm_mesh.folder.results_folder import ResultsFolder
from bsm_mesh.folder.run_writer import RunWriter
from bsm_mesh.folder.study_folder import StudyFolder
from tests.scenes.models import model_of
from tests.scenes.shapes import grid
from tests.scenes.small_case import LINEAR, MODEL, Case, tree
from tests.scenes.square_mesh import msh

LATIN = "B\udcf6schung"  # as Python names a folder of these bytes: B, f6, s, c, h ...


@pytest.fixture
def odd(tmp_path: Path) -> Path:
    """Return a folder whose name is Latin-1."""
    folder = tmp_path / LATIN
    try:
        folder.mkdir()
    except (OSError, UnicodeError):
        pytest.skip("this file system takes texts only")
    return folder


def test_a_folder_that_is_no_text_is_refused_before_anything_is_solved(
    case: Case, odd: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    solved: list[object] = []
    monkeypatch.setattr("bsm_mesh.folder.run_file.solve", lambda *given: solved.append(given))
    (odd / "model.toml").write_text(MODEL + LINEAR)
    (odd / "mesh.msh").write_bytes(content if isinstance(content := msh(), bytes) else content.encode())
    says = ["is no text in UTF-8 (Latin-1, perhaps?); rename that folder, or choose another one"]
    before = tree(odd)
    case.refuses("run", str(odd / "model.toml"), "-q", says=says)
    monkeypatch.chdir(odd)
    for command in ("run", "compare", "safety"):
        case.refuses(command, "model.toml", "-q", says=says)
    case.refuses("mesh", "brick-wall", "-o", "a.msh", says=says)
    out = str(case.folder / "out")  # elsewhere: but the model file there names the mesh
    case.refuses("run", "model.toml", "-q", "-o", out, says=["could not name the files of this model"])
    assert tree(odd) == before
    assert not solved
    assert not Path(out).exists()


def test_everything_that_writes_a_folder_refuses_it(odd: Path) -> None:
    for refuse in (
        lambda: ResultsFolder(odd / "out").refuse(),
        lambda: AddedFiles(odd / "out"),
        lambda: StudyFolder(odd / "out", {"study": "a"}).refuse_others(),
        lambda: bsm.run(model_of(grid(1, 2), fixed=(0,)), bsm.Options(scheme="linear")).save(odd / "out"),
    ):
        with pytest.raises(ModelError, match="is no text in UTF-8"):
            refuse()
    assert os.listdir(odd) == []


@pytest.mark.parametrize("error", [UnicodeEncodeError("utf-8", "\udcf6", 0, 1, "no"), MemoryError(), RuntimeError("x")])
def test_what_was_solved_is_there_though_a_file_cannot_be_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, error: Exception
) -> None:
    results = bsm.run(model_of(grid(1, 2), fixed=(0,)))

    def fails(*given: object, **options: object) -> None:
        raise error

    monkeypatch.setattr(result_files, "write_vtu", fails)
    with pytest.raises(type(error)) as caught, RunWriter(tmp_path / "out") as writer:
        writer.stage(results)
    assert any("solved, and in" in note and "certificate_0000.npz" in note for note in caught.value.__notes__)
    with np.load(tmp_path / "out.interrupted/certificate_0000.npz") as arrays:
        np.testing.assert_array_equal(arrays["displacement"], results.stages[0].displacement)
    monkeypatch.undo()
    results.save(tmp_path / "out")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["out"]
    assert storage.load_results(tmp_path / "out").status == results.status


@pytest.mark.skipif(sys.platform != "linux", reason="names of bytes")
def test_results_in_such_a_folder_are_read(tmp_path: Path, odd: Path) -> None:
    """They came there when the folder was given another name."""
    results = bsm.run(model_of(grid(1, 2), fixed=(0,)))
    results.save(tmp_path / "out").rename(odd / "out")
    assert storage.load_results(odd / "out").status == results.status
