"""Tables between marks in Markdown pages, and where they were measured."""

from __future__ import annotations

import platform
from pathlib import Path


def marks(maker: str) -> tuple[str, str]:
    """Return the lines before and after what a command makes."""
    return f"<!-- made by {maker}: begin -->", f"<!-- made by {maker}: end -->"


def write_between(page: Path, maker: str, said: str, parts: list[tuple[str, str]]) -> None:
    """Write a sentence and titled tables between the marks of a page.

    Parameters
    ----------
    page : Path
        A page in Markdown.
    maker : str
        What makes them, as in `marks`.
    said : str
        How they were measured.
    parts : list of (str, str)
        Title and table in Markdown, which may be empty.

    Raises
    ------
    ValueError
        If the page has no such marks.
    """
    begin, end = marks(maker)
    text = page.read_text(encoding="utf-8")
    before, found, rest = text.partition(begin)
    _, closed, after = rest.partition(end)
    if not found or not closed:
        raise ValueError(f"{page} has no lines '{begin}' and '{end}' to write between")
    body = [said, *(f"### {title}\n\n{table or 'None.'}" for title, table in parts)]
    page.write_text(before + begin + "\n\n" + "\n\n".join(body) + "\n\n" + end + after, encoding="utf-8")


def processor() -> str:
    """Return the kind of this machine's processor."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or platform.machine()
