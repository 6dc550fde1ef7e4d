"""What exact multipliers are worth: ``python -m benchmarks.limit_bounds [--count N] [--large]``.

Bounds of limit analysis on the factors of safety of random slopes (`benchmarks.safety`), with more or fewer shares of
its slack tried that the multiplier of a bound which is met exceeds; with `--large`, of slopes of up to 10 000 blocks,
with multipliers refined by a program of their change and without. The tables take the place of those of `PAGE`.
"""

from __future__ import annotations

import argparse
import math
import time
from pathlib import Path
from unittest.mock import patch

from benchmarks.safety import STIFFNESS, model_of
from bsm_mesh.arrays import FloatArray
from bsm_mesh.model.falls import Falls
from bsm_mesh.model.model import Model
from bsm_mesh.safety.bound import Limit, limit_of
from bsm_mesh.safety.trials import Reduction
from bsm_mesh.solve.limit import multipliers
from bsm_mesh.solve.limit.strength_factor import strength_limit
from examples.numbers.pages import with_table
from tests.scenes.large import jointed_slope

PAGE = Path(__file__).parents[1] / "docs/experiments/limit_analysis.md"
SIZES, FRICTION = (1000, 3000, 10000), 35.0
TENTHS = 0, 1, 2, 4, multipliers.TENTHS, 10  # 0: multipliers are not corrected


def unrefined(z: FloatArray, *_: object) -> FloatArray:
    """Return multipliers as they are."""
    return z


def limits(models: list[Model], tenths: int) -> tuple[list[Limit], float]:
    """Return what limit analysis says of models with so many shares tried, and processor seconds."""
    began = time.process_time()
    with patch.object(multipliers, "TENTHS", tenths), patch.object(multipliers, "_refined", unrefined):
        found = [limit_of(model, Reduction(), Falls()) for model in models]
    return found, time.process_time() - began


def large() -> str:
    """Return the table of large slopes."""
    lines = ["| blocks | refined | programs | forces exist up to | none beyond | s |", "|---|---|---|---|---|---|"]
    for size in SIZES:
        model = jointed_slope(size, FRICTION).model()
        for refined in (unrefined, multipliers._refined):
            began = time.process_time()
            with patch.object(multipliers, "_refined", refined):
                found = strength_limit(model)
            beyond = f"{found.beyond:.5f}" if math.isfinite(found.beyond) else "not proved"
            named = "no" if refined is unrefined else "yes"
            seconds = time.process_time() - began
            lines.append(
                f"| {model.blocks.count} | {named} | {found.programs} | {found.factor:.5f} | {beyond} | {seconds:.0f} |"
            )
            print(lines[-1], flush=True)
    return "\n".join(lines)


def main() -> None:
    """Print the slopes whose proof is spoilt, and write the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=90, help="slopes")
    parser.add_argument("--large", action="store_true", help="slopes of up to 10 000 blocks instead")
    given = parser.parse_args()
    if given.large:
        PAGE.write_text(with_table(PAGE.read_text(encoding="utf-8"), "limit-sizes", large()), encoding="utf-8")
        return
    models = [model_of("slopes", seed, STIFFNESS[0]) for seed in range(given.count)]
    lines = ["| shares tried | slopes | bounds | proofs that rounding spoils | s |", "|---|---|---|---|---|"]
    for tenths in TENTHS:
        found, seconds = limits(models, tenths)
        spoilt = [seed for seed, limit in enumerate(found) if "rounding spoils" in limit.text]
        bounds = sum(math.isfinite(limit.factor) for limit in found)
        name = f"{tenths}, as it is" if tenths == multipliers.TENTHS else f"{tenths or 'none'}"
        lines.append(f"| {name} | {len(found)} | {bounds} | {len(spoilt)} | {seconds:.0f} |")
        print(lines[-1], *spoilt, flush=True)
    PAGE.write_text(with_table(PAGE.read_text(encoding="utf-8"), "limit-bounds", "\n".join(lines)), encoding="utf-8")


if __name__ == "__main__":
    main()
