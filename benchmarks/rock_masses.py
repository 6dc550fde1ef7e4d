"""Random rock masses in space: verdict, conic proof and block theory (``python -m benchmarks.rock_masses``).

Each model is a cube of 10 m cut by three random joint sets into 40 to 250 blocks. Either its south side and top are
free, or its bottom is: a slope or a roof. The proof is of the blocks that a run leaves: those taken away because they
are too small to count (`falls.ignore_below`) may fall. Every model is written as a line of JSON.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections import Counter
from collections.abc import Callable, Sequence
from operator import itemgetter
from pathlib import Path
from typing import Any

import numpy as np

import bsm_mesh as bsm
from benchmarks.pages import add_into, tell
from bsm_mesh.geometries import three_d
from bsm_mesh.geometries.orientations import upward_normals
from bsm_mesh.model.supports import bars_of
from bsm_mesh.three_d.blocks.materials import Materials
from bsm_mesh.three_d.limit.rock_mass import analyse_rock
from examples.numbers.pages import markdown
from tests.scenes.rock_3d import rotations_held

MAKER = "python -m benchmarks.rock_masses"
SIDE = 10.0  # m
FREE = {"slope": ("south", "top"), "roof": ("bottom",)}
FRICTIONS = (20.0, 30.0, 40.0)  # degrees
LEAST, MOST = 40, 250  # blocks
ROUNDS = 60  # of block theory: until nothing more is named


def rock_mass(seed: int) -> tuple[bsm.Model, tuple[str, ...], dict[str, Any]]:
    """Return a model, its free boundaries and a description: kind, friction, blocks."""
    generator = np.random.default_rng(seed)
    kind = ("slope", "roof")[seed % 2]
    friction = float(generator.choice(FRICTIONS))
    free = FREE[kind]
    while True:
        blocks = _cut(generator)
        sides = [name for name in blocks.boundaries if name not in free]
        if LEAST <= blocks.count <= MOST and len(blocks.boundary_blocks(*sides)) < blocks.count:
            break
    law = bsm.MohrCoulomb(friction=friction)
    joints = [bsm.Joint(f"J{k}", normal_stiffness=1e10, shear_stiffness=5e9, law=law) for k in range(3)]
    model = bsm.Model(
        blocks=blocks,
        rocks=[bsm.Rock("rock", unit_weight=26e3)],
        joints=joints,
        supports=[bsm.Fixed(boundary=name) for name in sides],
    )
    return model, free, {"seed": seed, "kind": kind, "friction": friction, "blocks": blocks.count}


def _cut(generator: np.random.Generator) -> bsm.Polyhedra:
    spacing = SIDE / generator.uniform(LEAST, MOST) ** (1 / 3)
    corners = np.array(np.meshgrid([0, SIDE], [0, SIDE], [0, SIDE])).reshape(3, -1).T
    planes = []
    for number, dips in enumerate(((0.0, 40.0), (55.0, 90.0), (55.0, 90.0))):
        dip, direction = float(generator.uniform(*dips)), float(generator.uniform(0, 360))
        normal = upward_normals(np.array([dip]), np.array([direction]))[0]
        heights = corners @ normal
        place = heights.min() + spacing * generator.uniform(0.3, 1.0)
        while place < heights.max():
            point = tuple(normal * place)
            planes.append(three_d.JointPlane(name=f"J{number}", dip=dip, dip_direction=direction, point=point))
            place += 1.12 * spacing * generator.uniform(0.7, 1.3)
    return bsm.Polyhedra.from_cells(three_d.cut_cells(three_d.RockMass(box=((0, 0, 0), (SIDE,) * 3), joints=planes)))


def judged(seed: int) -> dict[str, Any]:
    """Return verdict of the engine, proof by cones, blocks that move, and which of them block theory does not name."""
    model, free, told = rock_mass(seed)
    blocks = model.blocks
    begun = time.process_time()
    stage = bsm.run(model, bsm.Options(threads=1)).stages[-1]
    told |= {"verdict": str(stage.status), "reason": stage.reason, "seconds": round(time.process_time() - begun, 1)}
    materials = Materials.checked(blocks, model.rocks, model.joints, None)
    present = stage.present.copy()
    present[stage.unstable_blocks] = True
    proof = analyse_rock(blocks, materials, present, free=free)
    told |= {"admissible": proof.admissible, "lacking": float(proof.lacking), "proves": proof.witness.proves}
    named = bsm.key_blocks(model, free=free, rounds=ROUNDS)
    moved = np.setdiff1d(stage.unstable_blocks, blocks.slivers)
    told["moves"] = moved.tolist()
    told["named"] = int((named.round > 0).sum())
    told["not_named"] = not_named = np.setdiff1d(moved, named.block[named.round > 0]).tolist()
    if not_named:
        told["translating"] = translating(model, named.block[named.round > 0])
        factors = dict(zip(named.block.tolist(), named.factor.tolist(), strict=True))
        told["factors"] = [round(factors[block], 2) if block in factors else None for block in not_named]
        told["turn"] = round(float(np.linalg.norm(stage.displacement[not_named, 3:], axis=1).max()), 3)
    return told


def translating(model: bsm.Model, named: Sequence[int]) -> tuple[str, list[int]]:
    """Return the verdict of a model whose blocks do not turn, and which blocks move that are not `named`."""
    free = np.flatnonzero(~bars_of(model.supports, model.blocks).held_blocks(model.blocks))
    held = model.replace(supports=[*model.supports, rotations_held(model.blocks, free)])
    stage = bsm.run(held, bsm.Options(threads=1)).stages[-1]
    others = np.setdiff1d(stage.unstable_blocks, np.append(model.blocks.slivers, named))
    return str(stage.status), others.tolist()


def table(records: Sequence[dict[str, Any]]) -> str:
    """Return the models by proof and verdict, the exceptions, and the blocks that block theory does not name."""
    counts = Counter((r["kind"], r["admissible"], r["verdict"]) for r in records)
    rows = [
        (kind, "admissible" if admissible else "inadmissible", verdict, str(count))
        for (kind, admissible, verdict), count in sorted(counts.items(), key=str)
    ]
    against = [r["seed"] for r in records if not r["admissible"] and r["verdict"] == "stable"]
    without = [r["seed"] for r in records if r["verdict"] == "not_converged"]
    moving = [r for r in records if r["moves"]]
    others = [r for r in records if r["not_named"]]
    seeds = {"against the proof": against, "without a verdict": without}
    lines = [
        f"{len(found)} of {len(records)} {title}" + f" (seeds {found})" * bool(found) for title, found in seeds.items()
    ]
    lines.append(f"{len(moving) - len(others)} of {len(moving)} move blocks only that block theory names")
    of_others = [
        (
            str(r["seed"]),
            r["kind"],
            f"{r['friction']:g}°",
            ", ".join(map(str, r["factors"])),
            str(r["turn"]),
            r["translating"][0],
            str(len(r["translating"][1])),
        )
        for r in others
    ]
    header = ("seed", "kind", "friction", "factors by block theory", "turn [rad]", "without turning", "not named then")
    first = markdown(("kind", "limit analysis", "verdict", "models"), rows)
    moved = sum(bool(r["translating"][1]) for r in others)
    last = (
        f"With the rotation of every block held, {moved} of these {len(others)} move a block that block theory does "
        "not name."
    )
    return "\n\n".join([first, f"{'; '.join(lines)}. The others:", markdown(header, of_others), last])


def continued(file: Path, seeds: Sequence[int], judge: Callable[[int], dict[str, Any]]) -> list[dict[str, Any]]:
    """Judge the seeds that a file of lines does not hold yet, add their lines, and return all by their seeds."""
    lines = file.read_text(encoding="utf-8").splitlines() if file.exists() else []
    known = {json.loads(line)["seed"] for line in lines}
    for seed in seeds:
        if seed in known:
            continue
        try:
            told = judge(seed)
        except Exception as error:
            print(f"seed {seed}: {type(error).__name__}: {error}", file=sys.stderr, flush=True)
            continue
        with file.open("a", encoding="utf-8") as out:
            out.write(json.dumps(told) + "\n")
        print(told, file=sys.stderr, flush=True)
    return sorted(map(json.loads, file.read_text(encoding="utf-8").splitlines()), key=itemgetter("seed"))


def main() -> None:
    """Judge a share of the models, and print the table of all lines in the file."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.rock_masses", description=__doc__.splitlines()[0])
    parser.add_argument("file", type=Path, help="file of lines that is continued")
    parser.add_argument("-n", type=int, default=500, help="models in all")
    parser.add_argument("--share", default="0/1", help="K/N: every N-th model from the K-th on")
    add_into(parser, MAKER)
    given = parser.parse_args()
    first, step = (int(part) for part in given.share.split("/"))
    tell(table(continued(given.file, range(first, given.n, step), judged)), MAKER, given.into)


if __name__ == "__main__":
    main()
