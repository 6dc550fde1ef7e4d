"""tools.coverage: what it reports of lines and branches that were measured."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from tools import coverage as command

pytest.importorskip("coverage")
HALF = "def f(x):\n    if x:\n        return 1\n    return 2\n\n\nprint(f({given}))\n"


@pytest.fixture
def measured(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Give a folder with two packages, of one of which a line and a branch are not reached."""
    monkeypatch.chdir(tmp_path)
    for name in ("COVERAGE_PROCESS_START", "COVERAGE_PROCESS_CONFIG"):  # of a measurement of this test itself
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(command, "ROOT", tmp_path)
    monkeypatch.setattr(command, "FOLDER", tmp_path / "out")
    monkeypatch.setattr(command, "PACKAGES", ("whole", "half"))
    for package, last in (("whole", "print(1)\n"), ("half", HALF.format(given=1))):
        (tmp_path / package).mkdir()
        (tmp_path / package / "a.py").write_text(last, encoding="utf-8")
    return tmp_path


def pretend(monkeypatch: pytest.MonkeyPatch, code: int) -> None:
    """Run both files under coverage.py where pytest would be run, and end with an exit code."""
    real = subprocess.run

    def run(called: list[str], **keys: object) -> subprocess.CompletedProcess[str]:
        coverage = called[: called.index("-m", called.index("coverage"))]
        assert [real([*coverage, f"{one}/a.py"], **keys).returncode for one in command.PACKAGES] == [0, 0]
        return subprocess.CompletedProcess(called, code, "", "")

    monkeypatch.setattr(subprocess, "run", run)
    monkeypatch.setattr(sys, "argv", ["coverage"])


@pytest.mark.heavy
@pytest.mark.parametrize(("code", "least", "exit_code"), [(0, 50.0, 0), (0, 95.0, 1), (1, 50.0, 1)])
def test_what_was_reached_is_told_and_too_little_or_a_failed_test_ends_with_1(
    measured: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    code: int,
    least: float,
    exit_code: int,
) -> None:
    pretend(monkeypatch, code)
    monkeypatch.setattr(command, "LEAST", least)
    assert command.main() == exit_code
    told = capsys.readouterr()
    assert "whole: 100.0 % of 1 lines\n" in told.out
    assert "half: 80.0 % of 5 lines, 50.0 % of 2 branches\n" in told.out
    assert told.out.partition("missing lines and branches:")[2].split()[:4] == ["2", "71.4", "%", "half/a.py"]
    assert ("pytest ended with exit code 1" in told.err) == (code == 1)
    monkeypatch.setattr(sys, "argv", ["coverage", "--report"])  # once more, of the measurement
    assert command.main() == int(least > 72)


@pytest.mark.usefixtures("measured")
def test_without_a_measurement_there_is_nothing_to_report(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "argv", ["coverage", "--report"])
    with pytest.raises(SystemExit) as end:
        command.main()
    assert end.value.code == 2
