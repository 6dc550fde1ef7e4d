"""Polyhedral blocks as VTU: a polyhedron a block with its own points, a polygon a contact; names as in the plane."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.converters.vtk_files import Compression, Faces, Grid, write_vtu
from bsm_mesh.converters.vtk_library import POLYGON, POLYHEDRON, numbered
from bsm_mesh.errors import ModelError
from bsm_mesh.movements import carried, cross
from bsm_mesh.reading import as_path
from bsm_mesh.three_d.blocks.contact_polygons import ContactPolygons
from bsm_mesh.three_d.blocks.polyhedra import Polyhedra
from bsm_mesh.three_d.key_blocks.modes import MODES
from bsm_mesh.three_d.key_blocks.record import KeyBlocks

NOT_AT_WALL = -1  # mode of blocks without a free face


def block_grid(
    blocks: Polyhedra,
    *,
    movement: FloatArray | None = None,
    present: BoolArray | None = None,
    key_blocks: KeyBlocks | None = None,
    cell_data: Mapping[str, FloatArray] | None = None,
) -> Grid:
    """Return a polyhedron a block, each with points of its own.

    Parameters
    ----------
    blocks : Polyhedra
        The blocks, as they were given.
    movement : (n, 6) float64, optional [m, rad]
        Displacements of the centroids and rotation vectors.
    present : (n,) bool, optional
        Blocks that are written, all by default; ``block_id`` has their numbers.
    key_blocks : KeyBlocks, optional
        Mode, factor, support pressure, ... of the blocks at free faces; others have the mode -1 and no numbers.
    cell_data : mapping of str to (n, ...) array, optional
        Other arrays of the blocks.
    """
    here = np.arange(blocks.count) if present is None else np.flatnonzero(present)
    face, side = _surfaces(blocks)
    shown = np.isin(blocks.face_blocks[face, side], here)
    face, side = face[shown], side[shown]
    block = blocks.face_blocks[face, side]
    owner, corner = loops_outwards(blocks, face, side)
    many = len(blocks.vertices)
    point, connectivity = np.unique(block[owner].astype(np.int64) * many + corner, return_inverse=True)
    of_block, vertex = point // many, point % many
    data: dict[str, Any] = {"block_id": np.arange(blocks.count, dtype=np.int32), "rock": blocks.rock}
    data["volume"] = blocks.moments.volume
    names, units = numbered("rock", blocks.rock_names), {"volume": "m^3", "displacement": "m"}
    if key_blocks is not None:
        data |= _key_arrays(blocks, key_blocks)
        names |= numbered("mode", MODES)
        units |= {"weight": "N", "support_pressure": "Pa"}
    return Grid(
        points=blocks.vertices[vertex],
        offsets=np.searchsorted(of_block, [*here, blocks.count]),
        connectivity=np.arange(len(point)),
        cell_type=POLYHEDRON,
        point_data=_moved(blocks, of_block, vertex, movement),
        cell_data={name: values[here] for name, values in {**data, **(cell_data or {})}.items()},
        names=names,
        units=units,
        faces=Faces(
            cell_offsets=np.searchsorted(block, [*here, blocks.count]),
            offsets=np.searchsorted(owner, np.arange(len(face) + 1)),
            connectivity=connectivity.reshape(-1),
        ),
    )


def loops_outwards(blocks: Polyhedra, face: IntArray, side: IntArray) -> tuple[IntArray, IntArray]:
    """Return the number in `face` (k,) and the point of each corner, counter-clockwise from outside the cell `side`."""
    sizes, start = np.diff(blocks.face_offsets)[face], blocks.face_offsets[face].astype(np.int64)
    owner = np.repeat(np.arange(len(face)), sizes)
    within = np.arange(len(owner)) - np.repeat(np.cumsum(sizes) - sizes, sizes)
    place = np.where(side[owner] == 0, start[owner] + within, start[owner] + sizes[owner] - 1 - within)
    return owner, blocks.face_vertices[place]


def contact_grid(
    blocks: Polyhedra,
    cell_data: Mapping[str, FloatArray] | None = None,
    polygons: ContactPolygons | None = None,
) -> Grid:
    """Return a polygon a contact polygon, with its blocks, joint, area and the outward normal of block_b.

    Parameters
    ----------
    blocks : Polyhedra
        The blocks, as they were given.
    cell_data : mapping of str to (n, ...) array, optional
        Other arrays of the contact polygons.
    polygons : ContactPolygons, optional
        Some of them; all by default.
    """
    polygons = blocks.contact_polygons if polygons is None else polygons
    data = {
        "block_a": polygons.block_a,
        "block_b": polygons.block_b,
        "joint": polygons.joint,
        "area": polygons.area,
        "normal": polygons.normal,
    }
    return Grid(
        points=polygons.corners,
        offsets=polygons.offsets,
        connectivity=np.arange(len(polygons.corners)),
        cell_type=POLYGON,
        cell_data={**data, **(cell_data or {})},
        names=numbered("joint", blocks.joint_names),
        units={"area": "m^2"},
    )


def write_blocks(
    path: str | os.PathLike[str],
    blocks: Polyhedra,
    *,
    key_blocks: KeyBlocks | None = None,
    compression: Compression = "zlib",
) -> Path:
    """Write blocks as VTU, with the arrays of key blocks where they are given; return the path.

    Raises
    ------
    ModelError
        If the name does not end in .vtu.
    """
    target = _target(path)
    write_vtu(target, block_grid(blocks, key_blocks=key_blocks), compression=compression)
    return target


def write_contacts(path: str | os.PathLike[str], blocks: Polyhedra, *, compression: Compression = "zlib") -> Path:
    """Write the contact polygons as VTU; return the path.

    Raises
    ------
    ModelError
        If the name does not end in .vtu.
    """
    target = _target(path)
    write_vtu(target, contact_grid(blocks), compression=compression)
    return target


def write_mechanism(blocks: Polyhedra, velocity: FloatArray, present: BoolArray, path: Path) -> None:
    """Write a collapse mechanism (n, 6) of blocks that are there (n,): the point array ``velocity``.

    Raises
    ------
    ModelError
        If the file cannot be written.
    """
    data = {"centroid_velocity": velocity[:, :3], "turn": velocity[:, 3:]}
    grid = block_grid(blocks, present=present, cell_data=data)
    at = blocks.moments.centroid[grid.cell_data["block_id"]]
    sizes = np.diff(grid.offsets)
    moved = np.repeat(velocity[present], sizes, axis=0)
    arm = grid.points - np.repeat(at, sizes, axis=0)
    points = {"velocity": moved[:, :3] + cross(moved[:, 3:], arm)}
    write_vtu(path, replace(grid, point_data=points))


def _target(path: str | os.PathLike[str]) -> Path:
    target = as_path("path", path)
    if target.suffix != ".vtu":
        raise ModelError(f"{target}: a grid is a VTU file; give a name that ends in .vtu")
    return target


def _surfaces(blocks: Polyhedra) -> tuple[IntArray, IntArray]:
    """Return the faces of the surfaces of all blocks and on which side of each its block lies, block after block."""
    first, second = blocks.face_blocks.T
    different = first != second
    face = np.concatenate([np.flatnonzero(different), np.flatnonzero(different & (second >= 0))])
    side = np.repeat([0, 1], [int(different.sum()), int((different & (second >= 0)).sum())])
    order = np.argsort(blocks.face_blocks[face, side], kind="stable")
    return face[order], side[order]


def _moved(blocks: Polyhedra, block: IntArray, vertex: IntArray, movement: FloatArray | None) -> dict[str, FloatArray]:
    """Return the displacements of points of blocks, exact for large rotations; nothing where blocks did not move."""
    if movement is None:
        return {}
    return {"displacement": carried(blocks.vertices[vertex] - blocks.moments.centroid[block], movement[block])}


def _key_arrays(blocks: Polyhedra, found: KeyBlocks) -> dict[str, Any]:
    """Return the numbers of key blocks as arrays of all blocks, NaN where there are none."""
    mode, unstable = np.full(blocks.count, NOT_AT_WALL, np.int32), np.zeros(blocks.count, np.uint8)
    mode[found.block] = found.mode
    unstable[found.block[found.unstable]] = 1
    arrays: dict[str, Any] = {"mode": mode, "unstable": unstable}
    for name, values in (
        ("factor", found.factor),
        ("weight", found.weight),
        ("support_pressure", found.support),
        ("direction", found.direction),
    ):
        whole = np.full((blocks.count, *values.shape[1:]), np.nan)
        whole[found.block] = values
        arrays[name] = whole
    return arrays
