"""Zones in large displacement whose rock yields, or in water: ``python -m benchmarks.large_rock --into PAGE``."""

from __future__ import annotations

import sys
from dataclasses import replace

import numpy as np

import bsm_mesh as bsm
from benchmarks.pages import table_command
from tests.scenes import meeting_zones as meeting
from tests.scenes.plastic_zones import Hole, footing, in_large_displacement, strut

COMMAND = "python -m benchmarks.large_rock"
HEADER = ("zones in large displacement that yield, or in water", "closed form or rigid blocks", "found")
PARTS = (0.99, 0.995, 1.005, 1.01)  # of the load at which a strut yields
ROWS = 8  # random rows of blocks in water
WATER = 9810.0  # N/m3


def rows() -> list[tuple[str, ...]]:
    """Return the lines of the table."""
    return [*_yields(), *_in_water()]


def _yields() -> list[tuple[str, ...]]:
    hole = Hole()
    small = hole.model(24, 12).replace(rocks=[replace(hole.rock(2, 30.0), young=1e3 * hole.young)])
    one, other = (bsm.run(model).stages[-1] for model in (small, in_large_displacement(small)))
    stress, radius, _ = hole.errors(other.zones)
    off = float(np.abs(other.displacement - one.displacement).max() / np.abs(one.displacement).max())
    case = "Salencon's hole, rock 1000 times as stiff"
    lines: list[tuple[str, ...]] = [
        (f"{case}: radius of the yielding rock over the closed form", "1", f"{1 + radius:.4f}"),
        (f"{case}: error of stresses up to three radii", "0", f"{stress:.1e}"),
        (f"{case}: displacement, greatest difference from small displacement", "0", f"{off:.1e}"),
    ]
    for degrees in (0.0, 37.0):
        held = [part for part in PARTS if bsm.run(strut(part, degrees=degrees)).status == "stable"]
        left = min(part for part in PARTS if part not in held)
        found = f"stable at {max(held):g}, not at {left:g}"
        lines.append((f"strut, turned by {degrees:g} degrees: load over 2 c cos(phi) / (1 - sin(phi))", "1", found))
    stages = bsm.run(in_large_displacement(footing([0.7, 0.95, 0.99, 1.01]))).stages
    held = [stage.name for stage in stages if stage.status.value == "stable"]
    left = next(stage.name for stage in stages if stage.name not in held)
    lines.append(("strip footing on clay: load over (2 + pi) c", "1", f"stable at {held[-1]}, not at {left}"))
    return lines


def _in_water() -> list[tuple[str, ...]]:
    table = bsm.Water(table=[(-9.0, 0.04), (9.0, 0.04)])
    fallen = bsm.run(meeting.dropped(young=1e11, size=1.0, gap=0.05, water=table))
    deep = 0.04 - 0.05 - fallen.stages[0].displacement[1, 1]
    exact, found = (f"{force / 1e3:.4f}" for force in (meeting.WEIGHT - WATER * deep, meeting.force_between(fallen)))
    lines: list[tuple[str, ...]] = [("block that falls into water: force of the floor, kN/m", exact, found)]
    rng = np.random.default_rng(7)
    for smooth, name in ((True, "without friction"), (False, "with friction")):
        runs = []
        for seed in range(ROWS):
            level, slope = rng.uniform(-0.2, 1.2), rng.uniform(-0.2, 0.2)
            water = bsm.Water(table=[(-5.0, level - 5 * slope), (8.0, level + 8 * slope)])
            model = meeting.row(seed, smooth=smooth).replace(water=water)
            runs.append([bsm.run(each) for each in (model, meeting.rigid(model))])
        same = sum(zones.status == rigid.status for zones, rigid in runs)
        case = f"random rows of stiff blocks {name} in water"
        lines.append((f"{case}: verdicts of rigid blocks", f"{ROWS}", f"{same}"))
        rest = [[each.stages[0].displacement for each in both] for both in runs if both[0].status == "stable"]
        off = max(float(np.abs(zones - rigid).max() / np.abs(rigid).max()) for zones, rigid in rest)
        if smooth:
            lines.append((f"{case}: greatest difference over the greatest movement", "0", f"{off:.1e}"))
    return lines


if __name__ == "__main__":
    sys.exit(table_command(COMMAND, __doc__, HEADER, rows))
