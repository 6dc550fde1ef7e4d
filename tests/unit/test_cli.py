"""The command line with good input: what is on stdout, on stderr, on disk, and the exit code."""

from __future__ import annotations

import csv
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import bsm_mesh as bsm
from bsm_mesh.converters.vtk_files import read_pvd
from bsm_mesh.results import Results
from tests.scenes.small_case import GEOMETRY, MODEL, Case, command, environment, tree

STAGE_KEYS = "name status steps newton_iterations factorizations residual max_displacement unstable_blocks"
STAGE_KEYS += " total_load total_reaction seconds"


def test_run_writes_the_whole_folder(case: Case) -> None:
    outcome = case.run("run", "model.toml")
    assert outcome.code == 0
    series = ("blocks", "contacts", "joints", "supports")
    files = {*(f"{kind}.pvd" for kind in series), *(f"{kind}_0000.vtu" for kind in series)}
    files |= {"history.csv", "summary.json", "model.toml", ".bsm-mesh-results"}
    files |= {"certificate.json", "certificate_0000.npz"}
    made = {f"out/model/{name}" for name in files}
    assert set(outcome.new) == made | {"out", "out/model"}
    assert "stable" in outcome.out
    assert "time of the solution" in outcome.out
    assert "stage 0, step 1: unbalanced force" in outcome.err  # progress, as plain lines
    for kind in series:
        assert read_pvd(case.folder / "out/model" / f"{kind}.pvd") == [
            (0.0, case.folder / "out/model" / f"{kind}_0000.vtu")
        ]


def test_json_is_all_there_is_on_stdout(case: Case) -> None:
    outcome = case.run("run", "model.toml", "--json")
    told = json.loads(outcome.out)
    assert outcome.err == ""
    assert (told["status"], told["folder"], told["notes"]) == ("stable", "out/model", [])
    assert json.loads(case.run("check", "model.toml", "--json").out)["blocks"] == 4
    assert json.loads(case.run("compare", "model.toml", "--json").out)["stages"]


LOAD = 4 * 26e3 + 2 * 1e6  # weights and the pressure on top [N/m]


def test_summary(case: Case) -> None:
    case.change(MODEL, MODEL + '[solver]\nscheme = "linear"\n')
    case.run("run", "model.toml", "-q")
    told = json.loads((case.folder / "out/model/summary.json").read_text())
    assert {"schema_version", "versions", "model_hash", "linear_solver", "status", "stages"} <= set(told)
    assert told["model_hash"] == bsm.load("model.toml").digest
    (stage,) = told["stages"]
    assert set(STAGE_KEYS.split()) <= set(stage)
    np.testing.assert_allclose(stage["total_load"], [0, -LOAD], rtol=1e-12, atol=1e-3)
    np.testing.assert_allclose(stage["total_reaction"], [0, LOAD], rtol=1e-12, atol=1e-3)
    (row,) = history(case)
    assert stage["steps"] == 1
    assert float(row["residual"]) == stage["residual"] < 1e-9


def test_summary_of_the_default_scheme(case: Case) -> None:
    case.run("run", "model.toml", "-q")
    (stage,) = json.loads((case.folder / "out/model/summary.json").read_text())["stages"]
    np.testing.assert_allclose(stage["total_load"], [0, -LOAD], rtol=1e-12, atol=1e-3)
    np.testing.assert_allclose(stage["total_reaction"], [0, LOAD], rtol=1e-6, atol=1e-3)  # the tolerance
    rows = history(case)
    assert len(rows) == stage["steps"] == 2  # the second confirms the first
    assert float(rows[-1]["residual"]) == stage["residual"] < 1e-6


def history(case: Case) -> list[dict[str, str]]:
    """Return the rows of history.csv."""
    with (case.folder / "out/model/history.csv").open() as file:
        return list(csv.DictReader(file))


@pytest.mark.heavy
def test_the_model_as_run_gives_the_same_again(case: Case) -> None:
    case.change(MODEL[MODEL.index("[[support]]") :], SUPPORTED)
    first = case.run("run", "model.toml", "-q")
    again = case.run("run", "out/model/model.toml", "-q", "-o", "again")
    assert (first.code, again.code) == (0, 0)
    one, two = Results.load("out/model"), Results.load("again")
    assert one.model_digest == two.model_digest
    np.testing.assert_array_equal(one.stages[0].displacement, two.stages[0].displacement)
    in_place = case.run("run", "out/model/model.toml", "-q")  # into the folder in which it is stable
    assert in_place.code == 0
    assert "out/model/model.toml" not in in_place.new


