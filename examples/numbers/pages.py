"""Tables between marks in Markdown pages, and by how much two of them differ."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from itertools import zip_longest

NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")
SMALLEST = 1e-9


@dataclass(frozen=True, kw_only=True)
class Table:
    """A part of a page that a command makes: a table, or sentences with numbers.

    Attributes
    ----------
    name : str
        As its marks carry it.
    page : str
        The page, relative to the checkout.
    make : callable
        Runs what it tells of, and returns it as Markdown.
    tolerance : float
        By how much its numbers may differ, over themselves; those with decimals always by one in the last.
    is_slow : bool
        Whether it takes minutes.
    draw : callable or None
        Draws the picture beside it, where the page is written.
    """

    name: str
    page: str
    make: Callable[[], str]
    tolerance: float = 0.005
    is_slow: bool = False
    draw: Callable[[], None] | None = None


def marks(name: str) -> tuple[str, str]:
    """Return the lines before and after a table."""
    return f"<!-- numbers {name}: begin -->", f"<!-- numbers {name}: end -->"


def table_in(page: str, name: str) -> str:
    """Return a table of a page."""
    return parted(page, marks(name))[1].strip()


def with_table(page: str, name: str, table: str) -> str:
    """Return a page with another table."""
    return with_between(page, marks(name), table)


def with_between(page: str, between: tuple[str, str], text: str) -> str:
    """Return a page with another text between two marks."""
    before, _, after = parted(page, between)
    return f"{before}{between[0]}\n\n{text.strip()}\n\n{between[1]}{after}"


def parted(page: str, between: tuple[str, str]) -> tuple[str, str, str]:
    """Return what stands before, between and after two marks of a page.

    Raises
    ------
    ValueError
        If a mark is not there once, or the second stands before the first.
    """
    begin, end = between
    before, _, rest = page.partition(begin)
    if page.count(begin) != 1 or rest.count(end) != 1 or end in before:
        raise ValueError(f"the page needs the marks {begin} and {end}, once each and in this order")
    found, _, after = rest.partition(end)
    return before, found, after


def differences(old: str, new: str, tolerance: float) -> list[str]:
    """Return what differs between two tables, a line each: numbers by more than `tolerance`, and other words."""
    lines = zip_longest(old.splitlines(), new.splitlines(), fillvalue="")
    return [f"{one!r} is {other!r}" for one, other in lines if _differ(one, other, tolerance)]


def _differ(one: str, other: str, tolerance: float) -> bool:
    words = [[part.strip() for part in NUMBER.sub("#", line).split()] for line in (one, other)]
    if words[0] != words[1]:
        return True
    return any(
        abs(float(a) - float(b)) > max(tolerance * max(abs(float(a)), abs(float(b)), SMALLEST), _last_digit(a))
        for a, b in zip(NUMBER.findall(one), NUMBER.findall(other), strict=True)
    )


def _last_digit(number: str) -> float:
    """Return one in the last decimal that is printed, and a little; nothing for a whole number."""
    decimals = len(number.partition(".")[2])
    return 1.001 * 10.0**-decimals if decimals and "e" not in number else 0.0


def markdown(header: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table as Markdown."""
    lines = [header, ["---"] * len(header), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)
