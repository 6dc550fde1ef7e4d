"""Runs that are interrupted: what they leave at their checkpoints, laid out for one that continues."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import bsm_mesh as bsm
from bsm_mesh.errors import ModelError
from bsm_mesh.folder import checkpoints
from bsm_mesh.folder.own_files import CHECKPOINT
from tests.file_operations import watched
from tests.scenes.model_folders import content


def copies_of(monkeypatch: pytest.MonkeyPatch, folder: Path, *, before: bool) -> list[Path]:
    """Have the folder of a run copied at each checkpoint, `before` or after it is written; return the copies."""
    copies: list[Path] = []
    write = checkpoints.Checkpoints.write

    def copy(place: Path) -> None:
        copies.append(folder / f"{os.getpid()}-{len(copies)}")
        shutil.copytree(place, copies[-1])

    def and_copy(self: Any, place: Path, *rest: Any) -> None:
        if before and (place / CHECKPOINT).exists():
            copy(place)
        write(self, place, *rest)
        if not before:
            copy(place)

    monkeypatch.setattr(checkpoints.Checkpoints, "write", and_copy)
    return copies


def interrupted(case: Path, copy: Path) -> None:
    """Bring the results of a model to where a run was killed, and nothing else is."""
    for name in ("out", "out.running", "out.interrupted"):
        shutil.rmtree(case / name, ignore_errors=True)
    shutil.copytree(copy, case / "out.running")


def stop(record: bsm.results.StepRecord) -> None:
    """End a run by Ctrl-C."""
    raise KeyboardInterrupt


def whole_run(model: Path, out: Path) -> dict[str, Any]:
    """Return what a run that nothing interrupts leaves, and take it away again."""
    shutil.rmtree(out, ignore_errors=True)
    bsm.run(model, output=out)
    wanted = content(out)
    shutil.rmtree(out)
    return wanted


def fails(action: Callable[[], object], hook: Callable[..., None]) -> str:
    """Return with which words an action is refused while a hook watches the operations on files; empty: it is not."""
    try:
        with watched(hook):
            action()
    except ModelError as error:
        return "; ".join([str(error), *getattr(error, "__notes__", [])])
    return ""
