"""Blocks of which two are taken away, one stage after the other."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

import bsm_mesh as bsm
from tests.scenes import models, shapes


def staged(pressure: float = 1e5) -> bsm.Model:
    """Return six blocks of which two go, one stage after the other, with a bolt and water."""
    blocks = models.framed(bsm.Blocks.from_polygons(shapes.grid(3, 2), rock="gneiss"), 3, 2)
    blocks = replace(blocks, excavations={"one": np.array([5], np.int32), "two": np.array([4], np.int32)})
    return bsm.Model(
        title="Two go",
        blocks=blocks,
        rocks=[bsm.Rock("gneiss", unit_weight=25e3, young=1e9, poisson=0.2)],
        joints=[bsm.Joint("J1", normal_stiffness=1e9, shear_stiffness=2e8, law=bsm.Patton(friction=30))],
        default_joint="J1",
        supports=[bsm.Fixed(boundary="bottom")],
        loads=[bsm.Pressure(boundary="top", pressure=pressure)],
        bolts=[bsm.Bolt(start=(0, 0.4), end=(2.8, 0.6), diameter=0.02)],
        water=bsm.Water(table=[(0, 0.5)]),
        stages=[bsm.Stage(name="first", excavate=["one"]), bsm.Stage(name="second", excavate=["two"])],
    )
