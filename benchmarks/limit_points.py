"""A map of flat arches that snap through: ``python -m benchmarks.limit_points``; exit code 1 where one is wrong."""

from __future__ import annotations

import argparse
import itertools
import sys
import time
from concurrent.futures import ProcessPoolExecutor

import numpy as np

from tests.scenes.flat_arch import is_right, snapped

FLATNESS = (0.05, 0.1, 0.2, 0.3, 0.5)
FRACTIONS = (0.5, 0.8, 0.9, 0.95, 0.97, 0.98, 0.99, 1.01, 1.03)
STIFFNESS = (1e8, 1e9, 1e10, 1e11, 1e12, 1e13)
SHEAR = (10.0, 1e2, 1e3, 1e4)  # stiffness of shear springs over that of normal ones
FRICTION = (40.0, 60.0, 80.0)  # degrees
LOADS = {"load at once": {}, "load in 20 stages": {"stages": 20}, "weight": {"weight": True}}
Case = tuple[float, float, float, bool, str, float, float]
MAP: list[Case] = [
    *itertools.product(FLATNESS, FRACTIONS, STIFFNESS, (False, True), LOADS, (1.0,), (80.0,)),
    *itertools.product(FLATNESS[1:-1], FRACTIONS, STIFFNESS[:2], (True,), LOADS, SHEAR, FRICTION),
]


def judged(case: Case) -> tuple[Case, str, bool, float]:
    """Return a case with its verdict, whether that is right, and processor seconds."""
    flatness, fraction, kn, half, load, shear, friction = case
    began = time.process_time()
    stage, exact = snapped(flatness, fraction, kn, half=half, shear=shear, friction=friction, **LOADS[load])
    return case, str(stage.status), is_right(stage, exact), time.process_time() - began


def main() -> int:
    """Run the map, or some of it, and print the fault and how many there were."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sample", type=int, metavar="N", help="so many of all at random, always the same ones")
    parser.add_argument("--processes", type=int, default=1)
    given = parser.parse_args()
    cases = MAP
    if given.sample:
        cases = [MAP[k] for k in np.random.default_rng(0).permutation(len(MAP))[: given.sample]]
    with ProcessPoolExecutor(given.processes) as pool:
        found = list(pool.map(judged, cases, chunksize=4))
    for (flatness, fraction, kn, half, load, shear, friction), status, right, _ in found:
        if not right:
            stones = "one stone beside a smooth wall" if half else "two stones"
            joint = f"Kn {kn:.0e}, Ks {shear:g} Kn, friction {friction:g}"
            print(f"wrong: {stones}, rise {flatness:g}, {fraction:g} of the limit, {joint}, {load}: {status}")
    wrong = sum(not right for _, _, right, _ in found)
    print(f"{len(found)} cases, {wrong} wrong, {sum(seconds for *_, seconds in found):.0f} processor seconds")
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main())
