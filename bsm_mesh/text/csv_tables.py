"""The one writer of tables (CSV), and the reader of those that it wrote. A spreadsheet takes no text for a formula.

Tables of others are read by `bsm_mesh.table_rows`.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO

from bsm_mesh.files import whole_file
from bsm_mesh.reading import FORMULA


def as_cell(value: object) -> object:
    """Return the text of a value: one that a spreadsheet would run is behind an apostrophe.

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
        Output.
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


@contextmanager
def csv_file(path: Path) -> Iterator[CsvWriter]:
    """Give a writer of a file, which is there once it is whole."""
    with whole_file(path) as draft, draft.open("w", newline="", encoding="utf-8") as file:
        yield CsvWriter(file)


def written_rows(content: bytes) -> list[dict[str, str]]:
    """Return the rows of a file that `csv_file` wrote, by the names of the columns.

    Raises
    ------
    ValueError
        If it is no such table.
    """
    try:
        return list(csv.DictReader(io.StringIO(content.decode(), newline="")))
    except csv.Error as fault:
        raise ValueError(str(fault)) from fault


def csv_text(rows: Iterable[Iterable[object]]) -> str:
    """Return rows as the text of a table."""
    text = io.StringIO()
    CsvWriter(text, "\n").writerows(rows)
    return text.getvalue()