SUPPORTED = """\
[[support]]
boundary = "bottom"
fix = "normal"
[[support]]
point = ["0 mm", 0]
fix = ["x"]
[[support]]
boundary = "top"
direction = "90 deg"
displacement = "-1 mm"
[[load]]
boundary = "top"
traction = ["10 kPa", ["1 kPa", 0, "-2 kPa/m"]]
[[load]]
block = 3
point = [1.5, "150 cm"]
force = ["1 kN/m", -2]
[gravity]
direction = -60
[solver]
linear_solver = "superlu"
"""


def test_toml_and_python_build_equal_models(case: Case) -> None:
    case.change(MODEL[MODEL.index("[[support]]") :], SUPPORTED)
    built = bsm.load("model.toml")
    square = np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)])
    blocks = bsm.Blocks.from_polygons([square + np.array((x, y)) for y in (0, 1) for x in (0, 1)], rock="gneiss")
    blocks = blocks.with_joint("J1", lambda x, y: np.abs(y - 1) < 1e-9)
    blocks = blocks.with_boundary("bottom", lambda x, y: y < 1e-9).with_boundary("top", lambda x, y: y > 2 - 1e-9)
    said = bsm.Model(
        blocks=blocks,
        rocks=[bsm.Rock("gneiss", unit_weight=26e3, young=10e9, poisson=0.25)],
        joints=[bsm.Joint("J1", normal_stiffness=5e9, shear_stiffness=1e9, law=bsm.Patton(friction=35))],
        supports=[
            bsm.NormalRoller(boundary="bottom"),
            bsm.Roller(point=(0, 0), direction=0),
            bsm.PrescribedDisplacement(boundary="top", direction=90, displacement=-1e-3),
        ],
        loads=[
            bsm.Traction(boundary="top", traction=(10e3, (1e3, 0, -2e3))),
            bsm.PointLoad(block=3, point=(1.5, 1.5), force=(1e3, -2)),
        ],
        gravity_direction=-60,
    )
    assert built == said
    assert built.digest == said.digest


def test_check_tells_what_is_in_the_model(case: Case) -> None:
    outcome = case.run("check", "model.toml")
    assert outcome.code == 0
    assert outcome.new == []
    words = (
        "the model is valid",
        "rock:gneiss: 4 blocks",
        "joint:J1: 4 block edges",
        "boundary:top: 2 block edges",
        "boundary top",
        "104 kN/m",
    )
    assert all(word in outcome.out for word in words)


def test_compare_with_joints_says_so(case: Case) -> None:
    told = json.loads(case.run("compare", "model.toml", "--json").out)
    assert any("are interfaces of zero thickness" in note for note in told["notes"])
    assert not any("are ignored" in note for note in told["notes"])
    (stage,) = told["stages"]
    assert stage["class"] == "with interfaces"
    assert "with the same joints differ by" in stage["sentence"]
    assert any(row["label"].startswith("joint forces") for row in stage["rows"])
    ignored = json.loads(case.run("compare", "model.toml", "--json", "--no-joints").out)
    assert any("are ignored" in note for note in ignored["notes"])
    assert ignored["stages"][0]["class"] == "comparable"


@pytest.mark.heavy
def test_compare_refines_and_meshes_by_gmsh(case: Case) -> None:
    (stage,) = json.loads(case.run("compare", "model.toml", "--json", "--refine", "2", "--size", "0.4").out)["stages"]
    cells = [level["cells"] for level in stage["refinement"]["levels"]]
    assert cells == [cells[0], 4 * cells[0], 16 * cells[0]]
    assert "halving elements and interfaces twice" in stage["sentence"]
    printed = case.run("compare", "model.toml", "--refine", "1").out
    assert "Halved: greatest" in printed
    refused = case.run("compare", "model.toml", "--size", "0")
    assert refused.code == 2
    assert "size = 0.0 must be a length above 0 m" in refused.err


def test_compare_writes_both_and_their_difference(case: Case) -> None:
    outcome = case.run("compare", "model.toml", "-q")
    assert outcome.code == 0
    files = [".bsm-mesh-results", "compare.vtu", "compare_joints.vtu"]
    assert outcome.new == ["out", "out/model", *(f"out/model/{name}" for name in files)]
    assert "continuum" in outcome.out


def test_not_converged_is_exit_code_3(case: Case) -> None:
    case.write("model.toml", MODEL + "[solver]\nmax_steps = 1\n")
    outcome = case.run("run", "model.toml", "-q")
    assert outcome.code == 3
    assert "not converged" in outcome.out
    assert (case.folder / "out/model/summary.json").is_file()


def test_mesh_command_writes_a_mesh(case: Case) -> None:
    case.write("g.py", GEOMETRY)
    outcome = case.run("mesh", "g.py", "--set", "width=3", "-o", "deep/g.msh")
    assert outcome.code == 0
    assert outcome.new == ["deep", "deep/g.msh"]
    assert "rock:gneiss" in outcome.out
    assert case.run("mesh", "--list").out.count("circular_tunnel")
    assert "width" in case.run("mesh", "g.py", "--list").out


