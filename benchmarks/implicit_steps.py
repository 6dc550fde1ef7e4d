"""What the settings of the implicit integrator are worth, over random walls: ``python -m benchmarks.implicit_steps``.

Walls in running bond under two cycles of a sine, most of them without damping. Each setting is changed by itself. Runs
that end are compared with the explicit integrator. With ``--into PAGE`` the table takes the place of what is between
that page's marks.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import dataclass, replace
from unittest.mock import patch

import numpy as np

import bsm_mesh as bsm
from benchmarks.pages import add_into, tell
from bsm_mesh.model.base_motion import GRAVITY
from bsm_mesh.model.shaking import Integrator
from bsm_mesh.results.records import StageResult
from bsm_mesh.solve.continuation import implicit_motion
from examples.numbers.pages import markdown
from tests.scenes.shaken import wall

COMMAND = "python -m benchmarks.implicit_steps"
SEED, EVERY, PART = 5959, 0.05, 0.1  # s, of it
MOVED = 1e-5  # m: where walls move by less, movements are not compared
CHANGES: tuple[dict[str, float], ...] = (
    {},
    {"residual": 1e-10},
    {"residual": 1e-6},
    {"residual": 1e-4},
    {"halvings": 0},
    {"halvings": 3},
    {"halvings": 6},
    {"least_energy": 0.0},
    {"least_energy": 0.03},
)


@dataclass(frozen=True, kw_only=True)
class Member:
    """A random wall: courses, bricks in one, joint stiffness [Pa/m], friction [degrees], the input, the damping."""

    courses: int
    bricks: int
    stiffness: float
    friction: float
    peak: float
    frequency: float
    damping: float
    softens: bool

    def run(self, integrator: Integrator) -> StageResult:
        """Return the shaken stage by an integrator."""
        shaking = bsm.Shaking(
            waveform="sine",
            frequency=self.frequency,
            amplitude=self.peak,
            cycles=2,
            duration=2 / self.frequency + 0.1,
            every=EVERY,
            contact_damping=self.damping,
        )
        if integrator == "implicit":
            shaking = replace(shaking, integrator="implicit", time_step=PART)
        model = wall(shaking, courses=self.courses, bricks=self.bricks, kn=self.stiffness, friction=self.friction)
        if self.softens:
            law = bsm.MohrCoulomb(friction=self.friction, residual_friction=0.7 * self.friction)
            model = model.replace(joints=[replace(model.joints[0], law=law)])
        return bsm.run(model).stages[-1]


def drawn(count: int) -> list[Member]:
    """Return so many members."""
    random = np.random.default_rng(SEED)
    return [
        Member(
            courses=int(random.integers(1, 6)),
            bricks=int(random.integers(1, 4)),
            stiffness=float(10 ** random.uniform(8, 9.5)),
            friction=float(random.uniform(20, 40)),
            peak=float(random.uniform(0.2, 0.8) * GRAVITY),
            frequency=float(10 ** random.uniform(0.4, 0.8)),
            damping=float(random.choice([0.0, 0.0, 0.05])),
            softens=bool(random.random() < 0.25),
        )
        for _ in range(count)
    ]


def rms(stage: StageResult) -> float:
    """Return the root mean square of the bricks' movement [m]."""
    return float(np.sqrt((stage.stage_displacement[1:, :2] ** 2).sum(axis=1).mean()))


def row(members: list[Member], explicit: list[StageResult], change: dict[str, float]) -> tuple[str, ...]:
    """Return the row of a changed setting."""
    settings = replace(implicit_motion.SETTINGS, **change)  # type: ignore[arg-type]  # one of them is an int
    with patch.object(implicit_motion, "SETTINGS", settings):
        begun = time.process_time()
        stages = [member.run("implicit") for member in members]
        seconds = time.process_time() - begun
    found = [stage.shaking for stage in stages]
    ended = [stage.status.is_at_rest for stage in stages]
    given_up = sum("gives up" in stage.reason for stage in stages)
    steps = sum(one.cycles for one in found if one is not None)
    missed = [100 * one.imbalance for one, at_rest in zip(found, ended, strict=True) if one is not None and at_rest]
    pairs = zip(stages, explicit, ended, strict=True)
    apart = [
        100 * abs(rms(one) / rms(other) - 1)
        for one, other, at_rest in pairs
        if at_rest and other.status.is_at_rest and rms(other) > MOVED
    ]
    name = ", ".join(f"`{key}` = {value:g}" for key, value in change.items()) or "as it is"
    sizes = f"{max(missed, default=np.nan):.2g}", f"{np.median(apart):.2g}" if apart else "-", str(len(apart))
    return name, str(sum(ended)), str(given_up), str(steps), *sizes, f"{seconds:.0f}"


def main() -> None:
    """Make the table, and print it or put it into a page."""
    parser = argparse.ArgumentParser(prog=COMMAND, description=__doc__)
    parser.add_argument("--members", type=int, default=10)
    add_into(parser, COMMAND)
    given = parser.parse_args()
    members = drawn(given.members)
    explicit = [member.run("explicit") for member in members]
    rows = []
    for change in CHANGES:
        rows.append(row(members, explicit, change))
        print(*rows[-1], flush=True)
    header = (
        "setting",
        f"at rest, of {len(members)}",
        "given up",
        "time steps",
        "balance missed by at most, %",
        "rms movement from explicit, median %",
        "of",
        "processor time, s",
    )
    tell(markdown(header, rows), COMMAND, given.into)


if __name__ == "__main__":
    main()
