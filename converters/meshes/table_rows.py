"""Rows of tables (CSV): commas, semicolons or tabs between the columns, whose names stand in the first row."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np

from bsm_mesh.errors import ModelError

DECIMAL_COMMAS = "where commas are decimal points part columns by semicolons"


def read_rows(path: Path, holds: str) -> tuple[list[str], list[int], list[list[str]]]:
    """Return the names of the columns, and of each row its number in the file and its cells, with decimal points.

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
        table = [(reader.line_num, [cell.strip() for cell in row]) for row in reader if any(row)]
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
    lines, rows = [line for line, _ in rest], [row for _, row in rest]
    return header, lines, rows if parting == "," else [[cell.replace(",", ".") for cell in row] for row in rows]


def number_in(cell: str) -> float:
    """Return the number in a cell, or that it is none."""
    try:
        return float(cell)
    except ValueError:
        return np.nan
