"""Fixtures that several tests share."""

from __future__ import annotations

import gc
import os
import shutil
import time
import timeit
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from numba.core import event

import bsm_mesh as bsm
from bsm_mesh.converters.meshes import apart
from bsm_mesh.folder import checkpoints
from bsm_mesh.pictures import plot
from tests.scenes.here import run_here
from tests.scenes.interrupted import copies_of, interrupted
from tests.scenes.model_folders import put_model
from tests.scenes.small_case import MODEL, Case, environment
from tests.scenes.square_mesh import msh


@pytest.fixture
def case(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Case:
    """Return a good model in files; its folder is the current one."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PYTHONPATH", environment()["PYTHONPATH"])  # of the process that draws
    made = Case(tmp_path, capsys)
    made.write("model.toml", MODEL)
    made.write("mesh.msh", msh())
    return made


@pytest.fixture
def drawn_here(monkeypatch: pytest.MonkeyPatch) -> None:
    """Pictures are drawn in this process."""
    monkeypatch.setattr(plot, "run_with_lines", run_here)


@pytest.fixture(autouse=True)
def read_here(monkeypatch: pytest.MonkeyPatch) -> None:
    """Foreign meshes, VTU among them, are read in this process.

    In a process of their own they are read by test_apart, which has a fixture of this name that does nothing.
    """

    def read(reader: Callable[[Path], Any], path: Path) -> Any:
        return reader(path)

    monkeypatch.setattr(apart, "read_apart", read)


def checkpoint_every_step(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(checkpoints.SETTINGS, "interval", 0.0)
    patch.setattr(os, "fsync", lambda descriptor: None)


@pytest.fixture
def at_every_step(monkeypatch: pytest.MonkeyPatch) -> None:
    """Checkpoints are written after every step, and nothing waits for the disk itself."""
    checkpoint_every_step(monkeypatch)


@pytest.fixture
def left(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> list[Path]:
    """Copy the folder of a run after each checkpoint, as a run that is killed there leaves it."""
    return copies_of(monkeypatch, tmp_path / "left", before=False)


@pytest.fixture(scope="session")
def killed_once(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of a staged model in which a run was killed amid its second stage."""
    folder = tmp_path_factory.mktemp("killed")
    with pytest.MonkeyPatch.context() as patch:
        checkpoint_every_step(patch)
        left = copies_of(patch, folder / "left", before=False)
        model = put_model(folder / "case", "staged")
        bsm.run(model, output=model.parent / "out")
        interrupted(model.parent, left[4])
    return model.parent


@pytest.fixture
def killed(tmp_path: Path, killed_once: Path, at_every_step: None) -> tuple[Path, Path]:
    """Return a copy of that model, and its folder of results."""
    case = shutil.copytree(killed_once, tmp_path / "case")
    return case / "model.toml", case / "out"


gc.disable()  # while tests are collected: all that is made stays


def pytest_collection_finish() -> None:
    """Leave modules and collected tests out of all later rounds of the garbage collector."""
    gc.collect()
    gc.freeze()
    gc.enable()


APART = ("robust", "heavy", "slow")  # markers of tests that are not in the daily tier
LOOP, LOOP_SECONDS = 500_000, 0.006  # a Python loop, and its processor time on the machine where the limit was chosen


@pytest.fixture(scope="session")
def seconds_allowed() -> float | None:
    """Return the processor time that a test of the daily tier may take; None without a limit.

    `TEST_SECONDS` gives it. A slower machine has proportionally more.
    """
    limit = os.environ.get("TEST_SECONDS")
    if limit is None:
        return None
    loop = min(timeit.repeat(f"for i in range({LOOP}): pass", number=1, timer=time.process_time))
    return float(limit) * max(1.0, loop / LOOP_SECONDS)


class Compiling(event.Listener):  # type: ignore[misc]
    """Processor seconds of the compiler: the first test that needs a kernel pays for those after it."""

    def __init__(self) -> None:
        self.seconds = 0.0
        self._begun: list[float] = []
        event.register("numba:compile", self)

    def on_start(self, event: Any) -> None:
        self._begun.append(time.process_time())

    def on_end(self, event: Any) -> None:
        spent = time.process_time() - self._begun.pop()
        if not self._begun:  # the outermost kernel, with those that it calls
            self.seconds += spent


COMPILING = Compiling()


def seconds_spent() -> float:
    """Return the processor time of this process and its children, without the compiler's."""
    return sum(os.times()[:4]) - COMPILING.seconds


@pytest.fixture(autouse=True)
def in_time(request: pytest.FixtureRequest, seconds_allowed: float | None) -> Iterator[None]:
    """Fail a test of the daily tier that takes too long; fixtures that several tests share do not count."""
    before = seconds_spent()
    yield
    spent = seconds_spent() - before
    if seconds_allowed is not None and spent > seconds_allowed and not any(map(request.node.get_closest_marker, APART)):
        pytest.fail(f"{spent:.1f} s of processor time, {seconds_allowed:.1f} allowed: shorten it or mark it heavy")


died: list[str] = []


@pytest.hookimpl(optionalhook=True)  # of pytest-xdist
def pytest_handlecrashitem(crashitem: str, report: pytest.TestReport, sched: Any) -> None:
    """Run a test whose process died once more, for the system may have ended it; a second time it has failed."""
    if crashitem not in died:
        died.append(crashitem)
        sched.mark_test_pending(crashitem)
        report.outcome = "rerun"  # type: ignore[assignment]


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Say which processes died, for it is a fault wherever it does not come from outside."""
    for test in died:
        terminalreporter.write_line(f"DIED   {test}: its process died, and it was run once more")
