"""Polyhedra in two programs: time to a verdict, and LMGC90's for a second (``python -m benchmarks.lmgc90_space``).

``--python PYTHON`` is one with compas_lmgc90. Blocks, friction and density are the same; LMGC90's contacts are rigid.
It goes through steps of time and gives no verdict: the greatest displacement in a second tells rest from motion.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

import bsm_mesh as bsm
from benchmarks.pages import add_into, processor, tell
from bsm_mesh.geometries import three_d
from bsm_mesh.geometries.orientations import upward_normals
from examples.numbers.pages import markdown
from tests.scenes.rock_3d import dome

MAKER = "python -m benchmarks.lmgc90_space"
STEPS, TIME_STEP = 100, 0.01  # s
DENSITY, GRAVITY = 2500.0, 9.81
ROCK_SETS = ((20.0, 30.0), (75.0, 120.0), (80.0, 220.0))  # dip and dip direction
HEADER = ("model", "blocks", "verdict", "time", "time of LMGC90", "displaced in LMGC90", "ratio of times")
PEER = """
import json, sys, time
import numpy as np
from compas_lmgc90.solver import Solver
given, steps, step = json.load(open(sys.argv[1])), int(sys.argv[2]), float(sys.argv[3])
begun = time.process_time()
solver = Solver(dt=step, theta=0.5, density=given["density"])
solver.geometry_from_v_f([dict(vertices=v, faces=f) for v, f in given["solids"]])
for block in given["fixed"]:
    solver.v_drvdof[block] = {k: np.zeros(6) for k in range(1, 7)}
solver.contact_law("IQS_CLB", given["friction"])
solver.preprocess()
for number in range(steps):
    bodies = np.array(solver.lmgc90.compute_one_step().bodies)
    start = bodies if number == 0 else start
print("ANSWER", json.dumps([time.process_time() - begun, float(np.abs(bodies - start).max())]))
"""


def cubes(side: int) -> tuple[bsm.Polyhedra, np.ndarray]:
    """Return a pile of cubes of 1 m, and which lie at the bottom."""
    corners = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)], float)
    faces = [(0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]
    places = np.array(np.meshgrid(*3 * [np.arange(side)], indexing="ij")).reshape(3, -1).T
    blocks = bsm.Polyhedra.from_solids([(corners + place, faces) for place in places], rock="stone", joint="J1")
    return blocks, places[:, 2] == 0


def rock(count: int, side: float = 10.0) -> tuple[bsm.Polyhedra, np.ndarray]:
    """Return a cube of rock in three joint sets, and which blocks reach its bottom."""
    generator, spacing, planes = np.random.default_rng(0), side / count ** (1 / 3), []
    corners = np.array(np.meshgrid([0, side], [0, side], [0, side])).reshape(3, -1).T
    for dip, direction in ROCK_SETS:
        normal = upward_normals(np.array([dip]), np.array([direction]))[0]
        height = corners @ normal
        place = height.min() + spacing * generator.uniform(0.3, 1.0)
        while place < height.max():
            planes.append(three_d.JointPlane(name="J1", dip=dip, dip_direction=direction, point=normal * place))
            place += 1.12 * spacing * generator.uniform(0.7, 1.3)
    mass = three_d.RockMass(box=((0, 0, 0), (side,) * 3), joints=planes, rock="stone")
    blocks = bsm.Polyhedra.from_cells(three_d.cut_cells(mass))
    bottom = np.zeros(blocks.count, dtype=bool)
    bottom[blocks.boundary_blocks("bottom")] = True
    return blocks, bottom


MODELS: dict[str, tuple[Callable[[], tuple[bsm.Polyhedra, np.ndarray]], float]] = {
    "pile of cubes": (lambda: cubes(8), 35.0),
    "dome, thickness 0.06 of the radius": (lambda: dome(0.06, 16, 20), 45.0),
    "rock, friction 25": (lambda: rock(200), 25.0),
}


def solids(blocks: bsm.Polyhedra) -> Iterator[tuple[list[list[float]], list[list[int]]]]:
    """Return corners and faces of every block of one cell, counter-clockwise from outside."""
    for block in range(blocks.count):
        faces = blocks.block_faces(block)
        loops = [blocks.face_vertices[blocks.face_offsets[f] : blocks.face_offsets[f + 1]] for f in faces]
        loops = [
            loop if blocks.face_blocks[f, 0] == block else loop[::-1] for f, loop in zip(faces, loops, strict=True)
        ]
        own, number = np.unique(np.concatenate(loops), return_inverse=True)
        ends = np.cumsum([len(loop) for loop in loops])
        yield blocks.vertices[own].tolist(), [part.tolist() for part in np.split(number.reshape(-1), ends[:-1])]


def compared(name: str, python: str) -> tuple[str, ...]:
    """Return the row of a model."""
    build, friction = MODELS[name]
    blocks, fixed = build()
    law = bsm.MohrCoulomb(friction=friction)
    model = bsm.Model(
        blocks=blocks,
        rocks=[bsm.Rock("stone", unit_weight=DENSITY * GRAVITY)],
        joints=[bsm.Joint("J1", normal_stiffness=1e10, shear_stiffness=5e9, law=law)],
        default_joint="J1",
        supports=[bsm.Fixed(blocks=np.flatnonzero(fixed).tolist())],
    )
    begun = time.process_time()
    verdict = bsm.run(model, bsm.Options(threads=1)).status
    own = time.process_time() - begun
    given: dict[str, Any] = {"solids": list(solids(blocks)), "fixed": np.flatnonzero(fixed).tolist()}
    given |= {"density": DENSITY, "friction": float(np.tan(np.radians(friction)))}
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "model.json"
        path.write_text(json.dumps(given), encoding="utf-8")
        words = [python, "-c", PEER, str(path), str(STEPS), str(TIME_STEP)]
        done = subprocess.run(words, capture_output=True, text=True, cwd=folder, check=True)
    answer = next(line for line in done.stdout.splitlines() if line.startswith("ANSWER"))
    seconds, moved = json.loads(answer.removeprefix("ANSWER"))
    times = f"{own:.1f} s", f"{seconds:.0f} s", f"{moved:.1g} m", f"{seconds / own:.0f}"
    return name, str(blocks.count), str(verdict), *times


def main() -> None:
    """Print the table, or write it into a page."""
    parser = argparse.ArgumentParser(prog=MAKER, description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", help="parts of the models' names; all by default")
    parser.add_argument("--python", required=True, help="a Python with compas_lmgc90")
    add_into(parser, MAKER)
    given = parser.parse_args()
    chosen = [name for name in MODELS if not given.names or any(part in name for part in given.names)]
    rows = [compared(name, given.python) for name in chosen]
    told = f"Processor time on {processor()}. LMGC90: {STEPS} steps of {TIME_STEP:g} s."
    tell(f"{markdown(HEADER, rows)}\n\n{told}", MAKER, given.into)


if __name__ == "__main__":
    main()
