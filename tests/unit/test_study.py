"""Studies: equal tables whoever does the runs and however often it is killed; failing runs; what is reported."""

from __future__ import annotations

import json
import math
import os
import shutil
import signal
import subprocess
import sys
import types
from collections.abc import Iterator
from importlib.machinery import ModuleSpec
from pathlib import Path
from typing import Any

import numpy as np
import psutil
import pytest

import bsm_mesh as bsm
from bsm_mesh.commands import study as module
from bsm_mesh.commands.study import run_study
from bsm_mesh.commands.study_file import load_study
from bsm_mesh.commands.study_work import work_of
from bsm_mesh.errors import ModelError
from bsm_mesh.folder.study_folder import RUNS
from bsm_mesh.studies.statistics import main_answer
from bsm_mesh.studies.table import StudyTable, make_table
from tests.scenes.small_case import LOAD, MODEL, Case, command, environment, run_process
from tests.scenes.square_mesh import msh
from tests.scenes.studies import RUNS_OF_STUDY, STUDY, finished, rows, wait_for, write_study


@pytest.fixture
def study(case: Case) -> Case:
    write_study(case.folder)
    return case


@pytest.fixture(scope="module")
def whole_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of the study by one process, which nothing kills."""
    folder = tmp_path_factory.mktemp("whole")
    return bsm.study(write_study(folder), processes=1).folder


@pytest.fixture(scope="module")
def whole(whole_folder: Path) -> dict[str, list[Any]]:
    """Return the rows of that study."""
    return rows(whole_folder)


@pytest.fixture
def done(study: Case, whole_folder: Path) -> Case:
    """Return the study with all of its runs done."""
    shutil.copytree(whole_folder, study.folder / "out/study")
    return study


@pytest.mark.slow
def test_both_verdicts_occur(whole: dict[str, list[Any]]) -> None:
    """A block slips on its joint where the slope of 30 degrees, more or less, is beyond the joint's friction."""
    assert {"stable", "unstable"} <= set(whole["status"])
    assert whole["run"] == list(range(RUNS_OF_STUDY))
    slides = [
        friction < direction + 90
        for friction, direction in zip(whole["joint.J1.friction"], whole["gravity.direction"], strict=True)
    ]
    close = sum(one != (status == "unstable") for one, status in zip(slides, whole["status"], strict=True))
    assert close <= 1  # where the scatter of the joint decides


@pytest.mark.slow
def test_two_processes_give_the_same(study: Case, whole: dict[str, list[Any]]) -> None:
    said = study.run("study", "study.toml", "--processes", "2", "--json")
    assert said.code == 0
    told = json.loads(said.out)
    assert rows(Path("out/study")) == whole
    assert told["failure"]["unstable"] == whole["status"].count("unstable")
    assert told["failure"]["interval"][0] < told["failure"]["share"] < told["failure"]["interval"][1]
    assert {Path(path).name for path in told["pictures"]} == {
        "histogram.png",
        "model.png",
        "scatter.png",
        "tornado.png",
    }
    assert said.new == sorted(
        [
            "out",
            "out/study",
            "out/study/pictures",
            *(f"out/study/pictures/{name}.png" for name in ("histogram", "model", "scatter", "tornado")),
            *(
                f"out/study/{name}"
                for name in (RUNS, "study.csv", "study.json", "study.parquet", "study.toml", "summary.json")
            ),
        ]
    )
    table = StudyTable.read(Path("out/study/study.parquet"))
    assert table.metadata["study_file"] == STUDY
    assert table.metadata["version"] == bsm.__version__
    assert [table.unit(key) for key in ("joint.J1.friction", "gravity.direction")] == ["degrees", "degrees"]
    assert table.metadata["model"] == bsm.load("model.toml").digest


@pytest.mark.heavy
def test_what_is_finished_is_not_done_again(done: Case) -> None:
    times = StudyTable.read(Path("out/study/study.parquet")).columns["seconds"]
    again = done.run("study", "study.toml")
    assert StudyTable.read(Path("out/study/study.parquet")).columns["seconds"] == times
    assert "Which key decides: share that fails" in again.out
    assert "probability of failure, 95 % interval" in again.out
    assert again.new == []


@pytest.mark.slow
@pytest.mark.robust
def test_a_worker_that_is_killed(study: Case, whole: dict[str, list[Any]]) -> None:
    out = study.folder / "out/study"
    with subprocess.Popen(command("study", "study.toml", "--processes", "2", "-q"), env=environment()) as driver:
        wait_for(lambda: finished(out) >= 2)
        children = psutil.Process(driver.pid).children()
        children[0].kill()
        assert driver.wait(timeout=100) == 0
    assert rows(out) == whole
    assert finished(out) == RUNS_OF_STUDY


