"""Separate stones as closed surfaces, in OBJ and STL files: read as convex blocks, and written."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.converters.meshes.files import refuse_unreadable
from bsm_mesh.converters.three_d.surface_files import ENDINGS, read_surface, surface_text
from bsm_mesh.errors import ModelError, raise_faults
from bsm_mesh.files import write_text
from bsm_mesh.merged_points import merge_points
from bsm_mesh.model.blocks import MERGE_TOLERANCE
from bsm_mesh.reading import as_path
from bsm_mesh.three_d.blocks.polygons import vector_areas
from bsm_mesh.three_d.blocks.polyhedra import Polyhedra

if TYPE_CHECKING:
    from scipy.spatial import ConvexHull

FLAT = 1e-6  # sine of an angle: faces that bend less are one
CONVEX = 1e-6  # of the volume: by so much the convex hull may exceed the stone
BOTTOM = "bottom"
Solid = tuple[FloatArray, list[list[int]]]


def read_stones(
    path: str | os.PathLike[str],
    *,
    rock: str,
    joint: str | None = None,
    unit_scale: float = 1.0,
    merge_tolerance: float = MERGE_TOLERANCE,
) -> Polyhedra:
    """Return the blocks of an OBJ or STL file: one convex block for each closed surface.

    The faces of a stone follow each other in the file. Its plane faces may be in parts, as in STL. The outer faces at
    the lowest level are the boundary ``bottom``.

    Parameters
    ----------
    path : path
        The file, ``.obj`` or ``.stl`` (text or binary), z up.
    rock : str
        Rock of all blocks.
    joint : str, optional
        Joint of the faces that two stones share.
    unit_scale : float [m]
        Unit of length of the file.
    merge_tolerance : float [m]
        Points nearer than this are one.

    Raises
    ------
    ModelError
        If the file is no surface, or a stone is open, flat or not convex; the message has its number.
    """
    file = as_path("stones", path)
    refuse_unreadable(file, "surface")
    points, faces = read_surface(file)
    if not faces:
        raise ModelError(f"{file}: has no faces; write the stones as triangles or polygons")
    points = points * unit_scale
    number = merge_points(points, merge_tolerance)
    _, first = np.unique(number, return_index=True)
    loops = [[int(number[corner]) for corner in face] for face in faces]
    solids, faults = [], []
    for k, stone in enumerate(_closed_surfaces(file, loops)):
        try:
            solids.append(_convex(points[first], stone))
        except ValueError as fault:
            faults.append(f"{file}: stone {k} {fault}")
    raise_faults(faults)
    blocks = Polyhedra.from_solids(solids, rock=rock, joint=joint, merge_tolerance=merge_tolerance)
    bottom = _lowest(blocks)
    return replace(blocks, boundaries={BOTTOM: bottom} if len(bottom) else {})


def write_surfaces(path: str | os.PathLike[str], blocks: Polyhedra, *, movement: FloatArray | None = None) -> Path:
    """Write the surface of every block, as an object of an OBJ file or as a solid of a text STL; return the path.

    Parameters
    ----------
    path : path
        The file, ``.obj`` or ``.stl``.
    blocks : Polyhedra
        The blocks.
    movement : (n, 6) float64, optional [m, rad]
        By which they are moved.

    Raises
    ------
    ModelError
        If the name ends otherwise.
    """
    from bsm_mesh.converters.three_d.vtu import block_grid

    target = as_path("path", path)
    if target.suffix.lower() not in ENDINGS:
        raise ModelError(f"{target}: surfaces are OBJ or STL files; give a name that ends in {' or '.join(ENDINGS)}")
    grid = block_grid(blocks, movement=movement)
    points = grid.points + (grid.point_data["displacement"] if movement is not None else 0.0)
    assert grid.faces is not None
    corners = np.split(grid.faces.connectivity, grid.faces.offsets[1:-1])
    names = [f"block_{k}" for k in range(blocks.count)]
    sides = [corners[a:b] for a, b in zip(grid.faces.cell_offsets[:-1], grid.faces.cell_offsets[1:], strict=True)]
    write_text(target, surface_text(target.suffix.lower(), points, names, sides))
    return target


def _closed_surfaces(file: Path, loops: Sequence[list[int]]) -> list[list[list[int]]]:
    """Return the faces of every stone: it ends where each of its edges has two faces."""
    stones: list[list[list[int]]] = []
    faces: list[list[int]] = []
    bare: set[tuple[int, int]] = set()
    for loop in loops:
        faces.append(loop)
        for one, other in zip(loop, [*loop[1:], loop[0]], strict=True):
            if one != other:
                bare ^= {(min(one, other), max(one, other))}
        if not bare:
            stones.append(faces)
            faces = []
    if bare:
        raise ModelError(
            f"{file}: stone {len(stones)} is open: {len(bare)} of its edges have one face; close it, and write the "
            "faces of one stone after those of the other"
        )
    return stones


def _convex(points: FloatArray, faces: list[list[int]]) -> Solid:
    """Return corners and plane faces of a convex stone.

    Raises
    ------
    ValueError
        If it has no volume or is not convex.
    """
    from scipy.spatial import ConvexHull, QhullError

    sizes = [len(face) for face in faces]
    number = np.concatenate(faces)
    own, place = np.unique(number, return_inverse=True)
    corners = points[own]
    middle = corners.mean(axis=0)
    try:
        hull = ConvexHull(corners)
    except (QhullError, ValueError):
        raise ValueError("has no volume; leave it out") from None
    loops = corners[place.reshape(-1)] - middle
    offsets = np.concatenate([[0], np.cumsum(sizes)])
    heights = np.add.reduceat(loops, offsets[:-1], axis=0) / np.array(sizes)[:, None]
    volume = abs(float((heights * vector_areas(loops, offsets)).sum())) / 3
    if abs(hull.volume - volume) > CONVEX * hull.volume:
        raise ValueError(
            f"is not convex, or its faces turn different ways: volume {volume:.4g} m3 of {hull.volume:.4g} m3 of its "
            "convex hull; cut it into convex stones"
        )
    return corners, [_outline(corners, hull, facet) for facet in _facets(hull)]


def _facets(hull: ConvexHull) -> list[IntArray]:
    """Return the triangles of every plane face of a hull."""
    count = len(hull.simplices)
    one = np.repeat(np.arange(count), 3)
    other = hull.neighbors.reshape(-1)
    bend = np.linalg.norm(np.cross(hull.equations[one, :3], hull.equations[other, :3]), axis=1)
    even = (bend < FLAT) & (np.einsum("ij,ij->i", hull.equations[one, :3], hull.equations[other, :3]) > 0)
    graph = coo_array((np.ones(int(even.sum())), (one[even], other[even])), shape=(count, count))
    parts, face = connected_components(graph, directed=False)
    return [np.flatnonzero(face == k) for k in range(parts)]


def _outline(corners: FloatArray, hull: ConvexHull, triangles: IntArray) -> list[int]:
    """Return the corners of a plane face, counter-clockwise from outside, without those on straight edges."""
    own = np.unique(hull.simplices[triangles])
    normal = hull.equations[triangles, :3].mean(axis=0)
    across = corners[own[1]] - corners[own[0]]
    frame = np.stack([across, np.cross(normal, across)]) / np.linalg.norm(across)
    flat = (corners[own] - corners[own].mean(axis=0)) @ frame.T
    order = np.argsort(np.arctan2(flat[:, 1], flat[:, 0]))
    loop, place = own[order], flat[order]
    before, after = place - np.roll(place, 1, axis=0), np.roll(place, -1, axis=0) - place
    turn = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    bends = turn > FLAT * np.linalg.norm(before, axis=1) * np.linalg.norm(after, axis=1)
    return [int(corner) for corner in loop[bends]]


def _lowest(blocks: Polyhedra) -> IntArray:
    """Return the outer faces at the lowest level."""
    height = blocks.vertices[blocks.face_vertices, 2]
    top = np.maximum.reduceat(height, blocks.face_offsets[:-1])
    level = height.min() + FLAT * float(np.ptp(blocks.vertices, axis=0).max())
    return np.flatnonzero((top <= level) & (blocks.face_blocks[:, 1] < 0)).astype(np.int32)
