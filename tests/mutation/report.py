"""What a sample says: the score of every room with its sampling error, and its survivors, explained or open."""

from __future__ import annotations

from collections.abc import Iterator
from math import sqrt
from typing import Any

from .equivalent import EQUIVALENT
from .place import KILLED, SURVIVED, TIMEOUT
from .rooms import ROOMS

Row = dict[str, Any]
CONFIDENCE = 1.96  # standard deviations of a normal distribution that hold 95 %


def markdown(rows: list[Row], size: int, seed: int) -> str:
    """Return the score in a sentence, its table by rooms and that of the survivors."""
    survived = sorted((row for row in rows if row["outcome"] == SURVIVED), key=lambda row: (row["file"], row["line"]))
    equivalent = sum(reason(row) is not None for row in survived)
    noticed, count = len(rows) - len(survived), len(rows)
    at_first = sum(row["first"] != SURVIVED for row in rows)
    said = [f"Seed {seed}, {count} of {size} mutants tried: at the first try tests noticed {_score(at_first, count)}."]
    if noticed > at_first:
        said.append(f"With tests written for its survivors they notice {noticed} of {count}, {noticed / count:.0%}.")
    if equivalent:
        part = f"{noticed} of {count - equivalent}, {noticed / (count - equivalent):.0%}"
        said.append(f"Equivalent to the program are {equivalent}: without these {part}.")
    seconds = sum(row["seconds"] for row in rows) / max(count, 1)
    said.append(f"A mutant took {seconds:.0f} s of processor time on the average.")
    return "\n\n".join([" ".join(said), "\n".join(_rooms(rows)), "\n".join(_survivors(survived))])


def reason(row: Row) -> str | None:
    """Return why a mutant computes the same, where that is known."""
    old, new = (" ".join(line[2:] for line in row["diff"] if line[0] == sign) for sign in "-+")
    return EQUIVALENT.get((row["file"], old, new))


def interval(noticed: int, count: int) -> tuple[float, float]:
    """Return the interval of Wilson (1927, J. Am. Stat. Assoc. 22, 209) for a share, of 95 % confidence."""
    z, share = CONFIDENCE, noticed / count
    middle = share + z**2 / (2 * count)
    half = z * sqrt(share * (1 - share) / count + z**2 / (4 * count**2))
    return (middle - half) / (1 + z**2 / count), (middle + half) / (1 + z**2 / count)


def _score(noticed: int, count: int) -> str:
    if count == 0:
        return "none"
    low, high = interval(noticed, count)
    return f"{noticed} of {count}, {noticed / count:.0%} (of all mutants {low:.0%} to {high:.0%}, with 95 % confidence)"


def _rooms(rows: list[Row]) -> Iterator[str]:
    yield "| room | mutants | killed | timeout | survived | equivalent | score |"
    yield "|---|---|---|---|---|---|---|"
    for name, some in _by_room(rows):
        count = {outcome: sum(row["outcome"] == outcome for row in some) for outcome in (KILLED, TIMEOUT, SURVIVED)}
        equivalent = sum(row["outcome"] == SURVIVED and reason(row) is not None for row in some)
        numbers = " | ".join(map(str, (len(some), *count.values(), equivalent)))
        yield f"| {name} | {numbers} | {1 - count[SURVIVED] / len(some):.0%} |"


def _by_room(rows: list[Row]) -> Iterator[tuple[str, list[Row]]]:
    for room in ROOMS:
        some = [row for row in rows if row["room"] == room]
        if some:
            yield room, some
    if rows:
        yield "all", rows


def _survivors(rows: list[Row]) -> Iterator[str]:
    if not rows:
        yield "No mutant survived."
        return
    yield "| survivor | the program | the mutant | equivalent because |"
    yield "|---|---|---|---|"
    for row in rows:
        old, new = (_code(" ".join(line[2:] for line in row["diff"] if line[0] == sign)) for sign in "-+")
        why = reason(row) or ("open" if row["tests"] else "open: no test calls it")
        yield f"| `{row['file']}:{row['line']}` | {old} | {new} | {why} |"


def _code(text: str) -> str:
    return f"`{text.replace('|', chr(92) + '|')}`"
