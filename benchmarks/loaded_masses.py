"""Random rock masses in space under random loads: verdict, conic proof and block theory.

``python -m benchmarks.loaded_masses FILE``. The masses are those of `benchmarks.rock_masses`. Each has some of these at
random: cohesion, an earthquake, a plane of groundwater or a pressure in a joint, bolts, a pressure on a free boundary.
"""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

import bsm_mesh as bsm
from benchmarks.pages import add_into, tell
from benchmarks.rock_masses import ROUNDS, SIDE, continued, rock_mass, translating
from bsm_mesh.arrays import IntArray
from examples.numbers.pages import markdown

MAKER = "python -m benchmarks.loaded_masses"
PROOF = {True: "admissible", False: "inadmissible"}
GLUE = 10  # tensile strength over cohesion, with which joints do not open
OFTEN = 0.5  # share of the masses that have a kind of load


def loaded_mass(seed: int) -> tuple[bsm.Model, tuple[str, ...], dict[str, Any]]:
    """Return a model, its free boundaries and a description: kind, friction, blocks, loads."""
    model, free, told = rock_mass(seed)
    generator = np.random.default_rng([seed, 1])
    makers = {"cohesion": _cohesion, "earthquake": _earthquake, "water": _water, "bolts": _bolts, "pressure": _pressure}
    chosen = [name for name in makers if generator.random() < OFTEN]
    changes: dict[str, Any] = {}
    for name in chosen:
        changes |= makers[name](generator, model, free)
    return model.replace(**changes), free, {**told, "loads": chosen}


def _cohesion(generator: np.random.Generator, model: bsm.Model, _: tuple[str, ...]) -> dict[str, Any]:
    cohesion = float(generator.choice([5e3, 20e3, 50e3]))
    return {"joints": [replace(joint, law=replace(joint.law, cohesion=cohesion)) for joint in model.joints]}


def _earthquake(generator: np.random.Generator, _: bsm.Model, __: tuple[str, ...]) -> dict[str, Any]:
    part, trend = float(generator.uniform(0.05, 0.35)), float(generator.uniform(0, 360))
    return {"gravity_horizontal": part, "gravity_trend": trend}


def _water(generator: np.random.Generator, model: bsm.Model, _: tuple[str, ...]) -> dict[str, Any]:
    if generator.random() < OFTEN:
        level, dip, direction = (float(generator.uniform(*ends)) for ends in ((2, 9), (0, 25), (0, 360)))
        plane = bsm.HeadPlane(point=(SIDE / 2, SIDE / 2, level), dip=dip, dip_direction=direction)
        return {"water": bsm.Water(plane=plane)}
    joint = model.joints[int(generator.integers(len(model.joints)))].name
    return {"water": bsm.Water(joint_pressure={joint: float(generator.choice([5e3, 20e3, 50e3]))})}


def _bolts(generator: np.random.Generator, _: bsm.Model, free: tuple[str, ...]) -> dict[str, Any]:
    bolts = []
    for _number in range(int(generator.integers(1, 5))):
        across, along = (float(place) for place in generator.uniform(1, SIDE - 1, 2))
        deep = float(generator.uniform(3, 8))
        if "bottom" in free:
            start, end = (across, along, 0.01), (across, along, deep)
        else:
            start, end = (across, 0.01, along), (across, deep, max(0.5, along - float(generator.uniform(0, 2))))
        kind = str(generator.choice(["grouted", "end_anchored"]))
        pulled = 1e5 if kind == "end_anchored" else 0.0
        bolts.append(
            bsm.Bolt(start=start, end=end, diameter=0.025, kind=kind, yield_strength=500e6, pretension=pulled)  # type: ignore[arg-type]
        )
    return {"bolts": bolts}


def _pressure(generator: np.random.Generator, _: bsm.Model, free: tuple[str, ...]) -> dict[str, Any]:
    pressure = float(generator.choice([20e3, 100e3, -30e3]))
    return {"loads": [bsm.Pressure(boundary=free[int(generator.integers(len(free)))], pressure=pressure)]}


