"""The worked example of docs/extending.md, "Add a method": one file of at most 80 lines, one line in PLANS."""

from __future__ import annotations

import importlib
from pathlib import Path

import pytest

import bsm_mesh as bsm
from bsm_mesh.solve.continuation.plan import PLANS, Phase
from tests.scenes.models import model_of
from tests.scenes.shapes import rectangle

PAGE = Path(__file__).parents[2] / "docs" / "extending.md"


def test_the_worked_example_ends_steps(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    text = PAGE.read_text(encoding="utf-8").partition("## Add a method")[2]
    code = text.partition("```python\n")[2].partition("```")[0]
    assert len(code.splitlines()) <= 80
    (tmp_path / "damped_newton.py").write_text(code, encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    method = importlib.import_module("damped_newton").DampedNewton()
    for phase in (Phase.START, Phase.NEAR_REST):
        monkeypatch.setitem(PLANS, phase, (method, *PLANS[phase]))
    wall = [rectangle(-2, -1, 2, 0), rectangle(-1, 0, 0, 1), rectangle(0, 0, 1, 1), rectangle(-0.5, 1, 0.5, 2)]
    stage = bsm.run(model_of(wall, friction=30), bsm.Options(scheme="continuation")).stages[-1]
    assert stage.status == "stable"
    assert "damped Newton" in {step.method for step in stage.steps}
