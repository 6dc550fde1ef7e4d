"""Models that once flipped between two lists of contacts for ever: ``python -m benchmarks.gradual``.

Exit code 1 where one has no verdict.

The Cassiar slope as a mesh, its water at once and rising in four stages, and Dupont Circle Station, whose excavation is
released at once and in parts.
"""

from __future__ import annotations

import argparse
import dataclasses
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import bsm_mesh as bsm
from bsm_mesh.converters import read_blocks
from bsm_mesh.geometries.cassiar_slope import build

EXAMPLES = Path(__file__).parents[1] / "examples"
SIZES = (60.0, 45.0, 30.0, 20.0)  # of the slope's elements [m]
PARTS = (1, 2, 4, 8)
OPTIONS = bsm.Options(scheme="continuation", displacement_limit=10.0)


def slopes(size: float) -> Iterator[tuple[str, bsm.Model]]:
    """Return the Cassiar slope meshed to a size [m]: high water from zero stress at once, and water that rises."""
    rising = bsm.load(EXAMPLES / "cassiar_slope/model.toml")
    with tempfile.TemporaryDirectory() as folder:
        mesh = build(Path(folder) / "slope.msh", size=size, north_fault_dip=35.0)
        rising = rising.replace(blocks=read_blocks(mesh))
    at_once = dataclasses.replace(rising, in_situ=None, stages=(), water=rising.stages[-1].water)
    yield f"Cassiar, elements of {size:g} m, water at once", at_once
    yield f"Cassiar, elements of {size:g} m, water rises", rising


def station(name: str, parts: int) -> tuple[str, bsm.Model]:
    """Return the station of a model file, its excavation released in so many parts."""
    model = bsm.load(EXAMPLES / "dupont_station" / name)
    released = tuple((k + 1) / parts for k in range(parts))
    stages = (dataclasses.replace(model.stages[0], relaxation=released), *model.stages[1:])
    return f"Dupont, {name}, released in {parts}", dataclasses.replace(model, stages=stages)


def main() -> int:
    """Run them all and print a table."""
    argparse.ArgumentParser(description=__doc__).parse_args()
    models = [model for size in SIZES for model in slopes(size)]
    models += [station(name, parts) for name in ("model.toml", "bolts.toml") for parts in PARTS]
    print("| model | blocks | verdict | steps | processor time | most distant |\n|---|---:|---|---:|---:|---:|")
    unanswered = 0
    for name, model in models:
        began = time.process_time()
        results = bsm.run(model, OPTIONS)
        seconds, last = time.process_time() - began, results.stages[-1]
        steps = sum(len(stage.steps) for stage in results.stages)
        unanswered += last.status.value == "not_converged"
        moved = abs(last.displacement[:, :2]).max()
        told = last.status.value, steps, f"{seconds:.1f} s", f"{moved:.3g} m"
        print(f"| {name} | {model.blocks.count} | {' | '.join(map(str, told))} |", flush=True)
    print(f"\n{len(models)} models, {unanswered} without a verdict")
    return int(unanswered > 0)


if __name__ == "__main__":
    sys.exit(main())
