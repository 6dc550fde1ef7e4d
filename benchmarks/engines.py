"""Both engines that cut rock, own cutter and Gmsh's fragment, give the same blocks: ``python -m benchmarks.engines``.

On every geometry of the package that is cut, and on 50 random networks. Tolerance: an area may differ by what its
outline sweeps over the tolerance to which each engine knows where lines cross (a millionth of the model's diagonal).
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from tempfile import TemporaryDirectory
from typing import Any
from unittest import mock

import numpy as np

from bsm_mesh.geometries import (
    Exponential,
    JointSet,
    Lognormal,
    Opening,
    Region,
    RockMass,
    circle,
    cut_blocks,
    rectangle,
)
from bsm_mesh.geometries.cases import find_case
from tests.scenes.networks import areas_within, lengths

CASES = ("jointed_tunnel", "cassiar_slope", "dupont_station")
NETWORKS = 50
HEADER = "| geometry | blocks | blocks, gmsh | areas differ by | joints differ by | cutter s | gmsh s |"


def masses() -> Iterator[tuple[str, RockMass]]:
    """Give the rock of every geometry that is cut, and of random networks."""
    for name in CASES:
        yield name, _mass_of(name)
    generator = np.random.default_rng(41)
    for number in range(NETWORKS):
        sets = [
            JointSet(name="J1", dip=generator.uniform(-90, 90), spacing=Lognormal(2.0, 0.6), scatter=4),
            JointSet(name="J2", dip=generator.uniform(-90, 90), density=0.5, length=Exponential(6.0), scatter=8),
            JointSet(
                name="J3", dip=generator.uniform(-90, 90), spacing=4.0, persistence=0.7, bridge=1.0, ends="t_ended"
            ),
        ]
        regions: list[Any] = [Region(outline=rectangle(-10, -10, 10, 10), rock="gneiss")]
        regions += [Opening(outline=circle(3.0), boundary="tunnel")] * (number % 2)
        yield f"network {number}", RockMass(regions=regions, joints=sets, seed=number)


def _mass_of(case: str) -> RockMass:
    """Return the rock that a case gives to the cutter."""
    found: list[RockMass] = []

    def kept(mass: RockMass, *engine: Any) -> Any:
        found.append(mass)
        return cut_blocks(mass)

    with mock.patch("bsm_mesh.geometries.cutting.cut.cut_blocks", kept), TemporaryDirectory() as folder:
        find_case(case).build(f"{folder}/a.msh")
    return found[0]


def timed(call: Callable[[], Any]) -> tuple[Any, float]:
    """Return what a call returns, and its processor time [s]."""
    begun = time.process_time()
    return call(), time.process_time() - begun


def compared(name: str, mass: RockMass) -> tuple[str, bool, float, float]:
    """Return a row, whether both agree, and both times."""
    (one, first), (other, second) = (timed(lambda e=e: cut_blocks(mass, e)) for e in ("shapely", "gmsh"))
    (mine, open_by), (theirs, _) = (areas_within(cut, mass.grid) for cut in (one, other))
    count = min(one.count, other.count)
    off = np.abs(mine[:count] - theirs[:count])
    slivers = [area[count:] < by[count:] for area, by in (areas_within(cut, mass.grid) for cut in (one, other))]
    joints = [lengths(cut, dict(cut.joints)) for cut in (one, other)]
    apart = max((abs(joints[0].get(k, 0) - joints[1].get(k, 0)) for k in {*joints[0], *joints[1]}), default=0.0)
    agree = bool((off <= open_by[:count]).all() and all(s.all() for s in slivers) and apart < 1e-3)
    difference = f"{(off / mine[:count]).max():.1g} of a block" + ("" if agree else ": NO")
    row = f"| {name} | {one.count} | {other.count} | {difference} | {apart:.1g} m | {first:.2f} | {second:.2f} |"
    return row, agree, first, second


def main() -> None:
    """Print the table: every geometry, and the networks in one row."""
    print(HEADER, "|---" * 7 + "|", sep="\n")
    rows = [(name, *compared(name, mass)) for name, mass in masses()]
    for name, row, agree, _, _ in rows:
        if not name.startswith("network") or not agree:
            print(row, flush=True)
    agreed = [agree for name, _, agree, _, _ in rows if name.startswith("network")]
    cutter, gmsh = np.array([row[3:] for row in rows if row[0].startswith("network")]).sum(axis=0)
    print(f"| {len(agreed)} random networks | {sum(agreed)} agree | | | | {cutter:.1f} | {gmsh:.1f} |")


if __name__ == "__main__":
    main()
