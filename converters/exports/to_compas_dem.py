"""compas_dem (Block Research Group): a Python script that builds the model, solves it and writes the forces as CSV."""

from __future__ import annotations

from pathlib import Path

from bsm_mesh.converters.exports.prisms import write_script
from bsm_mesh.model.model import Model


def write(model: Model, path: Path) -> tuple[str, ...]:
    """Write a model; return omissions."""
    return write_script(model, path, SCRIPT, loads=False)


SCRIPT = '''"""A model of bsm-mesh for compas_dem 0.6 or newer: python THIS.py [RBE | CRA] forces.csv

pip install compas_dem compas_cra. Blocks are prisms of 1 m; z is up. Forces are on the first block of each pair, in N.
"""

import csv
import sys

from compas.datastructures import Mesh
from compas_dem.elements import Block
from compas_dem.material import GenericMaterial
from compas_dem.models import BlockModel
from compas_dem.problem import Problem, Solver

DATA = DATA_OF_THE_MODEL


def prism(corners):
    n = len(corners)
    points = [(x, 0.0, z) for x, z in corners] + [(x, 1.0, z) for x, z in corners]
    sides = [[i, (i + 1) % n, n + (i + 1) % n, n + i][::-1] for i in range(n)]
    return Mesh.from_vertices_and_faces(points, [list(range(n)), list(range(2 * n - 1, n - 1, -1)), *sides])


def build():
    """Return the model and the problem; block k of bsm-mesh is node k."""
    model = BlockModel()
    materials = {}
    for corners, density in zip(DATA["blocks"], DATA["density"]):
        block = Block.from_mesh(prism(corners))
        model.add_element(block)
        if density not in materials:
            materials[density] = GenericMaterial(density=density, name=f"rock of {density:.1f} kg/m3")
            model.add_material(materials[density])
        model.assign_material(materials[density], elements=[block])
    for block in DATA["fixed"]:
        list(model.elements())[block].is_support = True
    model.compute_contacts()
    problem = Problem(model)
    problem.set_contact_model("MohrCoulomb", mu=DATA["friction"])
    if DATA["loads"]:
        loads = problem.add_boundary_condition("loads")
        for block, (x, z, moment) in DATA["loads"].items():
            loads.add_point_load(int(block), [x, 0.0, z], moment=[0.0, -moment, 0.0])
    return model, problem


def main():
    method, file = (sys.argv[1:] + ["RBE", "forces.csv"][len(sys.argv) - 1 :])[:2]
    model, problem = build()
    problem.set_solver(getattr(Solver, method)())
    results = problem.solve()
    with open(file, "w", newline="") as out:
        table = csv.writer(out)
        table.writerow(["block_a", "block_b", "force_x [N/m]", "force_y [N/m]"])
        for edge in model.graph.edges():
            force = results.resultant_global(edge)
            if force is not None:
                table.writerow([*edge, -force[0], -force[2]])  # compas_dem gives that on the second


if __name__ == "__main__":
    main()
'''
