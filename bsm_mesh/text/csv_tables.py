"""The one writer of tables (CSV). A spreadsheet takes no text in them for a formula."""

from __future__ import annotations

import csv
from collections.abc import Iterable
from typing import IO

from bsm_mesh.reading import FORMULA


def as_cell(value: object) -> object:
    """Return what is written of a value: a text that a spreadsheet would run is behind an apostrophe.

    `bsm_mesh.reading.as_given_text` takes it away. Numbers, also those that are texts, stay as they are.

    Examples
    --------
    >>> as_cell("=1+1"), as_cell("J1"), as_cell("-1.5e3"), as_cell(-2)
    ("'=1+1", 'J1', '-1.5e3', -2)
    """
    if not isinstance(value, str) or FORMULA.match(value) is None:
        return value
    try:
        float(value)
    except ValueError:
        return f"'{value}"
    return value


class CsvWriter:
    """Writes rows of texts and numbers.

    Parameters
    ----------
    file : file
        What is written to.
    end : str
        Of a line.
    """

    def __init__(self, file: IO[str], end: str = "\r\n") -> None:
        self._writer = csv.writer(file, lineterminator=end)

    def writerow(self, cells: Iterable[object]) -> None:
        """Write a row."""
        self._writer.writerow([as_cell(cell) for cell in cells])

    def writerows(self, rows: Iterable[Iterable[object]]) -> None:
        """Write several rows."""
        for row in rows:
            self.writerow(row)
