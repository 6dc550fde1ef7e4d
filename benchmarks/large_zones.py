"""Zones in large displacement and closed forms: ``python -m benchmarks.large_zones --into docs/zones_large.md``."""

from __future__ import annotations

import sys
from dataclasses import replace

import numpy as np

import bsm_mesh as bsm
from benchmarks.pages import table_command
from tests.scenes import large_zones as scenes
from tests.scenes import meeting_zones as meeting
from tests.scenes.arch import arch

COMMAND = "python -m benchmarks.large_zones"
HEADER = ("zones in large displacement", "closed form or rigid blocks", "found")
PARTS = (0.98, 0.99, 1.01, 1.02)  # of the critical load
ROWS = 15  # random rows of blocks
PLACES = (0.001, *np.arange(1, 13) / 8)  # m, at which a block is looked at that slides over zones of .5 m


def rows() -> list[tuple[str, ...]]:
    """Return the lines of the table."""
    lines: list[tuple[str, ...]] = []
    for alpha in (1.0, 4.0):
        exact, found = scenes.elastica_exact(alpha), scenes.elastica(alpha)[1]
        for name, one, other in zip(("deflection", "shortening"), exact, found, strict=True):
            case = f"cantilever, P L^2 / (E I) = {alpha:g}, L = 20 H: {name} of the tip over L"
            lines.append((case, f"{one:.4f}", f"{other:.4f}"))
    held = [part for part in PARTS if scenes.pressed(part).status == "stable"]
    left = min(part for part in PARTS if part not in held)
    lines.append(("column: buckling load over Euler's, with shear", "1", f"stable at {max(held):g}, not at {left:g}"))
    for thickness in (0.3, 0.2, 0.12):
        rigid, zoned = _arch(thickness)
        case = f"arch of 11 stones, {thickness:g} m thick, E = 1e13 Pa: crown, mm"
        lines.append((case, f"{rigid:.5f}", f"{zoned:.5f}"))
    for order in (1, 2):
        resultant, jump = _slides(order)
        case = f"block that slides over three zones of order {order}"
        lines.append((f"{case}: shear over N tan(friction)", "1", f"{resultant:.5f}"))
        lines.append((f"{case}: greatest jump of a point's force over their mean", "0", f"{jump:.1e}"))
    moved, tension = scenes.bolted_exact()
    stage = bsm.run(scenes.bolted()).stages[0]
    found = float(np.hypot(*stage.displacement[1, :2]))
    lines.append(("block on a smooth slope slides on a soft bolt, which turns: m", f"{moved:.5f}", f"{found:.5f}"))
    lines.append(("the same: tension, kN", f"{tension / 1e3:.4f}", f"{stage.bolts.axial_force[0] / 1e3:.4f}"))
    return [*lines, *_meetings()]


def _meetings() -> list[tuple[str, ...]]:
    """Return the lines of blocks that meet where they touched nothing before."""
    load, lines = 1e4, []
    exact, found = meeting.beams_exact(load), meeting.force_between(bsm.run(meeting.beams(load)))
    lines.append(("cantilevers, L = 10 H, whose gap closes: force between them, kN/m", *_kilo(exact, found)))
    fallen = bsm.run(meeting.dropped(young=1e10, size=0.5))
    lines.append(
        ("block that falls onto a floor: force on it, kN/m", *_kilo(meeting.WEIGHT, meeting.force_between(fallen)))
    )
    for degrees in (0.0, 37.0):
        found, exact = meeting.leaning_force(bsm.run(meeting.leaning(degrees)), degrees)
        case = (
            f"column that falls onto a smooth wall, E = 1e13 Pa, turned by {degrees:g} degrees: force of the wall, kN/m"
        )
        lines.append((case, *_kilo(exact, found)))
    for smooth, name in ((True, "without friction"), (False, "with friction")):
        runs = [[bsm.run(each) for each in _both(meeting.row(seed, smooth=smooth))] for seed in range(ROWS)]
        same = sum(zones.status == rigid.status for zones, rigid in runs)
        lines.append((f"random rows of stiff blocks {name}: verdicts of rigid blocks", f"{ROWS}", f"{same}"))
        if smooth:
            off = max(_off(*(each.stages[0].displacement for each in both)) for both in runs)
            lines.append((f"the same {name}: greatest difference over the greatest movement", "0", f"{off:.1e}"))
    return lines


def _both(model: bsm.Model) -> tuple[bsm.Model, bsm.Model]:
    return model, meeting.rigid(model)


def _off(zones: np.ndarray, rigid: np.ndarray) -> float:
    return float(np.abs(zones - rigid).max() / np.abs(rigid).max())


def _kilo(exact: float, found: float) -> tuple[str, str]:
    return f"{exact / 1e3:.4f}", f"{abs(found) / 1e3:.4f}"


def _slides(order: int) -> tuple[float, float]:
    """Return the shear force below a block that is pushed over its statics, the farthest off, and the greatest jump.

    A jump is what forces change by in .2 mm about every quarter of a zone's side, at the nodes too.
    """
    off, jump = [], []
    for place in PLACES:
        before, after = (
            scenes.forces_below(bsm.run(scenes.pushed(place + small, order=order))) for small in (-1e-4, 1e-4)
        )
        x, y = before.sum(axis=0)
        off.append(-x / y / np.tan(np.radians(scenes.FRICTION)))
        jump.append(float(np.abs(after - before).max() * len(before) / y))
    return max(off, key=lambda part: abs(part - 1)), max(jump)


def _arch(thickness: float) -> tuple[float, float]:
    """Return by how much the crown of an arch moves up [mm]: of rigid blocks, and of zones in stiff rock."""
    model = arch(11, thickness, 40.0)
    zones = bsm.Zones(order=1, displacement="large")
    stiff = model.replace(rocks=[replace(model.rocks[0], young=1e13, poisson=0.2, zones=zones)])
    rigid, zoned = (1e3 * float(bsm.run(each).stages[0].displacement[5, 1]) for each in (model, stiff))
    assert np.isfinite((rigid, zoned)).all()
    return rigid, zoned


if __name__ == "__main__":
    sys.exit(table_command(COMMAND, __doc__, HEADER, rows))
