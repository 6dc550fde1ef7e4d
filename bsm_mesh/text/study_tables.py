"""Printed tables of the command ``study``: probability of failure, scatter of the answers, and the key that decides."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

import numpy as np

from bsm_mesh.errors import counted
from bsm_mesh.studies.statistics import UNIT, failure_of
from bsm_mesh.studies.table import StudyTable
from bsm_mesh.text.tables import engineering, print_table
from bsm_mesh.text.terminal import say

MAX_RUNS = 50  # in a table of single runs
GAVE_WAY = "of these after blocks fell or moved by more than a tenth of their size (movement_limit makes them failures)"
MOST_ERRORS = 5  # different ones that are shown
SHOWN_QUANTILES = ("5 %", "50 %", "95 %")
SHEET_UNITS = {**UNIT, "unstable_area": "m^2", "unstable_volume": "m^3", "seconds": "s"}
NAMES = {"failure": "share that fails", "factor": "factor of safety", "max_displacement": "greatest displacement"}


Rows = list[tuple[str, ...]]


def print_study(table: StudyTable, summary: Mapping[str, Any]) -> None:
    """Print the summary of a study; of chosen values, which are no sample, the single runs too."""
    chosen = any("least" in told for told in summary["answers"])
    for title, header, rows in [*study_rows(summary), *([run_rows(table)] if chosen else [])]:
        if rows:
            print_table(title, header, rows)
    errors = Counter(error for error in table.columns["error"] if error)
    for error, number in errors.most_common(MOST_ERRORS):
        say(f"{counted(number, 'run')} crashed: {error}")


def study_rows(summary: Mapping[str, Any]) -> list[tuple[str, tuple[str, ...], Rows]]:
    """Return the tables of a study's summary: title, header and rows of each."""
    without = [
        (f"runs without a {NAMES['factor']}", str(summary["failure"]["runs"] - told["runs"]))
        for told in summary["answers"]
        if told["answer"] == "factor" and told["runs"] < summary["failure"]["runs"]
    ]
    tables: list[tuple[str, tuple[str, ...], Rows]] = [
        (summary["title"], ("", ""), [*_failure_rows(summary["failure"]), *without]),
    ]
    answers: Rows = [
        (
            NAMES[told["answer"]],
            str(told["runs"]),
            *(_shown(told[name], told["answer"]) for name in ("mean", "deviation")),
            *(_shown(told["quantiles"][name], told["answer"]) for name in SHOWN_QUANTILES),
        )
        for told in summary["answers"]
        if "mean" in told
    ]
    if answers:
        tables.append(("Answers", ("", "runs", "mean", "deviation", *SHOWN_QUANTILES), answers))
    tables += _extremes(summary["answers"])
    for answer in dict.fromkeys(told["answer"] for told in summary["effects"]):
        effects: Rows = [
            (told["key"], f"{told['correlation']:+.2f}", *(_shown(told[end], answer) for end in ("low", "high")))
            for told in summary["effects"]
            if told["answer"] == answer and told["correlation"] is not None
        ]
        if effects:
            header = ("", "rank correlation", "low quarter", "high quarter")
            tables.append((f"Which key decides: {NAMES[answer]}", header, effects))
    return tables


def _extremes(answers: Iterable[Mapping[str, Any]]) -> list[tuple[str, tuple[str, ...], Rows]]:
    """Return the table of the least and the greatest answers of a grid or a list; none of runs that were drawn."""
    rows: Rows = [
        (
            f"{end} {NAMES[told['answer']].removeprefix('greatest ')}",
            _shown(told[end], told["answer"]),
            ", ".join(f"{key} = {value}" for key, value in told[f"{end}_at"].items())
            + _more(told.get(f"{end}_runs", 1) - 1),
        )
        for told in answers
        if "least" in told
        for end in ("least", "greatest")
    ]
    return [("Answers (chosen values are no sample: no mean, no probability)", ("", "", "at"), rows)] if rows else []


def _more(runs: int) -> str:
    return f", and {counted(runs, 'more run')}" if runs else ""


def run_rows(table: StudyTable) -> tuple[str, tuple[str, ...], Rows]:
    """Return the table of single runs: title, header and rows; none where there are too many to read."""
    told = [name for name in ("factor", "max_displacement") if name in table.columns]
    answers = [name for name in told if np.isfinite(table.numbers(name)).any()]
    header = ("run", *table.keys, "verdict", *(NAMES[name] for name in answers))
    rows: Rows = [
        (
            str(run),
            *table.given_to(row).values(),
            str(table.columns["status"][row]).replace("_", " "),
            *(_shown(value, name) if (value := table.columns[name][row]) is not None else "-" for name in answers),
        )
        for row, run in enumerate(table.columns["run"][: MAX_RUNS + 1])
    ]
    return "Runs", header, rows if len(rows) <= MAX_RUNS else []


def sheet_rows(table: StudyTable) -> Iterator[list[Any]]:
    """Return the rows of a study's table for a spreadsheet: names with units, then a row a run; empty: no value."""
    units = SHEET_UNITS | {key: table.unit(key) for key in table.keys}
    yield [f"{name} [{units[name]}]" if units.get(name) else name for name in table.columns]
    for row in zip(*table.columns.values(), strict=True):
        yield ["" if value is None else value for value in row]


def _failure_rows(told: Mapping[str, Any]) -> list[tuple[str, str]]:
    rows = [
        ("runs", str(told["runs"])),
        ("stable", str(told["stable"])),
        *([(GAVE_WAY, str(told["gave_way"]))] if told.get("gave_way") else []),
        *([("stable, but moved too far", str(told["moved_far"]))] if told["moved_far"] else []),
        ("unstable", str(told["unstable"])),
        ("undecided", str(told["undecided"])),
        ("crashed", str(told["failed"])),
    ]
    if told["interval"] is None:  # a grid or a list: its shares are those of the chosen values
        return rows
    rows.append(("share that fails, of those with a verdict", f"{told['share']:.4g}"))
    low, high = told["interval"]
    rows.append((f"probability of failure, {100 * told['confidence']:g} % interval", f"{low:.4g} to {high:.4g}"))
    if told["undecided"] or told["failed"]:
        low, high = told["bounds"]
        rows.append(("share that fails, if none or all of the runs without a verdict fail", f"{low:.4g} to {high:.4g}"))
    return rows


def _shown(value: float, answer: str) -> str:
    return engineering(value, UNIT[answer]) if answer in UNIT else f"{value:.4g}"


def failure_in_words(table: StudyTable) -> str:
    """Return how many runs fail, for the heading of a picture."""
    told = failure_of(table, drawn=False)
    failing, others = told.unstable + told.moved_far, told.undecided + told.failed
    return f"{failing} of {told.stable + failing} fail" + (f", {others} without verdict" if others else "")
