"""Rows of tables (CSV) of any country: traces, scan lines, bolts, measured values, results of other programs.

Commas, semicolons or tabs part the columns, whose names are in the first row, in any case, with or without a unit.
A comma is a decimal point where other signs part the columns, and in cells in quotation marks. Lines that begin with
``#`` are comments, unless rows of numbers follow without a header: then the last of them is the header.
"""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from bsm_mesh.errors import ModelError, raise_faults
from bsm_mesh.named_units import factor_of, unit_in, without_unit
from bsm_mesh.reading import as_given_text, read_text

DECIMAL_COMMAS = "where commas are decimal points part columns by semicolons"
NUMBER = re.compile(r"[-+]?[\d.,]+([eE][-+]?\d+)?(\s.*)?")  # with a unit behind it
COMMA = re.compile(r"[-+]?\d*,\d+([eE][-+]?\d+)?(\s.*)?")
POINT = re.compile(r"[-+]?\d*\.\d+([eE][-+]?\d+)?(\s.*)?")
FIGURE = re.compile(r"[-+]?[\d.,]*\d[\d.,]*([eE][-+]?\d+)?")
NO_HEADER = 0.5  # of the cells of a first row: more numbers are a row without a header
THOUSANDS = re.compile(r"[-+]?[1-9]\d{0,2}(,\d{3})+(\s.*)?")  # or a number with three decimals


class Rows(NamedTuple):
    """A table as it is in a file.

    Attributes
    ----------
    path : Path
        The file.
    header : list of str
        Names of the columns as they be there.
    lines : list of int
        Of each row its number in the file.
    cells : list of list of str
        Of each row.
    decimal_commas : bool
        Whether a comma is a decimal point.
    """

    path: Path
    header: list[str]
    lines: list[int]
    cells: list[list[str]]
    decimal_commas: bool

    @property
    def names(self) -> list[str]:
        """Names of the columns in small letters, without units, ``_`` for spaces."""
        return [re.sub(r"[\s-]+", "_", without_unit(name).lower()) for name in self.header]

    def columns(self, *names: str) -> list[int]:
        """Return the numbers of columns.

        Raises
        ------
        ModelError
            With those that are not there, or there twice.
        """
        known = self.names
        lacking = [name for name in names if name not in known]
        if lacking:
            s = "s" if len(names) > 1 else ""
            raise ModelError(f"{self.path}: needs the column{s} {', '.join(names)}; it has {', '.join(self.header)}")
        twice = [name for name in names if known.count(name) > 1]
        if twice:
            raise ModelError(f"{self.path}: two columns are called '{twice[0]}'; name them apart")
        return [known.index(name) for name in names]

    def factor(self, column: int, units: dict[str, float], example: str) -> float:
        """Return by what numbers in a column are multiplied: its name may have a unit, one of `units`.

        Raises
        ------
        ModelError
            If its unit is none of these.
        """
        name = self.header[column]
        return factor_of(unit_in(name), units, f"{self.path}: column '{name}'", f"{without_unit(name)} [{example}]")

    def place(self, row: int) -> str:
        """Return file and line of a row, for messages."""
        return f"{self.path}, line {self.lines[row]}"

    def plain(self, cell: str) -> str:
        """Return a cell with a point for its decimal comma."""
        return cell.replace(",", ".") if self.decimal_commas else cell

    def number(self, row: int, column: int) -> float:
        """Return the number in a cell, or that it is none."""
        try:
            return float(self.plain(self.cells[row][column]))
        except ValueError:
            return math.nan

    def finite(self, row: int, column: int, faults: list[str]) -> float:
        """Return the number in a cell; add a fault where there is none, or no finite one."""
        number, cell = self.number(row, column), self.cells[row][column]
        if not math.isfinite(number):
            cure = self.cure(cell, "")
            told = f"{self.place(row)}: {without_unit(self.header[column])} = '{cell}' is no finite number"
            faults.append(f"{told}; {cure}" if cure else told)
        return number

    def cure(self, cell: str, otherwise: str) -> str:
        """Return what helps a cell that is no number: semicolons, where its comma may be a decimal point."""
        return DECIMAL_COMMAS if "," in cell and not self.decimal_commas else otherwise


