"""Tables of the values compared with histories: with the computed values, and as a file that is read again."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

from bsm_mesh.errors import named_stage
from bsm_mesh.model.beside import UNITS, Beside, number_of
from bsm_mesh.results.beside import found_beside
from bsm_mesh.results.results import Results
from bsm_mesh.text.csv_tables import csv_text
from bsm_mesh.text.tables import engineering

NAME = "measured.csv"  # in the results folder of a model that was built in Python
HEADER = ("history", "stage", "quantity", "computed", "beside it", "of", "differs by")
MOST_LISTED = 30  # values of one source, stage and quantity of a history: more of them are a curve


def beside_rows(results: Results) -> list[tuple[str, ...]]:
    """Return the values compared with the histories, with the computed ones: a row a value, as `HEADER` heads it.

    Curves along a line are left out, and stages that the run has not come to.
    """
    rows = []
    names = [stage.name for stage in results.stages]
    for recorded in results.recorded:
        listed = Counter((one.source, one.stage, one.quantity) for one in recorded.measured)
        for one in recorded.measured:
            number = number_of(one.stage, names)
            if number is not None and listed[one.source, one.stage, one.quantity] <= MOST_LISTED:
                found = found_beside(results, recorded, one)
                rows.append((recorded.name, names[number], *_told(one, found)))
    return rows


def beside_lines(results: Results) -> list[str]:
    """Return the same in lines that fit a terminal."""
    last = results.stages[-1].name
    return [
        f"{history}{'' if stage == last else f', {named_stage(stage)}'}, {quantity}: {computed}; {source}: {value}"
        for history, stage, quantity, computed, value, source, _ in beside_rows(results)
    ]


def _told(one: Beside, found: float) -> tuple[str, ...]:
    """Return quantity, computed value, the values compared with it, their sources, and the differences."""

    def told(value: float) -> str:
        if math.isnan(value):
            return "-"
        unit = UNITS[one.quantity]
        return engineering(value, unit) if unit in ("m", "N") else f"{value:.4g} {unit}".rstrip()

    quantity = one.quantity.replace("_", " ") + ("" if one.distance is None else f" at {one.distance:g} m")
    value = told(one.value) if one.until is None else f"{told(one.value)} to {told(one.until)}"
    return quantity, told(found), value, one.source, told(one.difference(found))


def table_of(values: Mapping[str, Sequence[Beside]]) -> str:
    """Return values compared with histories, by these histories' names, as a table that `read_beside` reads."""
    quantities = dict.fromkeys(one.quantity for listed in values.values() for one in listed)
    columns = {f"{name} [{UNITS[name]}]" if UNITS[name] else name: name for name in quantities}
    columns |= {title.replace(name, f"{name}_until"): f"{name}_until" for title, name in columns.items()}
    written: list[list[Any]] = [["history", "source", "stage", "distance [m]", *columns]]
    for history, listed in values.items():
        rows: dict[tuple[Any, ...], list[dict[str, float]]] = {}
        for one in listed:
            mine = {one.quantity: one.value} | ({} if one.until is None else {f"{one.quantity}_until": one.until})
            row = rows.setdefault((history, one.source, one.stage, one.distance), [])
            if not row or one.quantity in row[-1]:
                row.append({})
            row[-1] |= mine
        for place, told in ((place, told) for place, several in rows.items() for told in several):
            written.append([*place, *(told.get(name, "") for name in columns.values())])
    return csv_text(written)
