"""Calls, folders, disks and results that cannot be used: one message, exit code 2, as in test_bad_input."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from small_case import FILE, JUNK, LOAD, MODEL, Case, check_refusal, run_process
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridWriter


def test_new_and_demo_leave_what_is_there_alone(case: Case) -> None:
    case.refuses("new", "tunel", "x", says=["there is no starter 'tunel'", "did you mean 'tunnel'"])
    case.refuses("new", "tunnel", ".", says=["exists and is not empty", "name a new folder"])
    case.refuses("new", "tunnel", "mesh.msh", says=["name a new folder"])
    case.refuses("demo", "-o", ".", says=["exists and is not empty", "name a new folder"])


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["rnu"], ["No such command 'rnu'", "run"]),
        (["run", "model.toml", "--jsn"], ["No such option", "--json"]),
        (["run"], ["Missing argument 'MODEL'"]),
        (["run", "model.toml", "b.toml"], ["unexpected extra argument"]),
        (["compare", "model.toml", "--order", "3"], ["--order", "1<=x<=2"]),
    ],
)
def test_usage(case: Case, arguments: list[str], words: list[str]) -> None:
    outcome = case.run(*arguments)
    assert (outcome.code, outcome.out, outcome.new) == (2, "", [])
    assert all(word in outcome.err for word in words)
    assert "Traceback" not in outcome.err


@pytest.mark.parametrize("command", ["run", "compare"])
def test_output_folders_that_cannot_be(case: Case, command: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Told before the solution, not after it."""
    monkeypatch.setattr("bsm_mesh.app.commands.run", lambda *_: pytest.fail("was solved first"))
    case.refuses(command, "model.toml", "-o", "mesh.msh", says=["cannot write results to mesh.msh", "not a folder"])
    case.refuses(command, "model.toml", "-o", "mesh.msh/out", says=["mesh.msh is not a folder"])
    monkeypatch.setattr(os, "access", lambda _, mode: not mode & os.W_OK)  # a superuser may write everywhere
    case.refuses(command, "model.toml", says=["is not writable", "choose another folder"])


def test_a_model_file_is_never_replaced(case: Case) -> None:
    """The model as run goes to the output folder as model.toml; that must not be anybody's own file."""
    text = (case.folder / "model.toml").read_bytes()
    outcome = case.run("run", "model.toml", "-o", ".", "-q")
    assert outcome.code == 0
    assert (case.folder / "model.toml").read_bytes() == text
    case.write("other.toml", text)
    case.refuses("run", "other.toml", "-o", ".", says=["model.toml is not from a run and would be replaced"])
    assert case.run("run", "other.toml", "-o", "out", "-q").code == 0
    assert case.run("run", "model.toml", "-o", "out", "-q").code == 0  # that one came from a run


def test_a_full_disk_leaves_nothing_half_written(case: Case, monkeypatch: pytest.MonkeyPatch) -> None:
    assert case.run("run", "model.toml", "-q").code == 0

    def full(path: Path, text: str) -> None:
        raise OSError(28, "No space left on device", str(path))

    monkeypatch.setattr("bsm_mesh.app.storage.write_text", full)
    outcome = case.run("run", "model.toml", "-q")
    assert outcome.code == 2
    assert "cannot write results to out: No space left on device; choose another folder" in outcome.err
    assert not list(case.folder.rglob("*.tmp"))
    assert not (case.folder / "out/summary.json").exists()  # the mark of a complete run
    case.refuses("plot", "out", says=["out holds no results (no summary.json)"])


def test_a_vtu_that_cannot_be_written(case: Case, monkeypatch: pytest.MonkeyPatch) -> None:
    class Failing(vtkXMLUnstructuredGridWriter):  # type: ignore[misc]
        def Write(self) -> int:  # noqa: N802 - VTK's name
            return 0

    monkeypatch.setattr("vtkmodules.vtkIOXML.vtkXMLUnstructuredGridWriter", Failing)
    outcome = case.run("run", "model.toml", "-q")
    assert outcome.code == 2
    assert "blocks_0000.vtu" in outcome.err
    assert list((case.folder / "out").iterdir()) == []


def test_pardiso_where_it_is_not_installed(case: Case, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("bsm_mesh.solve.algebra.pardiso._library", lambda: None)
    case.change(LOAD, '[solver]\nlinear_solver = "pardiso"\n')
    case.refuses("run", "model.toml", says=["needs the package mkl", "pip install", "choose 'superlu'"])


def test_no_continuum_of_rigid_rock(case: Case) -> None:
    case.change("young", "stiffness = 'rigid'\nyoung")
    case.change(FILE, FILE + 'default_joint = "J1"\n')
    assert case.run("check", "model.toml").code == 0
    case.refuses("compare", "model.toml", says=["rock 'gneiss': a continuum solution needs an elastic rock"])


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (None, ["out holds no results", "give the output folder of a run"]),
        ("[1, 2]", ["is not from a run of bsm-mesh"]),
        ("null", ["is not from a run of bsm-mesh"]),
        ('{"name": "npm"}', ["is not from a run of bsm-mesh"]),
        ('{"schema_version": 1}', ["is not complete", "run the model again"]),
        ('{"schema_version": 99}', ["schema version 99; this is 1", "run again"]),
        ('{"schema_ver', ["summary.json is damaged"]),
        (JUNK, ["summary.json is damaged"]),
    ],
)
def test_plot_of_what_is_no_run(case: Case, content: str | bytes | None, words: list[str]) -> None:
    if content is not None:
        case.write("out/summary.json", content)
    case.refuses("plot", "out", says=words)


@pytest.mark.parametrize("name", ["blocks.pvd", "blocks_0000.vtu"])
def test_plot_of_a_damaged_run(case: Case, name: str) -> None:
    assert case.run("run", "model.toml", "-q").code == 0
    path = case.folder / "out" / name
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) // 2])
    message = case.refuses("plot", "out", says=[name, "PVD" if "pvd" in name else "not a complete VTU file"])
    path.unlink()
    message += case.refuses("plot", "out", says=[name, "there is no such file"])
    assert "apt-get" not in message  # the renderer is not to blame


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["run", "bad.toml", "-o", "new/folder", "--json"], ["bad.toml", "does not convert to Pa"]),
        (["check", "junk.toml"], ["junk.toml: not a text file"]),
        (["compare", "gone.toml"], ["gone.toml: there is no such file"]),
        (["mesh", "nope"], ["there is no case 'nope'"]),
        (["plot", "."], [". holds no results"]),
        (["new", "tunnel", "."], ["exists and is not empty"]),
    ],
)
def test_in_a_process_of_its_own(case: Case, arguments: list[str], words: list[str]) -> None:
    case.write("bad.toml", MODEL.replace("10 GPa", "10 GPa/m"))
    case.write("junk.toml", JUNK)
    check_refusal(run_process(case.folder, *arguments), words)
