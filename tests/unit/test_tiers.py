"""Of the heavy cases of a test, the first one runs on every change; of tests of examples, all."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
TESTS = """import pytest


@pytest.mark.heavy
@pytest.mark.parametrize("case", [1, 2, 3])
def test_heavy(case): ...


@pytest.mark.heavy
def test_heavy_of_one_case(): ...


@pytest.mark.parametrize("case", [pytest.param(1, marks=pytest.mark.heavy), pytest.param(2, marks=pytest.mark.heavy)])
def test_cases_marked_one_by_one(case): ...


@pytest.mark.parametrize("case", [1, 2])
def test_light(case): ...
"""


@pytest.mark.parametrize(
    ("tier", "names"),
    [
        ("not slow and not heavy", ["test_light[1]", "test_light[2]"]),
        (
            "heavy and not slow",
            ["test_heavy[1]", "test_heavy_of_one_case", "test_cases_marked_one_by_one[1]"],
        ),
        ("slow", ["test_heavy[2]", "test_heavy[3]", "test_cases_marked_one_by_one[2]"]),
    ],
)
def test_heavy_cases_leave_their_first(tmp_path: Path, tier: str, names: list[str]) -> None:
    assert collected(tmp_path, "test_some.py", tier) == names


def test_every_example_is_solved(tmp_path: Path) -> None:
    names = ["test_heavy[2]", "test_heavy[3]"]
    assert collected(tmp_path, "tests/examples/test_some.py", "slow") == names


def collected(tmp_path: Path, file: str, tier: str) -> list[str]:
    shutil.copy(ROOT / "conftest.py", tmp_path)
    (tmp_path / "pytest.ini").write_text("[pytest]\nmarkers =\n    heavy\n    slow\n", encoding="utf-8")
    (tmp_path / file).parent.mkdir(parents=True, exist_ok=True)
    (tmp_path / file).write_text(TESTS, encoding="utf-8")
    command = [sys.executable, "-m", "pytest", "--collect-only", "-q", "-m", tier, str(tmp_path)]
    alone = {**os.environ, "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"}  # plugins take longer to load than tests to collect
    done = subprocess.run(command, cwd=tmp_path, env=alone, capture_output=True, encoding="utf-8", check=True)
    return [line.partition("::")[2] for line in done.stdout.splitlines() if "::" in line]
