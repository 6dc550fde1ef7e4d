"""Pages that are notebooks too: ``python -m docs.notebooks`` runs their cells and writes page, picture and notebook.

The page is the source. Its blocks of Python are the cells, and a block ``text`` after one holds the lines that the cell
printed. The notebook is made from the page, without a library of notebooks: its format is JSON (nbformat 4.5).
"""

from __future__ import annotations

import json
import re
import shutil
import tempfile
from contextlib import chdir, redirect_stdout
from dataclasses import dataclass
from io import StringIO
from pathlib import Path
from typing import Any

PAGE = Path(__file__).with_name("notebook.md")
CELL = re.compile(r"^```python\n(?P<code>.*?)^```\n(?:\n```text\n(?P<printed>.*?)^```\n)?", re.DOTALL | re.MULTILINE)


@dataclass(frozen=True, slots=True)
class Cell:
    """A cell of a notebook.

    Attributes
    ----------
    text : str
        Markdown, or Python where `is_code`.
    is_code : bool
    printed : str
        The lines that the code prints.
    """

    text: str
    is_code: bool = False
    printed: str = ""


def cells_of(page: str) -> list[Cell]:
    """Return the cells of a page, in order."""
    cells, end = [], 0
    for match in CELL.finditer(page):
        cells += [Cell(page[end : match.start()].strip()), Cell(match["code"], True, match["printed"] or "")]
        end = match.end()
    return [cell for cell in [*cells, Cell(page[end:].strip())] if cell.text]


def page_of(cells: list[Cell]) -> str:
    """Return the page of some cells."""
    parts = []
    for cell in cells:
        parts.append(f"```python\n{cell.text}```" if cell.is_code else cell.text)
        if cell.printed:
            parts.append(f"```text\n{cell.printed}```")
    return "\n\n".join(parts) + "\n"


def run_cells(cells: list[Cell], folder: Path) -> list[Cell]:
    """Return the cells with the lines that they print now; their files are written into `folder`."""
    names: dict[str, Any] = {}
    done = []
    with chdir(folder):
        for cell in cells:
            printed = StringIO()
            if cell.is_code:
                with redirect_stdout(printed):
                    exec(compile(cell.text, str(PAGE), "exec"), names)
            done.append(Cell(cell.text, cell.is_code, printed.getvalue()))
    return done


def notebook_of(cells: list[Cell]) -> str:
    """Return the notebook of some cells, as JSON."""
    listed: list[dict[str, Any]] = []
    number = 0
    for cell in cells:
        made: dict[str, Any] = {"cell_type": "markdown", "id": f"cell-{len(listed)}", "metadata": {}}
        if cell.is_code:
            number += 1
            stream = {"name": "stdout", "output_type": "stream", "text": cell.printed.splitlines(keepends=True)}
            made |= {"cell_type": "code", "execution_count": number, "outputs": [stream] if cell.printed else []}
        listed.append({**made, "source": cell.text.rstrip("\n").splitlines(keepends=True)})
    kernel = {"display_name": "Python 3", "language": "python", "name": "python3"}
    whole = {
        "cells": listed,
        "metadata": {"kernelspec": kernel, "language_info": {"name": "python"}},
        "nbformat": 4,
        "nbformat_minor": 5,
    }
    return json.dumps(whole, indent=1, ensure_ascii=False) + "\n"


def main() -> None:
    """Run the cells of the page and write page, pictures and notebook."""
    with tempfile.TemporaryDirectory() as folder:
        cells = run_cells(cells_of(PAGE.read_text(encoding="utf-8")), Path(folder))
        for picture in Path(folder).glob("*.png"):
            shutil.copy(picture, PAGE.parent)
    PAGE.write_text(page_of(cells), encoding="utf-8")
    PAGE.with_suffix(".ipynb").write_text(notebook_of(cells), encoding="utf-8")


if __name__ == "__main__":
    main()