def read_rows(path: Path, holds: str) -> Rows:
    """Return the table in a file.

    Parameters
    ----------
    path : Path
        The file.
    holds : str
        What its rows hold, for messages: ``x and y among them, a row a node``.

    Raises
    ------
    ModelError
        If it is no text, has no table, two columns have one name, or a row is not complete. Commas and points as
        decimal points in one table are an error too.
    """
    lines, parting = _table_lines(read_text(path).split("\n"))
    reader = csv.reader([f"{line}\n" for line in lines], delimiter=parting, skipinitialspace=True, strict=True)
    try:
        table = [
            (reader.line_num, [as_given_text(cell.strip()) for cell in row])
            for row in reader
            if any(map(str.strip, row))
        ]
    except csv.Error as fault:
        raise ModelError(f"{path}, line {reader.line_num}: is no table: {fault}; correct the line") from fault
    if len(table) < 2:
        raise ModelError(f"{path}: has no rows; it needs a header and rows below it ({holds})")
    header = _without_empty_end(table[0][1], 1)
    if _share_of_numbers(header[:1]) and _share_of_numbers(header) > NO_HEADER:  # stages may be columns: x, y, 1, 2, 3
        raise ModelError(
            f"{path}, line {table[0][0]}: is no header; write one above it that names the columns ({holds})"
        )
    if twice := [name for name in header if name and header.count(name) > 1]:
        raise ModelError(f"{path}: two columns are called '{twice[0]}'; name them apart")
    rest = [(line, _without_empty_end(row, len(header))) for line, row in table[1:]]
    raise_faults(
        [
            f"{path}, line {line}: has more or fewer cells than the header ({len(row)}, not {len(header)})"
            + (f"; {DECIMAL_COMMAS}" if parting == "," and len(row) > len(header) else "")
            for line, row in rest
            if len(row) != len(header)
        ]
    )
    cells = [row for _, row in rest]
    return Rows(path, header, [line for line, _ in rest], cells, _decimal_commas(path, cells, parting))


def _decimal_commas(path: Path, cells: list[list[str]], parting: str) -> bool:
    """Return whether commas are decimal points; raise where points are too.

    In quotation marks between commas they may part thousands instead, unless some cell shows that they do not.
    """
    with_commas = [cell for row in cells for cell in row if "," in cell and COMMA.fullmatch(cell)]
    certain = parting != "," or any(not THOUSANDS.fullmatch(cell) for cell in with_commas)
    if with_commas and certain:
        numbers = [c for c in zip(*cells, strict=True) if all(not cell or NUMBER.fullmatch(cell) for cell in c)]
        if point := next((cell for column in numbers for cell in column if POINT.fullmatch(cell)), None):
            raise ModelError(
                f"{path}: has numbers with commas ('{with_commas[0]}') and with points ('{point}'); use one of them"
            )
    return certain


def _table_lines(lines: list[str]) -> tuple[list[str], str]:
    """Return the lines of a table, those of comments empty, and the sign that parts its columns."""
    sign = re.fullmatch(r'"?sep=(.)"?', lines[0].strip())  # as spreadsheets write it
    given = ["", *lines[1:]] if sign else lines
    kept = ["" if line.lstrip().startswith("#") else line for line in given]
    first = next((k for k, line in enumerate(kept) if line.strip()), None)
    if first is None:
        return kept, ","
    parting = sign[1] if sign else next((part for part in ";\t" if part in kept[first]), ",")
    above = next((k for k in range(first - 1, -1, -1) if given[k].strip()), None)
    if above is not None and _share_of_numbers(kept[first].split(parting)) > 0:
        header = given[above].lstrip(" \t#")
        if header.count(parting) == kept[first].count(parting):
            kept[above] = header
    return kept, parting


def _share_of_numbers(cells: Sequence[str]) -> float:
    """Return how many of some cells are numbers, as names of columns are not."""
    return sum(FIGURE.fullmatch(cell.strip().strip('"')) is not None for cell in cells) / len(cells)


def _without_empty_end(row: list[str], least: int) -> list[str]:
    """Return a row without the empty cells at its end, which spreadsheets add; so many are kept at least."""
    while len(row) > least and not row[-1]:
        row = row[:-1]
    return row
