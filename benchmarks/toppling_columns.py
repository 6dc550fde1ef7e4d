"""Random columns on a stepped base, in the plane and as slices of space (``python -m benchmarks.toppling_columns``).

Columns lean by 25 to 32 degrees, as those of Goodman & Bray by 30. Those that topple turn about their corners at the
toe and push the columns before them.
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter

import numpy as np

import bsm_mesh as bsm
from benchmarks.pages import add_into, tell
from benchmarks.slices import extruded
from examples.numbers.pages import markdown
from tests.scenes.known_factors import columns

MAKER = "python -m benchmarks.toppling_columns"
OPTIONS = bsm.Options(threads=1)


def model(seed: int) -> bsm.Model:
    """Return 8 to 14 columns, 10 m wide: they rise from 4 m at the toe to the crest, and fall behind it."""
    rng = np.random.default_rng(seed)
    count = rng.integers(8, 15)
    along = np.linspace(0, 1, count)
    crest = rng.uniform(0.5, 0.7)
    shape = np.minimum(along / crest, (1 - along) / (1 - crest))
    heights = (4 + rng.uniform(15, 35) * shape) * rng.uniform(0.9, 1.1, count)
    step, lean, friction = rng.uniform(0.5, 1.5), rng.uniform(25, 32), rng.uniform(32, 48)
    return columns(heights, step, lean, friction)


def verdicts(seed: int) -> tuple[str, str]:
    """Return the verdicts in the plane and of the slice."""
    flat = model(seed)
    plane, space = (str(bsm.run(each, OPTIONS).status) for each in (flat, extruded(flat)))
    print(seed, plane, space, file=sys.stderr, flush=True)
    return plane, space


def table(found: list[tuple[str, str]]) -> str:
    """Return how many models have which verdicts."""
    counts = sorted(Counter(found).items(), reverse=True)
    return markdown(("plane", "slice", "models"), [(*both, str(number)) for both, number in counts])


def main() -> None:
    """Judge models, and print how their verdicts compare."""
    parser = argparse.ArgumentParser(prog=MAKER, description=__doc__.splitlines()[0])
    parser.add_argument("-n", type=int, default=60, help="models in all")
    parser.add_argument("--first", type=int, default=0, help="seed of the first")
    add_into(parser, MAKER)
    given = parser.parse_args()
    tell(table([verdicts(seed) for seed in range(given.first, given.first + given.n)]), MAKER, given.into)


if __name__ == "__main__":
    main()
