"""The README's first blocks of code run as they stand."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from small_case import Case

import bsm_mesh as bsm
from bsm_mesh.app.cli import cli

README = Path(__file__).parents[2] / "README.md"
TEXT = README.read_text(encoding="utf-8") if README.is_file() else ""


def test_the_first_python_block(case: Case) -> None:
    found = re.search(r"^```python\n(.*?)^```", TEXT, re.DOTALL | re.MULTILINE)
    if found is None:
        pytest.skip("README.md has no Python block")
    names: dict[str, object] = {}
    exec(compile(found[1], str(README), "exec"), names)
    results = names["results"]
    assert isinstance(results, bsm.Results)
    assert results.check().ok
    settlement = re.search(r"settles by (\S+) \((\d \+ \d \+ \d)\) / (\S+) m", found[1])
    if settlement is not None:
        weight, sum_of_heights, stiffness = settlement.groups()
        expected = float(weight) * sum(map(float, sum_of_heights.split("+"))) / float(stiffness)
        np.testing.assert_allclose(results.stages[-1].displacement[-1], [0, -expected, 0], rtol=1e-9, atol=1e-15)


def test_its_commands_are_there(case: Case) -> None:
    """Those that go to `bsm-mesh` run one after the other; `sh bootstrap.sh` would install."""
    lines = re.findall(r"^(?:    |)bsm-mesh (.*?)(?: *#.*)?$", TEXT, re.MULTILINE)
    if not lines:
        pytest.skip("README.md has no commands")
    for line in lines:
        name, *arguments = line.split()
        assert name in cli.commands
        outcome = case.run(name, *arguments)
        assert outcome.code == 0, f"bsm-mesh {line}: {outcome.err}"
    for command in re.findall(r"sh bootstrap\.sh (\w+)", TEXT):
        assert f"{command} " in (README.parent / "bootstrap.sh").read_text(encoding="utf-8")
