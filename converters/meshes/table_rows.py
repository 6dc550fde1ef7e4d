"""Rows of tables (CSV): commas, semicolons or tabs between the columns, whose names stand in the first row."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import NamedTuple

import numpy as np

from bsm_mesh.errors import ModelError
from bsm_mesh.reading import as_given_text

DECIMAL_COMMAS = "where commas are decimal points part columns by semicolons"


class Rows(NamedTuple):
    """A table as it stands in a file.

    Attributes
    ----------
    header : list of str
        Names of the columns.
    lines : list of int
        Of each row its number in the file.
    cells : list of list of str
        Of each row.
    decimal_commas : bool
        Whether a comma may be a decimal point.
    """

    header: list[str]
    lines: list[int]
    cells: list[list[str]]
    decimal_commas: bool

    def number(self, row: int, column: int) -> float:
        """Return the number in a cell, or that it is none."""
        cell = self.cells[row][column]
        try:
            return float(cell.replace(",", ".") if self.decimal_commas else cell)
        except ValueError:
            return np.nan

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
        If it is no text, holds no table, two columns have one name, or a row is not complete.
    """
    try:
        text = path.read_text(encoding="utf-8-sig").splitlines()
    except UnicodeDecodeError as error:
        raise ModelError(
            f"{path}: no text of UTF-8 ({error.reason} at byte {error.start}); save it as CSV UTF-8"
        ) from None
    parting = next((sign for sign in ";\t" if text and sign in text[0]), ",")
    reader = csv.reader(text, delimiter=parting)
    try:
        table = [(reader.line_num, [as_given_text(cell.strip()) for cell in row]) for row in reader if any(row)]
    except csv.Error:
        table = []
    if len(table) < 2:
        raise ModelError(f"{path}: holds no table; its first row names the columns, {holds}")
    (_, header), *rest = table
    if twice := [name for name in header if name and header.count(name) > 1]:
        raise ModelError(f"{path}: two columns are called '{twice[0]}'; name them apart")
    for line, row in rest:
        if len(row) != len(header):
            cure = f"; {DECIMAL_COMMAS}" if parting == "," and len(row) > len(header) else ""
            raise ModelError(f"{path}: row {line} has {len(row)} columns, and the first {len(header)}{cure}")
    return Rows(header, [line for line, _ in rest], [row for _, row in rest], parting != ",")
