"""The paper cites what its bibliography has, and sends its readers to pages that are there."""

from __future__ import annotations

import re
from pathlib import Path

ROOT = Path(__file__).parents[2]
PAPER = (ROOT / "paper" / "paper.md").read_text(encoding="utf-8")
KEYS = re.findall(r"^@\w+\{(\w+),", (ROOT / "paper" / "paper.bib").read_text(encoding="utf-8"), re.MULTILINE)


def test_citations_and_bibliography_are_the_same() -> None:
    assert set(re.findall(r"@([a-z]+\d{4})", PAPER)) == set(KEYS)
    assert len(KEYS) == len(set(KEYS))


def test_numbers_stand_in_pages_that_are_there() -> None:
    pages = re.findall(r"`(docs/\w+\.md)`", PAPER)
    assert len(pages) > 5
    assert [page for page in pages if not (ROOT / page).is_file()] == []


def test_it_has_the_length_that_the_journal_takes() -> None:
    words = len(PAPER.split("---", 2)[2].split())
    assert 750 <= words <= 1750
