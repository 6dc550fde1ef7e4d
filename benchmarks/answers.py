"""Models that were slow to answer or did not, near and at their limits: ``python -m benchmarks.answers [PART ...]``.

Stiff columns just over their friction, walls through their limit, arches about their least thickness, slopes with a
bolt, some with joints that dip exactly at their friction. Exit code 1 where one has no verdict, or is too slow.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np

import bsm_mesh as bsm
from benchmarks.campaign.families.arches import STEEP, THICKNESS, voussoirs
from benchmarks.campaign.scene import Scene, box, turn
from tests.scenes.large import Scene as LargeScene
from tests.scenes.large import jointed_slope, tilted_wall

MOST = 20.0  # processor seconds a model
OPTIONS = bsm.Options(scheme="continuation", threads=1)
Named = tuple[str, Callable[[], bsm.Model]]


def columns() -> Iterator[Named]:
    """Return columns of stiff blocks, 2 degrees steeper than their friction and just over their tipping angle."""
    for count in (1, 2, 3, 5, 10, 20, 40):
        for kn in (1e9, 1e10, 1e11, 1e12, 1e13):
            for over in (2.0, 0.1):
                friction = 0.9 * float(np.degrees(np.arctan(2 / count))) - over
                yield (
                    f"column of {count}, {over:g} degrees over friction, Kn {kn:.0e}",
                    _column(count, friction, over, kn),
                )


def _column(count: int, friction: float, over: float, kn: float) -> Callable[[], bsm.Model]:
    reach = 3.0 * count + 3
    cells = [box(-reach, -1, reach, 0), *(box(-1, k, 1, k + 1) for k in range(count))]
    turned = [turn(cell, -(friction + over)) for cell in cells]
    return Scene(polygons=turned, held=np.array([0]), friction=friction, kn=kn, ks=kn).model


def walls() -> Iterator[Named]:
    """Return walls in bond, tilted in small steps through the angle at which they fail."""
    for tilt in np.arange(24, 31.01, 0.25):
        yield f"wall of 100 at {tilt:g} degrees", tilted_wall(100, 35.0, float(tilt)).model
    for tilt in (20.0, 21.0, 22.0, 23.0, 24.0, 24.4, 24.8, 24.9, 25.0, 25.4, 26.0, 27.0, 28.0, 29.0, 30.0):
        yield f"wall of 1000 at {tilt:g} degrees", tilted_wall(1000, 35.0, tilt).model


def arches() -> Iterator[Named]:
    """Return semicircular arches about their least thickness."""
    for count, least in THICKNESS.items():
        for part in (0.95, 0.99, 1.01, 1.03, 1.1):
            for kn in (1e9, 1e11):
                stones, springings = voussoirs(count, 1.0, part * least)
                held = np.array([count, count + 1])
                scene = Scene(polygons=[*stones, *springings], held=held, friction=STEEP, kn=kn, ks=kn)
                yield f"arch of {count}, {part:g} of its least thickness, Kn {kn:.0e}", scene.model


def slopes() -> Iterator[Named]:
    """Return slopes with a bolt: deep in the rock, and in a face whose joints dip exactly at their friction (30)."""
    for blocks in (100, 235, 500):
        for friction in (28.0, 29.0, 30.0, 31.0, 32.0):
            slope = jointed_slope(blocks, friction)
            for name, bolt in _bolts(slope):
                bolted = replace(slope, bolts=[] if bolt is None else [bolt])
                yield f"slope of {blocks}, friction {friction:g}, {name}", bolted.model


def _bolts(slope: LargeScene) -> Iterator[tuple[str, bsm.Bolt | None]]:
    """Return no bolt, one in the face, and one deep in the rock, each from a block's middle to another's."""
    centre = np.array([np.mean(polygon, axis=0) for polygon in slope.polygons])
    height = slope.surface[0][1]

    def nearest(x: float, y: float) -> tuple[float, float]:
        found = centre[np.argmin(np.hypot(*(centre - (x * height, y * height)).T))]
        return float(found[0]), float(found[1])

    steel = {"diameter": 0.025, "yield_strength": 500e6, "bond_strength": 200e3}
    yield "no bolt", None
    yield "bolt in the face", bsm.Bolt(start=nearest(-0.42, 0.4), end=nearest(-0.9, 0.3), **steel)
    yield "deep bolt", bsm.Bolt(start=nearest(-1.0, 0.3), end=nearest(-1.2, 0.0), **steel)


PARTS = {"columns": columns, "walls": walls, "arches": arches, "slopes": slopes}


def main() -> int:
    """Run the parts and print a line a part, and every model without an answer or too slow."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("parts", nargs="*", choices=[*PARTS, []], metavar="PART", help=", ".join(PARTS))
    given = parser.parse_args()
    wrong = 0
    print("| models | number | stable | unstable | no verdict | median | greatest | slowest |")
    print("|---|---:|---:|---:|---:|---:|---:|---|")
    for part in given.parts or PARTS:
        found = []
        for name, model_of in PARTS[part]():
            model, began = model_of(), time.process_time()
            status = bsm.run(model, OPTIONS).stages[-1].status.value
            found.append((time.process_time() - began, status, name))
            if status == "not_converged" or found[-1][0] > MOST:
                print(f"{name}: {status}, {found[-1][0]:.1f} s", file=sys.stderr, flush=True)
                wrong += 1
        seconds = [second for second, *_ in found]
        verdicts = [sum(of == kind for _, of, _ in found) for kind in ("stable", "unstable", "not_converged")]
        told = f"{np.median(seconds):.2f} s | {max(seconds):.1f} s | {max(found)[2]}"
        print(f"| {part} | {len(found)} | {' | '.join(map(str, verdicts))} | {told} |", flush=True)
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main())
