"""Rules of corners of blocks with zones, left out one by one: ``python -m benchmarks.zone_corners``.

Blocks are pushed by little beyond a joint of their base: friction alone resists. Starter slopes with weak bedding and
cross joints slide; verdicts of rigid blocks on the same mesh say whether they come to rest. With ``--into PAGE`` the
table takes the place of what is between that page's marks.
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from time import process_time
from typing import Any
from unittest.mock import patch

import numpy as np

import bsm_mesh as bsm
from benchmarks.pages import add_into, tell
from benchmarks.sliding_zones import SEED, Member
from benchmarks.starters import starter
from bsm_mesh.solve.motion.following import DAMPED
from bsm_mesh.solve.zones import met_points, moved_supports, shaking_run, zones_to_rest
from bsm_mesh.solve.zones.face_chains import FaceChains
from bsm_mesh.solve.zones.moving_points import MovingPoints
from bsm_mesh.solve.zones.zones_to_rest import ZonesToRest
from examples.numbers.pages import markdown
from tests.scenes.large_zones import FRICTION, forces_below

COMMAND = "python -m benchmarks.zone_corners"
# Rules, and what takes their place.
RULES: tuple[tuple[str, Any, str, Any], ...] = (
    ("all rules", ZonesToRest, "slide", ZonesToRest.slide),
    ("a lip carries", MovingPoints, "_tails", property(lambda self: np.zeros(len(self.node), dtype=int))),
    ("corners behind another face", met_points, "_leaves_over_another", lambda near, on, face: np.zeros_like(on)),
    ("two opposing edges at once", met_points, "_opposed", lambda near, on: np.zeros_like(on)),
    ("points pass to any block", FaceChains, "_may_pass", lambda self, own, piece, further, present: further >= 0),
    ("points pass over any step", FaceChains, "_gap", lambda self, point, piece, place: np.zeros(len(piece))),
    (
        "points pass with another force",
        moved_supports,
        "_offset_after",
        lambda joints, moved, history, u: history.offset,
    ),
    ("`slide` = 0.001", ZonesToRest, "slide", 0.001),
    ("`slide` = 0.02", ZonesToRest, "slide", 0.02),
    ("`stiff` = 0.99", zones_to_rest, "DAMPED", replace(DAMPED, stiff=0.99)),
    ("`SLOW` = 0.1", shaking_run, "SLOW", 0.1),
)
SECOND_BENCH = '[[stage]]\nname = "lower bench"'  # and what follows it in the starter's file
FAMILY = {
    "height": (6.0, 10.0),
    "angle": (60.0, 80.0),
    "bedding_dip": (38.0, 58.0),
    "joint_dip": (100.0, 130.0),
    "bedding_spacing": (3.0, 5.0),
    "joint_spacing": (3.0, 6.0),
}  # m, degrees
STIFFNESS = {
    "bedding.normal_stiffness": 1e9,
    "bedding.shear_stiffness": 5e8,
    "J2.normal_stiffness": 1e10,
    "J2.shear_stiffness": 5e8,
}  # Pa/m: bedding sinks in so far that corners of neighbours stand out
STRENGTH = {"bedding": (15.0, 35.0), "J2": (10.0, 30.0)}  # degrees
NONE = "not_converged"  # no verdict


def beyond_joints(count: int) -> list[Member]:
    """Return blocks whose front is pushed up to .03 of their width beyond a joint of the base."""
    random, found = np.random.default_rng(SEED), []
    for number in range(count):
        width, by = random.uniform(0.6, 1.6), random.uniform(0.1, 1.0)
        joint = 0.5 + width + by - random.uniform(0, 0.03) * width
        size = float(random.uniform(0.25, 0.6))
        base, block = (0.0, joint, joint + 1.5), (0.5, 0.5 + width)
        found.append(Member(by=by, order=1 + number % 2, size=size, base=base, block=block))
    return found


def slopes(count: int) -> list[bsm.Model]:
    """Return so many starter slopes of one bench with zones, weak bedding and cross joints."""
    random, found = np.random.default_rng(SEED), list[bsm.Model]()
    with starter("slope", lambda text: text.partition(SECOND_BENCH)[0]) as file:
        for number in range(count):
            drawn = {name: float(random.uniform(*ends)) for name, ends in FAMILY.items()}
            values = {f"mesh.parameters.{name}": value for name, value in (drawn | {"seed": number + 1}).items()}
            values |= {f"joint.{name}.friction": float(random.uniform(*ends)) for name, ends in STRENGTH.items()}
            values |= {f"joint.{name}": value for name, value in STIFFNESS.items()}
            model = file.model(values | {"mesh.parameters.benches": 1, "in_situ.surface": drawn["height"]}).model
            zones = bsm.Zones(order=1, displacement="large")
            rocks = [replace(rock, young=1e9, poisson=0.25, zones=zones) for rock in model.rocks]
            found.append(model.replace(rocks=rocks))
    return found


def rigid(model: bsm.Model) -> bsm.Model:
    """Return the same slope of rigid blocks."""
    return model.replace(rocks=[replace(rock, zones=None) for rock in model.rocks])


def verdict(model: bsm.Model) -> str:
    """Return the verdict of the last stage."""
    return str(bsm.run(model).stages[-1].status)


def main() -> None:
    """Make the table, and print it or put it into a page."""
    parser = argparse.ArgumentParser(prog=COMMAND, description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--members", type=int, default=24)
    parser.add_argument("--slopes", type=int, default=8)
    add_into(parser, COMMAND)
    given = parser.parse_args()
    members, models, rows = beyond_joints(given.members), slopes(given.slopes), []
    expected = [verdict(rigid(model)) for model in models]
    for name, owner, attribute, value in RULES:
        with patch.object(owner, attribute, value):
            found = [member.run() for member in members]
            start = process_time()
            ends = [verdict(model) for model in models]
            took = process_time() - start
        off = []
        for one in found:
            if one.status == "stable":
                x, y = forces_below(one).sum(axis=0)
                off.append(abs(-x / y / np.tan(np.radians(FRICTION)) - 1))
        same = sum(one == other != NONE for one, other in zip(ends, expected, strict=True))
        numbers = len(off), f"{max(off):.1e}", same, ends.count(NONE), round(took)
        rows.append((name, *(str(number) for number in numbers)))
        print(*rows[-1], flush=True)
    header = (
        "rules",
        f"at rest beyond a joint, of {len(members)}",
        "shear off N tan(friction)",
        f"of {len(models) - expected.count(NONE)} slopes the verdict of rigid blocks",
        "not converged",
        "processor time of the slopes, s",
    )
    tell(markdown(header, rows), COMMAND, given.into)


if __name__ == "__main__":
    main()
