"""What a verdict near the limit owes to how loads come on: ``python -m benchmarks.first_stage``.

Walls in bond at 0.88 to 0.98 of the tilt at which limit analysis has no forces any more. Friction is not associated:
one way of loading may find an equilibrium where another finds none. Each wall is loaded at once, with the ramp of
dynamic relaxation as it is, halved and doubled; and it is built on the level and tilted in stages.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import replace
from unittest.mock import patch

import numpy as np

import bsm_mesh as bsm
from benchmarks.campaign.scene import DOWN, Dig, Scene
from benchmarks.campaign.tables import Row, as_markdown, as_text
from benchmarks.pages import add_into, tell
from bsm_mesh.solve.motion import relaxation
from tests.scenes.large import STIFFNESS, tilted_courses

MAKER = "the first stage"
SHARES = (0.88, 0.92, 0.95, 0.98)  # of the limit tilt
ACCURACY = 0.02  # of the limit tilt [degrees]
USUAL = relaxation.SETTINGS.ramp
RAMPS = (USUAL / 2, USUAL, 2 * USUAL)
STAGES = (6, 24)


def wall(generator: np.random.Generator) -> tuple[Scene, float]:
    """Return a wall on the level, and the tilt at which it is asked for [degrees]."""
    courses, bricks = generator.integers(4, 16), generator.integers(3, 16)
    friction, share = float(generator.uniform(25, 45)), float(generator.choice(SHARES))
    drawn = tilted_courses(int(courses), int(bricks), friction, 0.0)
    scene = Scene(
        polygons=list(drawn.polygons), held=drawn.held.astype(np.int64), friction=friction, kn=STIFFNESS, ks=STIFFNESS
    )
    low, high = 0.0, friction
    while high - low > ACCURACY:
        middle = (low + high) / 2
        stands = bsm.limit_analysis(replace(scene, gravity=DOWN + middle).model()).admissible
        low, high = (middle, high) if stands else (low, middle)
    return scene, share * low


def verdicts(scene: Scene, tilt: float) -> dict[str, str]:
    """Return the verdict of a wall by every way of loading it."""
    found = {}
    at_once = replace(scene, gravity=DOWN + tilt).model()
    for ramp in RAMPS:
        with patch.object(relaxation, "SETTINGS", replace(relaxation.SETTINGS, ramp=ramp)):
            found[f"at once, {ramp:g} transits"] = str(bsm.run(at_once).status)
    for stages in STAGES:
        turns = DOWN + tilt * np.arange(1, stages + 1) / stages
        digs = tuple(Dig(blocks=np.zeros(0, np.int64), gravity=float(turn)) for turn in turns)
        found[f"level, tilted in {stages} stages"] = str(bsm.run(replace(scene, digs=digs).model()).status)
    return found


def table(models: int, seed: int = 0) -> list[Row]:
    """Return how many walls have which verdict by each way, and how many another than at once."""
    generator, found = np.random.default_rng(seed), []
    for number in range(models):
        found.append(verdicts(*wall(generator)))
        if len(set(found[-1].values())) > 1:
            print(f"wall {number}: {found[-1]}", file=sys.stderr, flush=True)
    usual = f"at once, {USUAL:g} transits"
    rows: list[Row] = [["loads", "stable", "unstable", "no verdict", "other than usual"]]
    for way in found[0]:
        count = [sum(one[way] == verdict for one in found) for verdict in ("stable", "unstable", "not_converged")]
        rows.append([way, *map(str, count), str(sum(one[way] != one[usual] for one in found))])
    return rows


def main() -> int:
    """Print the table, or write it into a page."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--models", type=int, default=300, help="how many walls (default %(default)s)")
    parser.add_argument("--seed", type=int, default=0)
    add_into(parser, MAKER)
    given = parser.parse_args()
    rows = table(given.models, given.seed)
    tell(as_markdown(rows) if given.into else as_text(rows), MAKER, given.into)
    return 0


if __name__ == "__main__":
    sys.exit(main())
