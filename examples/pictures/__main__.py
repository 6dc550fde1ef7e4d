"""Draw the pictures of README and examples anew: ``python -m examples.pictures [TARGET ...] [--list]``.

Each is drawn by `bsm-mesh plot` from a run of its model, or by a script of its own. The table of docs/pictures.md is
written with them.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from pathlib import Path

from examples.pictures.drawing import ROOT, draw, table
from examples.pictures.listed import PICTURES

PAGE = ROOT / "docs/pictures.md"


def main() -> None:
    """Draw what is asked for, and write the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("targets", nargs="*", help="files, relative to the checkout; by default all")
    parser.add_argument("--list", action="store_true", help="write the table only")
    given = parser.parse_args()
    chosen = [picture for picture in PICTURES if not given.targets or picture.target in given.targets]
    with tempfile.TemporaryDirectory() as folder:
        for picture in [] if given.list else chosen:
            began = time.perf_counter()
            draw(picture, Path(folder))
            print(f"{picture.target} ({time.perf_counter() - began:.1f} s)", flush=True)
    from examples.numbers.pages import with_table

    PAGE.write_text(with_table(PAGE.read_text(encoding="utf-8"), "pictures", table(PICTURES)), encoding="utf-8")


if __name__ == "__main__":
    main()
