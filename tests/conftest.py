"""Fixtures that several tests share."""

from __future__ import annotations

from pathlib import Path

import pytest

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
