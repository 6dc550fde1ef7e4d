"""Tunnels in jointed rock that yields, at random: ``python -m benchmarks.plastic_tunnels``.

A round tunnel in rock of all strengths, which two shear zones cross or miss: verdict, displacement, processor time.
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from time import process_time
from typing import Any

import numpy as np

import bsm_mesh as bsm
from benchmarks.pages import add_into, tell
from benchmarks.rock_masses import continued
from bsm_mesh import geometries as g
from bsm_mesh.converters import read_mesh
from bsm_mesh.errors import ModelError
from examples.numbers.pages import markdown

MAKER = "python -m benchmarks.plastic_tunnels"
SIDE = 20.0  # half the side of the rock around the tunnel [m]
LONG = 10.0  # processor time [s] above which tunnels are counted


def drawn(seed: int) -> bsm.Model:
    """Return a random tunnel, excavated in one part or two, in rock that yields."""
    generator = np.random.default_rng([7, seed])
    friction = float(generator.choice([20, 30, 35]))
    cohesion = float(generator.uniform(0.3e6, 2.5e6))
    rock = bsm.Rock(
        "mudstone",
        unit_weight=25e3,
        young=float(generator.choice([1e9, 5e9, 20e9])),
        poisson=0.3,
        cohesion=cohesion,
        friction=friction,
        tensile_strength=float(generator.choice([0, 0.1e6, 0.3e6])),
        zones=bsm.Zones(
            size=float(generator.choice([3, 4, 5])),
            order=2,
            law="mohr_coulomb",
            dilation=float(generator.choice([0, 5, friction])),
        ),
    )
    law = bsm.MohrCoulomb(
        friction=float(generator.choice([15, 25, 35])), cohesion=float(generator.choice([0, 0, 0.2e6]))
    )
    joints = [
        bsm.Joint(name, law=law, normal_stiffness=stiffness, shear_stiffness=0.4 * stiffness)
        for name, stiffness in (("zone", 50e9), ("fault", 200e9))
    ]
    first, second = generator.uniform(-12, 8, 2), generator.uniform(-8, 8, 2)
    first[1] += 4
    lines = {"zone": [(-SIDE, first[0]), (SIDE, first[1])], "fault": [(second[0], -SIDE), (second[1], SIDE)]}
    return bsm.Model(
        blocks=_blocks(lines, float(generator.uniform(2, 4))),
        rocks=[rock],
        joints=joints,
        supports=[bsm.NormalRoller(boundary=side) for side in ("bottom", "left", "right")],
        loads=[bsm.InSituTraction(boundary="top")],
        in_situ=bsm.InSitu(
            surface=float(generator.choice([100, 200, 300])), k0=float(generator.choice([0.5, 0.7, 1, 1.5]))
        ),
        stages=[bsm.Stage("dig", excavate=["tunnel"], relaxation=[[0.5, 1.0], [1.0]][int(generator.integers(2))])],
    )


def _blocks(lines: dict[str, Any], radius: float) -> bsm.Blocks:
    regions = [
        g.Region(outline=g.rectangle(-SIDE, -SIDE, SIDE, SIDE), rock="mudstone"),
        g.Excavation(outline=g.circle(radius, sides=24), name="tunnel"),
    ]
    cut = g.cut_blocks(
        g.RockMass(regions=regions, joints=[g.Fault(name=name, lines=[line]) for name, line in lines.items()])
    )
    with TemporaryDirectory() as folder:
        return read_mesh(g.write_blocks(cut, Path(folder) / "rock.msh"), blocks="regions")[0]


def judged(seed: int) -> dict[str, Any]:
    """Return a tunnel's verdict, greatest displacement of a block [m] and processor time [s]."""
    model, start = drawn(seed), process_time()
    try:
        stage = bsm.run(model, bsm.Options(threads=1)).stages[-1]
    except ModelError as error:
        return {"seed": seed, "verdict": "refused", "why": str(error)}
    moved = float(np.linalg.norm(stage.displacement[stage.present, :2], axis=1).max())
    return {"seed": seed, "verdict": str(stage.status), "moved": moved, "seconds": round(process_time() - start, 1)}


def table(records: Sequence[dict[str, Any]]) -> str:
    """Return the tunnels by verdict, and their effort."""
    rows = []
    for verdict, number in sorted(Counter(each["verdict"] for each in records).items()):
        seconds = [each["seconds"] for each in records if each["verdict"] == verdict and "seconds" in each] or [0.0]
        slow = sum(each > LONG for each in seconds)
        rows.append((verdict, *map(str, (number, f"{np.median(seconds):.1f}", f"{max(seconds):.0f}", slow))))
    header = ("verdict", "tunnels", "processor time, median, s", "greatest, s", f"above {LONG:.0f} s")
    return markdown(header, rows)


def against(records: Sequence[dict[str, Any]], others: Sequence[dict[str, Any]]) -> str:
    """Return the tunnels with another verdict or displacement than before, and the processor time of both."""
    before, lines = {each["seed"]: each for each in others}, []
    both = [(each, before[each["seed"]]) for each in records if each["seed"] in before]
    for new, old in both:
        same = new["verdict"] == old["verdict"]
        if not same or (new["verdict"] == "stable" and not np.isclose(new["moved"], old["moved"], rtol=1e-6)):
            lines.append(f"{new['seed']}: {old} -> {new}")
    times = [sum(each.get("seconds", 0.0) for each in side) for side in zip(*both, strict=True)]
    return "\n".join([*lines, f"{len(both)} tunnels, {len(lines)} of them otherwise; processor time, s: {times}"])


def main() -> None:
    """Judge the tunnels, and print the table of all lines in the file."""
    parser = argparse.ArgumentParser(prog=MAKER, description=(__doc__ or "").splitlines()[0])
    parser.add_argument("file", type=Path, help="file of lines that is continued")
    parser.add_argument("-n", type=int, default=120, help="tunnels in all")
    parser.add_argument("--against", type=Path, help="file of lines of another state of the program")
    add_into(parser, MAKER)
    given = parser.parse_args()
    records = continued(given.file, range(given.n), judged)
    if given.against:
        print(against(records, continued(given.against, (), judged)), file=sys.stderr)
    tell(table(records), MAKER, given.into)


if __name__ == "__main__":
    main()
