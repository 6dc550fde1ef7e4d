"""What a command makes, between marks in a Markdown page (``--into PAGE``), and where it was measured."""

from __future__ import annotations

import argparse
import platform
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from bsm_mesh.files import write_text
from examples.numbers.pages import markdown, parted, with_between


def marks(maker: str) -> tuple[str, str]:
    """Return the lines before and after what a command makes."""
    return f"<!-- made by {maker}: begin -->", f"<!-- made by {maker}: end -->"


def add_into(command: argparse.ArgumentParser, maker: str) -> None:
    """Add the option ``--into PAGE``; a page without the marks of `maker` is refused before anything is run."""

    def page(given: str) -> Path:
        try:
            parted(Path(given).read_text(encoding="utf-8"), marks(maker))
        except (OSError, ValueError) as error:
            raise argparse.ArgumentTypeError(f"{given}: {error}") from None
        return Path(given)

    command.add_argument("--into", type=page, metavar="PAGE", help="a page in Markdown: what is between its marks")


def tell(text: str, maker: str, page: Path | None) -> None:
    """Write a text between the marks of a page, or print it where no page is given."""
    if page is None:
        print(text)
    else:
        write_text(page, with_between(page.read_text(encoding="utf-8"), marks(maker), text))


def table_command(
    maker: str, about: str | None, header: Sequence[str], rows: Callable[[], list[tuple[str, ...]]]
) -> int:
    """Solve the cases of a command, and print the table of its rows or put it into a page; return the exit code."""
    parser = argparse.ArgumentParser(prog=maker, description=about)
    add_into(parser, maker)
    given = parser.parse_args()
    tell(markdown(header, rows()), maker, given.into)
    return 0


def seeds_command(
    maker: str,
    about: str | None,
    count: int,
    judge: Callable[[int], dict[str, Any]],
    table: Callable[[list[dict[str, Any]]], str],
) -> int:
    """Judge models by their seeds, and print their table or put it into a page; return the exit code."""
    parser = argparse.ArgumentParser(prog=maker, description=(about or "").splitlines()[0])
    parser.add_argument("-n", type=int, default=count, help="models in all")
    parser.add_argument("--first", type=int, default=0, help="seed of the first")
    add_into(parser, maker)
    given = parser.parse_args()
    records = []
    for seed in range(given.first, given.first + given.n):
        records.append(judge(seed))
        print(records[-1], file=sys.stderr, flush=True)
    tell(table(records), maker, given.into)
    return 0


def titled(said: str, parts: list[tuple[str, str]]) -> str:
    """Return a sentence that says how tables were measured, and the tables (title, Markdown, which may be empty)."""
    return "\n\n".join([said, *(f"### {title}\n\n{table or 'None.'}" for title, table in parts)])


def processor() -> str:
    """Return the kind of this machine's processor."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or platform.machine()
