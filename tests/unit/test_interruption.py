"""Ctrl-C, SIGTERM and SIGHUP: one line and exit code 130, at whatever moment; what was finished is on disk."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from bsm_mesh.results import Results
from bsm_mesh.text.interruption import Interrupted, guarded
from tests.file_operations import drafts, names
from tests.scenes.small_case import MODEL, Case, environment

PATIENCE = 300  # s; a busy machine
pytestmark = [pytest.mark.robust, pytest.mark.skipif(os.name != "posix", reason="signals")]

STAGES = "".join(f'[[stage]]\nname = "{name}"\nexcavate = [{block}]\n' for name, block in (("one", 3), ("two", 2)))
COMMAND = """\
import pathlib, sys
from bsm_mesh.__main__ import _command
from bsm_mesh.text.interruption import guarded
def command():
    pathlib.Path("started").touch()
    exec(sys.argv.pop(1), globals())
    return _command()
guarded(command, last=True)
"""
WAIT_AT = """\
from bsm_mesh.folder import run_file
whole = run_file.solve
def waiting(model, options, step, report, snapshot, finished, resumption):
    def look(record):
        if record.stage == {stage}:
            pathlib.Path("waiting").touch()
            import time; time.sleep(300)
        step(record)
    return whole(model, options, look, report, snapshot, finished, resumption)
run_file.solve = waiting
"""


def start(case: Case, before: str, *arguments: str) -> subprocess.Popen[str]:
    """Start a command whose own signal handling is in place when ``started`` is there."""
    case.write("model.toml", MODEL + STAGES)
    (case.folder / "started").unlink(missing_ok=True)
    process = subprocess.Popen(
        [sys.executable, "-c", COMMAND, before, *arguments],
        cwd=case.folder,
        env=environment(),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=lambda: [signal.signal(n, signal.SIG_DFL) for n in SIGNALS],  # ignored where tests are in background
    )
    wait_for(case.folder / "started", process)
    return process


@pytest.fixture(autouse=True)
def heeded() -> Iterator[None]:
    """Ctrl-C is ignored where the tests run in the background of a shell; here it is not."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP) if os.name == "posix" else ()


def wait_for(path: Path, process: subprocess.Popen[str]) -> None:
    end = time.monotonic() + PATIENCE
    while not path.exists() and process.poll() is None and time.monotonic() < end:
        time.sleep(0.002)


def whole_run(case: Case) -> float:
    """Return the time that a run takes [s]."""
    process, began = start(case, "", "run", "model.toml", "-q"), time.monotonic()
    assert process.wait(PATIENCE) == 0
    return time.monotonic() - began


@pytest.mark.slow
def test_signals_at_random_moments(case: Case) -> None:
    """Imports, mesh, compiled code, writing: never a traceback, never anything half-written."""
    chance, lasts = random.Random(12), whole_run(case)
    for number in SIGNALS:
        process = start(case, "", "run", "model.toml", "-q")
        time.sleep(chance.random() * lasts)
        process.send_signal(number)
        if chance.random() < 0.5:
            process.send_signal(number)
        out, err = process.communicate(timeout=PATIENCE)
        assert process.returncode in (0, 130), (process.returncode, err)
        assert "Traceback" not in err
        if process.returncode == 130:
            assert out == ""
            (line,) = [line for line in err.splitlines() if line]
            assert line.startswith("interrupted" if number == signal.SIGINT else f"interrupted ({number.name}): ")
        assert set(names(case.folder / "out")) <= {"model", "model.interrupted"}
        assert drafts(case.folder) == []
        assert Results.load("out/model").status == "stable"  # of the first run, or of this one


@pytest.mark.slow
@pytest.mark.usefixtures("drawn_here")
@pytest.mark.parametrize("number", SIGNALS)
def test_finished_stages_stay_and_are_told(case: Case, number: signal.Signals) -> None:
    process = start(case, WAIT_AT.format(stage=2), "run", "model.toml", "-q")
    wait_for(case.folder / "waiting", process)
    process.send_signal(number)
    out, err = process.communicate(timeout=PATIENCE)
    which = "" if number == signal.SIGINT else f" ({number.name})"
    told = f"interrupted{which}: finished and in out/model.interrupted: 2 stages (initial, one)"
    told += "; continue with: bsm-mesh run model.toml --resume"
    assert (process.returncode, out, err.strip()) == (130, "", told)
    left = Results.load("out/model.interrupted")
    assert (left.status, [stage.name for stage in left.stages]) == ("unfinished", ["initial", "one"])
    assert names(case.folder / "out") == ["model.interrupted"]
    if number != signal.SIGINT:
        return
    says = ["out/model does not exist", "finished stages of a run that was interrupted are in out/model.interrupted"]
    case.refuses("plot", "out/model", says=says)
    assert case.run("plot", "out/model.interrupted", "--only", "joints_state").code == 0
    assert case.run("run", "model.toml", "-q").code == 0
    assert names(case.folder / "out") == ["model"]


def test_nothing_is_left_where_no_stage_was_finished(case: Case) -> None:
    process = start(case, WAIT_AT.format(stage=0), "run", "model.toml", "-q")
    wait_for(case.folder / "waiting", process)
    process.send_signal(signal.SIGINT)
    assert process.communicate(timeout=PATIENCE)[1].strip() == "interrupted: no stage was finished"
    assert process.returncode == 130
    assert not (case.folder / "out").exists()


