"""Openings in 24 blocks: what stands over them hangs on bolts, or falls."""

from __future__ import annotations

import bsm_mesh as bsm
from tests.scenes.models import model_of
from tests.scenes.shapes import grid

HELD = [b for b in range(24) if b // 6 in (0, 3) or b % 6 in (0, 5)]
OPENED, ROOF = (2, 3, 8, 9), (14, 15)  # excavated in the two lower rows of four, and what is over that


def opening(*, bolted: bool) -> bsm.Model:
    """Return six by four unit blocks with the outer ones fixed; two are excavated, and there is water at their feet."""
    bolts = [
        bsm.Bolt(start=(x, 2.0), end=(x, 3.9), name=f"B{number}", diameter=0.025, young=200e9, spacing=1.5)
        for number, x in enumerate((2.5, 3.5), 1)
    ]
    return model_of(
        grid(6, 4),
        fixed=HELD,
        friction=5.0,
        bolts=bolts if bolted else (),
        water=bsm.Water(table=[(0.0, 0.6), (6.0, 0.8)]),
        stages=[bsm.Stage(name="dig", excavate=OPENED)],
        title="Opening with bolts" if bolted else "Opening without bolts",
    )
