"""history.csv: a row a step."""

from __future__ import annotations

import csv
import io
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any

from bsm_mesh.errors import ModelError
from bsm_mesh.files import whole_file
from bsm_mesh.results.records import Results, StepRecord

HISTORY = "history.csv"


def write_history(results: Results, folder: Path) -> None:
    """Write the steps of all stages, one below the other: the next stage adds its own at the end."""
    with whole_file(folder / HISTORY) as draft, draft.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, [field.name for field in fields(StepRecord)])
        writer.writeheader()
        writer.writerows(asdict(step) for stage in results.stages for step in stage.steps)


def read_history(content: bytes, count: int, path: Path) -> list[StepRecord]:
    """Return the steps that ``history.csv`` tells of.

    Raises
    ------
    ModelError
        If they are not `count` steps.
    """
    kinds: dict[str, Any] = {field.name: int if field.type == "int" else float for field in fields(StepRecord)}
    try:
        rows = list(csv.DictReader(io.StringIO(content.decode(), newline="")))
        steps = [StepRecord(**{name: kind(row[name]) for name, kind in kinds.items()}) for row in rows]
    except (KeyError, TypeError, ValueError, csv.Error):
        steps = []
    if len(steps) != count:
        raise ModelError(f"{path} is damaged; run the model again")
    return steps
