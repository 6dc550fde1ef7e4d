"""Bolts to VTU lines, and back."""

from __future__ import annotations

from typing import Any

import numpy as np

from bsm_mesh.converters.vtk_files import Grid, spatial
from bsm_mesh.converters.vtk_library import LINE, numbered
from bsm_mesh.results.bolts import BoltForces, BoltLimit, BoltStatus
from bsm_mesh.results.records import StageResult
from bsm_mesh.results.results import Results


def bolt_grid(results: Results, stage: StageResult) -> Grid:
    """Return the bolts, a line an element at the original position.

    The cell array ``bond_force`` is the greater of the bond forces at an element's two nodes; the point array has all.
    """
    bolts = stage.bolts
    first = bolts.first_node
    two = np.stack([bolts.bond_force[first], bolts.bond_force[first + 1]])
    bond = two[np.abs(two).argmax(axis=0), np.arange(len(first))]
    bolt_of_node = np.repeat(np.arange(bolts.count, dtype=np.int32), np.diff(bolts.node_start))
    cells: dict[str, Any] = {
        "bolt": bolts.bolt,
        "axial_force": bolts.axial_force,
        "bond_force": bond,
        "utilisation": bolts.utilisation,
        "limit": bolts.limit.astype(np.int8),
        "plastic_stretch": bolts.plastic_stretch,
        "shear_force": bolts.shear_force,
        "shear_point": spatial(bolts.shear_point),
        "shear_direction": spatial(bolts.shear_direction),
        "alive": bolts.alive.astype(np.uint8),
        "status": bolts.status[bolts.bolt].astype(np.int8),
    }
    points: dict[str, Any] = {
        "displacement": spatial(bolts.displacement),
        "position": spatial(bolts.point),
        "bolt": bolt_of_node,
        "block_id": bolts.block.astype(np.int32),
        "station": bolts.station,
        "bond_force": bolts.bond_force,
        "slip": bolts.slip,
        "spacing": bolts.spacing[bolt_of_node],
        "status": bolts.status[bolt_of_node].astype(np.int8),
    }
    return Grid(
        points=bolts.original,
        offsets=2 * np.arange(len(first) + 1),
        connectivity=np.stack([first, first + 1], axis=1).reshape(-1),
        cell_type=LINE,
        point_data=points,
        cell_data=cells,
        names={
            **numbered("bolt", bolts.names),
            **numbered("status", [status.name.lower() for status in BoltStatus]),
            **numbered("limit", [limit.name.lower() for limit in BoltLimit]),
        },
    )


def bolts_of_grid(grid: Grid) -> BoltForces:
    """Return the written bolts, whose points have as many coordinates as those of the grid."""
    nodes, cells, coordinates = grid.point_data, grid.cell_data, grid.points.shape[1]
    names = grid.names_of("bolt")
    node_start = np.searchsorted(nodes["bolt"], np.arange(len(names) + 1)).astype(np.int32)
    return BoltForces(
        names=names,
        node_start=node_start,
        block=nodes["block_id"],
        station=nodes["station"],
        original=grid.points,
        point=nodes["position"][:, :coordinates],
        displacement=nodes["displacement"][:, :coordinates],
        spacing=nodes["spacing"][node_start[:-1]],
        status=nodes["status"][node_start[:-1]],
        alive=cells["alive"].astype(bool),
        axial_force=cells["axial_force"],
        bond_force=nodes["bond_force"],
        slip=nodes["slip"],
        plastic_stretch=cells["plastic_stretch"],
        utilisation=cells["utilisation"],
        limit=cells.get("limit", np.zeros(len(cells["utilisation"]), np.int8)),
        shear_force=cells["shear_force"],
        shear_point=cells["shear_point"][:, :coordinates],
        shear_direction=cells["shear_direction"][:, :coordinates],
    )
