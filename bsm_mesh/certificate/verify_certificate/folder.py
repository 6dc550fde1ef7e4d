"""The check of a results folder."""

from __future__ import annotations

import json
from pathlib import Path

from .arrays_file import read_arrays
from .model_file import GivenFiles
from .stage import check_stage


def main(folder: Path) -> int:
    """Check a results folder, print a line a stage, and return the exit code."""
    try:
        return _checked(folder)
    except (ArithmeticError, AttributeError, LookupError, OSError, RecursionError, TypeError, ValueError) as error:
        print(f"DOES NOT HOLD: a file is missing, damaged or of another form ({type(error).__name__}: {error})")
        return 1


def _checked(folder: Path) -> int:
    told, summary = (json.loads((folder / name).read_text("utf-8")) for name in ("certificate.json", "summary.json"))
    verdicts = [(stage["name"], stage["status"]) for stage in summary["stages"]]
    holds = verdicts == [(stage["name"], stage["verdict"]) for stage in told["stages"]]
    if not holds:
        print("DOES NOT HOLD: summary.json and certificate.json give different verdicts")
    files = GivenFiles(folder)
    for stage in told["stages"]:
        arrays = read_arrays(folder / Path(stage["arrays"]).name)
        text, faults = check_stage(told, stage, arrays, files)
        holds = holds and not faults
        said = f"DOES NOT HOLD: {'; '.join(faults)}" if faults else text
        print(f"{stage['name']!a}: {stage['verdict']}, {stage['ground']}: {said}")
    return 0 if holds else 1
