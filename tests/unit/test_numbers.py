"""Tables of pages: found between their marks, replaced whole, compared number by number."""

from pathlib import Path

import pytest

from examples.numbers.__main__ import TABLES
from examples.numbers.pages import differences, markdown, table_in, with_table

ROOT = Path(__file__).parents[2]
PAGE = "# Page\n\n<!-- numbers one: begin -->\n\n| a |\n\n<!-- numbers one: end -->\n\nafter\n"


def test_a_table_is_replaced_between_its_marks():
    changed = with_table(PAGE, "one", "| b |")
    assert table_in(changed, "one") == "| b |"
    assert changed == PAGE.replace("| a |", "| b |")
    with pytest.raises(ValueError, match="needs the marks"):
        table_in(PAGE, "two")


@pytest.mark.parametrize(
    ("old", "new", "count"),
    [
        ("| x | 1.000 |", "| x | 1.004 |", 0),
        ("| x | 1.000 |", "| x | 1.006 |", 1),
        ("| x | 1.0 |", "| y | 1.0 |", 1),
        ("| x | 0 |", "| x | 1e-12 |", 0),
        ("| x | 1.0 |", "| x | 1.0 |\n| y | 2.0 |", 1),
        ("| x | -1.0 |", "| x | 1.0 |", 1),
    ],
)
def test_numbers_may_differ_by_the_tolerance_and_words_not_at_all(old, new, count):
    assert len(differences(old, new, 0.005)) == count


def test_every_table_has_its_marks():
    for table in TABLES.values():
        assert table_in((ROOT / table.page).read_text(encoding="utf-8"), table.name)


def test_markdown():
    assert markdown(("a", "b"), [("1", "2")]) == "| a | b |\n| --- | --- |\n| 1 | 2 |"