AMID_AN_IMPORT = """\
import signal
class Finder:
    def find_spec(self, name, *_):
        if name == "vtkmodules.vtkCommonMath":
            pathlib.Path("waiting").touch()
            signal.raise_signal(signal.SIGTERM)
import vtkmodules  # which has a finder of its own
sys.meta_path.insert(0, Finder())
"""


def test_a_signal_while_vtk_is_imported(case: Case) -> None:
    """Its C code dies where an exception is raised while one of its modules imports the next."""
    process = start(case, AMID_AN_IMPORT, "run", "model.toml", "-q")
    told = process.communicate(timeout=PATIENCE)[1]
    solved = "solved, and in out/model.interrupted as arrays alone: certificate_0000.npz"
    assert (process.returncode, told.strip()) == (130, f"interrupted (SIGTERM): no stage was finished; {solved}")
    assert (case.folder / "waiting").exists()
    assert not (case.folder / "out/model").exists()


def test_pictures_in_their_process(case: Case) -> None:
    assert case.run("run", "model.toml", "-q").code == 0
    slow = "import time, os\ntime.sleep(300)\n"
    case.write("fake/matplotlib.py", f"open({str(case.folder / 'waiting')!r}, 'w').close()\n{slow}")
    path = f'import os; os.environ["PYTHONPATH"] = {str(case.folder / "fake")!r} + ":" + os.environ["PYTHONPATH"]'
    process = start(case, path, "plot", "out/model")
    wait_for(case.folder / "waiting", process)
    assert (case.folder / "waiting").exists()
    process.send_signal(signal.SIGTERM)
    out, err = process.communicate(timeout=PATIENCE)
    assert (process.returncode, out) == (130, "")
    progress, said = err.rsplit("\n\n", 1)
    assert said == "interrupted (SIGTERM): nothing is half-written\n"
    assert all(line.startswith("[") for line in progress.splitlines())


def test_what_the_process_was_started_to_ignore_stays_ignored(case: Case) -> None:
    """As nohup does with SIGHUP."""
    before = "import signal; signal.signal(signal.SIGHUP, signal.SIG_IGN)"
    case.write("model.toml", MODEL + STAGES)
    code = f"{before}\n{COMMAND}"
    process = subprocess.Popen(
        [sys.executable, "-c", code, WAIT_AT.format(stage=1).replace("300", "0.5"), "run", "model.toml", "-q"],
        cwd=case.folder, env=environment(), stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
    )  # fmt: skip
    wait_for(case.folder / "waiting", process)
    process.send_signal(signal.SIGHUP)
    assert process.communicate(timeout=PATIENCE)[1] == ""
    assert process.returncode == 0


def test_a_signal_that_python_cannot_raise_is_taken_again(capfd: pytest.CaptureFixture[str]) -> None:
    """In a destructor Python prints a traceback, and continues as if nothing had been."""

    class Late:
        def __del__(self) -> None:
            signal.raise_signal(signal.SIGTERM)
            time.sleep(0)

    def command() -> None:
        Late()
        time.sleep(10)
        pytest.fail("continued")

    with pytest.raises(SystemExit) as caught:
        guarded(command)
    assert caught.value.code == 130
    assert capfd.readouterr().err == "interrupted (SIGTERM): nothing is half-written\n"


def test_what_a_library_makes_of_a_signal_in_its_call_back_is_an_interruption(
    capfd: pytest.CaptureFixture[str],
) -> None:
    """LLVM calls back with what it compiled; Numba then raised a RuntimeError: no compiled object yet."""

    class Late:
        def __del__(self) -> None:
            signal.raise_signal(signal.SIGINT)
            time.sleep(0)

    def command() -> None:
        Late()
        error = RuntimeError("no compiled object yet")
        error.add_note("two stages are finished")
        raise error

    with pytest.raises(SystemExit) as caught:
        guarded(command)
    assert caught.value.code == 130
    assert capfd.readouterr().err == "interrupted: two stages are finished\n"
    with pytest.raises(RuntimeError, match="on its own"):  # without a signal it is no interruption
        guarded(_fail)


def _fail() -> None:
    raise RuntimeError("on its own")


def test_a_second_signal_does_not_disturb_clearing_up(capfd: pytest.CaptureFixture[str]) -> None:
    cleared = []

    def command() -> None:
        try:
            signal.raise_signal(signal.SIGINT)
        finally:
            signal.raise_signal(signal.SIGINT)
            cleared.append(True)

    before = signal.getsignal(signal.SIGINT)
    with pytest.raises(SystemExit):
        guarded(command)
    assert cleared == [True]
    assert capfd.readouterr().err == "interrupted: nothing is half-written\n"
    assert signal.getsignal(signal.SIGINT) is before


def test_handlers_that_a_geometry_took_away_come_back(case: Case) -> None:
    """`gmsh.initialize` lets Ctrl-C kill the process, until `gmsh.finalize`, which a script may forget."""
    script = "import signal\ndef build(path):\n    signal.signal(signal.SIGINT, signal.SIG_DFL)\n"
    case.write("g.py", f"{script}    import shutil; shutil.copy('mesh.msh', path)\n")
    case.change('file = "mesh.msh"', 'geometry = "g.py"')

    def command() -> None:
        case.run("check", "model.toml")
        signal.raise_signal(signal.SIGINT)

    with pytest.raises(SystemExit) as caught:
        guarded(command)
    assert caught.value.code == 130


def test_an_interruption_bears_the_name_of_its_signal() -> None:
    assert issubclass(Interrupted, KeyboardInterrupt)
    assert str(Interrupted("SIGTERM")) == "SIGTERM"
