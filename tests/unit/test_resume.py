"""A run that is resumed ends as the one that was not interrupted, file by file and bit for bit, or is refused."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import bsm_mesh as bsm
from bsm_mesh.app import checkpoints
from bsm_mesh.app.own_files import CHECKPOINT
from bsm_mesh.errors import ModelError
from tests.campaigns.scenes import put_model
from tests.file_operations import names
from tests.scenes.small_case import MODEL, Case

SCHEMES = {"staged": ("continuation", "wang", "linear"), "bolted": ("continuation",), "collapsing": ("continuation",)}
RUNS = [(name, scheme) for name, schemes in SCHEMES.items() for scheme in schemes]


@pytest.fixture
def at_every_step(monkeypatch: pytest.MonkeyPatch) -> None:
    """Checkpoints are written after every step."""
    monkeypatch.setattr(checkpoints.SETTINGS, "interval", 0.0)


@pytest.fixture
def left(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Iterator[list[Path]]:
    """Copy the folder of a run after each checkpoint, as a run that is killed there leaves it."""
    copies: list[Path] = []
    write = checkpoints.Checkpoints.write

    def and_copy(self: Any, place: Path, *rest: Any) -> None:
        write(self, place, *rest)
        copies.append(tmp_path / "left" / str(len(copies)))
        shutil.copytree(place, copies[-1])

    monkeypatch.setattr(checkpoints.Checkpoints, "write", and_copy)
    yield copies


def content(folder: Path) -> dict[str, Any]:
    """Return what the files of a run hold, wall times aside."""
    told: dict[str, Any] = {path.name: path.read_bytes() for path in sorted(folder.iterdir())}
    rows = [line.split(",") for line in told["history.csv"].decode().splitlines()]
    at = rows[0].index("seconds")
    told["history.csv"] = [row[:at] + row[at + 1 :] for row in rows]
    summary = json.loads(told["summary.json"])
    for stage in summary["stages"]:
        del stage["seconds"]
    del summary["checksum"], summary["files"]["history.csv"]
    return {**told, "summary.json": summary}


def interrupted(case: Path, copy: Path) -> None:
    """Bring the results of a model to where a run was killed, and nothing else is."""
    for name in ("out", "out.running", "out.interrupted"):
        shutil.rmtree(case / name, ignore_errors=True)
    shutil.copytree(copy, case / "out.running")


@pytest.mark.usefixtures("at_every_step")
@pytest.mark.parametrize(("name", "scheme"), RUNS)
def test_resumed_from_every_checkpoint(tmp_path: Path, left: list[Path], name: str, scheme: str) -> None:
    model = put_model(tmp_path / "case", name, solver={"scheme": scheme, "max_steps": 40})
    out = model.parent / "out"
    whole = bsm.run(model, output=out)
    wanted, copies = content(out), list(left)
    steps = sum(len(stage.steps) for stage in whole.stages)
    assert len(copies) >= (len(whole.stages) if scheme == "linear" else steps)
    for copy in copies:
        interrupted(model.parent, copy)
        seen: list[bsm.results.StepRecord] = []
        results = bsm.run(model, output=out, resume=True, observer=seen.append)
        assert results.status == whole.status
        assert len(seen) < steps
        assert content(out) == wanted
        assert names(model.parent) == ["bolts.csv", "mesh.msh", "model.toml", "out"]
