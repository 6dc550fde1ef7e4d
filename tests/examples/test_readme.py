"""What the README shows runs as it is stable."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

from docs.code_blocks import README, TEXT, files_of, python_blocks, typed
from examples.numbers.pages import differences
from tests.scenes.small_case import Case, environment

LINEAR_SOLVERS = 0.005  # relative: SuperLU and MKL round differently, and slip near the limit depends on it


@pytest.mark.heavy
@pytest.mark.usefixtures("drawn_here")
def test_the_first_answer_prints_what_is_shown(case: Case, capsys: pytest.CaptureFixture[str]) -> None:
    block = python_blocks()[0]
    assert len([line for line in block.splitlines() if line]) == 5
    assert case.run("new", "slope", "s").code == 0
    capsys.readouterr()
    exec(compile(block, str(README), "exec"), {})
    shown = re.search(r"^```text\n(.*?)^```$", TEXT, re.DOTALL | re.MULTILINE)
    assert shown is not None
    assert differences(shown[1], capsys.readouterr().out, LINEAR_SOLVERS) == []
    assert (case.folder / "slope.png").is_file()


def test_it_is_short_and_names_the_thesis_once() -> None:
    prose = re.sub(r"^```.*?^```$", "", TEXT, flags=re.DOTALL | re.MULTILINE)
    assert len(re.sub(r"\]\([^)]*\)", "]", prose).split()) <= 500
    assert TEXT.count("A Block-Spring Model for Jointed Rocks") == 1
    assert len(files_of(TEXT)["mine.toml"].splitlines()) == 8


@pytest.mark.heavy
def test_its_commands_as_typed(tmp_path: Path) -> None:
    """One after the other in one shell, in a folder with `.venv`; what installs, `sh bootstrap.sh ...`, is left out."""
    lines = typed()
    first_command = next(n for n, line in enumerate(lines) if line.startswith("bsm-mesh "))
    assert ". .venv/bin/activate" in lines[:first_command]
    if not (Path(sys.prefix) / "bin" / "activate").is_file():
        pytest.skip("not in a virtual environment")
    (tmp_path / ".venv").symlink_to(sys.prefix)
    for name, text in files_of(TEXT).items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    path = "/usr/local/bin:/usr/bin:/bin"  # no other bsm-mesh than that of .venv
    done = subprocess.run(
        ["sh", "-e"], input="\n".join(lines), cwd=tmp_path, env={**environment(), "PATH": path},
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "s").is_dir()
    assert list((tmp_path / "out" / "mine" / "pictures").glob("*.png"))
    assert (tmp_path / "out" / "mine" / "report.html").is_file()


def test_what_bootstrap_tells_to_type_is_what_the_readme_tells() -> None:
    script = (README.parent / "bootstrap.sh").read_text(encoding="utf-8")
    assert "/bin/activate" in script
    for command in re.findall(r"sh bootstrap\.sh (\w+)", TEXT):
        assert re.search(rf"^#     sh bootstrap\.sh {command}\b", script, re.MULTILINE)
