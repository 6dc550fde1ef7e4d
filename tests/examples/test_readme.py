"""What the README shows runs as it stands."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import bsm_mesh as bsm
from docs.code_blocks import README, TEXT, python_blocks, typed
from tests.scenes.small_case import Case, environment


def test_the_first_python_block(case: Case) -> None:
    block = python_blocks()[0]
    names: dict[str, object] = {}
    exec(compile(block, str(README), "exec"), names)
    results = names["results"]
    assert isinstance(results, bsm.Results)
    assert results.check().ok
    settlement = re.search(r"settles by (\S+) \((\d \+ \d \+ \d)\) / (\S+) m", block)
    if settlement is not None:
        weight, sum_of_heights, stiffness = settlement.groups()
        expected = float(weight) * sum(map(float, sum_of_heights.split("+"))) / float(stiffness)
        np.testing.assert_allclose(results.stages[-1].displacement[-1], [0, -expected, 0], rtol=1e-9, atol=1e-15)


@pytest.mark.heavy
def test_its_commands_as_typed(tmp_path: Path) -> None:
    """One after the other in one shell, in a folder with `.venv`; what installs, `sh bootstrap.sh ...`, is left out."""
    lines = typed()
    first_command = next(n for n, line in enumerate(lines) if line.startswith("bsm-mesh "))
    assert ". .venv/bin/activate" in lines[:first_command]
    if not (Path(sys.prefix) / "bin" / "activate").is_file():
        pytest.skip("not in a virtual environment")
    (tmp_path / ".venv").symlink_to(sys.prefix)
    path = "/usr/local/bin:/usr/bin:/bin"  # no other bsm-mesh than that of .venv
    done = subprocess.run(
        ["sh", "-e"], input="\n".join(lines), cwd=tmp_path, env={**environment(), "PATH": path},
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "s").is_dir()
    assert list((tmp_path / "my_tunnel").rglob("*.png"))


def test_what_bootstrap_tells_to_type_is_what_the_readme_tells() -> None:
    script = (README.parent / "bootstrap.sh").read_text(encoding="utf-8")
    assert "/bin/activate" in script
    for command in re.findall(r"sh bootstrap\.sh (\w+)", TEXT):
        assert re.search(rf"^#     sh bootstrap\.sh {command}\b", script, re.MULTILINE)
