"""energy.csv, time_history.csv, shaken_blocks.csv: energies, histories over time, peaks of blocks in shaken stages."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from bsm_mesh.errors import ModelError
from bsm_mesh.folder.histories import columns_of
from bsm_mesh.results.records import StepRecord
from bsm_mesh.results.results import Results
from bsm_mesh.results.shaking import ENERGIES, ShakingResult
from bsm_mesh.text.csv_tables import csv_file, written_rows

ENERGY, PEAKS, TIMES = "energy.csv", "shaken_blocks.csv", "time_history.csv"
SHAKEN_FILES = (ENERGY, PEAKS, TIMES)
SCALARS = ("end_velocity", "time_step", "cycles", "windows", "heaviest", "imbalance")
_TIMES = ("time [s]", "base_acceleration [m/s2]", *(f"{name} [N]" for name in ENERGIES))
_PEAKS = ("peak_velocity [m/s]", "peak_acceleration [m/s2]", "heavier")
SHAKEN = "shaking"  # the method of a step that is a time of the shaking


def write_shaking(results: Results, folder: Path) -> list[str]:
    """Write the files of all stages that are shaken, one below the other; return their names."""
    shaken = [(number, stage, stage.shaking) for number, stage in enumerate(results.stages) if stage.shaking]
    if not shaken:
        return []
    with csv_file(folder / ENERGY) as writer:
        writer.writerow(["stage", "stage_name", *_TIMES])
        for number, stage, one in shaken:
            table = np.column_stack([one.time, one.base_acceleration, one.energy])
            writer.writerows([number, stage.name, *row] for row in table.tolist())
    with csv_file(folder / PEAKS) as writer:
        writer.writerow(["stage", "stage_name", "block", *_PEAKS])
        for number, stage, one in shaken:
            peaks = zip(one.peak_velocity.tolist(), one.peak_acceleration.tolist(), one.heavier.tolist(), strict=True)
            writer.writerows([number, stage.name, block, *row[:2], int(row[2])] for block, row in enumerate(peaks))
    _write_times(results, folder)
    return list(SHAKEN_FILES)


def _write_times(results: Results, folder: Path) -> None:
    """Write the model's histories over the times of shaken stages, a row a time and a column a quantity."""
    titles = [f"{one.name}: {column}" for one in results.recorded for column in columns_of(one)]
    with csv_file(folder / TIMES) as writer:
        writer.writerow(["stage", "stage_name", *_TIMES[:2], "max_displacement [m]", *titles])
        for stage in results.stages:
            if stage.shaking is None:
                continue
            steps = [step for step in stage.steps if step.time is not None]
            for step, base in zip(steps, stage.shaking.base_acceleration[1:].tolist(), strict=True):
                values = ["" if np.isnan(value) else value for value in step.recorded]
                writer.writerow([step.stage, stage.name, step.time, base, step.max_displacement, *values])


def shaking_summary(shaking: ShakingResult) -> dict[str, Any]:
    """Return the entries of the summary for a shaken stage."""
    return {name: getattr(shaking, name) for name in SCALARS} | {"slip_energy": shaking.slip_energy.tolist()}


def read_shaking(told: dict[str, Any], number: int, content: Callable[[str], bytes], folder: Path) -> ShakingResult:
    """Return how a stage was shaken.

    Parameters
    ----------
    told : dict
        Its record in the summary.
    number : int
        Of the stage.
    content : callable
        Returns the content of a file.
    folder : Path
        Where the files are, for messages.

    Raises
    ------
    ModelError
        If a file is not of this stage.
    """
    try:
        times, peaks = (_rows(content(name), number, titles) for name, titles in ((ENERGY, _TIMES), (PEAKS, _PEAKS)))
        return ShakingResult(
            time=times[:, 0],
            base_acceleration=times[:, 1],
            energy=times[:, 2:],
            peak_velocity=peaks[:, 0],
            peak_acceleration=peaks[:, 1],
            heavier=peaks[:, 2] > 0,
            slip_energy=np.array(told["slip_energy"], dtype=np.float64),
            end_velocity=float(told["end_velocity"]),
            time_step=float(told["time_step"]),
            cycles=int(told["cycles"]),
            windows=int(told["windows"]),
            heaviest=float(told["heaviest"]),
            imbalance=float(told["imbalance"]),
        )
    except (KeyError, TypeError, ValueError):
        raise ModelError(f"{folder}: {ENERGY} or {PEAKS} is damaged; run the model again") from None


def _rows(content: bytes, number: int, titles: tuple[str, ...]) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Return the columns of a stage, (k, columns)."""
    rows = written_rows(content)
    found = [[float(row[title]) for title in titles] for row in rows if int(row["stage"]) == number]
    return np.array(found, dtype=np.float64).reshape(len(found), len(titles))


def with_times(steps: tuple[StepRecord, ...], shaking: ShakingResult | None) -> tuple[StepRecord, ...]:
    """Return the steps of a stage with the times of those in which it was shaken."""
    if shaking is None:
        return steps
    times = iter(shaking.time[1:].tolist())
    return tuple(replace(step, time=next(times, None)) if step.method == SHAKEN else step for step in steps)
