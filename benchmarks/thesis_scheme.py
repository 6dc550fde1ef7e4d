"""The thesis's own iteration on random models: ``python -m benchmarks.thesis_scheme [--count N] [--into PAGE]``.

Models are those of the campaign with few blocks. What is right is the closed form, where there is one that can say;
else what ``scheme = "continuation"`` says, at which the campaign's oracles look. Blocks that reach rest after moving
a tenth of their size moved. A table tells, for `wang` as it is and with other settings, how many models have an
answer, how many of these are wrong, and at what cost.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass

import numpy as np

import bsm_mesh as bsm
from benchmarks.campaign.families import FAMILIES
from benchmarks.campaign.trial import Trial, trial_of
from benchmarks.pages import add_into, tell
from bsm_mesh.results.movement import moved_far
from bsm_mesh.solve.continuation import wang
from examples.numbers.pages import markdown

COMMAND = "python -m benchmarks.thesis_scheme"
KINDS = (
    "incline",
    "column",
    "tower",
    "plane",
    "arch",
    "wall",
    "pile",
    "layers",
    "slope",
    "tunnel",
    "wall+bolts",
    "pile+water",
)
MOST = 60  # blocks
CYCLES = 1000


@dataclass(frozen=True, kw_only=True)
class Setting:
    """A variant of the iteration.

    Attributes
    ----------
    holds : int
        Cycles in a row in which a contact has to carry before it holds a block.
    least : float
        Least part of their shear stiffness that sliding contacts keep.
    """

    holds: int = wang.HOLDS
    least: float = bsm.Options().sliding_stiffness

    def __str__(self) -> str:
        return f"holds after {self.holds}, least part {self.least:g}"


SETTINGS = (
    Setting(),
    *(Setting(holds=count) for count in (1, 2, 5, 10, 20)),
    *(Setting(least=part) for part in (1.0, 1e-4, 1e-8)),
)
Task = tuple[str, int]


@dataclass(frozen=True, kw_only=True)
class Row:
    """The outcome of a model with a setting: whether it is stable, and does by what is known; None: no verdict."""

    setting: Setting
    stands: bool | None
    known: bool
    cycles: int
    seconds: float


def small_trials(count: int) -> Iterator[Trial]:
    """Give the first models of every kind that have few blocks and an answer of their own."""
    for kind in KINDS:
        found = (trial for seed in range(20 * count) if (trial := trial_of(FAMILIES[kind], seed)).scene.count <= MOST)
        yield from (trial for trial, _ in zip(found, range(count), strict=False))


def known_of(trial: Trial) -> bool | None:
    """Return whether a model stands."""
    if trial.expected is not None and trial.expected.rests is not None:
        return trial.expected.rests
    return _stands(bsm.run(trial.scene.model(), bsm.Options(threads=1)))


def _stands(results: bsm.Results) -> bool | None:
    """Return whether blocks rest where they were given; None: no verdict."""
    if any(moved_far(results.blocks, stage).size for stage in results.stages):
        return False
    return {"stable": True, "unstable": False}.get(str(results.status))


def measure(task: Task) -> list[Row]:
    """Return a row a setting of a model; none where nothing is known of it."""
    trial = trial_of(FAMILIES[task[0]], task[1])
    known = known_of(trial)
    rows: list[Row] = []
    for setting in SETTINGS if known is not None else ():
        wang.HOLDS = setting.holds
        options = bsm.Options(scheme="wang", sliding_stiffness=setting.least, max_steps=CYCLES, threads=1)
        began = time.process_time()
        results = bsm.run(trial.scene.model(), options)
        assert known is not None
        rows.append(
            Row(
                setting=setting,
                stands=_stands(results),
                known=known,
                cycles=sum(len(stage.steps) for stage in results.stages),
                seconds=time.process_time() - began,
            )
        )
    return rows


def table_of(rows: Sequence[Row]) -> str:
    """Return the table in Markdown."""
    lines = []
    for setting in SETTINGS:
        mine = [row for row in rows if row.setting == setting]
        answered = [row for row in mine if row.stands is not None]
        wrong = [row for row in answered if row.stands != row.known]
        lines.append(
            (
                str(setting),
                str(len(mine)),
                str(len(answered)),
                str(sum(not row.known for row in wrong)),
                str(sum(row.known for row in wrong)),
                f"{np.median([row.cycles for row in mine]):.0f}",
                f"{sum(row.seconds for row in mine):.0f}",
            )
        )
    header = (
        "setting",
        "models",
        "answers",
        "rests, but must move",
        "moves, but rests",
        "median cycles",
        "processor s",
    )
    return markdown(header, lines)


def main() -> int:
    """Run the models with every setting; print the table or put it into a page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=8, help="models of a kind")
    parser.add_argument("--processes", type=int, default=2)
    add_into(parser, COMMAND)
    given = parser.parse_args()
    tasks: list[Task] = [(trial.family, trial.seed) for trial in small_trials(given.count)]
    with ProcessPoolExecutor(given.processes) as pool:
        rows = [row for each in pool.map(measure, tasks) for row in each]
    tell(table_of(rows), COMMAND, given.into)
    return 0


if __name__ == "__main__":
    sys.exit(main())
