"""Factors of safety of random slopes and tunnels: ``python -m benchmarks.safety [slopes] [tunnels] [--count N]``.

Jointed slopes of 100 to 400 blocks and excavated tunnels, at two stiffnesses. Told are brackets that did not close,
undecided trials, factors beyond the bound of limit analysis, and processor seconds a factor. Exit code 1 where a
bracket stays open or lies beyond its bound.
"""

from __future__ import annotations

import argparse
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace

import numpy as np

import bsm_mesh as bsm
from benchmarks.campaign.families.slopes import draw_slope
from benchmarks.campaign.families.tunnels import draw_tunnel
from benchmarks.campaign.trial import Draw, generator_of

TOLERANCE = 0.005
LEAST, MOST = 100, 400  # blocks
STIFFNESS = 1e10, 1e11  # Pa/m
KINDS: dict[str, tuple[tuple[Draw, ...], int]] = {"slopes": ((draw_slope,), 40), "tunnels": ((draw_tunnel,), 20)}


@dataclass(frozen=True, kw_only=True)
class Row:
    """The outcome of one model."""

    kind: str
    seed: int
    blocks: int
    kn: float
    stable: float | None
    unstable: float | None
    undecided: int
    closed: bool
    decided: bool
    bound: float
    trials: int
    seconds: float
    greatest: float

    @property
    def is_wrong(self) -> bool:
        """Whether the bracket is open, though something failed, or lies beyond the bound."""
        beyond = self.stable is not None and self.stable > self.bound * (1 + TOLERANCE)
        return beyond or not self.decided


def model_of(kind: str, seed: int, kn: float) -> bsm.Model:
    """Return the model of a seed: the first of its draws of the right size whose former stages stand."""
    draws, _ = KINDS[kind]
    generator = generator_of("safety", kind, seed)
    while True:
        scene = draws[seed % len(draws)](generator).scene
        if not LEAST <= scene.count <= MOST:
            continue
        model = replace(scene, kn=kn, ks=kn * scene.ks / scene.kn).model()
        former = model.replace(stages=model.stages[:-1])
        if not model.stages or bsm.run(former, bsm.Options(threads=1)).status == "stable":
            return model


def measure(task: tuple[str, int, float]) -> Row:
    """Return the factor of safety of a model, and what it cost."""
    from bsm_mesh.safety.factor import factor_of_safety

    kind, seed, kn = task
    model = model_of(kind, seed, kn)
    began = time.process_time()
    found = factor_of_safety(model, bsm.Options(threads=1), tolerance=TOLERANCE)
    return Row(
        kind=kind,
        seed=seed,
        blocks=model.blocks.count,
        kn=kn,
        stable=found.stable,
        unstable=found.unstable,
        undecided=len(found.undecided),
        closed=found.is_closed,
        decided=found.is_decided,
        bound=found.limit.factor,
        trials=len(found.trials),
        seconds=time.process_time() - began,
        greatest=max((trial.seconds for trial in found.trials), default=0.0),
    )


def told(value: float | None) -> str:
    return "-" if value is None else f"{value:.4f}"


def summary(rows: list[Row], kind: str, kn: float) -> str:
    """Return what an issue asks of a kind, in a sentence."""
    mine = [row for row in rows if row.kind == kind and row.kn == kn]
    seconds = np.array([row.seconds for row in mine])
    failing = [row for row in mine if row.stable is not None and row.unstable is not None]
    closed, undecided = sum(row.closed for row in failing), sum(row.undecided for row in mine)
    beyond = sum(row.is_wrong and row.decided for row in mine)
    return (
        f"{kind}, Kn {kn:.0e}: {closed} of {len(failing)} brackets closed "
        f"({len(mine) - len(failing)} others: nothing fails, or no strength is enough), {undecided} undecided trials "
        f"in them, {beyond} beyond the bound; s: median {np.median(seconds):.1f}, greatest {seconds.max():.1f}"
    )


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("kinds", nargs="*", help="slopes, tunnels")
    parser.add_argument("--count", type=int, help="models of each kind")
    parser.add_argument("--processes", type=int, default=2)
    given = parser.parse_args()
    chosen = given.kinds or list(KINDS)
    tasks = [(kind, seed, kn) for kind in chosen for seed in range(given.count or KINDS[kind][1]) for kn in STIFFNESS]
    print("kind     seed blocks      Kn   stable unstable undecided  bound  trials      s  slowest trial")
    rows = []
    with ProcessPoolExecutor(given.processes) as pool:
        for row in pool.map(measure, tasks):
            rows.append(row)
            print(
                f"{row.kind:8} {row.seed:4} {row.blocks:6} {row.kn:7.0e} {told(row.stable):>8} {told(row.unstable):>8} "
                f"{row.undecided:9} {row.bound:7.4f} {row.trials:6} {row.seconds:6.1f} {row.greatest:6.1f}"
                f"{'  WRONG' if row.is_wrong else ''}",
                flush=True,
            )
    for kind in chosen:
        for kn in STIFFNESS:
            print(summary(rows, kind, kn))
    return int(any(row.is_wrong for row in rows))


if __name__ == "__main__":
    sys.exit(main())
