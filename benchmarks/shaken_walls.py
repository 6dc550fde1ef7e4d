"""Brick walls under a record: steps, movement, energies, processor time: ``python -m benchmarks.shaken_walls``.

A wall in running bond on a base, ten seconds of a sine of 2 Hz and 0.3 g. Parts of the stable time step follow each
other, so movement that depends on the step is seen. With ``--into PAGE`` the table takes the place of what is between
that page's marks.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import replace

import numpy as np

import bsm_mesh as bsm
from benchmarks.pages import add_into, processor, tell
from bsm_mesh.model.base_motion import GRAVITY
from bsm_mesh.model.shaking import Integrator
from examples.numbers.pages import markdown
from tests.scenes.shaken import quake, wall

COMMAND = "python -m benchmarks.shaken_walls"
LENGTH, PEAK = 10.0, 0.3 * GRAVITY  # s, m/s2
HEADER = (
    "blocks",
    "`integrator`",
    "`time_step`",
    "steps",
    "greatest, mm",
    "rms, mm",
    "balance missed by, %",
    "processor time, s",
)


def row(side: int, integrator: Integrator, part: float, threads: int) -> tuple[str, ...]:
    """Return the row of a wall of so many courses and bricks, an integrator, and its `time_step`."""
    shaking = bsm.Shaking(record=quake(PEAK, LENGTH), every=LENGTH / 100, integrator=integrator)
    model = wall(replace(shaking, time_step=part), courses=side, bricks=side)
    begun = time.process_time()
    stage = bsm.run(model, bsm.Options(threads=threads)).stages[-1]
    seconds = time.process_time() - begun
    found = stage.shaking
    assert found is not None
    moved = 1e3 * np.hypot(*stage.stage_displacement[1:, :2].T)
    sizes = f"{moved.max():.2f}", f"{np.sqrt((moved**2).mean()):.2f}"
    count, balance = str(model.blocks.count), f"{100 * found.imbalance:.1g}"
    return count, integrator, f"{part:g}", str(found.cycles), *sizes, balance, f"{seconds:.0f}"


def main() -> None:
    """Make the table, and print it or put it into a page."""
    parser = argparse.ArgumentParser(prog=COMMAND, description=__doc__)
    parser.add_argument("--sides", nargs="+", type=int, default=(17, 55), help="courses, and bricks in one")
    parser.add_argument("--threads", type=int, default=1)
    add_into(parser, COMMAND)
    given = parser.parse_args()
    bsm.run(wall(bsm.Shaking(record=quake(PEAK, 2.1), every=1.0), courses=2, bricks=2))  # compiles
    rows = []
    for number, side in enumerate(given.sides):
        runs: list[tuple[Integrator, float]] = [("explicit", 0.5)]
        if number == 0:
            runs += [("explicit", 0.25), ("explicit", 0.125), ("implicit", 0.05)]
        for integrator, part in runs:
            rows.append(row(side, integrator, part, given.threads))
            print(*rows[-1], flush=True)
    said = f"Measured on one thread of {processor()}." if given.threads == 1 else f"Measured on {processor()}."
    tell(f"{markdown(HEADER, rows)}\n\n{said}", COMMAND, given.into)


if __name__ == "__main__":
    main()
