"""Both engines that cut rock, own cutter and Gmsh's fragment, give the same blocks: ``python -m benchmarks.engines``.

On every geometry of the package that is cut, and on 50 random networks: as many blocks, areas equal to 1e-9 of each
block, the length of each joint to 1e-9 m. ``--awkward 1000`` adds networks that Hypothesis draws; where lines of these
are nearer to each other than the tolerance one engine may take them as one, the other as two with a sliver between.
``--sizes`` times patterns of growing size, from which the greatest one for Gmsh is taken (`cut.MOST_MEETINGS`).
``--slivers`` joins slivers of other widths, from which that of `slivers.THINNEST` is taken.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from tempfile import TemporaryDirectory
from typing import Any
from unittest import mock

import numpy as np

from benchmarks.pages import add_into, tell, titled
from benchmarks.report import where
from bsm_mesh.geometries import (
    Exponential,
    JointSet,
    Lognormal,
    Opening,
    Region,
    RockMass,
    Voronoi,
    bricks,
    circle,
    cut_blocks,
    rectangle,
)
from bsm_mesh.geometries.cases import find_case
from bsm_mesh.geometries.cutting.cut import count_meetings
from bsm_mesh.geometries.cutting.pieces import gather_pieces
from bsm_mesh.geometries.joint_sets import FloatArray
from bsm_mesh.geometries.rock_mass import TOLERANCE
from examples.numbers.pages import markdown
from tests.scenes.networks import areas, lengths, rock

CASES = ("jointed_tunnel", "cassiar_slope", "dupont_station")
NETWORKS = 50
EQUAL = 1e-9  # of a block's area; m of a joint
HEADER = ("geometry", "blocks", "blocks, gmsh", "areas differ by", "joints differ by", "cutter s", "gmsh s")
COMMAND = "python -m benchmarks.engines"


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


def patterns() -> Iterator[tuple[str, RockMass]]:
    """Give rock in patterns of joints of growing size."""
    whole = [Region(outline=rectangle(-20, -20, 20, 20), rock="gneiss")]
    for s in (1.0, 0.5, 0.25):
        lines = [
            JointSet(name="J1", dip=30, spacing=s),
            JointSet(name="J2", dip=110, spacing=Exponential(1.2 * s), scatter=3),
        ]
        yield f"two sets, {s:g} m", RockMass(regions=whole, joints=lines, seed=1)
        ended = [
            JointSet(name="J1", dip=30, spacing=s),
            JointSet(name="J2", dip=110, spacing=s, persistence=0.7, bridge=s, ends="t_ended"),
        ]
        yield f"one ended at the other, {s:g} m", RockMass(regions=whole, joints=ended, seed=1)
        traces = [
            JointSet(name=f"J{dip}", dip=dip, density=1 / s, length=Lognormal(4, 2), scatter=10)
            for dip in (20, 80, 140)
        ]
        yield f"network, {1 / s:g} m/m2 a set", RockMass(regions=whole, joints=traces, seed=1)
        yield f"Voronoi, {s:g} m", RockMass(regions=whole, joints=[Voronoi(name="V", size=s)], seed=1)
        yield f"bricks, {s:g} m", RockMass(regions=whole, joints=bricks(s, s / 2))


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


@dataclass(frozen=True, slots=True, kw_only=True)
class Compared:
    """What both engines made of one geometry, the cutter first."""

    name: str
    blocks: tuple[int, int]
    areas_apart: float  # of a block's area, the greatest
    joints_apart: float  # m, the greatest
    seconds: tuple[float, float]
    joined: int = 0  # slivers, by the cutter

    @property
    def agree(self) -> bool:
        """Whether the blocks are the same."""
        return self.blocks[0] == self.blocks[1] and max(self.areas_apart, self.joints_apart) <= EQUAL

    @property
    def row(self) -> tuple[str, ...]:
        """The row of the table."""
        found = f"{self.areas_apart:.1g} of a block", f"{self.joints_apart:.1g} m"
        return self.name, *map(str, self.blocks), *found, *(f"{s:.2f}" for s in self.seconds)


def compared(name: str, mass: RockMass) -> Compared:
    """Cut a rock mass by both engines."""
    (one, first), (other, second) = (timed(lambda e=e: cut_blocks(mass, e)) for e in ("shapely", "gmsh"))
    mine, theirs = (np.sort(areas(cut))[::-1] for cut in (one, other))
    common = min(one.count, other.count)
    joints = [lengths(cut, dict(cut.joints)) for cut in (one, other)]
    return Compared(
        name=name,
        blocks=(one.count, other.count),
        areas_apart=float((np.abs(mine[:common] - theirs[:common]) / mine[:common]).max()),
        joints_apart=max((abs(joints[0].get(k, 0) - joints[1].get(k, 0)) for k in {*joints[0], *joints[1]}), default=0),
        seconds=(first, second),
        joined=one.by.slivers,
    )


def awkward(count: int) -> list[Compared]:
    """Compare both engines on networks of the property tests."""
    from hypothesis import HealthCheck, given, settings

    from tests.properties.test_joint_networks import networks

    found: list[Compared] = []

    @settings(
        max_examples=count, deadline=None, derandomize=True, database=None, suppress_health_check=list(HealthCheck)
    )
    @given(networks())
    def compare(mass: RockMass) -> None:
        found.append(compared("awkward", mass))

    compare()
    return found


def together(name: str, found: list[Compared]) -> Compared:
    """Return many geometries as one: sums of blocks and times, the greatest differences."""
    agreed = sum(one.agree for one in found)
    return Compared(
        name=f"{len(found)} {name} networks, {agreed} the same",
        blocks=(sum(one.blocks[0] for one in found), sum(one.blocks[1] for one in found)),
        areas_apart=max(one.areas_apart for one in found),
        joints_apart=max(one.joints_apart for one in found),
        seconds=(sum(one.seconds[0] for one in found), sum(one.seconds[1] for one in found)),
    )


def table_of_sizes() -> str:
    """Return the times of both engines for patterns of growing size."""
    rows = []
    for name, mass in patterns():
        met = count_meetings(gather_pieces(mass)[0])
        one = compared(name, mass)
        seconds = [f"{s:.2f}" for s in one.seconds]
        rows.append((name, str(met), " and ".join(map(str, one.blocks)), *seconds))
        print(*rows[-1], sep="; ", file=sys.stderr, flush=True)
    return markdown(("pattern", "lines meet at", "blocks, cutter and gmsh", "cutter s", "gmsh s"), rows)


def table_of_slivers(count: int = 300) -> str:
    """Return how often the engines make as many blocks of three lines nearly through one point, by what is joined."""
    generator = np.random.default_rng(4)
    gaps = TOLERANCE * np.hypot(10, 10) * generator.uniform(-5, 5, count)  # the third from where the others cross
    triples = [
        rock(*(through((3.1, 4.2), angle, gap) for angle, gap in zip(angles, (0.0, 0.0, far), strict=True)))
        for angles, far in zip(generator.uniform(0, 180, (count, 3)), gaps, strict=True)
    ]
    rows = []
    for width in (0.0, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0):
        with mock.patch("bsm_mesh.geometries.cutting.slivers.THINNEST", width):
            found = [compared("three lines", mass) for mass in triples]
        same, joined = sum(one.blocks[0] == one.blocks[1] for one in found), sum(one.joined for one in found)
        rows.append((f"{width:g} tolerances", str(count), str(same), str(joined)))
    return markdown(("slivers joined below", "three lines", "as many blocks", "slivers joined"), rows)


def table_of_geometries(more: int) -> str:
    """Return what both engines make of every geometry, of the random networks, and of `more` awkward ones."""
    found = [compared(name, mass) for name, mass in masses()]
    networks = [one for one in found if one.name.startswith("network")]
    rows = [*(one for one in found if one not in networks), together("random", networks)]
    if more:
        found += (drawn := awkward(more))
        rows.append(together("awkward", drawn))
    apart = [one.name for one in found if not one.agree]
    said = f"Not the same: {', '.join(f'{count} {name}' for name, count in Counter(apart).items()) or 'none'}."
    return f"{markdown(HEADER, [one.row for one in rows])}\n\n{said}"


def through(point: tuple[float, float], angle: float, offset: float) -> FloatArray:
    """Return a line (2, 2) past a point, by an offset to its left."""
    along = np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle))])
    return np.array(point) + offset * np.array([-along[1], along[0]]) + np.outer([-20, 20], along)


def main() -> None:
    """Make the tables, and print them or put them into a page."""
    parser = argparse.ArgumentParser(prog=COMMAND, description=__doc__)
    parser.add_argument("--awkward", type=int, default=0, metavar="N", help="also N networks that Hypothesis draws")
    parser.add_argument("--sizes", action="store_true", help="also time patterns of growing size, in minutes")
    parser.add_argument("--slivers", action="store_true", help="also join slivers of other widths")
    add_into(parser, COMMAND)
    asked = parser.parse_args()
    parts = [("Every geometry that is cut", table_of_geometries(asked.awkward))]
    if asked.slivers:
        parts.append(("Slivers joined", table_of_slivers()))
    if asked.sizes:
        parts.append(("Patterns of growing size", table_of_sizes()))
    tell(titled(f"{where(1)}.", parts), COMMAND, asked.into)


if __name__ == "__main__":
    main()
