"""Calls, folders, disks and results that cannot be used: one message, exit code 2, as in test_bad_input."""

from __future__ import annotations

import os

import pytest
from vtkmodules.vtkCommonMisc import vtkErrorCode
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridWriter

from bsm_mesh.results import Results
from tests.file_operations import watched
from tests.scenes.small_case import FILE, JUNK, LOAD, MODEL, Case, check_refusal, run_process


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
    for solver in ("commands.comparing.run", "folder.run_file.solve"):
        monkeypatch.setattr(f"bsm_mesh.{solver}", lambda *_: pytest.fail("was solved first"))
    case.refuses(command, "model.toml", "-o", "mesh.msh", says=["cannot write results to mesh.msh", "not a folder"])
    case.refuses(command, "model.toml", "-o", "mesh.msh/out", says=["mesh.msh is not a folder"])
    monkeypatch.setattr(os, "access", lambda _, mode: not mode & os.W_OK)  # a superuser may write everywhere
    case.refuses(command, "model.toml", says=["is not writable", "choose another folder"])


@pytest.mark.heavy
def test_a_run_writes_only_into_a_folder_of_its_own(case: Case) -> None:
    """The user's own model.toml and bolts.csv carry the names of results; so may anything else."""
    case.write("bolts.csv", "start_x,start_y,end_x,end_y,diameter\n0.5,0.2,0.5,1.8,0.02\n")
    case.change(LOAD, f'{LOAD}[[bolt]]\ntable = "bolts.csv"\n[output]\nfolder = "."\n')
    case.write("other.toml", (case.folder / "model.toml").read_bytes())
    words = [" holds files and is no results folder", "no .bsm-mesh-results", "choose a new or an empty folder"]
    for arguments in (["run", "model.toml"], ["run", "other.toml"], ["compare", "model.toml"]):
        case.refuses(*arguments, says=words)
    case.write("elsewhere/notes.txt", "mine")
    for command in ("run", "compare", "limit"):
        case.refuses(command, "model.toml", "-o", "elsewhere", says=words)
    assert case.run("run", "model.toml", "-o", "out", "-q").code == 0
    assert case.run("run", "other.toml", "-o", "out", "-q").code == 0  # that one came from a run


def test_variants_beside_each_other_do_not_replace_each_other(case: Case) -> None:
    case.write("steep.toml", MODEL.replace("1 MPa", "2 MPa"))
    for name in ("model", "steep"):
        assert f"written to out/{name}: " in case.run("run", f"{name}.toml", "-q").out
    one, two = (Results.load(f"out/{name}").stages[-1].total_load[1] for name in ("model", "steep"))
    assert two - one == pytest.approx(-2e6)


@pytest.mark.heavy
def test_what_a_run_reads_in_its_own_folder_stays(case: Case) -> None:
    """As where one changes the model as run, there, and runs it again: neither it nor its mesh is eaten."""
    assert case.run("run", "model.toml", "-q").code == 0
    (case.folder / "mesh.msh").rename(case.folder / "out/model/mesh.msh")
    changed = (case.folder / "out/model/model.toml").read_text().replace("../../mesh.msh", "mesh.msh") + "# mine\n"
    case.write("out/model/model.toml", changed)
    for _ in range(2):
        assert case.run("run", "out/model/model.toml", "-q").code == 0
        assert (case.folder / "out/model/model.toml").read_text() == changed
    assert Results.load("out/model").status == "stable"
    case.write("out/model/history.csv", "start_x,start_y,end_x,end_y,diameter\n0.5,0.2,0.5,1.8,0.02\n")
    case.write("out/model/model.toml", f'{changed}[[bolt]]\ntable = "history.csv"\n')
    says = ["out/model/history.csv is read by this model, and a run writes a file of that name; keep it elsewhere"]
    case.refuses("run", "out/model/model.toml", says=says)


def kept_as_arrays(new: list[str]) -> bool:
    """Return whether what was solved stays beside the results, as arrays at least, and nothing else is new."""
    beside = [name for name in new if name != "out"]
    return "out/model.interrupted/certificate_0000.npz" in beside and all(
        name.split("/")[:2] == ["out", "model.interrupted"] for name in beside
    )


@pytest.mark.parametrize("operation", ["write", "settle"])
def test_a_full_disk_leaves_the_former_results(case: Case, operation: str) -> None:
    assert case.run("run", "model.toml", "-q").code == 0
    case.change("1 MPa", "2 MPa")

    def full(done: str, path: str, *_: str) -> None:
        if done == operation:
            raise OSError(28, "No space left on device", path)

    with watched(full):
        outcome = case.run("run", "model.toml", "-q")
        added = case.run("compare", "model.toml", "-q")
    assert outcome.code == added.code == 2
    says = "cannot write results to out/model: No space left on device; free space there, or choose a folder on another"
    assert says in outcome.err
    assert outcome.new == [] if operation == "write" else kept_as_arrays(outcome.new)
    assert "out/model holds the former results" in outcome.err
    if operation == "write":
        assert "cannot write out/model/compare.vtu: No space left on device; free space there" in added.err
    assert Results.load("out/model").stages[-1].total_load[1] == pytest.approx(-2.104e6)


def test_a_vtu_that_cannot_be_written(case: Case, monkeypatch: pytest.MonkeyPatch) -> None:
    class Failing(vtkXMLUnstructuredGridWriter):  # type: ignore[misc]
        def Write(self) -> int:  # noqa: N802 - VTK's name
            return 0

    monkeypatch.setattr("vtkmodules.vtkIOXML.vtkXMLUnstructuredGridWriter", Failing)
    outcome = case.run("run", "model.toml", "-q")
    assert outcome.code == 2
    assert "blocks_0000.vtu" in outcome.err
    assert kept_as_arrays(outcome.new)


