"""A thousand bolts in a wall of ten thousand bricks: what they cost. ``python -m benchmarks.bolts [bricks] [bolts]``.

The tilted wall of the other benchmarks; grouted bolts of 2.5 m in random directions with limited bond and yield. Every
run goes from the same start to equilibrium, the second of two is timed. Pretension is another load, so that run takes
another way: compare the times of a factorization. Processor seconds count where other programs run beside it.
"""

from __future__ import annotations

import sys
import time

import numpy as np

import bsm_mesh as bsm
from benchmarks.scenes import tilted_wall

LENGTH, AWAY = 2.5, 4.0  # of a bolt; of the heads from the wall's sides [m]


def random_bolts(blocks: bsm.Blocks, count: int, **keys: float) -> list[bsm.Bolt]:
    """Return bolts that lie in the wall."""
    rng = np.random.default_rng(0)
    low, high = blocks.vertices.min(axis=0) + AWAY, blocks.vertices.max(axis=0) - AWAY
    head = rng.uniform(low, high, (count, 2))
    angle = rng.uniform(0, 2 * np.pi, count)
    tip = head + LENGTH * np.column_stack([np.cos(angle), np.sin(angle)])
    ends = zip(head.tolist(), tip.tolist(), strict=True)
    keys = {"diameter": 0.025, "yield_strength": 500e6, "bond_strength": 150e3, "spacing": 1.5, **keys}
    return [bsm.Bolt(start=tuple(h), end=tuple(t), **keys) for h, t in ends]


def timed(model: bsm.Model) -> tuple[bsm.Results, float, float]:
    """Return the results, and the wall and processor seconds of a run whose compiled code is warm."""
    options = bsm.Options(scheme="continuation")
    bsm.run(model, options)
    began, work = time.perf_counter(), time.process_time()
    results = bsm.run(model, options)
    return results, time.perf_counter() - began, time.process_time() - work


def main(bricks: int, count: int) -> None:
    """Print a row a run."""
    model = tilted_wall(bricks).model()
    began = time.perf_counter()
    passive = model.replace(bolts=random_bolts(model.blocks, count))
    print(f"{model.blocks.count} blocks, {count} bolts; placed and checked in {time.perf_counter() - began:.2f} s")
    tensioned = model.replace(bolts=random_bolts(model.blocks, count, pretension=20e3))
    plain = 0.0
    for name, case in (("no bolts", model), ("passive", passive), ("pre-tensioned", tensioned)):
        results, seconds, work = timed(case)
        plain = plain or work
        stage = results.stages[-1]
        factorizations = sum(step.factorizations for step in stage.steps)
        taut = int((stage.bolts.greatest_force > 1.0).sum())
        print(
            f"{name:14s} {results.status.value:8s} {seconds:7.2f} s, "
            f"processor {work:.2f} s ({100 * (work / plain - 1):+.0f} %)  "
            f"{factorizations:4d} factorizations, {1e3 * seconds / factorizations:.0f} ms each  "
            f"{taut:4d} bolts in tension",
            flush=True,
        )


if __name__ == "__main__":
    main(*(int(a) for a in sys.argv[1:3])) if len(sys.argv) > 2 else main(10_000, 1000)
