"""Verdicts of random slopes in the plane and of their slices in space (``python -m benchmarks.random_slices``).

Columns on steps lean by 25 to 32 degrees, as those of Goodman & Bray by 30. Blocks on a plane through the toe, with
cohesion and half of them with water behind, have 1.05 times less strength than limit equilibrium asks for.
"""

from __future__ import annotations

import sys
from collections import Counter
from typing import Any

import numpy as np

import bsm_mesh as bsm
from benchmarks.pages import seeds_command
from benchmarks.slices import extruded
from examples.numbers.pages import markdown
from tests.scenes.known_factors import columns
from tests.scenes.plane_failure import PlaneFailure

MAKER = "python -m benchmarks.random_slices"
OPTIONS = bsm.Options(threads=1)
BEYOND = 1.05  # of the known factor


def toppling_columns(rng: np.random.Generator) -> bsm.Model:
    """Return 8 to 14 columns, 10 m wide: they rise from 4 m at the toe to the crest, and fall behind it."""
    count = rng.integers(8, 15)
    along = np.linspace(0, 1, count)
    crest = rng.uniform(0.5, 0.7)
    shape = np.minimum(along / crest, (1 - along) / (1 - crest))
    heights = (4 + rng.uniform(15, 35) * shape) * rng.uniform(0.9, 1.1, count)
    step, lean, friction = rng.uniform(0.5, 1.5), rng.uniform(25, 32), rng.uniform(32, 48)
    return columns(heights, step, lean, friction)


def sliding_block(rng: np.random.Generator) -> bsm.Model:
    """Return a block 12 m high on a plane of 28 to 42 degrees, a crack behind it, below its known factor."""
    height, dip, face = 12.0, *np.radians([rng.uniform(28, 42), rng.uniform(55, 75)])
    crest = height / np.tan(face)
    behind = crest + rng.uniform(0.2, 0.6) * (height / np.tan(dip) - crest)
    foot = behind * np.tan(dip)
    water = rng.uniform(0.3, 0.9) * (height - foot) * rng.integers(2)
    case = PlaneFailure(
        crest=(crest, height),
        top=(behind, height),
        crack=(behind, foot),
        gamma=26e3,
        friction=rng.uniform(20, 37),
        cohesion=rng.uniform(10e3, 40e3),
        zw=water,
    )
    return case.model(BEYOND * case.factor)


KINDS = {"columns on steps": toppling_columns, "block on a plane": sliding_block}


def verdicts(seed: int) -> dict[str, Any]:
    """Return the verdicts in the plane and of the slice, by kind."""
    kind = list(KINDS)[seed % len(KINDS)]
    flat = KINDS[kind](np.random.default_rng(seed // len(KINDS)))
    plane, space = (str(bsm.run(each, OPTIONS).status) for each in (flat, extruded(flat)))
    return {"seed": seed, "kind": kind, "plane": plane, "slice": space}


def table(records: list[dict[str, Any]]) -> str:
    """Return how many models have which verdicts."""
    counts = Counter((told["kind"], told["plane"], told["slice"]) for told in records)
    return markdown(
        ("model", "plane", "slice", "models"), [(*key, str(number)) for key, number in sorted(counts.items())]
    )


if __name__ == "__main__":
    sys.exit(seeds_command(MAKER, __doc__, 120, verdicts, table))
