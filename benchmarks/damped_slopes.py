"""Time steps with dashpots over random slopes, by two rules: ``python -m benchmarks.damped_slopes``.

Starter slopes of 12 m with random joint sets under one cycle of a sine. The time step follows from the sums of dashpots
at a block, or from the greatest ratio of a dashpot to its spring. With ``--into PAGE`` the table takes the place of
what is between that page's marks.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import replace
from unittest.mock import patch

import numpy as np

import bsm_mesh as bsm
from benchmarks.pages import add_into, tell
from benchmarks.starters import starter
from bsm_mesh.arrays import FloatArray
from bsm_mesh.model.base_motion import GRAVITY
from bsm_mesh.results.records import StageResult
from bsm_mesh.solve.continuation.time_steps import time_steps_of
from bsm_mesh.solve.motion.masses import Weighed
from bsm_mesh.solve.motion.real_masses import RealMasses
from examples.numbers.pages import markdown

MAKER = "python -m benchmarks.damped_slopes"
SEED, MEMBERS = 2011, 6
DAMPINGS: tuple[float | str, ...] = (0.05, 0.2, "housner")
HEIGHT, ANGLE, INSIDE = 12.0, 65.0, [25.0, 10.0]  # m, degrees, m
FAMILY = {
    "bedding_dip": (25.0, 55.0),
    "bedding_spacing": (2.5, 5.0),
    "joint_dip": (70.0, 120.0),
    "joint_spacing": (4.0, 8.0),
}  # degrees, m
HEADER = (
    "blocks",
    "`contact_damping`",
    "verdict",
    "time steps by `check`",
    "time steps",
    "by ratios",
    "displacement, m",
    "by ratios",
    "energy error, %",
    "by ratios",
)


def drawn(count: int) -> list[tuple[float | str, bsm.Model, bsm.Options]]:
    """Return part of the critical damping, model and options of so many slopes."""
    random, found = np.random.default_rng(SEED), list[tuple[float | str, bsm.Model, bsm.Options]]()
    with starter("slope") as file:
        for number in range(count):
            given = {key: round(float(random.uniform(*ends)), 1) for key, ends in FAMILY.items()}
            given |= {"height": HEIGHT, "angle": ANGLE, "seed": int(random.integers(1, 1000))}
            values = {f"mesh.parameters.{key}": value for key, value in given.items()}
            loaded = file.model(values | {"in_situ.surface": HEIGHT, "history.crest.point": INSIDE})
            damping = DAMPINGS[number % len(DAMPINGS)]
            shaking = bsm.Shaking(
                waveform="sine",
                frequency=20.0,
                amplitude=0.4 * GRAVITY,
                cycles=1,
                duration=0.1,
                contact_damping=damping,
            )
            stages = [*loaded.model.stages, bsm.Stage(name="quake", shaking=shaking)]
            options = replace(loaded.options or bsm.Options(), threads=1)
            found.append((damping, loaded.model.replace(stages=stages), options))
    return found


def by_greatest_ratio(masses: RealMasses, weighed: Weighed) -> FloatArray:
    """Return springs' sums (n, 3) times the greatest ratio of a dashpot to its spring at a block: the former rule."""
    a, b, columns = weighed
    stiffness = columns["normal_stiffness"].astype(np.float64)
    ratio, over = np.zeros(len(masses.real)), masses._dashpots(1 / masses.real[:, 0], a, b, stiffness) / stiffness
    for side in (a, b):
        np.maximum.at(ratio, side, over)
    return ratio[:, None] * masses._sums


def row(damping: float | str, model: bsm.Model, options: bsm.Options) -> tuple[str, ...]:
    """Return the row of a slope."""
    (expected,) = time_steps_of(model, options)
    now = bsm.run(model, options).stages[-1]
    with patch.object(RealMasses, "_sums_of_dashpots", by_greatest_ratio):
        before = bsm.run(model, options).stages[-1]
    ends = dict.fromkeys(stage.status.value for stage in (now, before))
    given = str(model.blocks.count), f"`{damping}`" if damping != "housner" else '`"housner"`', ", ".join(ends)
    return *given, str(expected.steps), *(text for both in zip(_told(now), _told(before), strict=True) for text in both)


def _told(stage: StageResult) -> tuple[str, str, str]:
    """Return time steps, displacement and energy error of a shaken stage."""
    found = stage.shaking
    assert found is not None
    return str(found.cycles), f"{stage.max_stage_displacement:.3g}", f"{100 * found.imbalance:.1g}"


def main() -> None:
    """Make the table, and print it or put it into a page."""
    parser = argparse.ArgumentParser(prog=MAKER, description=__doc__)
    parser.add_argument("--members", type=int, default=MEMBERS)
    add_into(parser, MAKER)
    given = parser.parse_args()
    rows = []
    for member in drawn(given.members):
        rows.append(row(*member))
        print(*rows[-1], file=sys.stderr, flush=True)
    tell(markdown(HEADER, rows), MAKER, given.into)


if __name__ == "__main__":
    main()
