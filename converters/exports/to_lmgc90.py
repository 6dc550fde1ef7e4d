"""LMGC90 (non-smooth contact dynamics): a Python script for its bindings compas_lmgc90."""

from __future__ import annotations

from pathlib import Path

from bsm_mesh.converters.exports.prisms import write_script
from bsm_mesh.model.model import Model


def write(model: Model, path: Path) -> tuple[str, ...]:
    """Write a model; return omissions."""
    return write_script(model, path, SCRIPT)


SCRIPT = '''"""A model of bsm-mesh for LMGC90: python THIS.py [steps] [forces.csv] [movements.csv]

pip install compas_lmgc90 (0.1.11 or newer). Blocks are prisms of 1 m; z is up. Steps are of 0.01 s. Forces are on the
first block of each pair, in N, sums over its contact points; movements are those of the corners of every block,
a table of nodes that `bsm-mesh compare --with` reads.
"""

import csv
import sys
from collections import defaultdict

import numpy as np
from compas_lmgc90.solver import Solver

DATA = DATA_OF_THE_MODEL


def prism(corners):
    n = len(corners)
    vertices = [(x, 0.0, z) for x, z in corners] + [(x, 1.0, z) for x, z in corners]
    sides = [[i, (i + 1) % n, n + (i + 1) % n, n + i][::-1] for i in range(n)]
    return {"vertices": vertices, "faces": [list(range(n)), list(range(2 * n - 1, n - 1, -1)), *sides]}


def main():
    steps, forces, movements = (sys.argv[1:] + ["200", "forces.csv", "movements.csv"][len(sys.argv) - 1 :])[:3]
    solver = Solver(dt=0.01)
    solver.geometry_from_v_f([prism(corners) for corners in DATA["blocks"]], density=DATA["density"])
    for block in DATA["fixed"]:
        for component in ("Vx", "Vy", "Vz", "Rx", "Ry", "Rz"):
            solver.apply_velocity(block_index=block, component=component, value=0.0)
    for block, (x, z, moment) in DATA["loads"].items():
        for component, value in (("Fx", x), ("Fz", z), ("My", -moment)):
            if value:
                solver.apply_force(block_index=int(block), component=component, value=value)
    solver.contact_law("IQS_CLB", DATA["friction"])
    solver.preprocess()
    solver.run(nb_steps=int(steps))
    result = solver.last_result
    pairs = defaultdict(lambda: np.zeros(3))
    for (a, b), force in zip(result.interaction_bodies, result.interaction_force_global):
        pairs[a - 1, b - 1] += np.array(force)
    with open(forces, "w", newline="") as out:
        table = csv.writer(out)
        table.writerow(["block_a", "block_b", "force_x [N/m]", "force_y [N/m]"])
        table.writerows([a, b, f[0], f[2]] for (a, b), f in sorted(pairs.items()))
    with open(movements, "w", newline="") as out:
        table = csv.writer(out)
        table.writerow(["block", "x [m]", "y [m]", "displacement_x [m]", "displacement_y [m]"])
        for block, (corners, mesh) in enumerate(zip(DATA["blocks"], solver.trimeshes)):
            now = mesh.vertices_attributes("xyz")  # corners at the front come first
            table.writerows([block, x, z, p[0] - x, p[2] - z] for (x, z), p in zip(corners, now))
    solver.finalize()


if __name__ == "__main__":
    main()
'''
