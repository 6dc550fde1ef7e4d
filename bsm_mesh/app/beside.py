"""What is set beside the histories of a run: tables of values, or other runs; and the table of both."""

from __future__ import annotations

import csv
import io
import math
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from bsm_mesh.errors import ModelError, nearest
from bsm_mesh.model.beside import Beside, number_of, unknown_stages
from bsm_mesh.reading import as_path
from bsm_mesh.results.beside import found_beside, set_beside, values_of_run
from bsm_mesh.results.results import Results, Source

if TYPE_CHECKING:
    from bsm_mesh.model.histories import History

NAME = "measured.csv"  # in the results folder of a model that was built in Python


def with_sources(results: Results, given: Mapping[str, Source] | Sequence[Source] | Source) -> Results:
    """Return results with tables of values, or other runs, set beside their histories.

    Parameters
    ----------
    results : Results
        What came out.
    given : path, Results, or several of them, or a mapping of names to them
        Tables (CSV), results folders and other results. A name says where values come from; by default a table says so
        itself, and a folder's is its own.

    Raises
    ------
    ModelError
        If a source cannot be read, or says nothing of these histories.
    """
    if not results.recorded:
        raise ModelError("nothing to set values beside: the run recorded no [[history]]; add them and run it again")
    if isinstance(given, str | os.PathLike | Results):
        given = [given]
    named = list(given.items()) if isinstance(given, Mapping) else [("", source) for source in given]
    for name, source in named:
        if isinstance(source, Results):
            values = _of_run(results, source, name or source.title or "other run", f"'{name or source.title}'")
        else:
            values = _of_path(results, as_path("beside", source), name)
        results = set_beside(results, values)
    return results


def named_source(text: str) -> tuple[str, str]:
    """Return the name and the path of ``NAME=PATH``, or a path without a name."""
    name, equals, path = text.partition("=")
    return (name.strip(), path) if equals and name.strip() and not Path(text).exists() else ("", text)


def _of_path(results: Results, path: Path, name: str) -> dict[str, tuple[Beside, ...]]:
    from bsm_mesh.app.storage import load_results
    from bsm_mesh.converters.beside_files import read_beside

    if path.is_dir():
        return _of_run(results, load_results(path), name or path.resolve().name, str(path))
    values = read_beside(path, source=name or None)
    known = [one.name for one in results.recorded]
    stages = [stage.name for stage in results.stages]
    faults = [
        f"{path}: the run recorded no history '{history}'{nearest(history, known)}"
        for history in values
        if history not in known
    ]
    for recorded in results.recorded:
        faults += [f"{path}: {fault}" for fault in _faults(recorded.name, recorded.kind, values, recorded.distances)]
        faults += [f"{path}: {fault}" for fault in unknown_stages(recorded.name, values.get(recorded.name, ()), stages)]
    if faults:
        raise ModelError(faults)
    return values


def _faults(name: str, kind: str, values: Mapping[str, Sequence[Beside]], distances: Sequence[float]) -> list[str]:
    from bsm_mesh.model.beside import faults_beside

    return list(faults_beside(name, kind, values.get(name, ()), max(distances, default=0.0)))


def _of_run(results: Results, other: Results, source: str, place: str) -> dict[str, tuple[Beside, ...]]:
    """Return what another run finds of the same histories; points and lines need not be recorded there."""
    there = {one.name for one in other.recorded}
    values = {
        one.name: values_of_run(other, one, source)
        for one in results.recorded
        if one.name in there or one.kind == "line"
    }
    if not any(values.values()):
        raise ModelError(f"{place}: recorded none of the histories {', '.join(one.name for one in results.recorded)}")
    names = [stage.name for stage in results.stages]
    return {  # stages that only the other one has say nothing here
        name: tuple(one for one in listed if number_of(one.stage, names) is not None) for name, listed in values.items()
    }


def beside_rows(results: Results) -> list[tuple[str, ...]]:
    """Return what is set beside the histories, and what the run finds there: a row a value, as `HEADER` heads it.

    Values of other runs along a line are left out: they are curves.
    """
    rows = []
    names = [stage.name for stage in results.stages]
    for recorded in results.recorded:
        listed: dict[tuple[object, ...], int] = {}
        for one in recorded.measured:
            key = (one.source, one.stage, one.quantity)
            listed[key] = listed.get(key, 0) + 1
        for one in recorded.measured:
            number = number_of(one.stage, names)
            if number is None or listed[one.source, one.stage, one.quantity] > MOST_LISTED:
                continue
            rows.append(_row(results, recorded.name, one, names[number], found_beside(results, recorded, one)))
    return rows


HEADER = ("history", "stage", "quantity", "computed", "set beside", "of", "difference")
MOST_LISTED = 30  # values of one source, stage and quantity of a history: more of them are a curve


def _row(results: Results, history: str, one: Beside, stage: str, found: float) -> tuple[str, ...]:
    from bsm_mesh.app.tables import engineering
    from bsm_mesh.model.beside import UNITS

    unit = UNITS[one.quantity]

    def told(value: float) -> str:
        if math.isnan(value):
            return "-"
        return engineering(value, unit) if unit in ("m", "N") else f"{value:.4g} {unit}".rstrip()

    quantity = one.quantity if one.distance is None else f"{one.quantity} at {one.distance:g} m"
    value = told(one.value) if one.until is None else f"{told(one.value)} to {told(one.until)}"
    ends = sorted((one.value, one.value if one.until is None else one.until))
    away = found - ends[1] if found > ends[1] else min(0.0, found - ends[0])
    difference = (
        "in it" if one.until is not None and away == 0 else told(away if one.until is not None else found - one.value)
    )
    return (
        history,
        stage,
        quantity.replace("_", " "),
        told(found),
        value,
        one.source,
        "-" if math.isnan(found) else difference,
    )


def table_of(histories: Sequence[History]) -> str:
    """Return all values that are set beside histories as a table, which `read_beside` reads."""
    quantities = list(dict.fromkeys(one.quantity for history in histories for one in history.measured))
    columns = [name for quantity in quantities for name in (quantity, f"{quantity}_until")]
    text = io.StringIO()
    writer = csv.DictWriter(text, ["history", "source", "stage", "distance", *columns], lineterminator="\n")
    writer.writeheader()
    for history in histories:
        for one in history.measured:
            row = {"history": history.name, "source": one.source, "stage": one.stage, "distance": one.distance}
            writer.writerow({**row, one.quantity: one.value, f"{one.quantity}_until": one.until})
    return text.getvalue()