DYING = """
import os, sys
from bsm_mesh import files
from bsm_mesh.commands.cli import main

appended = 0

def hook(event, arguments):
    global appended
    if event == files.EVENT and arguments[0] == "append":
        appended += 1
        if appended == 5:
            with open(arguments[1], "ab") as file:
                file.write(b'\\n{"run": 9, "status": "unst')
            os.kill(os.getpid(), 9)

sys.addaudithook(hook)
main(["study", "study.toml", "--processes", "2", "-q"])
"""


@pytest.mark.slow
def test_a_driver_that_is_killed(study: Case, whole: dict[str, list[Any]]) -> None:
    """Four runs are on the disk, and half a line of the fifth."""
    done = subprocess.run([sys.executable, "-c", DYING], env=environment(), check=False, timeout=100)
    assert done.returncode == -signal.SIGKILL
    out = study.folder / "out/study"
    assert finished(out) == 4
    before = (out / RUNS).read_text()
    assert run_process(study.folder, "study", "study.toml", "-q").code == 0
    assert rows(out) == whole
    assert finished(out) == RUNS_OF_STUDY
    assert (out / RUNS).read_text().startswith(before)


def heed() -> None:
    """Take Ctrl-C, also where the tests run in the background, which ignores it."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


@pytest.mark.slow
@pytest.mark.robust
def test_ctrl_c_says_how_to_go_on(study: Case) -> None:
    """Of so many runs that a fast machine is not done before it is interrupted."""
    many = 300
    study.write("study.toml", STUDY.replace(f"runs = {RUNS_OF_STUDY}", f"runs = {many}"))
    out = study.folder / "out/study"
    words = command("study", "study.toml", "--processes", "2", "-q")
    with subprocess.Popen(words, env=environment(), stderr=subprocess.PIPE, text=True, preexec_fn=heed) as driver:
        wait_for(lambda: finished(out) >= 2)
        children = psutil.Process(driver.pid).children()
        driver.send_signal(signal.SIGINT)
        _, said = driver.communicate(timeout=100)
    assert driver.returncode == 130
    assert not any(child.is_running() and child.status() != psutil.STATUS_ZOMBIE for child in children)
    left = finished(out)
    assert 2 <= left < many
    assert f"interrupted: {left} of {many} runs are finished in out/study; continue with: " in said
    assert "bsm-mesh study study.toml --processes 2" in said


@pytest.fixture
def cluster(monkeypatch: pytest.MonkeyPatch) -> Iterator[Any]:
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None, host="127.0.0.1"
    ) as made:
        yield made


@pytest.mark.slow
def test_dask_gives_the_same_also_where_a_worker_is_killed(
    study: Case, cluster: Any, whole: dict[str, list[Any]], monkeypatch: pytest.MonkeyPatch
) -> None:
    from distributed import Client

    with Client(cluster.scheduler_address) as client:
        workers = list(client.run(os.getpid).values())
    killed = []

    def report(text: str) -> None:
        if text.startswith("3 of") and not killed:
            killed.append(workers[0])
            os.kill(workers[0], signal.SIGKILL)

    monkeypatch.setattr(module, "OFTEN", 0.0)
    run_study(study.folder / "study.toml", scheduler=cluster.scheduler_address, report=report)
    assert killed
    assert rows(study.folder / "out/study") == whole


def test_no_dask_scheduler(study: Case, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("distributed")
    monkeypatch.setattr("bsm_mesh.studies.dask_scheduler.WAITING", "1 s")
    study.run("study", "study.toml", "-q", "--scheduler", "tcp://127.0.0.1:1")
    with pytest.raises(ModelError, match="no Dask scheduler answers"):
        run_study(Path("study.toml"), scheduler="tcp://127.0.0.1:1")


def test_processes_or_a_scheduler(study: Case) -> None:
    study.refuses("study", "study.toml", "--processes", "2", "--scheduler", "tcp://h:1", says=["not both"])


@pytest.mark.slow
def test_a_run_that_fails_is_a_row(study: Case) -> None:
    study.write(
        "study.toml",
        'model = "model.toml"\nsampling = "list"\n[vary]\nsupport.1.boundary = {values = ["bottom", "bottm"]}\n'
        "joint.J1.friction = {values = [40, 35]}\n",
    )
    said = study.run("study", "study.toml", "--processes", "1", "-q")
    assert said.code == 0
    found = rows(Path("out/study"))
    assert found["status"] == ["stable", "failed"]
    assert "there is no boundary 'bottm'; did you mean 'bottom'" in found["error"][1]
    assert found["support.1.boundary"] == ["bottom", "bottm"]
    assert "1 run crashed: " in said.out
    told = json.loads(Path("out/study/summary.json").read_text())["failure"]
    assert (told["failed"], told["share"], told["bounds"], told["interval"]) == (1, 0.0, [0.0, 0.5], None)


@pytest.mark.slow
@pytest.mark.usefixtures("done")
def test_two_at_once_are_refused() -> None:
    from bsm_mesh.locks import free_lock, take_lock

    lock = Path("out/study/.lock")
    held = take_lock(lock)
    assert held is not None
    try:
        code = subprocess.run(command("study", "study.toml", "-q"), env=environment(), capture_output=True, check=False)
    finally:
        free_lock(lock, held)
    assert code.returncode == 2
    assert b"is at work on this study" in code.stderr


@pytest.mark.heavy
def test_rows_do_not_depend_on_the_others(study: Case, whole: dict[str, list[Any]]) -> None:
    """A run is a matter of its number and values alone."""
    loaded = load_study(Path("study.toml"))
    run = 7
    answers = work_of(loaded, "key")(run, loaded.plan.of(run))
    assert answers["max_displacement"] == whole["max_displacement"][run]
    assert answers["status"] == whole["status"][run]


@pytest.mark.slow
def test_new_networks_by_seeds(study: Case) -> None:
    study.write("wall.toml", MODEL.replace(LOAD, "").replace('file = "mesh.msh"', 'geometry = "walls.py"'))
    high = msh([(x, 2 * y) for y in range(3) for x in range(3)])
    study.write(
        "walls.py",
        "from pathlib import Path\n"
        "def build(path, seed=0):\n"
        f"    Path(path).write_text({msh()!r} if seed % 2 else {high!r})\n",
    )
    study.write(
        "seeds.toml", 'model = "wall.toml"\nruns = 3\nseed = 10\n[vary]\nmesh.parameters.seed = {seeds = true}\n'
    )
    found = run_study(Path("seeds.toml"), processes=1).table.columns
    assert found["mesh.parameters.seed"] == [10, 11, 12]
    first, second, third = found["max_displacement"]
    assert first == third != second


@pytest.fixture
def factors(monkeypatch: pytest.MonkeyPatch) -> list[dict[str, Any]]:
    """Put a factor of safety in the place of the real one; return what it is asked."""
    asked: list[dict[str, Any]] = []

    def factor_of_safety(model: bsm.Model, options: bsm.Options, **given: Any) -> types.SimpleNamespace:
        asked.append({"options": options, **given})
        factor = float(np.mean([joint.law.friction for joint in model.joints])) / 30  # type: ignore[union-attr]
        if factor > 1.19:
            return types.SimpleNamespace(factor=math.inf, stable=math.inf, unstable=None, undecided=())
        return types.SimpleNamespace(factor=factor, stable=factor - 0.001, unstable=factor + 0.001, undecided=(factor,))

    fake = types.ModuleType("bsm_mesh.safety")
    fake.__spec__ = ModuleSpec("bsm_mesh.safety", None)
    fake.factor_of_safety = factor_of_safety  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "bsm_mesh.safety", fake)
    return asked


def test_factors_of_safety(study: Case, factors: list[dict[str, Any]]) -> None:
    study.write(
        "study.toml",
        'model = "model.toml"\nsampling = "grid"\nanswers = ["factor_of_safety"]\n'
        '[safety]\ntolerance = 0.01\njoints = ["J1"]\n'
        "[vary]\njoint.J1.friction = {from = 24, to = 36, count = 9}\n"
        "[scatter]\njoint.J1.friction = {deviation = 0.1, classes = 2}\n",
    )
    loaded = load_study(Path("study.toml"))
    work = work_of(loaded, "key")
    found = {run: work(run, loaded.plan.of(run)) for run in range(9)}
    assert [found[run]["status"] for run in (0, 4, 8)] == ["unstable", "not_converged", "stable"]
    assert found[7]["factor"] == pytest.approx(34.5 / 30)
    assert found[7]["factor_undecided"] == 1
    assert factors[0]["tolerance"] == 0.01
    assert factors[0]["joints"] == ["J1~1", "J1~2"]
    assert found[8]["factor_stable"] is None  # it never fails: JSON knows no infinity
    assert factors[0]["options"].threads == 1
    table = make_table(loaded.plan, found, factor=True, bulk="area", metadata={})
    assert main_answer(table) == "factor"
    table.write(Path("study.parquet"))
    assert StudyTable.read(Path("study.parquet")).columns["factor_stable"][7] == pytest.approx(34.5 / 30 - 0.001)


def test_a_factor_beside_the_verdict(study: Case, factors: list[dict[str, Any]]) -> None:
    study.write("study.toml", STUDY.replace("sampling", 'answers = ["verdict", "factor_of_safety"]\nsampling'))
    loaded = load_study(Path("study.toml"))
    found = work_of(loaded, "key")(0, loaded.plan.of(0))
    assert found["stage"] == "initial"
    assert found["factor"] > 0


def test_a_table_is_printed_in_a_line_and_is_a_frame_of_pandas():
    columns = {"run": [0, 1], "joint.J1.friction": [30.0, 31.5], "status": ["stable", None]}
    table = StudyTable(keys=("joint.J1.friction",), columns=columns, metadata={})
    assert repr(table) == "StudyTable: 2 runs; columns run, joint.J1.friction, status"
    pytest.importorskip("pandas")
    frame = table.to_pandas()
    assert list(frame) == list(columns)
    assert frame["joint.J1.friction"].tolist() == [30.0, 31.5]
