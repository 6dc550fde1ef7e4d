"""Words and sentences that readers stumble over: ``python -m tools.words [--list RULE] [--since main] [--write]``.

Counts each rule of `RULES` in pages (README, CHANGELOG, CONTRIBUTING and others, docs, examples), in docstrings of the
program, and in its messages, and compares the counts with `words.json`. The exit code is 1 if a count is higher.
`--list` names every place of a rule (or of all rules), `--since` the places in lines that differ from a revision, and
`--write` stores counts that have fallen.
"""

from __future__ import annotations

import argparse
import ast
import json
import re
import subprocess
import sys
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

ROOT = Path(__file__).parents[1]
STORED = Path(__file__).with_name("words.json")
PACKAGES = ("bsm_mesh", "converters", "geometries")
PLACES = ("pages", "docstrings", "messages")
MAX_WORDS = 25  # of a sentence
MIN_WORDS = 3  # of a string that is a message: others are keys and names
RULES = {  # what is counted: where it matches; in any case of letters, without what stands between backquotes
    "what is ... as a noun": r"\bwhat (is|are|was|were|has|have|had|it|they|a|an|the|no|one|each|every|must|may|can)\b",
    "sentence that begins with what, who, those that, where it is": r"(?:^|[.:;!] )(what|who|whoever|whatever"
    r"|those that|where (it|that|this|they) (is|are|was|were))\b[^.?]*(?:[.]|$)",
    "tell": r"\b(tell|tells|told|telling)\b",
    "beside": r"\bbeside\b",
    "bear": r"\b(bear|bears|bore|borne)\b",
    "stand": r"\b(stand|stands|stood)\b",
    "lack": r"\black(s|ed)?\b",
    "lend": r"\b(lends?|lent)\b",
    "settles": r"\b(settles|settled)\b",
    "come": r"\b(come|comes|came) (down|out|to|up|in|for|of|again|by)\b",
    "go": r"\b(go|goes|went|gone) (on|by|with|for|out|into)\b",
    "has moved": r"\b(has|have|had) moved\b",
    "mend": r"\bmend(s|ed|ing)?\b",
    "farther": r"\b(farther|farthest)\b",
    "in vain, by turns, to and fro": r"\b(in vain|by turns|to and fro)\b",
}
ENTRY = re.compile(r"\w[\w, .*]* : \S")  # of numpydoc: a name and its type; what follows is a text of its own
TOO_LONG = f"sentence of more than {MAX_WORDS} words"
REPEATS = "first line that repeats the name"


@dataclass(frozen=True, slots=True)
class Text:
    """A paragraph, docstring or message, and where it begins.

    Attributes
    ----------
    place : str
        One of `PLACES`.
    path : pathlib.Path
    line : int
        Of its first line in the file, from 1.
    words : str
        Without what is between backquotes.
    name : str
        Of the function whose docstring it is; empty for others.
    """

    place: str
    path: Path
    line: int
    words: str
    name: str = ""


def read_texts(root: Path = ROOT) -> Iterator[Text]:
    """Yield every text of a checkout."""
    pages = [*root.glob("*.md"), *root.glob("docs/**/*.md"), *root.glob("examples/**/*.md")]
    for path in sorted(pages):
        yield from page_texts(path)
    for package in PACKAGES:
        for path in sorted((root / package).rglob("*.py")):
            yield from module_texts(path)


def page_texts(path: Path) -> Iterator[Text]:
    """Yield the paragraphs, items and rows of a page, without its code blocks."""
    begin, lines, in_code = 1, [], False

    def close() -> Iterator[Text]:
        if lines:
            yield Text("pages", path, begin, plain(" ".join(lines)))

    before, indented = "", False
    for number, line in enumerate([*path.read_text(encoding="utf-8").splitlines(), ""], 1):
        if line.lstrip().startswith("```"):
            in_code = not in_code
        indented = line.startswith("    ") and (indented or not before)  # code, without backquotes
        before = line.strip()
        is_break = not before or in_code or indented or line.lstrip().startswith("```")
        if is_break or re.match(r"\s*([-*|#>]|\d+\.) ?", line):
            yield from close()
            begin, lines = number, []
        if not is_break:
            lines.append(re.sub(r"^\s*([-*#>]+|\d+\.) +", "", line.strip()))


