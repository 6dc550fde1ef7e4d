"""Random walls with and without corrections that let the residual rise (``python -m benchmarks.tall_walls``).

Walls of 5000 to 10 000 bricks, from four times as long as high to eight times as high as long, friction from 25 to 45
degrees, tilted by up to half the angle at which they topple, from zero stress. At most `STEPS` steps are solved.
"""

from __future__ import annotations

import argparse
import time

import numpy as np

import bsm_mesh as bsm
from benchmarks.campaign.tables import Row, as_markdown
from benchmarks.pages import add_into, tell
from bsm_mesh.solve.methods import newton
from bsm_mesh.solve.step.attempt import Attempt
from bsm_mesh.solve.step.equations import StepEquations
from tests.scenes import large

MAKER = "python -m benchmarks.tall_walls"
WALLS, SEED, STEPS = 20, 62, 4
HEAD = ["courses x bricks", "tilt, friction", "verdict", "steps", "factorizations", "s", "moved [m]"]
WITHOUT = [f"{name} without" for name in HEAD[2:]]


def wall(number: int) -> tuple[int, int, float, float]:
    """Return courses, bricks, tilt and friction [degrees] of a wall."""
    generator = np.random.default_rng([number, SEED])
    slender, blocks = np.exp(generator.uniform(np.log(0.25), np.log(8.0))), generator.uniform(5000, 10_000)
    bricks = round(float((blocks / (2 * slender)) ** 0.5))
    courses = round(blocks / bricks)
    topples = float(np.degrees(np.arctan(bricks / (0.5 * courses))))
    friction = round(float(generator.uniform(25, 45)), 1)
    tilt = round(float(generator.uniform(0, 0.5)) * min(topples, friction), 1)
    return courses, bricks, tilt, friction


def cells(model: bsm.Model) -> list[str]:
    """Return verdict, steps, factorizations, processor seconds and greatest movement of a run."""
    began = time.process_time()
    results = bsm.run(model, bsm.Options(threads=1, max_steps=STEPS))
    spent, stage = time.process_time() - began, results.stages[-1]
    factorizations = sum(step.factorizations for step in stage.steps)
    moved = float(np.abs(stage.displacement[:, :2]).max())
    return [results.status, str(len(stage.steps)), str(factorizations), f"{spent:.1f}", f"{moved:.6g}"]


def falling(local: StepEquations, tolerance: float) -> Attempt:
    """Return the result for blocks apart of corrections that reduce the norm, and of no others."""
    return newton.newton(local, local.start, tolerance, shrinking=newton.WORTH_REPEATING)


def row(number: int) -> list[str]:
    """Return a row of the table: a wall with, and without."""
    courses, bricks, tilt, friction = wall(number)
    model = large.tilted_courses(courses, bricks, friction, tilt).model()
    with_it, kept = cells(model), newton._solved_apart
    newton._solved_apart = falling
    try:
        without = cells(model)
    finally:
        newton._solved_apart = kept
    return [f"{courses} x {bricks}", f"{tilt:g}, {friction:g}", *with_it, *without]


def main() -> None:
    """Run the walls, and print or write their table."""
    parser = argparse.ArgumentParser(prog=MAKER, description=__doc__.partition("(")[0])
    parser.add_argument("--walls", nargs="+", type=int, default=range(WALLS), help="numbers (default: all)")
    add_into(parser, MAKER)
    given = parser.parse_args()
    rows: list[Row] = [[*HEAD, *WITHOUT]]
    cells(large.tilted_courses(20, 10, 35.0, 5.0).model())  # kernels are loaded
    for number in given.walls:
        rows.append(row(number))
        print(*rows[-1], sep=" | ", flush=True)
    tell(as_markdown(rows), MAKER, given.into)


if __name__ == "__main__":
    main()
