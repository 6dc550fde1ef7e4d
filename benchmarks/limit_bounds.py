"""What exact multipliers are worth: ``python -m benchmarks.limit_bounds [--count N]``.

Bounds of limit analysis on the factors of safety of random slopes (`benchmarks.safety`), with more or fewer shares of
its slack tried that the multiplier of a bound which is met exceeds. The table takes the place of that of `PAGE`.
"""

from __future__ import annotations

import argparse
import math
import time
from pathlib import Path
from unittest.mock import patch

from benchmarks.safety import STIFFNESS, model_of
from bsm_mesh.model.falls import Falls
from bsm_mesh.model.model import Model
from bsm_mesh.safety.bound import Limit, limit_of
from bsm_mesh.safety.trials import Reduction
from bsm_mesh.solve.limit import interior_point
from examples.numbers.pages import with_table

PAGE = Path(__file__).parents[1] / "docs/experiments/limit_analysis.md"
TENTHS = 0, 1, 2, 4, interior_point.TENTHS, 10  # 0: multipliers are not corrected


def limits(models: list[Model], tenths: int) -> tuple[list[Limit], float]:
    """Return what limit analysis says of models with so many shares tried, and processor seconds."""
    began = time.process_time()
    with patch.object(interior_point, "TENTHS", tenths):
        found = [limit_of(model, Reduction(), Falls()) for model in models]
    return found, time.process_time() - began


def main() -> None:
    """Print the slopes whose proof is spoilt, and write the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=90, help="slopes")
    given = parser.parse_args()
    models = [model_of("slopes", seed, STIFFNESS[0]) for seed in range(given.count)]
    lines = ["| shares tried | slopes | bounds | proofs that rounding spoils | s |", "|---|---|---|---|---|"]
    for tenths in TENTHS:
        found, seconds = limits(models, tenths)
        spoilt = [seed for seed, limit in enumerate(found) if "rounding spoils" in limit.text]
        bounds = sum(math.isfinite(limit.factor) for limit in found)
        name = f"{tenths}, as it is" if tenths == interior_point.TENTHS else f"{tenths or 'none'}"
        lines.append(f"| {name} | {len(found)} | {bounds} | {len(spoilt)} | {seconds:.0f} |")
        print(lines[-1], *spoilt, flush=True)
    PAGE.write_text(with_table(PAGE.read_text(encoding="utf-8"), "limit-bounds", "\n".join(lines)), encoding="utf-8")


if __name__ == "__main__":
    main()
