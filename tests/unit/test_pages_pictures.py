"""The table of docs/pictures.md: every picture that a page shows is in it, and every one in it is there."""

from __future__ import annotations

import re
from pathlib import Path

from examples.numbers.pages import table_in
from examples.pictures.drawing import ROOT, table
from examples.pictures.listed import PICTURES

SHOWN = re.compile(r"!\[[^\]]*\]\(([^)]+)\)")


def test_every_picture_of_the_pages_was_judged() -> None:
    pages = [ROOT / "README.md", *(ROOT / "docs").glob("*.md"), *(ROOT / "examples").glob("*/README.md")]
    shown = {
        (page.parent / target).resolve().relative_to(ROOT).as_posix()
        for page in pages
        for target in SHOWN.findall(page.read_text(encoding="utf-8"))
    }
    assert shown - {picture.target for picture in PICTURES} == set()
    for picture in PICTURES:
        assert (ROOT / picture.target).is_file()
        made = [
            model for model in picture.models if model.startswith(("demo/", "starter/", "tutorial/")) or ":" in model
        ]
        assert all((ROOT / model).is_file() for model in set(picture.models) - set(made))
        assert picture.elsewhere or picture.script or picture.models


def test_the_table_is_that_of_the_list() -> None:
    page = Path(ROOT / "docs/pictures.md").read_text(encoding="utf-8")
    assert table_in(page, "pictures") == table(PICTURES)
