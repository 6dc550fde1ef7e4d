"""What exact multipliers are worth: ``python -m benchmarks.limit_bounds [--count N]``.

Proofs of limit analysis with multipliers as the interior point method leaves them, corrected by least squares, and
refined by a program of their change: bounds on the factors of safety of random slopes (`benchmarks.safety`), and
factors of strength of slopes of up to 10 000 blocks. The tables take the place of those of `PAGE`.
"""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from unittest.mock import patch

from benchmarks.safety import STIFFNESS, model_of
from bsm_mesh.arrays import FloatArray
from bsm_mesh.model.falls import Falls
from bsm_mesh.safety.bound import limit_of
from bsm_mesh.safety.trials import Reduction
from bsm_mesh.solve.limit import multipliers
from bsm_mesh.solve.limit.strength_factor import strength_limit
from examples.numbers.pages import with_table
from tests.scenes.large import jointed_slope

PAGE = Path(__file__).parents[1] / "docs/experiments/limit_analysis.md"
SIZES, FRICTION = (1000, 3000, 10000), 35.0
LEFT_OUT = {"as they are": ("_projected", "_refined"), "least squares": ("_refined",), "and refined": ()}


def unchanged(z: FloatArray, *_: object) -> FloatArray:
    """Return multipliers as they are."""
    return z


@contextmanager
def without(names: tuple[str, ...]) -> Iterator[None]:
    """Leave out corrections of these names."""
    with ExitStack() as stack:
        for name in names:
            stack.enter_context(patch.object(multipliers, name, unchanged))
        yield


def small(count: int) -> str:
    """Return the table of random slopes."""
    models = [model_of("slopes", seed, STIFFNESS[0]) for seed in range(count)]
    lines = ["| multipliers | slopes | bounds | proofs that rounding spoils | s |", "|---|---|---|---|---|"]
    for name, left_out in LEFT_OUT.items():
        began = time.process_time()
        with without(left_out):
            found = [limit_of(model, Reduction(), Falls()) for model in models]
        spoilt = sum("rounding spoils" in limit.text for limit in found)
        bounds = sum(math.isfinite(limit.factor) for limit in found)
        lines.append(f"| {name} | {count} | {bounds} | {spoilt} | {time.process_time() - began:.0f} |")
        print(lines[-1], flush=True)
    return "\n".join(lines)


def large() -> str:
    """Return the table of large slopes."""
    lines = ["| blocks | multipliers | programs | forces exist up to | none beyond | s |", "|---|---|---|---|---|---|"]
    for size in SIZES:
        model = jointed_slope(size, FRICTION).model()
        for name in ("least squares", "and refined"):
            began = time.process_time()
            with without(LEFT_OUT[name]):
                found = strength_limit(model)
            beyond = f"{found.beyond:.5f}" if math.isfinite(found.beyond) else "not proved"
            seconds = time.process_time() - began
            lines.append(
                f"| {model.blocks.count} | {name} | {found.programs} | {found.factor:.5f} | {beyond} | {seconds:.0f} |"
            )
            print(lines[-1], flush=True)
    return "\n".join(lines)


def main() -> None:
    """Write the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=90, help="random slopes")
    given = parser.parse_args()
    for name, table in (("limit-bounds", small(given.count)), ("limit-sizes", large())):
        PAGE.write_text(with_table(PAGE.read_text(encoding="utf-8"), name, table), encoding="utf-8")


if __name__ == "__main__":
    main()
