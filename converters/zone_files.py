"""Zones to VTU triangles, and back."""

from __future__ import annotations

import numpy as np

from bsm_mesh.converters.stress_components import six_components, tensors
from bsm_mesh.converters.vtk_files import Grid, spatial
from bsm_mesh.converters.vtk_library import QUADRATIC_TRIANGLE, TRIANGLE, numbered
from bsm_mesh.results.records import StageResult
from bsm_mesh.results.results import Results
from bsm_mesh.results.stress import principal_stresses
from bsm_mesh.results.zones import ZoneResult


def zone_grid(results: Results, stage: StageResult) -> Grid:
    """Return the zones, a triangle each at its original position, with displacements of nodes and mean stresses."""
    zones = stage.zones
    assert zones is not None
    corners = zones.cells.shape[1]
    sigma_1, sigma_3 = principal_stresses(zones.stress)
    return Grid(
        points=zones.points,
        offsets=corners * np.arange(len(zones.cells) + 1),
        connectivity=zones.cells.reshape(-1),
        cell_type=TRIANGLE if corners == 3 else QUADRATIC_TRIANGLE,
        point_data={"displacement": spatial(zones.displacement)},
        cell_data={
            "block_id": zones.block.astype(np.int32),
            "rock": results.blocks.rock[zones.block].astype(np.int32),
            "stress": six_components(zones.stress),
            "sigma_1": sigma_1,
            "sigma_3": sigma_3,
            "yielded": zones.yielded,
            "plastic_strain": zones.plastic_strain,
        },
        names=numbered("rock", results.blocks.rock_names),
    )


def zones_of_grid(grid: Grid) -> ZoneResult:
    """Return the written zones."""
    return ZoneResult(
        points=grid.points,
        displacement=grid.point_data["displacement"][:, :2].copy(),
        cells=grid.connectivity.reshape(-1, int(np.diff(grid.offsets[:2])[0])).astype(np.int32),
        block=grid.cell_data["block_id"].astype(np.int32),
        stress=tensors(grid.cell_data["stress"]),
        yielded=grid.cell_data["yielded"].copy(),
        plastic_strain=grid.cell_data["plastic_strain"].copy(),
    )
