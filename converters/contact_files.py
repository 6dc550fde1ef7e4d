"""Contacts, the faces that they make, supports and the water table to VTU grids, and back.

Points lie in the given geometry, and their array ``displacement`` moves them with the blocks (Warp By Vector).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.converters.vtk_files import Grid, spatial
from bsm_mesh.converters.vtk_library import LINE, VERTEX, numbered
from bsm_mesh.results.joint_faces import joint_faces
from bsm_mesh.results.joint_sets import ROCK_FACE
from bsm_mesh.results.movement import as_given, displacement_of
from bsm_mesh.results.records import ContactForces, ContactStatus, StageResult, SupportForces
from bsm_mesh.results.results import Results

STATUS_NAMES = tuple(status.name.lower() for status in ContactStatus)


def names_of_contacts(results: Results) -> dict[str, int]:
    """Return the meanings of the numbers of ``status`` and ``joint``."""
    status, joints = numbered("status", STATUS_NAMES), numbered("joint", results.joint_names)
    return {**status, **joints, f"joint:{ROCK_FACE}": -1}


def contact_grid(results: Results, stage: StageResult) -> Grid:
    """Return the contacts, a vertex a contact."""
    contacts = stage.contacts
    cells: dict[str, Any] = {
        "block_a": contacts.block_a.astype(np.int32),
        "block_b": contacts.block_b.astype(np.int32),
        "length": contacts.length,
        "normal_force": contacts.normal_force,
        "shear_force": contacts.shear_force,
        "normal_traction": contacts.normal_force / contacts.length,
        "shear_traction": contacts.shear_force / contacts.length,
        "status": contacts.status.astype(np.int8),
        "utilisation": contacts.utilisation,
        "opening": contacts.opening,
        "slip": contacts.slip,
        "joint": contacts.joint.astype(np.int32),
        "water_pressure": contacts.water_pressure,
        "force": spatial(contacts.force),
        "normal": spatial(contacts.normal),
    }
    grid = _vertices(results, stage, contacts.block_a, contacts.point, cells)
    return replace(grid, names=names_of_contacts(results))


def joint_grid(results: Results, stage: StageResult) -> Grid:
    """Return the faces between blocks, a line a face, with points of its own."""
    faces = joint_faces(results, stage)
    count = len(faces.length)
    cells: dict[str, Any] = {
        "block_a": faces.block_a.astype(np.int32),
        "block_b": faces.block_b.astype(np.int32),
        "joint": faces.joint.astype(np.int32),
        "length": faces.length,
        "slip": faces.slip,
        "opening": faces.opening,
        "pressure": faces.pressure,
        "shear_traction": faces.shear_traction,
        "utilisation": faces.utilisation,
        "status": faces.status,
        "slipping_share": faces.slipping,
        "open_share": faces.open,
        "water_pressure": faces.water_pressure,
    }
    moved = np.stack([faces.start_displacement, faces.end_displacement], axis=1).reshape(-1, 2)
    return Grid(
        points=np.stack([faces.start, faces.end], axis=1).reshape(-1, 2),
        offsets=2 * np.arange(count + 1),
        connectivity=np.arange(2 * count),
        cell_type=LINE,
        point_data={"displacement": spatial(moved)},
        cell_data=cells,
        names=names_of_contacts(results),
    )


def support_grid(results: Results, stage: StageResult) -> Grid:
    """Return the supports, a vertex a held point."""
    supports = stage.supports
    cells: dict[str, Any] = {
        "block_id": supports.block.astype(np.int32),
        "reaction": spatial(supports.reaction),
        "moment": supports.moment,
    }
    return _vertices(results, stage, supports.block, supports.point, cells)


def water_grid(results: Results, stage: StageResult) -> Grid:
    """Return the water table over the model, a line a straight piece; it does not move."""
    count = len(stage.water_table)
    return Grid(
        points=stage.water_table.reshape(-1, 2),
        offsets=2 * np.arange(count + 1),
        connectivity=np.arange(2 * count),
        cell_type=LINE,
        point_data={"displacement": np.zeros((2 * count, 3))},
        cell_data={"piece": np.arange(count, dtype=np.int32), "pressure_gradient": stage.water_gradient},
    )


def contacts_of_grid(grid: Grid) -> ContactForces:
    """Return the written contacts."""
    cells = grid.cell_data
    names = [name for name in ContactForces.__slots__ if name not in ("point", "normal")]
    return ContactForces(
        point=_where(grid.point_data), normal=cells["normal"][:, :2], **{name: cells[name] for name in names}
    )


def supports_of_grid(grid: Grid) -> SupportForces:
    """Return the written supports."""
    cells = grid.cell_data
    return SupportForces(
        block=cells["block_id"],
        point=_where(grid.point_data),
        reaction=cells["reaction"][:, :2],
        moment=cells["moment"],
    )


def _where(points: Mapping[str, Any]) -> FloatArray:
    position: FloatArray = points["position"][:, :2]
    return position


def _vertices(results: Results, stage: StageResult, block: IntArray, point: FloatArray, cells: dict[str, Any]) -> Grid:
    """Return points of blocks where they were given; `point` is where they are, or were given in the linear scheme."""
    blocks, count = results.blocks, len(point)
    moved = np.zeros_like(stage.origin) if results.has_small_displacements else stage.displacement + stage.origin
    given = as_given(blocks, moved, block, point)
    return Grid(
        points=given,
        offsets=np.arange(count + 1),
        connectivity=np.arange(count),
        cell_type=VERTEX,
        point_data={
            "displacement": spatial(displacement_of(blocks, stage.displacement, block, given)),
            "position": spatial(point),
        },
        cell_data=cells,
    )