def module_texts(path: Path) -> Iterator[Text]:
    """Yield the docstrings and messages of a module."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    docstrings = set()
    inside = {id(part) for joined in ast.walk(tree) if isinstance(joined, ast.JoinedStr) for part in joined.values}
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            text = ast.get_docstring(node)
            if text is not None:
                constant = node.body[0].value  # type: ignore[attr-defined]
                docstrings.add(id(constant))
                name = node.name if isinstance(node, ast.FunctionDef) and not node.name.startswith("_") else ""
                yield from _docstring_texts(text, path, constant.lineno, name)
        elif isinstance(node, ast.JoinedStr):
            parts = [part.value if isinstance(part, ast.Constant) else "`x`" for part in node.values]
            yield from _message("".join(parts), path, node.lineno)
        elif isinstance(node, ast.Constant) and isinstance(node.value, str) and not {id(node)} & (docstrings | inside):
            yield from _message(node.value, path, node.lineno)


def _docstring_texts(text: str, path: Path, line: int, name: str) -> Iterator[Text]:
    """Yield the paragraphs of a docstring and the entries of its lists, without heads of sections and examples."""
    paragraphs = re.split(r"(\n\s*\n)", text)
    for index, paragraph in enumerate(paragraphs[::2]):
        rows = paragraph.splitlines()
        starts = [0, *(number for number, row in enumerate(rows) if number and ENTRY.match(row)), len(rows)]
        for first, end in pairwise(starts):
            part = [row for row in rows[first:end] if set(row.strip()) != {"-"}]
            words = "\n".join(part).partition(">>>")[0]
            if words.strip():
                is_first = not index and not first
                yield Text("docstrings", path, line + first, plain(words), name if is_first else "")
        line += sum(part.count("\n") for part in paragraphs[2 * index : 2 * index + 2])


def _message(words: str, path: Path, line: int) -> Iterator[Text]:
    if len(words.split()) >= MIN_WORDS:
        yield Text("messages", path, line, plain(words))


def plain(text: str) -> str:
    """Return a text on one line, without code and the targets of links.

    >>> plain("as `told` in  [pages](beside.md)")
    'as x in pages'
    """
    text = re.sub(r"`+[^`]+`+", "x", text)
    text = re.sub(r"\]\([^)]*\)", "", text).replace("[", "").replace("**", "")
    return " ".join(text.split())


def broken_rules(text: Text) -> list[str]:
    """Return the rules that a text breaks, each as often as it does."""
    found = [
        rule for rule, pattern in RULES.items() for _ in re.finditer(pattern, text.words, re.IGNORECASE | re.MULTILINE)
    ]
    if not text.words.startswith("|"):  # a row of a table
        sentences = re.split(r"[.?!;] |[.?!]$", text.words)
        found += [TOO_LONG for sentence in sentences if len(re.findall(r"[^\W\d_]{2,}|\ba\b", sentence)) > MAX_WORDS]
    if text.name:
        words = set(re.findall(r"[a-z]+", text.words.lower())) - {"return", "yield", "a", "an", "the", "of", "its"}
        if words <= set(text.name.split("_")):
            found.append(REPEATS)
    return found


def count(texts: list[Text]) -> dict[str, dict[str, int]]:
    """Return how often each rule is broken in each place."""
    found = Counter((rule, text.place) for text in texts for rule in broken_rules(text))
    return {rule: {place: found[rule, place] for place in PLACES} for rule in [*RULES, TOO_LONG, REPEATS]}


def changed_lines(revision: str) -> set[tuple[Path, int]]:
    """Return the lines of the checkout that differ from a revision, as (file, line)."""
    command = ["git", "diff", "--unified=0", "--no-color", "--no-ext-diff", revision]
    found, path = set(), ROOT
    for line in subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout.splitlines():
        if line.startswith("+++ "):
            path = ROOT / line.removeprefix("+++ b/")
        elif match := re.match(r"@@ -\S+ \+(\d+)(?:,(\d+))? @@", line):
            first, number = int(match[1]), int(match[2] or 1)
            found |= {(path, first + offset) for offset in range(number)}
    return found


def list_places(texts: list[Text], rule: str, revision: str | None) -> None:
    """Print the places where a rule is broken, or any where `rule` is empty."""
    changed = None if revision is None else changed_lines(revision)
    for text in texts:
        length = text.words.count(" ") // 10 + 2  # lines, about
        if changed is not None and not any((text.path, text.line + offset) in changed for offset in range(length)):
            continue
        for broken in dict.fromkeys(broken_rules(text)):
            if rule in broken:
                print(f"{text.path.relative_to(ROOT)}:{text.line}: {broken}: {text.words[:200]}")


def compare(counts: dict[str, dict[str, int]], stored: dict[str, dict[str, int]]) -> bool:
    """Print what has risen or fallen; return whether nothing has risen."""
    risen = False
    for rule, places in counts.items():
        for place, number in places.items():
            before = stored.get(rule, {}).get(place, 0)
            if number != before:
                print(f"{place}, {rule}: {before} before, {number} now")
            risen |= number > before
    if risen:
        print("write the new ones in other words: `python -m tools.words --since main --list` names them")
    return not risen


def main() -> int:
    """Count, list or store."""
    parser = argparse.ArgumentParser(prog="python -m tools.words", description="Words that readers stumble over.")
    parser.add_argument(
        "--list", metavar="RULE", nargs="?", const="", help="name the places, of rules with this in them"
    )
    parser.add_argument("--since", metavar="REVISION", help="list places in lines that differ from this revision")
    parser.add_argument("--write", action="store_true", help="store counts that have fallen")
    asked = parser.parse_args()
    texts = list(read_texts())
    if asked.list is not None or asked.since:
        list_places(texts, asked.list or "", asked.since)
        return 0
    counts = count(texts)
    stored = json.loads(STORED.read_text(encoding="utf-8")) if STORED.is_file() else counts
    held = compare(counts, stored)
    if asked.write:
        for rule, places in counts.items():
            for place in places:
                places[place] = min(places[place], stored.get(rule, counts[rule])[place])
        rows = ",\n".join(f"  {json.dumps(rule)}: {json.dumps(places)}" for rule, places in counts.items())
        STORED.write_text(f"{{\n{rows}\n}}\n", encoding="utf-8")
    return 0 if held else 1


if __name__ == "__main__":
    sys.exit(main())
