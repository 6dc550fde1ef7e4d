"""The notebook page: its cells run and print the lines that the page shows, and the notebook is that of the page."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from docs.notebooks import PAGE, cells_of, notebook_of, page_of, run_cells
from examples.numbers.pages import differences

ROUNDING = 0.005  # relative: linear solvers round differently
TEXT = PAGE.read_text(encoding="utf-8")


def test_the_notebook_is_that_of_the_page() -> None:
    stored = PAGE.with_suffix(".ipynb").read_text(encoding="utf-8")
    assert page_of(cells_of(TEXT)) == TEXT
    assert stored == notebook_of(cells_of(TEXT)), "run `python -m docs.notebooks`"


def test_a_notebook_has_the_parts_of_the_format() -> None:
    notebook = json.loads(notebook_of(cells_of("# Title\n\n```python\nprint(1)\n```\n\n```text\n1\n```\n\nEnd.\n")))
    assert (notebook["nbformat"], notebook["nbformat_minor"]) == (4, 5)
    kinds = [cell["cell_type"] for cell in notebook["cells"]]
    assert kinds == ["markdown", "code", "markdown"]
    assert len({cell["id"] for cell in notebook["cells"]}) == 3
    code = notebook["cells"][1]
    assert code["source"] == ["print(1)"]
    assert code["outputs"] == [{"name": "stdout", "output_type": "stream", "text": ["1\n"]}]


@pytest.mark.heavy
@pytest.mark.usefixtures("drawn_here")
def test_the_cells_print_the_lines_of_the_page(tmp_path: Path) -> None:
    cells = cells_of(TEXT)
    for shown, now in zip(cells, run_cells(cells, tmp_path), strict=True):
        assert differences(shown.printed, now.printed, ROUNDING) == []
    assert (tmp_path / "notebook.png").stat().st_size > 0
