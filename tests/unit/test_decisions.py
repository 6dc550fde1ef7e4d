"""Decision records: at most thirty, half a page each, dated, in the index; ids in the code are those of records."""

from __future__ import annotations

import re
from pathlib import Path

ROOT = Path(__file__).parents[2]
RECORDS = sorted((ROOT / "docs" / "decisions").glob("[0-9]*.md"))
MAX_RECORDS, MAX_WORDS = 30, 350
HEAD = re.compile(r"# (D\d{4}): (.+)\n\nDate: \d{4}-\d\d-\d\d\. Status: (accepted|not taken|superseded by \[D\d{4}\])")
INDEX = (ROOT / "docs" / "decisions" / "README.md").read_text(encoding="utf-8")


def test_records_are_numbered_dated_and_listed() -> None:
    for record in RECORDS:
        found = HEAD.match(record.read_text(encoding="utf-8"))
        assert found is not None, record.name
        assert found[1] == f"D{record.name[:4]}", record.name
        assert f"| [{found[1]}]({record.name}) | {found[2]} |" in INDEX
    assert INDEX.count("| [D") == len(RECORDS) > 0


def test_records_are_few_and_short() -> None:
    """Measurements are in docs/experiments, reasons of one module in its docstring."""
    assert len(RECORDS) <= MAX_RECORDS
    words = {record.name: len(record.read_text(encoding="utf-8").split()) for record in RECORDS}
    assert {name: number for name, number in words.items() if number > MAX_WORDS} == {}


def test_every_record_says_what_was_chosen() -> None:
    assert [record.name for record in RECORDS if "\n## Choice\n" not in record.read_text(encoding="utf-8")] == []


def test_ids_in_the_code_are_those_of_records() -> None:
    known = {f"D{record.name[:4]}" for record in RECORDS}
    sources = [
        path
        for part in ("bsm_mesh", "converters", "geometries", "tests", "benchmarks", "tools")
        for path in (ROOT / part).rglob("*.py")
    ]
    named = {name for path in sources for name in re.findall(r"\bD\d{4}\b", path.read_text(encoding="utf-8"))}
    assert named - known == set()
