"""Run what the pages tell of, and write its numbers into them: ``python -m examples.numbers [NAME ...] [--check]``.

A table of a page stands between two marks that bear its name. ``--check`` changes nothing, and ends with exit code 1
where a number differs by more than its table allows. ``--quick`` leaves out what takes minutes.
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

from examples.numbers.joint_laws import TABLES as JOINT_LAWS
from examples.numbers.licences import TABLES as LICENCES
from examples.numbers.pages import Table, differences, table_in, with_table
from examples.numbers.rough_joint import TABLES as ROUGH_JOINT
from examples.numbers.safety import TABLES as SAFETY

ROOT = Path(__file__).parents[2]
TABLES: dict[str, Table] = {table.name: table for table in (*SAFETY, *JOINT_LAWS, *ROUGH_JOINT, *LICENCES)}


def main() -> int:
    """Run tables and write or compare them."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", help=f"{', '.join(TABLES)}; all by default")
    parser.add_argument("--check", action="store_true")
    parser.add_argument("--quick", action="store_true")
    given = parser.parse_args()
    unknown = [name for name in given.names if name not in TABLES]
    if unknown:
        parser.error(f"there is no table {unknown[0]}; there are {', '.join(TABLES)}")
    chosen = [TABLES[name] for name in given.names or TABLES]
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
            page.write_text(with_table(text, table.name, made), encoding="utf-8")
    return int(given.check and wrong > 0)


if __name__ == "__main__":
    sys.exit(main())
