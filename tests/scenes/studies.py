"""A study of a small case, and what its folder holds."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from bsm_mesh.folder.study_folder import RUNS
from bsm_mesh.studies.table import StudyTable
from tests.scenes.small_case import LOAD, MODEL
from tests.scenes.square_mesh import msh

RUNS_OF_STUDY = 10
STUDY = f"""\
model = "model.toml"
title = "Tilted squares"
runs = {RUNS_OF_STUDY}
sampling = "latin_hypercube"

[vary]
joint.J1.friction = {{distribution = "normal", mean = 30, deviation = 4, lower = 20, upper = 40}}
gravity.direction = {{distribution = "uniform", lower = -62, upper = -58}}
rock.gneiss.unit_weight = {{values = ["26 kN/m^3", "27 kN/m^3"]}}

[[correlation]]
between = ["joint.J1.friction", "gravity.direction"]
coefficient = -0.3

[scatter]
joint.J1.friction = {{deviation = 0.5}}
"""


def write_study(folder: Path, text: str = STUDY) -> Path:
    """Write a study of a small model into a folder; return its file."""
    (folder / "model.toml").write_text(MODEL.replace(LOAD, ""))
    (folder / "mesh.msh").write_text(msh())
    (folder / "study.toml").write_text(text)
    return folder / "study.toml"


def rows(folder: Path) -> dict[str, list[Any]]:
    """Return the table of a study, but for how long its runs took."""
    columns = dict(StudyTable.read(folder / "study.parquet").columns)
    assert all(seconds is None or seconds > 0 for seconds in columns.pop("seconds"))
    return columns


def finished(folder: Path) -> int:
    """Return how many runs the journal holds."""
    path = folder / RUNS
    return path.read_text().count('"seconds"') if path.exists() else 0


def wait_for(condition: Callable[[], bool]) -> None:
    deadline = time.monotonic() + 100
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.01)
