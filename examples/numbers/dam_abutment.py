"""A wedge in a dam's abutment: factors by limit equilibrium, strength reduction and limit analysis."""

from __future__ import annotations

import tomllib
from pathlib import Path

import numpy as np

import bsm_mesh as bsm
from bsm_mesh.arrays import FloatArray
from bsm_mesh.geometries.orientations import upward_normals
from docs.code_blocks import ROOT
from examples.numbers.pages import Table, markdown

FOLDER = Path("examples/dam_abutment")
UPLIFT = {0.0: "", 50e3: "model.toml", 100e3: "", 150e3: "", 200e3: "undrained.toml"}  # Pa
WEDGE = 0


def limit_equilibrium(normals: FloatArray, friction: FloatArray, force: FloatArray) -> tuple[float, str]:
    """Return the factor of a wedge on two planes under a force [N], and how it slides (Londe 1973).

    Normals (2, 3) point into the wedge. Shear forces are along the line of both planes. Where one plane would have to
    pull, the wedge slides on the other alone.
    """
    slope = np.tan(np.radians(friction))
    line = np.cross(*normals)
    line *= np.sign(line @ force) / np.linalg.norm(line)
    first, second, _ = np.linalg.solve(np.column_stack([*normals, line]), -force)
    if min(first, second) >= 0:
        return float((first * slope[0] + second * slope[1]) / (line @ force)), "on both joints"
    stays = int(first < second)
    pressed = -force @ normals[stays]
    along = force + pressed * normals[stays]
    return float(pressed * slope[stays] / np.linalg.norm(along)), f"on the {('foliation', 'shear zone')[stays]}"


def wedge() -> str:
    """Return volume and weight of the wedge."""
    model = bsm.load(ROOT / FOLDER / "model.toml")
    volume, gamma = model.blocks.moments.volume[WEDGE], model.rocks[0].unit_weight
    return f"The wedge has {volume:.0f} m³ and weighs {volume * gamma / 1e6:.0f} MN."


def factors() -> str:
    """Return the table of factors over the water pressure in the foliation."""
    table = tomllib.loads((ROOT / FOLDER / "model.toml").read_text(encoding="utf-8"))
    planes = table["joint_plane"]
    normals = upward_normals(np.array([p["dip"] for p in planes]), np.array([p["dip_direction"] for p in planes]))
    friction = np.array([table["joint"][plane["name"]]["friction"] for plane in planes])
    model = bsm.load(ROOT / FOLDER / "model.toml")
    stage, gamma = model.stages[0], model.rocks[0].unit_weight
    faces = model.blocks.contact_polygons
    touches = (faces.block_a == WEDGE) | (faces.block_b == WEDGE)
    area = faces.area[touches & (faces.joint == model.blocks.joint_names.index("foliation"))].sum()
    force = np.array([*stage.loads[0].force[:2], -gamma * model.blocks.moments.volume[WEDGE]])
    rows = []
    for pressure, file in UPLIFT.items():
        exact, how = limit_equilibrium(normals, friction, force + pressure * area * normals[0])
        water = bsm.Water(joint_pressure={"foliation": pressure}) if pressure else None
        found = bsm.factor_of_safety(model.replace(stages=[bsm.Stage(name=stage.name, loads=stage.loads, water=water)]))
        bound = f"{found.limit.factor:.3f}"
        rows.append((file, f"{pressure / 1e3:g} kPa", f"{exact:.3f}", how, f"{found.stable:.3f}", bound))
    header = ("file", "uplift", "limit equilibrium", "slides", "strength reduction", "bound by limit analysis")
    return markdown(header, rows)


README = f"{FOLDER}/README.md"
TABLES = (
    Table(name="dam-abutment-wedge", page=README, make=wedge),
    Table(name="dam-abutment", page=README, make=factors, tolerance=0.005, is_slow=True),
)
