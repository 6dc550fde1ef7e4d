"""Zones that are shaken and closed forms: ``python -m benchmarks.shaken_zones --into docs/zones_shaken.md``."""

from __future__ import annotations

import sys

import numpy as np

import bsm_mesh as bsm
from benchmarks.pages import table_command
from tests.scenes import shaken_zones as scenes
from tests.scenes.quiet import velocities

COMMAND = "python -m benchmarks.shaken_zones"
HEADER = ("zones that are shaken", "closed form or rigid blocks", "found")
JOINT = 2e9, 12.0  # Pa/m, m: stiffness of the joint across a column, and its height


def rows() -> list[tuple[str, ...]]:
    """Return the lines of the table."""
    lines: list[tuple[str, ...]] = []
    for order in (1, 2):
        model, exact = scenes.newmarks_block(zones=bsm.Zones(size=0.5, order=order, displacement="large"))
        stage = bsm.run(model).stages[-1]
        case = f"Newmark's block slides over zones of order {order}: displacement, m"
        lines.append((case, f"{exact:.5f}", f"{-stage.stage_displacement[1, 0]:.5f}"))
        case = "the same: error of the energy balance over the greatest energy"
        lines.append((case, "0", f"{stage.shaking.imbalance:.0e}"))
    for order in (1, 2):
        found, exact, stage = scenes.started(order)
        case = f"bar on a base that starts, zones of order {order}: greatest error over the greatest displacement"
        lines.append((case, "0", f"{np.abs(found - exact).max() / np.abs(exact).max():.1e}"))
    for direction, name, kind in ((0, "u", "S"), (90, "v", "P")):
        model, speed, _ = scenes.column(direction)
        time, velocity = velocities(bsm.run(model), name)
        left = np.abs(velocity[time > scenes.passed(speed)]).max() / velocity.max()
        lines.append((f"{kind} wave of 40 zones a length: part reflected by a quiet end", "0", f"{left:.1e}"))
    for direction, name, kind in ((0, "u", "S"), (90, "v", "P")):
        model, speed, density = scenes.column(direction, joint=JOINT)
        time, velocity = velocities(bsm.run(model), name)
        exact = scenes.through_a_joint(model, time, JOINT[0], speed, density)
        off = np.abs(velocity - exact).max() / np.abs(exact).max()
        lines.append(
            (f"{kind} wave through an elastic joint: greatest error over the greatest velocity", "0", f"{off:.1e}")
        )
    rigid = _upper(scenes.stack())
    for order in (1, 2):
        zones = bsm.Zones(size=0.5, order=order, displacement="large")
        case = f"stack of two blocks, zones of order {order}: displacement of the upper one, mm"
        lines.append((case, f"{rigid:.1f}", f"{_upper(scenes.stack(zones)):.1f}"))
    return lines


def _upper(model: bsm.Model) -> float:
    """Return the permanent displacement of the last block [mm]."""
    return 1e3 * float(bsm.run(model).stages[-1].stage_displacement[-1, 0])


if __name__ == "__main__":
    sys.exit(table_command(COMMAND, __doc__, HEADER, rows))
