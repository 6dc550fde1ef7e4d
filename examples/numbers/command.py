"""The command that writes tables into pages, or compares them with what is there."""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterable
from pathlib import Path

from examples.numbers.pages import Table, differences, table_in, with_table

ROOT = Path(__file__).parents[2]


def write_or_check(every: Iterable[Table], description: str | None) -> int:
    """Run tables and write or compare them, as the command line asks; return the exit code."""
    tables = {table.name: table for table in every}
    parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", help=f"{', '.join(tables)}; all by default")
    parser.add_argument("--check", action="store_true")
    parser.add_argument("--quick", action="store_true")
    given = parser.parse_args()
    unknown = [name for name in given.names if name not in tables]
    if unknown:
        parser.error(f"there is no table {unknown[0]}; there are {', '.join(tables)}")
    chosen = [tables[name] for name in given.names or tables]
    wrong = 0
    for table in (table for table in chosen if not (given.quick and table.is_slow)):
        began = time.perf_counter()
        page = ROOT / table.page
        text = page.read_text(encoding="utf-8")
        made = table.make()
        found = differences(table_in(text, table.name), made, table.tolerance)
        print(f"{table.page}: {table.name}: {len(found)} differ ({time.perf_counter() - began:.1f} s)", flush=True)
        for line in found:
            print(f"  {line}")
        wrong += len(found)
        if not given.check:
            text = page.read_text(encoding="utf-8")  # what a writer has changed meanwhile stays
            page.write_text(with_table(text, table.name, made), encoding="utf-8")
            if table.draw is not None:
                table.draw()
    return int(given.check and wrong > 0)
