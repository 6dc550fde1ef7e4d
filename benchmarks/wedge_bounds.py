"""Upper bounds of random wedges where the solver gives up: ``python -m benchmarks.wedge_bounds``.

The starter `wedge` with friction angles from 20 to 40 degrees, half of them with dips from 44 to 50. `NEAR` says how
far beside the place where the solver gave up limit analysis asks again; with 0 it does not. With ``--into PAGE`` the
table takes the place of what is between that page's marks.
"""

from __future__ import annotations

import sys
from typing import Any
from unittest.mock import patch

import numpy as np

import bsm_mesh as bsm
from benchmarks.pages import seeds_command
from benchmarks.starters import starter
from bsm_mesh.model.falls import Falls
from bsm_mesh.safety.bound import limit_of
from bsm_mesh.safety.trials import Reduction
from bsm_mesh.three_d.limit import analysis
from examples.numbers.pages import markdown

MAKER = "python -m benchmarks.wedge_bounds"
NEARS = (0.0, 1e-6, 1e-5, analysis.NEAR, 1e-3)


def drawn(seed: int) -> bsm.Model:
    """Return the starter with other friction angles, and odd seeds with other dips."""
    rng = np.random.default_rng(seed)
    with starter("wedge") as file:
        friction = {f"joint.{name}.friction": float(rng.uniform(20, 40)) for name in "AB"}
        dip = {f"joint_plane.{name}.dip": float(rng.uniform(44, 50)) for name in "AB" if seed % 2}
        return file.model(friction | dip).model


def bounds(seed: int) -> dict[str, Any]:
    """Return the bound with every setting; None: none."""
    model, found = drawn(seed), {}
    for near in NEARS:
        with patch.object(analysis, "NEAR", near):
            limit = limit_of(model, Reduction(), Falls())
        found[f"{near:g}"] = limit.factor if np.isfinite(limit.factor) else None
    return {"seed": seed, **found}


def table(records: list[dict[str, Any]]) -> str:
    """Return how many wedges have a bound, and how far it is above the least of all settings."""
    least = [min((v for name, v in told.items() if name != "seed" and v), default=np.nan) for told in records]
    rows = []
    for near in NEARS:
        values = np.array([told[f"{near:g}"] or np.nan for told in records])
        above = np.nanmax(values / least - 1)
        usual = " (as it is)" if near == analysis.NEAR else ""
        rows.append((f"`NEAR` = {near:g}{usual}", str(int(np.isfinite(values).sum())), f"{above:.1e}"))
    return markdown(("setting", f"with a bound, of {len(records)}", "above the least bound, at most"), rows)


if __name__ == "__main__":
    sys.exit(seeds_command(MAKER, __doc__, 40, bounds, table))
