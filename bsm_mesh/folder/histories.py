"""history_NAME.csv: a row a step, a column a quantity, its unit in the header."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from bsm_mesh.errors import ModelError
from bsm_mesh.results.histories import HistorySeries, Recorded
from bsm_mesh.results.records import StepRecord
from bsm_mesh.results.results import Results
from bsm_mesh.text.csv_tables import csv_file, written_rows


def history_file(name: str) -> str:
    """Return the name of the file of a history."""
    return f"history_{name}.csv"


def columns_of(recorded: Recorded) -> list[str]:
    """Return the header of a history's columns: ``u [m]``."""
    return [
        f"{name} [{unit}]" if unit else name for name, unit in zip(recorded.quantities, recorded.units, strict=True)
    ]


def write_histories(results: Results, folder: Path) -> list[str]:
    """Write the histories of all stages, one file each; return their names."""
    stage_names = [stage.name for stage in results.stages]
    for name, series in results.histories.items():
        with csv_file(folder / history_file(name)) as writer:
            writer.writerow(["stage", "stage_name", "step", *columns_of(series.recorded)])
            writer.writerows(_rows(series, stage_names))
    return [history_file(name) for name in results.histories]


def _rows(series: HistorySeries, stage_names: list[str]) -> list[list[Any]]:
    return [
        [stage, stage_names[stage], step, *("" if np.isnan(value) else value for value in values)]
        for stage, step, values in zip(series.stage.tolist(), series.step.tolist(), series.values.tolist(), strict=True)
    ]


def with_histories(
    steps: list[StepRecord], recorded: tuple[Recorded, ...], content: Callable[[str], bytes], folder: Path
) -> list[StepRecord]:
    """Return steps with what their histories' files tell of them.

    Parameters
    ----------
    steps : list of StepRecord
        All steps of the results.
    recorded : tuple of Recorded
        The histories.
    content : callable
        Returns the content of a file.
    folder : Path
        Where the files are, for messages.

    Raises
    ------
    ModelError
        If a file is not of these steps.
    """
    values: list[tuple[float, ...]] = [()] * len(steps)
    for one in recorded:
        name = history_file(one.name)
        try:
            rows = written_rows(content(name))
            found = [tuple(float(row[column] or "nan") for column in columns_of(one)) for row in rows]
        except (KeyError, TypeError, ValueError):
            found = []
        if len(found) != len(steps):
            raise ModelError(f"{folder / name} is damaged; run the model again")
        values = [before + more for before, more in zip(values, found, strict=True)]
    return [replace(step, recorded=value) for step, value in zip(steps, values, strict=True)]
