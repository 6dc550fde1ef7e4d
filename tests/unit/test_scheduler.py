"""Runs on processes: all of them once, also where processes die; the input up; nothing is left running."""

from __future__ import annotations

import pickle
import subprocess
import sys
from pathlib import Path

import psutil
import pytest

from bsm_mesh import worker_pool
from bsm_mesh.errors import ModelError
from bsm_mesh.studies.scheduler import Processes
from bsm_mesh.worker_pool import ATTEMPTS, WorkerPool
from tests.scenes.small_case import environment
from tests.scenes.study_works import Doubling, NotSent

pytestmark = pytest.mark.robust

TASKS = {run: {"x": float(run)} for run in range(8)}


@pytest.fixture(autouse=True)
def importable(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PYTHONPATH", environment()["PYTHONPATH"])


def children() -> list[int]:
    return [child.pid for child in psutil.Process().children() if child.status() != psutil.STATUS_ZOMBIE]


def test_every_run_once_in_several_processes(tmp_path: Path) -> None:
    before = children()
    done = list(Processes(2).run(Doubling(tmp_path, seconds=0.1), TASKS))
    assert sorted(one.run for one in done) == list(TASKS)
    assert all(one.answers is not None and one.answers["doubled"] == 2 * one.run for one in done)
    assert len({one.answers["process"] for one in done if one.answers}) == 2
    assert len(list(tmp_path.iterdir())) == len(TASKS)
    assert children() == before


def test_a_killed_process_loses_nothing(tmp_path: Path) -> None:
    done = list(Processes(2).run(Doubling(tmp_path, kills_once=(2, 3)), TASKS))
    assert sorted(one.run for one in done) == list(TASKS)
    assert all(one.answers is not None for one in done)
    assert len(list(tmp_path.glob("2-*"))) == 2
    assert len(list(tmp_path.iterdir())) == len(TASKS) + 2


def test_a_run_that_always_kills_is_given_up(tmp_path: Path) -> None:
    done = {one.run: one for one in Processes(2).run(Doubling(tmp_path, kills_always=(4,)), TASKS)}
    assert done[4].answers is None
    assert done[4].error == f"its process died {ATTEMPTS} times (signal 9)"
    assert len(list(tmp_path.glob("4-*"))) == ATTEMPTS
    assert sum(one.answers is not None for one in done.values()) == len(TASKS) - 1


def test_processes_live_from_round_to_round(tmp_path: Path) -> None:
    """A factor of safety tries some values, and then others, with the model that its processes hold."""
    before = children()
    with WorkerPool(Doubling(tmp_path), 2) as pool:
        ended = [one for _ in range(3) for one in pool.run({0: {"x": 1.0}, 1: {"x": 2.0}, 2: {"x": 3.0}})]
        assert sorted(one.answers["doubled"] for one in ended) == [2, 2, 2, 4, 4, 4, 6, 6, 6]
        assert len({one.answers["process"] for one in ended}) <= 2
    assert children() == before


SCRIPT = """
from bsm_mesh.worker_pool import WorkerPool


def squared(number, task):
    return task**2


if __name__ == "__main__":
    with WorkerPool(squared, 2, script=True) as pool:
        print(sorted(each.answers for each in pool.run({0: 3, 1: 4})))
"""


def test_the_work_may_be_a_function_of_a_script(tmp_path: Path) -> None:
    script = tmp_path / "script.py"
    script.write_text(SCRIPT, encoding="utf-8")
    ran = subprocess.run([sys.executable, script], capture_output=True, text=True, env=environment(), cwd=tmp_path)
    assert (ran.stdout, ran.stderr) == ("[9, 16]\n", "")


def test_nothing_goes_on_when_it_is_interrupted(tmp_path: Path) -> None:
    before = children()
    runs = Processes(2).run(Doubling(tmp_path, seconds=0.3), {run: {"x": 0.0} for run in range(50)})
    next(runs)
    runs.close()  # as an exception in the loop does
    assert children() == before
    assert len(list(tmp_path.iterdir())) < 8


def test_processes_that_do_not_start_are_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(worker_pool, "WORKER", "bsm_mesh.no_worker")
    with pytest.raises(ModelError, match=r"does not start \(exit code 1\): .*no_worker"):
        list(Processes(1).run(Doubling(tmp_path), TASKS))


def test_what_cannot_be_sent_is_given_up(tmp_path: Path) -> None:
    done = list(Processes(1).run(NotSent(), {0: {}}))
    assert [one.answers for one in done] == [None]
    assert "exit code 1" in done[0].error


def test_what_cannot_be_pickled_ends_the_runs(tmp_path: Path) -> None:
    before = children()
    work = Doubling(tmp_path)
    object.__setattr__(work, "folder", lambda: None)
    with pytest.raises((AttributeError, pickle.PicklingError)):
        list(Processes(2).run(work, TASKS))
    assert children() == before
