"""Runs the tests of this folder, and prints sizes and times of pages: ``python -m tests.viewers``."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest

import bsm_mesh as bsm
from bsm_mesh.pages.view import write_view
from tests.scenes.large import jointed_slope, tilted_wall
from tests.scenes.models import LINEAR
from tests.scenes.openings import opening
from tests.viewers.chromium import Page, chromium, missing
from tests.viewers.test_paraview import LACKING, PVPYTHON, XVFB

HEADER = ("blocks", "states", "page, MB", "to write, s", "to open, s", "a movement drawn anew, s", "of processors, s")


def main() -> int:
    """Return 0 where nothing is missing and every test passes."""
    lacking = [missing(), "" if PVPYTHON and XVFB else LACKING]
    for text in filter(None, lacking):
        print(text, file=sys.stderr)
    if not missing():
        print("| " + " | ".join(HEADER) + " |\n|" + "---|" * len(HEADER))
        with TemporaryDirectory() as folder:
            for row in measured(Path(folder)):
                print("| " + " | ".join(row) + " |", flush=True)
    failed = pytest.main([str(Path(__file__).parent), "-q"])
    return int(failed) or int(any(lacking))


def measured(place: Path) -> Iterator[tuple[str, ...]]:
    """Yield a row a model: its page written, and opened in a browser without graphics hardware."""
    models = (
        opening(bolted=True),
        tilted_wall(1000).model(),
        tilted_wall(10_000).model(),
        jointed_slope(10_000).model(),
    )
    with chromium() as driver:
        for number, model in enumerate(models):
            out = place / str(number)
            results = bsm.run(model, LINEAR if number else None)
            results.save(out)
            begin = time.perf_counter()
            path = write_view(out)
            taken = time.perf_counter() - begin
            page = Page(driver, path)
            numbers = (path.stat().st_size / 1e6, taken, page.seconds_to_open(), *page.seconds_a_movement())
            yield str(model.blocks.count), str(len(results.stages)), *(f"{number:.2f}" for number in numbers)


if __name__ == "__main__":
    sys.exit(main())
