"""What the settings of sliding zones are worth, over random blocks: ``python -m benchmarks.sliding_zones``.

A block of random width and zones is pushed along a base of one or two blocks, over nodes or over the end, some by
little. Each setting is changed by itself. Forces are compared with those of places found anew at every equilibrium.
Rows of blocks with gaps show the settings of blocks that meet.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import dataclass
from typing import Any
from unittest.mock import patch

import numpy as np

import bsm_mesh as bsm
from benchmarks.pages import add_into, tell
from bsm_mesh.arrays import FloatArray
from bsm_mesh.solve.zones import following, moving_points, shaken_zones
from examples.numbers.pages import markdown
from tests.scenes.large_zones import FRICTION, forces_below, pushed
from tests.scenes.meeting_zones import rigid as without_zones
from tests.scenes.meeting_zones import row as row_of_blocks

COMMAND = "python -m benchmarks.sliding_zones"
SEED = 6161
ANEW = 1e-9  # of the side of a zone: every point gets another place
CHANGES = (
    ("SLID", moving_points.SLID),
    ("SLID", 1e-1),
    ("SLID", 1e-2),
    ("SLID", 1e-4),
)
MEETING = (
    (shaken_zones, "BAND", shaken_zones.BAND),
    (shaken_zones, "BAND", 0.005),
    (shaken_zones, "BAND", 0.08),
    (following, "STIFFEST", 30.0),
    (following, "STIFFEST", 300.0),
)


@dataclass(frozen=True, kw_only=True)
class Member:
    """A random block: how far it is pushed, order and size of its zones, blocks of the base, its own sides [m]."""

    by: float
    order: int
    size: float
    base: tuple[float, ...]
    block: tuple[float, float]

    def run(self) -> bsm.Results:
        """Return the results."""
        return bsm.run(pushed(self.by, order=self.order, size=self.size, base=self.base, block=self.block))


def drawn(count: int) -> list[Member]:
    """Return so many members."""
    random = np.random.default_rng(SEED)
    found = []
    for number in range(count):
        width, joint = random.uniform(0.6, 1.6), random.uniform(1.5, 2.5)
        beyond = number % 2 * random.uniform(0.05, 0.4) * width  # of every other one, over the end of the base
        by = 10 ** random.uniform(-3.5, -1.2) if number % 4 == 2 else random.uniform(0.1, 1.5)
        end = 0.5 + width + by - beyond if number % 2 else 4.5
        parts = (0.0, min(joint, end - 0.3), end) if number % 3 == 0 else (0.0, end)
        size = float(random.uniform(0.25, 0.6))
        found.append(Member(by=by, order=1 + number % 4 // 2, size=size, base=parts, block=(0.5, 0.5 + width)))
    return found


def row(members: list[Member], anew: list[FloatArray | None], change: tuple[str, float]) -> tuple[str, ...]:
    """Return the row of a setting."""
    name, value = change
    begun = time.process_time()
    with patch.object(moving_points, name, value):
        results = [member.run() for member in members]
    seconds = time.process_time() - begun
    rests = [one.status == "stable" for one in results]
    off, statics = [], []
    for one, wanted, at_rest in zip(results, anew, rests, strict=True):
        if not at_rest:
            continue
        found = forces_below(one)
        x, y = found.sum(axis=0)
        statics.append(abs(-x / y / np.tan(np.radians(FRICTION)) - 1))
        if wanted is not None:
            off.append(np.abs(found - wanted).max() * len(found) / y)
    usual = " (as it is)" if value == getattr(moving_points, name) else ""
    numbers = f"{max(off, default=np.nan):.1e}", f"{max(statics, default=np.nan):.1e}", f"{seconds:.0f}"
    return f"`{name}` = {value:g}{usual}", str(sum(rests)), *numbers


def meeting_row(models: list[bsm.Model], rigid: list[bsm.Results], change: tuple[Any, str, float]) -> tuple[str, ...]:
    """Return the row of a setting of blocks that meet."""
    module, name, value = change
    begun = time.process_time()
    with patch.object(module, name, value):
        results = [bsm.run(model) for model in models]
    seconds = time.process_time() - begun
    same = sum(one.status == other.status for one, other in zip(results, rigid, strict=True))
    usual = " (as it is)" if value == getattr(module, name) else ""
    moved = ([each.stages[0].displacement for each in both] for both in zip(results, rigid, strict=True))
    off = [float(np.abs(one - other).max() / np.abs(other).max()) for one, other in moved]
    smooth = [each for each, model in zip(off, models, strict=True) if not model.joints[0].law.friction]
    return f"`{name}` = {value:g}{usual}", str(same), f"{max(smooth, default=np.nan):.1e}", f"{seconds:.0f}"


def meetings(count: int) -> str:
    """Return the table of the settings of blocks that meet, over rows of blocks with and without friction."""
    models = [row_of_blocks(seed, smooth=smooth) for smooth in (True, False) for seed in range(count // 2)]
    rigid = [bsm.run(without_zones(model)) for model in models]
    header = (
        "setting",
        f"verdicts of rigid blocks, of {len(models)}",
        "without friction: greatest difference over the greatest movement",
        "processor time, s",
    )
    return markdown(header, [meeting_row(models, rigid, change) for change in MEETING])


def main() -> None:
    """Make the table, and print it or put it into a page."""
    parser = argparse.ArgumentParser(prog=COMMAND, description=__doc__)
    parser.add_argument("--members", type=int, default=24)
    add_into(parser, COMMAND)
    given = parser.parse_args()
    members = drawn(given.members)
    with patch.object(moving_points, "SLID", ANEW):
        found = [member.run() for member in members]
    anew = [forces_below(one) if one.status == "stable" else None for one in found]
    rows = []
    for change in CHANGES:
        rows.append(row(members, anew, change))
        print(*rows[-1], flush=True)
    header = (
        "setting",
        f"at rest, of {len(members)}",
        "force of a point off, over their mean",
        "shear off N tan(friction)",
        "processor time, s",
    )
    tell(f"{markdown(header, rows)}\n\n{meetings(given.members)}", COMMAND, given.into)


if __name__ == "__main__":
    main()