def judged(seed: int) -> dict[str, Any]:
    """Return verdict of the engine, of cones for the blocks that it leaves, and the blocks that block theory misses."""
    model, free, told = loaded_mass(seed)
    results = bsm.run(model, bsm.Options(threads=1))
    stage = results.stages[-1]
    told |= {"verdict": str(stage.status), "certified": bool(results.check().ok)}
    gone = np.setdiff1d(np.flatnonzero(~stage.present), stage.unstable_blocks)
    left = bsm.Stage("left", excavate=[int(block) for block in gone])
    told["admissible"] = bool(bsm.limit_analysis(model.replace(stages=[left]), stage="left").admissible)
    named = bsm.key_blocks(model, free=free, rounds=ROUNDS)
    moved = np.setdiff1d(stage.unstable_blocks, model.blocks.slivers)
    told["moves"] = moved.tolist()
    known = named.block[named.round > 0]
    told["not_named"] = np.setdiff1d(moved, known).tolist()
    if told["not_named"]:
        told["translating"] = translating(model, known)
        told["glued"] = _glued(model, known)
        told["united"] = _united(model, free, moved)
    return told


def _glued(model: bsm.Model, known: Sequence[int]) -> list[int]:
    """Return which blocks move that are not `known`, with a tensile strength of joints of many times their cohesion."""
    joints = [replace(joint, tensile_strength=GLUE * joint.law.cohesion) for joint in model.joints]
    stage = bsm.run(model.replace(joints=joints), bsm.Options(threads=1)).stages[-1]
    return np.setdiff1d(stage.unstable_blocks, np.append(model.blocks.slivers, known)).tolist()


def _united(model: bsm.Model, free: tuple[str, ...], moved: IntArray) -> list[int]:
    """Return which of the blocks that move block theory names as one with those of them that they touch."""
    blocks, found = model.blocks, []
    polygons = blocks.contact_polygons
    for block in moved:
        pairs = np.stack([polygons.block_a, polygons.block_b], axis=1)[polygons.of(block)]
        number = np.arange(blocks.count)
        number[np.intersect1d(moved, pairs)] = block
        left, cells = np.unique(number, return_inverse=True)
        one = replace(blocks, cell_block=cells[blocks.cell_block].astype(np.int32), rock=blocks.rock[left])
        named = bsm.key_blocks(model.replace(blocks=one), free=free)
        if cells[block] in named.block[named.round > 0]:
            found.append(int(block))
    return found


def table(records: Sequence[dict[str, Any]]) -> str:
    """Return the models by proof and verdict, and the exceptions."""
    counts = Counter((r["kind"], PROOF[r["admissible"]], r["verdict"]) for r in records)
    rows = [(*case, str(count)) for case, count in sorted(counts.items())]
    moving = [r for r in records if r["moves"]]
    exceptions = {
        "`stable` against the proof": [r["seed"] for r in records if not r["admissible"] and r["verdict"] == "stable"],
        "without a verdict": [r["seed"] for r in records if r["verdict"] == "not_converged"],
        "`stable` without a certificate": [
            r["seed"] for r in records if r["verdict"] == "stable" and not r["certified"]
        ],
    }
    lines = [
        f"{len(seeds)} of {len(records)} {what}" + f" (seeds {seeds})" * bool(seeds)
        for what, seeds in exceptions.items()
    ]
    others = [r for r in moving if r["not_named"]]
    lines.append(f"{len(moving) - len(others)} of {len(moving)} move blocks only that block theory names")
    if others:
        turning = [not r["translating"][1] for r in others]
        glued = [not r["glued"] for r in others]
        proved = [not r["admissible"] for r in others]
        united = [bool(r["united"]) for r in others]
        whys = [any(why) for why in zip(turning, glued, proved, united, strict=True)]
        lines.append(f"{sum(turning)} of the other {len(others)} do so with the rotation of every block held")
        lines.append(f"{sum(glued)} with a tensile strength of joints of {GLUE} times their cohesion")
        lines.append(f"limit analysis proves that {sum(proved)} must move")
        lines.append(f"in {sum(united)} block theory names a block as one with the moving blocks that it touches")
        left = [r["seed"] for r, why in zip(others, whys, strict=True) if not why]
        lines[-1] += f"; none of this explains {len(left)} (seeds {left})"
    loads = Counter(name for r in records for name in r["loads"])
    given = ", ".join(f"{name} {count}" for name, count in loads.items())
    head = markdown(("kind", "limit analysis", "verdict", "models"), rows)
    return f"{head}\n\n{'; '.join(lines)}. Models that have a load: {given}."


def main() -> None:
    """Judge the models, and print the table of all lines in the file."""
    parser = argparse.ArgumentParser(prog=MAKER, description=__doc__.splitlines()[0])
    parser.add_argument("file", type=Path, help="file of lines that is continued")
    parser.add_argument("-n", type=int, default=150, help="models in all")
    add_into(parser, MAKER)
    given = parser.parse_args()
    tell(table(continued(given.file, range(given.n), judged)), MAKER, given.into)


if __name__ == "__main__":
    main()
