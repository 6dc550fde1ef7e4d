"""A model file run from Python: what the command does, and what can be stated otherwise."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_array_equal

import bsm_mesh as bsm
from bsm_mesh.converters.vtk_files import read_pvd
from tests.scenes.small_case import MODEL, SUPPORT, Case
from tests.scenes.square_mesh import CURVES, msh

SOLVER = '[solver]\nscheme = "linear"\ntolerance = 1e-8\n'
STEPS = '[output]\nfolder = "results"\nsnapshots = "steps"\n'


def files(folder: Path) -> set[str]:
    return {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}


@pytest.mark.parametrize("kind", [str, pytest.param(Path, marks=pytest.mark.heavy)])
def test_it_does_what_the_command_does(case: Case, kind: type) -> None:
    """Solver, folder and snapshots are the file's."""
    case.write("model.toml", MODEL + "[solver]\ntolerance = 1e-8\n" + STEPS)
    results = bsm.run(kind("model.toml"))
    assert (results.scheme, results.tolerance) == ("continuation", 1e-8)
    written = case.folder / "results"
    assert len(read_pvd(written / "blocks.pvd")) == len(results.stages[0].steps)
    assert case.run("run", "model.toml", "-o", "by_command", "-q").code == 0
    assert files(written) == files(case.folder / "by_command")
    assert (written / "model.toml").read_text() == (case.folder / "by_command/model.toml").read_text()
    theirs = bsm.Results.load("by_command")
    assert_array_equal(bsm.Results.load("results").stages[0].displacement, theirs.stages[0].displacement)
    assert_array_equal(results.stages[0].displacement, theirs.stages[0].displacement)


def test_the_folder_lies_beside_the_file(case: Case, monkeypatch: pytest.MonkeyPatch) -> None:
    (case.folder / "elsewhere").mkdir()
    monkeypatch.chdir(case.folder / "elsewhere")
    bsm.run("../model.toml")
    assert (case.folder / "out/model/summary.json").is_file()
    assert not files(case.folder / "elsewhere")


def test_another_folder_or_none(case: Case) -> None:
    before = files(case.folder)
    assert bsm.run("model.toml", output=False).status == "stable"
    assert files(case.folder) == before
    bsm.run("model.toml", output="other")
    assert {name.partition("/")[0] for name in files(case.folder) - before} == {"other"}


def test_options_that_are_given_win_and_are_what_is_written(case: Case) -> None:
    case.write("model.toml", MODEL + SOLVER)
    results = bsm.run("model.toml", bsm.Options(scheme="continuation", tolerance=1e-5))
    assert (results.scheme, results.tolerance) == ("continuation", 1e-5)
    again = bsm.run("out/model/model.toml", output=False)
    assert (again.scheme, again.tolerance) == ("continuation", 1e-5)
    assert_array_equal(again.stages[0].displacement, results.stages[0].displacement)


def test_observers_are_told_too(case: Case) -> None:
    case.write("model.toml", MODEL + STEPS)
    steps, reports, seen = [], [], []
    results = bsm.run("model.toml", None, steps.append, reports.append, lambda record, now: seen.append(now().status))
    assert tuple(steps) == results.stages[0].steps
    assert "writing results" in reports
    assert len(seen) == len(steps)
    assert len(read_pvd(case.folder / "results/blocks.pvd")) == len(steps)


def test_what_was_mended_is_warned_of_where_it_is_called(case: Case) -> None:
    case.write("mesh.msh", msh(curves={**CURVES, "boundary:middle": [(3, 4)]}))
    case.write("model.toml", MODEL + '\n[[load]]\nboundary = "middle"\npressure = "1 kPa"\n')
    for call in (lambda: bsm.run("model.toml", output=False), lambda: bsm.load("model.toml")):
        with pytest.warns(bsm.MeshWarning, match="middle") as told:
            call()
        assert {warning.filename for warning in told} == {__file__}


def test_a_model_that_is_loaded_brings_its_solver(case: Case) -> None:
    """Also when it is changed; its results are written by those who want them."""
    case.write("model.toml", MODEL + SOLVER)
    before = files(case.folder)
    model = bsm.load("model.toml")
    assert model.options == bsm.Options(scheme="linear", tolerance=1e-8)
    changed = model.replace(gravity_direction=-80.0)
    for one in (model, changed):
        results = bsm.run(one)
        assert (results.scheme, results.tolerance) == ("linear", 1e-8)
    assert bsm.run(model, bsm.Options()).scheme == "continuation"
    assert files(case.folder) == before
    assert model == model.replace(options=None)
    assert bsm.run(model.replace(options=None)).scheme == "continuation"


def test_faults_are_told_with_the_file(case: Case) -> None:
    case.change(SUPPORT, "")
    with pytest.raises(bsm.ModelError, match=r"^model.toml: the model is free to move in any direction"):
        bsm.run("model.toml")
    assert files(case.folder) == {"model.toml", "mesh.msh"}


def test_a_folder_that_is_refused_before_anything_is_solved(case: Case) -> None:
    case.write("out/model/model.toml", "mine = 1\n")
    with pytest.raises(bsm.ModelError, match=r"out/model holds files and is no results folder of bsm-mesh"):
        bsm.run("model.toml", report=lambda text: pytest.fail(text) if text == "contacts" else None)
    outcome = case.run("check", "model.toml")
    assert outcome.code == 0
    assert "note: to run it give another folder (-o): " in outcome.out
    assert any("-o" in note for note in json.loads(case.run("check", "model.toml", "--json").out)["notes"])


@pytest.mark.parametrize(
    ("arguments", "given", "words"),
    [
        ((1.0,), {}, "float is neither a bsm.Model nor the path"),
        (("model.toml",), {"output": True}, "output = True must be a folder, or False"),
        (("model.toml", {"scheme": "linear"}), {}, "must be bsm.Options"),
    ],
)
def test_what_cannot_be_run(case: Case, arguments: tuple[object, ...], given: dict[str, object], words: str) -> None:
    with pytest.raises(bsm.ModelError, match=words):
        bsm.run(*arguments, **given)
    assert files(case.folder) == {"model.toml", "mesh.msh"}


def test_output_goes_with_a_file(case: Case) -> None:
    model = bsm.load("model.toml")
    with pytest.raises(bsm.ModelError, match=r"results\.save\(folder\)"):
        bsm.run(model, output="out")
    assert np.isfinite(bsm.run(model).stages[0].displacement).all()
