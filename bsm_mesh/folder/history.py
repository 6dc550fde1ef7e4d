"""history.csv: a row a step."""

from __future__ import annotations

from dataclasses import asdict, fields
from pathlib import Path
from typing import Any

from bsm_mesh.errors import ModelError
from bsm_mesh.results.records import StepRecord
from bsm_mesh.results.results import Results
from bsm_mesh.text.csv_tables import csv_file, written_rows

HISTORY = "history.csv"
SEPARATOR = "; "  # between the methods of a step


def write_history(results: Results, folder: Path) -> None:
    """Write the steps of all stages, one below the other: the next stage adds its own at the end."""
    with csv_file(folder / HISTORY) as writer:
        writer.writerow(_KINDS)
        writer.writerows(_row(step) for stage in results.stages for step in stage.steps)


def _row(step: StepRecord) -> list[Any]:
    row = {**asdict(step), "tried": SEPARATOR.join(step.tried)}
    return [row[name] for name in _KINDS]


def _names(text: str) -> tuple[str, ...]:
    return tuple(text.split(SEPARATOR)) if text else ()


_TYPES: dict[Any, Any] = {"int": int, "float": float, "str": str, "tuple[str, ...]": _names}
_ELSEWHERE = "recorded", "time"  # in files of their own
_KINDS = {field.name: _TYPES[field.type] for field in fields(StepRecord) if field.name not in _ELSEWHERE}


def read_history(content: bytes, count: int, path: Path) -> list[StepRecord]:
    """Return the steps that ``history.csv`` tells of.

    Raises
    ------
    ModelError
        If they are not `count` steps.
    """
    try:
        rows = written_rows(content)
        steps = [StepRecord(**{name: kind(row[name]) for name, kind in _KINDS.items()}) for row in rows]
    except (KeyError, TypeError, ValueError):
        steps = []
    if len(steps) != count:
        raise ModelError(f"{path} is damaged; run the model again")
    return steps