def test_a_disk_that_is_full_for_vtk(case: Case, monkeypatch: pytest.MonkeyPatch) -> None:
    """It tells that by a number of its own."""

    class Full(vtkXMLUnstructuredGridWriter):  # type: ignore[misc]
        def Write(self) -> int:  # noqa: N802 - VTK's name
            return 0

        def GetErrorCode(self) -> int:  # noqa: N802
            return int(vtkErrorCode.OutOfDiskSpaceError)

    monkeypatch.setattr("vtkmodules.vtkIOXML.vtkXMLUnstructuredGridWriter", Full)
    outcome = case.run("run", "model.toml", "-q")
    assert outcome.code == 2
    assert "cannot write results to out/model: No space left on device; free space there" in outcome.err
    assert kept_as_arrays(outcome.new)


def test_pardiso_where_it_is_not_installed(case: Case, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("bsm_mesh.solve.algebra.pardiso._library", lambda: None)
    case.change(LOAD, '[solver]\nlinear_solver = "pardiso"\n')
    case.refuses("run", "model.toml", says=["needs the package mkl", "pip install", "choose 'superlu'"])


def test_no_continuum_of_rigid_rock_without_joints(case: Case) -> None:
    case.change("young", "stiffness = 'rigid'\nyoung")
    case.change(FILE, FILE + 'default_joint = "J1"\n')
    assert case.run("check", "model.toml").code == 0
    case.refuses(
        "compare", "model.toml", "--no-joints", says=["rock 'gneiss': a continuum solution needs an elastic rock"]
    )


@pytest.mark.parametrize("command", ["plot", "verify", "report", "view", "paraview"])
def test_the_folder_of_a_model_is_answered_with_that_of_its_results(case: Case, command: str) -> None:
    says = [". holds no results (no summary.json); give the output folder of a run"]
    assert "results are in" not in case.refuses(command, ".", "-q", says=says)
    for name in ("out/model", "other"):
        case.write(f"{name}/summary.json", '{"run": 1, "status": "stable"}')
    case.refuses(command, ".", "-q", says=[*says, "; results are in other, out/model"])
    case.refuses(command, "model.toml", "-q", says=["model.toml is no folder", "; results are in other, out/model"])


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (None, ["out does not exist", "give the output folder of a run"]),
        ("[1, 2]", ["is not from a run of bsm-mesh"]),
        ("null", ["is not from a run of bsm-mesh"]),
        ('{"study": "0f", "runs": 8}', ["is of a study; give the output folder of a run", "`bsm-mesh report out`"]),
        ('{"name": "npm"}', ["is not from a run of bsm-mesh"]),
        ('{"schema_version": 4}', ["is not complete", "run the model again"]),
        ('{"schema_version": 99}', ["was written with schema version 99; bsm-mesh ", "reads 3 and 4: update bsm-mesh"]),
        (
            '{"schema_version": 5, "versions": {"bsm-mesh": "2.0"}}',
            ["was written by bsm-mesh 2.0 with schema version 5"],
        ),
        ('{"schema_version": 2}', ["schema version 2; ", "reads 3 and 4: run its model.toml again"]),
        ('{"schema_version": "4"}', ["run its model.toml again"]),
        ('{"schema_ver', ["summary.json is damaged"]),
        (JUNK, ["summary.json is damaged"]),
    ],
)
def test_plot_of_what_is_no_run(case: Case, content: str | bytes | None, words: list[str]) -> None:
    if content is not None:
        case.write("out/summary.json", content)
    case.refuses("plot", "out", says=words)


@pytest.mark.heavy
@pytest.mark.parametrize("name", ["blocks.pvd", "blocks_0000.vtu"])
def test_plot_of_a_damaged_run(case: Case, name: str) -> None:
    assert case.run("run", "model.toml", "-q").code == 0
    path = case.folder / "out/model" / name
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) // 2])
    message = case.refuses("plot", "out/model", says=[name, "is damaged, or was changed after the run"])
    path.unlink()
    message += case.refuses("plot", "out/model", says=[name, "there is no such file"])
    assert "apt-get" not in message  # the renderer is not to blame


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["run", "bad.toml", "-o", "new/folder", "--json"], ["bad.toml", "does not convert to Pa"]),
        (["check", "junk.toml"], ["junk.toml: not a text file"]),
        (["compare", "gone.toml"], ["gone.toml: there is no such file"]),
        (["mesh", "nope"], ["there is no case 'nope'"]),
        (["plot", "."], [". holds no results"]),
        (["report", "model.toml"], ["model.toml is no folder; give the output folder of a run"]),
        (["new", "tunnel", "."], ["exists and is not empty"]),
    ],
)
def test_every_command_refuses(case: Case, arguments: list[str], words: list[str]) -> None:
    case.write("bad.toml", MODEL.replace("10 GPa", "10 GPa/m"))
    case.write("junk.toml", JUNK)
    case.refuses(*arguments, says=words)


@pytest.mark.heavy
def test_in_a_process_of_its_own(case: Case) -> None:
    case.write("bad.toml", MODEL.replace("10 GPa", "10 GPa/m"))
    outcome = run_process(case.folder, "run", "bad.toml", "-o", "new/folder", "--json")
    check_refusal(outcome, ["bad.toml", "does not convert to Pa"])
