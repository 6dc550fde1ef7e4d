"""Tables of values to be compared with histories (CSV): a row a place and stage, a column a quantity with its unit."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from bsm_mesh.converters.meshes.files import refuse_unreadable
from bsm_mesh.errors import ModelError, nearest
from bsm_mesh.model.beside import UNITS, Beside
from bsm_mesh.named_units import ANGLES, LENGTHS, POUND, factor_of, unit_in
from bsm_mesh.table_rows import Rows, read_rows

HOLDS = "a quantity of a history at least, a row a place and stage"
FORCES = {"N": 1.0, "kN": 1e3, "MN": 1e6, "lbf": POUND, "kip": 1e3 * POUND}
SHARES = {"%": 0.01}
TEXTS = ("history", "stage", "source", "note")
UNTIL = "_until"  # a column of the other ends of ranges


class Column(NamedTuple):
    """A column of numbers: its place, name, and factor."""

    number: int
    name: str
    factor: float


def read_beside(path: Path, history: str | None = None, source: str | None = None) -> dict[str, tuple[Beside, ...]]:
    """Return the values of a table, by the names of the histories.

    Columns are ``history`` (not needed where it is known), ``stage`` (name or number; empty: the last), ``distance``
    (of lines), ``source`` (by default the file's name), ``note`` (not read), and the quantities of `Beside`:
    ``v [mm]``; with ``v_until [mm]`` as well a row has a range. Numbers without a unit are in m, N, degrees, shares.

    Parameters
    ----------
    path : Path
        The file.
    history : str, optional
        Only the rows of this one; all, where there is no column of names.
    source : str, optional
        Where all values come from, whatever the table says.

    Raises
    ------
    ModelError
        With the fault, where, and the cure.
    """
    refuse_unreadable(path, "table")
    rows = read_rows(path, HOLDS)
    names = rows.names
    texts = {name: names.index(name) for name in TEXTS if name in names}
    columns = [
        _column(path, number, name, rows.header[number])
        for number, name in enumerate(names)
        if name and name not in TEXTS
    ]
    if not any(column.name in UNITS for column in columns):
        raise ModelError(f"{path}: no column is a quantity; name one of {', '.join(UNITS)}")
    if history is None and "history" not in texts:
        raise ModelError(f"{path}: no column says of which history; add one called history, with the name in each row")
    found: dict[str, list[Beside]] = {}
    for row, cells in enumerate(rows.cells):
        told = {name: cells[number] for name, number in texts.items()}
        name = told.get("history") or history or ""
        if history is not None and name != history:
            continue
        given = source or told.get("source") or path.stem
        values = _values(path, rows, row, columns, told.get("stage") or None, given)
        found.setdefault(name, []).extend(values)
    if history is not None and not found:
        raise ModelError(f"{path}: no row is of history '{history}'")
    return {name: tuple(values) for name, values in found.items()}


def _column(path: Path, number: int, name: str, title: str) -> Column:
    quantity = name.removesuffix(UNTIL)
    if quantity not in UNITS and name != "distance":
        known = (*TEXTS, "distance", *UNITS)
        raise ModelError(
            f"{path}: column '{title}' is none of {', '.join(known)}{nearest(quantity, known)}; "
            "put other texts into a column called note"
        )
    unit = "m" if name == "distance" else UNITS[quantity]
    factors = {"m": LENGTHS, "N": FORCES, "deg": ANGLES, "": SHARES}[unit]
    return Column(
        number, name, factor_of(unit_in(title), factors, f"{path}: column '{title}'", f"{name} [{next(iter(factors))}]")
    )


def _values(
    path: Path, rows: Rows, row: int, columns: list[Column], stage: str | None, source: str
) -> Iterator[Beside]:
    """Return the values of a row."""
    place, numbers = rows.place(row), dict[str, float]()
    for column in columns:
        cell = rows.cells[row][column.number]
        if not cell:
            continue
        number = rows.number(row, column.number)
        if not math.isfinite(number):
            cure = rows.cure(cell, "leave the cell empty where there is none")
            raise ModelError(f"{place}: {column.name} = '{cell}' is no number; {cure}")
        numbers[column.name] = number * column.factor
    for name in numbers:
        if name.endswith(UNTIL) and name.removesuffix(UNTIL) not in numbers:
            raise ModelError(f"{place}: {name} without {name.removesuffix(UNTIL)}; a range has two ends")
    for name, value in numbers.items():
        if name in UNITS:
            yield Beside(
                quantity=name,
                value=value,
                until=numbers.get(f"{name}{UNTIL}"),
                stage=stage,
                distance=numbers.get("distance"),
                source=source,
            )
