"""What an interrupted run left is refused in one sentence where it is damaged, or of another model or program."""

from __future__ import annotations

import hashlib
import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import bsm_mesh as bsm
from bsm_mesh.errors import ModelError
from bsm_mesh.folder.own_files import CHECKPOINT
from tests.scenes.model_folders import put_model
from tests.scenes.small_case import Case, environment, tree

pytestmark = [pytest.mark.robust, pytest.mark.filterwarnings("ignore::bsm_mesh.errors.MeshWarning")]


def refused(model: Path, out: Path, says: str) -> None:
    """Assert that a run is refused in one sentence with the cure, and that nothing is changed."""
    before = tree(out.parent)
    with pytest.raises(ModelError, match=says) as caught:
        bsm.run(model, output=out, resume=True)
    assert len(caught.value.faults) == 1
    assert str(caught.value).endswith("run without --resume")
    assert tree(out.parent) == before


def cut(content: bytes) -> bytes:
    return content[: len(content) // 2]


def flipped(content: bytes) -> bytes:
    return content[:5000] + bytes([content[5000] ^ 1]) + content[5001:]


DAMAGES: dict[str, Callable[[bytes], bytes]] = {
    "truncated": cut,
    "a byte less": lambda content: content[:-1],
    "a byte more": lambda content: content + b"\n",
    "a bit changed": flipped,
    "empty": lambda content: b"",
    "foreign": lambda content: b"PK\x03\x04 of another program",
    "a line": lambda content: b"\n",
}


@pytest.mark.parametrize("damage", DAMAGES)
def test_a_checkpoint_that_is_not_as_it_was_written(killed: tuple[Path, Path], damage: str) -> None:
    model, out = killed
    file = out.with_name("out.running") / CHECKPOINT
    file.write_bytes(DAMAGES[damage](file.read_bytes()))
    refused(model, out, "truncated, was changed, or is no checkpoint of bsm-mesh")


def sealed(file: Path, change: Callable[[dict[str, Any]], object]) -> None:
    """Change what is reported in a checkpoint, and seal it again."""
    with np.load(file) as members:
        arrays = dict(members)
    told = json.loads(arrays["content"].tobytes())
    change(told)
    arrays["content"] = np.frombuffer(json.dumps(told).encode(), np.uint8)
    np.savez(file, **arrays)
    content = file.read_bytes()
    file.write_bytes(content + f"{hashlib.sha256(content).hexdigest()}\n".encode())


CHANGES: dict[str, tuple[Callable[[dict[str, Any]], object], str]] = {
    "format": (lambda told: told.update(format=2), "has format 2, and this bsm-mesh reads 1"),
    "kind": (lambda told: told["checkpoint"].update(kind="Path"), "is no checkpoint of this program"),
    "field": (lambda told: told["checkpoint"].update(more=1), "is no checkpoint of this program"),
    "less": (lambda told: told.pop("files"), "is no checkpoint of this program"),
    "another state": (lambda told: told.update(checkpoint=[]), "holds no state of a run"),
    "code": (lambda told: told["identity"].update(code="0"), "another state of bsm-mesh's source"),
    "versions": (lambda told: told["identity"].update(versions="bsm-mesh 0.0"), "other versions .bsm-mesh 0.0; here"),
}


@pytest.mark.parametrize("change", CHANGES)
def test_a_checkpoint_of_another_program(killed: tuple[Path, Path], change: str) -> None:
    model, out = killed
    sealed(out.with_name("out.running") / CHECKPOINT, CHANGES[change][0])
    refused(model, out, CHANGES[change][1])


OTHERS: dict[str, tuple[dict[str, Any], str]] = {
    "model": ({"water": {"unit_weight": "9.8 kN/m^3"}}, "of another model"),
    "options": ({"solver": {"tolerance": 1e-7}}, "of another way to solve"),
    "falls": ({"falls": {"on_fall": "remove"}}, "of another way to solve"),
    "snapshots": ({"output": {"snapshots": "stages"}}, r"snapshots = 'steps' in .output., and now it is 'stages'"),
}


@pytest.mark.parametrize("other", OTHERS)
def test_a_model_that_was_changed_since(killed: tuple[Path, Path], other: str) -> None:
    model, out = killed
    put_model(model.parent, "staged", tables=OTHERS[other][0])
    refused(model, out, OTHERS[other][1])


@pytest.mark.parametrize("name", ["blocks_0000.vtu", "blocks_0001_00001.vtu"])
@pytest.mark.parametrize("how", ["gone", "changed"])
def test_a_grid_that_was_changed_since(killed: tuple[Path, Path], name: str, how: str) -> None:
    model, out = killed
    file = out.with_name("out.running") / name
    if how == "gone":
        file.unlink()
    else:
        file.write_bytes(file.read_bytes().replace(b"gneiss", b"gneisS"))
        file.write_bytes(flipped(file.read_bytes()) if len(file.read_bytes()) > 5000 else b"")
    refused(model, out, f"{name} is missing, or was changed after it was written")


def test_finished_stages_that_cannot_be_read(killed: tuple[Path, Path]) -> None:
    model, out = killed
    (out.with_name("out.running") / "summary.json").write_text("{}")
    refused(model, out, "the finished stages of an interrupted run: .*summary.json is not from a run")


def test_nothing_to_go_on_with(tmp_path: Path) -> None:
    model = put_model(tmp_path, "bolted")
    said: list[str] = []
    bsm.run(model, output=tmp_path / "out", resume=True, report=said.append)
    assert "no interrupted run to continue with: it begins at the start" in said
    assert not (tmp_path / "out" / CHECKPOINT).exists()
    refused(model, tmp_path / "out", "holds the finished results of this model, .* nothing to continue with")
    put_model(tmp_path, "bolted", unit_weight="25 kN/m^3")
    bsm.run(model, output=tmp_path / "out", resume=True)
    with pytest.raises(ModelError, match="output = False leaves nothing to continue with"):
        bsm.run(model, output=False, resume=True)
    with pytest.raises(ModelError, match="resume belongs to a model file"):
        bsm.run(bsm.load(model), resume=True)


def test_the_command(case: Case) -> None:
    """A run that is interrupted says how to continue; that command comes to the end."""
    case.write("model.toml", (case.folder / "model.toml").read_text() + '[[stage]]\nname = "one"\nexcavate = [3]\n')
    script = WAIT + "from bsm_mesh.__main__ import main; import sys; sys.argv[1:] = ['run', 'model.toml', '-q']; main()"
    done = subprocess.run(
        [sys.executable, "-c", script], cwd=case.folder, env=environment(), capture_output=True, text=True, check=False
    )
    assert done.returncode == 130
    told = "finished and in out/model.interrupted: 1 stage (initial); continue with: bsm-mesh run model.toml --resume"
    assert done.stderr.strip() == f"interrupted (SIGTERM): {told}"
    outcome = case.run("run", "model.toml", "--resume")
    assert outcome.code == 0
    assert "stage one" in outcome.err
    assert "stage initial" not in outcome.err
    assert len(bsm.Results.load("out/model").stages) == 2
    case.refuses("run", "model.toml", "--resume", says=["nothing to continue with", "run without --resume"])


WAIT = """
import os, signal
from bsm_mesh.text.progress import Progress
step = Progress.step
def strike(self, record):
    if record.stage:
        os.kill(os.getpid(), signal.SIGTERM)
    step(self, record)
Progress.step = strike
"""
