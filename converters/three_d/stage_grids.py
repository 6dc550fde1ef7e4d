"""A stage of polyhedra as VTU grids: blocks, contact polygons with their forces, supports; names as in the plane.

They are for ParaView; results are read back from the arrays of the certificate, which have the contact points too.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.converters.array_units import unit_of
from bsm_mesh.converters.bolt_files import bolt_grid
from bsm_mesh.converters.contact_files import names_of_contacts, support_grid
from bsm_mesh.converters.three_d.vtu import block_grid, contact_grid
from bsm_mesh.converters.vtk_files import Grid
from bsm_mesh.movements import translations, turns
from bsm_mesh.results.movement import displacement_of
from bsm_mesh.results.records import StageResult
from bsm_mesh.results.results import Results
from bsm_mesh.results.stress import principal_stresses
from bsm_mesh.three_d.joint_polygons import joint_polygons

LENGTHS = ("displacement", "stage_displacement", "position", "slip", "opening")
UNITS = {
    **dict.fromkeys(LENGTHS, "m"),
    **dict.fromkeys(("rotation", "stage_rotation"), "rad"),
    **dict.fromkeys(("stress", "sigma_1", "sigma_3", "pressure"), "Pa"),
    **dict.fromkeys(("load", "reaction", "force", "normal_force", "shear_force"), "N"),
    **dict.fromkeys(("load_moment", "reaction_moment", "moment"), "N m"),
    "area": "m^2",
    "volume": "m^3",
}


def blocks_of_stage(results: Results, stage: StageResult) -> Grid:
    """Return the blocks that are there, a polyhedron each; ``displacement`` of their points for Warp By Vector."""
    unstable = np.zeros(results.blocks.count, dtype=np.uint8)
    unstable[stage.unstable_blocks] = 1
    sigma_1, sigma_3 = principal_stresses(stage.stress)
    cells: dict[str, Any] = {
        "displacement": translations(stage.displacement),
        "rotation": turns(stage.displacement),
        "stage_displacement": translations(stage.stage_displacement),
        "stage_rotation": turns(stage.stage_displacement),
        "stress": six_components(stage.stress),
        "sigma_1": sigma_1,
        "sigma_3": sigma_3,
        "load": translations(stage.loads),
        "load_moment": turns(stage.loads),
        "reaction": translations(stage.reactions),
        "reaction_moment": turns(stage.reactions),
        "unstable": unstable,
    }
    blocks: Any = results.blocks
    return block_grid(blocks, movement=stage.displacement, present=stage.present, cell_data=cells)


def contacts_of_stage(results: Results, stage: StageResult) -> Grid:
    """Return the contact polygons between blocks that are there, each with the force on ``block_b`` and its state."""
    blocks: Any = results.blocks
    faces = joint_polygons(results, stage)
    polygons = blocks.contact_polygons.some(faces.polygon)
    across = np.einsum("ij,ij->i", faces.force, faces.normal)
    cells: dict[str, Any] = {
        "joint": faces.joint,
        "force": faces.force,
        "normal_force": across,
        "shear_force": np.linalg.norm(faces.force - across[:, None] * faces.normal, axis=1),
        "pressure": faces.pressure,
        "slip": faces.slip,
        "opening": faces.opening,
        "utilisation": faces.utilisation,
        "status": faces.status,
        "slipping_share": faces.slipping,
        "open_share": faces.open,
    }
    block = np.repeat(polygons.block_b, np.diff(polygons.offsets))
    moved = displacement_of(results.blocks, stage.displacement, block, polygons.corners)
    grid = contact_grid(blocks, polygons=polygons, cell_data=cells)
    return replace(grid, point_data={"displacement": moved}, names=names_of_contacts(results))


def six_components(stress: FloatArray) -> FloatArray:
    """Return XX YY ZZ XY YZ XZ of tensors (n, 3, 3)."""
    pairs = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))
    return np.column_stack([stress[:, i, j] for i, j in pairs])


def bolts_of_stage(results: Results, stage: StageResult) -> Grid:
    """Return the bolts, with the units that they have in the plane."""
    grid = bolt_grid(results, stage)
    return replace(grid, units={name: unit_of("bolts", name) for name in (*grid.point_data, *grid.cell_data)})


GRIDS = {
    "blocks": blocks_of_stage,
    "contacts": contacts_of_stage,
    "supports": support_grid,
    "bolts": bolts_of_stage,
}


def space_grid(kind: str, results: Results, stage: StageResult) -> Grid:
    """Return the grid of a kind at the end of a stage, with the units of its arrays."""
    grid = GRIDS[kind](results, stage)
    units = {name: UNITS[name] for name in (*grid.point_data, *grid.cell_data) if name in UNITS}
    return replace(grid, units={name: unit for name, unit in {**units, **grid.units}.items() if unit})
