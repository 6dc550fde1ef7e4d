"""Of a heavy test with several cases, the first one runs on every change."""

from __future__ import annotations

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
            [
                "test_heavy[1]",
                "test_heavy_of_one_case",
                "test_cases_marked_one_by_one[1]",
                "test_cases_marked_one_by_one[2]",
            ],
        ),
        ("slow", ["test_heavy[2]", "test_heavy[3]"]),
    ],
)
def test_a_heavy_test_leaves_its_first_case(tmp_path: Path, tier: str, names: list[str]) -> None:
    shutil.copy(ROOT / "conftest.py", tmp_path)
    (tmp_path / "pytest.ini").write_text("[pytest]\nmarkers =\n    heavy\n    slow\n", encoding="utf-8")
    (tmp_path / "test_some.py").write_text(TESTS, encoding="utf-8")
    command = [sys.executable, "-m", "pytest", "--collect-only", "-q", "-m", tier, str(tmp_path)]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, encoding="utf-8", check=True)
    found = [line.partition("::")[2] for line in done.stdout.splitlines() if "::" in line]
    assert found == names, done.stdout