SLOW_SCRIPT = """\
import pathlib, time
def build(path):
    pathlib.Path("started").touch()
    time.sleep(60)
"""


@pytest.mark.heavy
@pytest.mark.skipif(os.name != "posix", reason="SIGINT")
@pytest.mark.parametrize("where", ["mesh", "solution"])
def test_ctrl_c(case: Case, where: str) -> None:
    case.write("g.py", SLOW_SCRIPT)
    if where == "mesh":
        case.change('file = "mesh.msh"', 'geometry = "g.py"')
    start = command("run", "model.toml")
    if where == "solution":
        case.write("main.py", SLOW_SOLUTION)
        start = [sys.executable, "main.py"]
    before = tree(case.folder)
    process = subprocess.Popen(
        start,
        cwd=case.folder,
        env=environment(),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),  # ignored where tests run in the background
    )
    for _ in range(1200):
        if (case.folder / "started").exists() or process.poll() is not None:
            break
        time.sleep(0.05)
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=60)
    (case.folder / "started").unlink()
    assert process.returncode == 130
    assert out == ""
    assert err.rstrip().endswith("interrupted: no stage was finished")
    assert "Traceback" not in err
    assert tree(case.folder) == before


SLOW_SOLUTION = """\
import pathlib, sys, time
import bsm_mesh.__main__
from bsm_mesh.folder import run_file
def wait(*_):
    pathlib.Path("started").touch()
    time.sleep(60)
run_file.solve = wait
sys.argv[1:] = ["run", "model.toml"]
bsm_mesh.__main__.main()
"""


AT_THE_END = """\
import atexit, gc, sys
import bsm_mesh.__main__
atexit.register(lambda: print(gc.get_freeze_count() > 0))
sys.argv[1:] = [{}]
bsm_mesh.__main__.main()
"""


@pytest.mark.parametrize(("word", "code"), [("--version", 0), ("--wrong", 2)])
def test_nothing_is_collected_at_the_end(word: str, code: int) -> None:
    """The end of Python would take a third of a short run."""
    called = [sys.executable, "-c", AT_THE_END.format(repr(word))]
    done = subprocess.run(called, env=environment(), capture_output=True, text=True, check=False)
    assert done.returncode == code
    assert done.stdout.splitlines()[-1] == "True"


@pytest.mark.heavy
def test_a_reader_that_has_left(case: Case) -> None:
    """As in ``bsm-mesh schema | head -1``."""
    read, write = os.pipe()
    os.close(read)
    done = subprocess.run(
        command("schema"), cwd=case.folder, env=environment(), stdout=write, stderr=subprocess.PIPE, text=True,
        check=False, timeout=60,
    )  # fmt: skip
    os.close(write)
    assert (done.returncode, done.stderr) == (1, "")


@pytest.mark.heavy
@pytest.mark.skipif(not Path("/dev/full").exists(), reason="a full device")
def test_stdout_on_a_full_disk(case: Case) -> None:
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(
            command("schema"), cwd=case.folder, env=environment(), stdout=full, stderr=subprocess.PIPE, text=True,
            check=False, timeout=60,
        )  # fmt: skip
    assert done.returncode == 2
    assert done.stderr == "error: No space left on device\n"


@pytest.mark.slow
@pytest.mark.usefixtures("drawn_here")
def test_demo(case: Case) -> None:
    """The whole chain, as a new user starts it."""
    outcome = case.run("demo")
    assert outcome.code == 0, outcome.err
    made = {name.removeprefix("bsm-mesh-demo/") for name in outcome.new}
    assert {
        "model.toml",
        "cavern.py",
        "unbolted.toml",
        "out/model/blocks_0000.vtu",
        "out/model/blocks.pvd",
        "out/model/contacts.pvd",
    } <= made
    for name in ("unbolted", "model"):
        assert {
            f"out/{name}/pictures/{each}.png" for each in ("model", "final_position", "joints_state", "thrust")
        } <= made
    for word in ("verdict", "unbolted.toml, stage heading: unstable", "model.toml, stage bench: stable", "falls"):
        assert word in outcome.out
    falls, stands = (Results.load(case.folder / f"bsm-mesh-demo/out/{name}") for name in ("unbolted", "model"))
    assert (falls.status, stands.status) == ("unstable", "stable")
    assert stands.check().ok


@pytest.mark.parametrize("words", [["limit", "model.toml"], ["paraview", "out/model"], ["verify", "out/model"]])
def test_quiet_commands_show_no_progress(case: Case, words: list[str]) -> None:
    assert case.run("run", "model.toml", "-q").code == 0
    assert any(line.startswith("[") for line in case.run(*words).err.splitlines())
    quiet = case.run(*words, "-q")
    assert quiet.code == 0
    assert not any(line.startswith("[") for line in quiet.err.splitlines())
