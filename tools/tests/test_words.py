"""Rules for plain words are counted where they are broken, and counts only fall."""

import json
from pathlib import Path

import pytest

from tools import words
from tools.words import REPEATS, TOO_LONG, Text, broken_rules, compare, count, module_texts, page_texts


@pytest.mark.parametrize(
    ("sentence", "rule"),
    [
        ("Blocks in what is left fall.", "what is ... as a noun"),
        ("It falls. What falls is removed.", "sentence that begins with what, who, those that, where it is"),
        ("The user is told.", "tell"),
        ("The joint bears 3 kN.", "bear"),
        ("Numbers stand in the file.", "stand"),
        ("Many files come out.", "come"),
        (" ".join(["word"] * 26) + ".", TOO_LONG),
    ],
)
def test_a_sentence_that_breaks_a_rule(sentence, rule):
    assert broken_rules(Text("pages", Path("a.md"), 1, sentence)) == [rule]


@pytest.mark.parametrize("sentence", ["What holds it?", "The support is understood.", "word " * 25 + ". Another one."])
def test_a_sentence_that_breaks_none(sentence):
    assert broken_rules(Text("pages", Path("a.md"), 1, sentence)) == []


def test_a_first_line_that_repeats_the_name():
    assert broken_rules(Text("docstrings", Path("a.py"), 1, "Return a rock.", "make_rock")) == [REPEATS]
    assert broken_rules(Text("docstrings", Path("a.py"), 1, "Return the weight of a rock in N.", "make_rock")) == []


def test_code_is_not_counted_in_pages(tmp_path):
    page = tmp_path / "a.md"
    page.write_text(
        "Set `told` to 1:\n\n```\nit is told\n```\n- It is\n  told.\n\n    it is told\n    told\n| tell | 2 |\n",
        encoding="utf-8",
    )
    assert [(text.line, text.words) for text in page_texts(page)] == [
        (1, "Set x to 1:"),
        (6, "It is told."),
        (11, "| tell | 2 |"),
    ]


def test_docstrings_and_messages_of_a_module(tmp_path):
    module = tmp_path / "a.py"
    module.write_text(
        'def f():\n    """Tell it.\n\n    It bears.\n\n    >>> "told it all"\n    """\n'
        '    raise ValueError(f"what is {1} told, is told")\n\n\nNAME = "told"\n',
        encoding="utf-8",
    )
    texts = [(text.place, text.line, text.words) for text in module_texts(module)]
    assert texts == [
        ("docstrings", 2, "Tell it."),
        ("docstrings", 4, "It bears."),
        ("messages", 8, "what is x told, is told"),
    ]


def test_counts_may_fall_and_not_rise(tmp_path, monkeypatch, capsys):
    page = tmp_path / "a.md"
    page.write_text("It is told. It is told.\n", encoding="utf-8")
    counts = count(list(page_texts(page)))
    assert counts["tell"]["pages"] == 2
    assert compare(counts, counts)
    assert not capsys.readouterr().out
    assert not compare(counts, {**counts, "tell": {"pages": 1}})
    assert "1 before, 2 now" in capsys.readouterr().out
    stored = tmp_path / "words.json"
    monkeypatch.setattr(words, "STORED", stored)
    monkeypatch.setattr(words, "read_texts", lambda: page_texts(page))
    monkeypatch.setattr("sys.argv", ["words", "--write"])
    stored.write_text(json.dumps({rule: dict.fromkeys(places, 1) for rule, places in counts.items()}), encoding="utf-8")
    assert words.main() == 1, "what has risen is not stored"
    assert json.loads(stored.read_text(encoding="utf-8"))["tell"] == {"pages": 1, "docstrings": 0, "messages": 0}
