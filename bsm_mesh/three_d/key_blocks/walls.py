"""Blocks at a free face, and the planes that bound them, in rows of equal length."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.model.polygons import owner_of_corner
from bsm_mesh.three_d.blocks.polygons import polygon_moments, spread, sums
from bsm_mesh.three_d.blocks.polyhedra import Polyhedra
from bsm_mesh.three_d.key_blocks.modes import PARALLEL

MIN_AREA = 1e-6  # of the contact area of a block: smaller contact faces are edges that break


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Wall:
    """Blocks at free faces.

    Attributes
    ----------
    block : (n,) int32
        The blocks.
    held : (n,) bool
        Whether a block reaches the surface of the body elsewhere, where what lies beyond is unknown.
    face : (k,) int32
        All free faces.
    area : (n,) float64 [m2]
        Of the free faces.
    outward : (n, 3) float64 [m2]
        Sum of the free faces' areas times their normals, out of the block.
    trace : (n,) float64 [m]
        Greatest distance between corners of the free faces.
    apex : (n,) float64 [m]
        Greatest depth of the block behind the centroid of its free faces, across them.
    """

    block: IntArray
    held: BoolArray
    face: IntArray
    area: FloatArray
    outward: FloatArray
    trace: FloatArray
    apex: FloatArray


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Planes:
    """Contact faces of blocks and the planes in which they lie.

    Attributes
    ----------
    row : (k,) int64
        Row of each contact face's block.
    polygon : (k,) int64
        Its contact polygon.
    normal : (k, 3) float64
        Its unit normal, into the block.
    plane : (k,) int64
        Its plane among those of the block.
    normals : (n, p, 3) float64
        Unit normals of the planes of every block; zeros where there are fewer.
    area : (n, p) float64 [m2]
        Areas of the planes.
    """

    row: IntArray
    polygon: IntArray
    normal: FloatArray
    plane: IntArray
    normals: FloatArray
    area: FloatArray


def wall_of(blocks: Polyhedra, free: Sequence[str], present: BoolArray) -> Wall:
    """Return the blocks that are `present` with a face on one of the `free` boundaries, or where a block is gone."""
    pairs = blocks.face_blocks
    there = np.where(pairs >= 0, present[pairs], False)
    is_free = np.zeros(len(pairs), dtype=bool)
    for name in free:
        is_free[blocks.boundary_faces(name)] = True
    opened = (pairs >= 0).all(axis=1) & (there.sum(axis=1) == 1)
    face = np.flatnonzero((is_free & there[:, 0]) | opened)
    owner = np.where(there[face, 0], pairs[face, 0], pairs[face, 1])
    sense = np.where(there[face, 0], 1.0, -1.0)
    block, row = np.unique(owner, return_inverse=True)
    closed = (pairs[:, 1] < 0) & ~is_free
    sizes = np.diff(blocks.face_offsets)[face]
    corners = blocks.vertices[blocks.face_vertices[spread(blocks.face_offsets[face], sizes)]]
    moments = polygon_moments(corners, np.concatenate([[0], np.cumsum(sizes)]).astype(np.int32))
    count, row = len(block), row.reshape(-1)
    area = sums(row, moments.area, count)
    outward = sums(row, (moments.area * sense)[:, None] * moments.normal, count)
    centre = sums(row, moments.area[:, None] * moments.centroid, count) / area[:, None]
    return Wall(
        block=block.astype(np.int32),
        held=np.isin(block, pairs[closed, 0]),
        face=face.astype(np.int32),
        area=area,
        outward=outward,
        trace=_spans(corners, np.repeat(row, sizes), count),
        apex=_depths(blocks, block, centre, outward),
    )


def planes_of(blocks: Polyhedra, wall: Wall, present: BoolArray) -> Planes:
    """Return the planes in which blocks at a wall touch others that are present, the largest first."""
    polygons = blocks.contact_polygons
    both = present[polygons.block_a] & present[polygons.block_b]
    row = np.full(blocks.count, -1)
    row[wall.block] = np.arange(len(wall.block))
    of, number, sign = [], [], []
    for side, into in ((polygons.block_a, 1.0), (polygons.block_b, -1.0)):  # normals point into block_a
        chosen = np.flatnonzero(both & (row[side] >= 0))
        of.append(row[side[chosen]])
        number.append(chosen)
        sign.append(np.full(len(chosen), into))
    rows, polygon, sense = np.concatenate(of), np.concatenate(number), np.concatenate(sign)
    area = polygons.area[polygon]
    large = area > MIN_AREA * sums(rows, area, len(wall.block))[rows]
    rows, polygon, sense, area = rows[large], polygon[large], sense[large], area[large]
    order = np.lexsort((-area, rows))
    rows, polygon, area = rows[order], polygon[order], area[order]
    normal = polygons.normal[polygon] * sense[order, None]
    plane, first = _merged(rows, normal, len(wall.block))
    most = max(int(plane.max(initial=-1)) + 1, 2)  # two planes make a line
    normals, areas = np.zeros((len(wall.block), most, 3)), np.zeros((len(wall.block), most))
    normals[rows[first], plane[first]] = normal[first]
    np.add.at(areas, (rows, plane), area)
    return Planes(row=rows, polygon=polygon, normal=normal, plane=plane, normals=normals, area=areas)


def _merged(rows: IntArray, normal: FloatArray, count: int) -> tuple[IntArray, IntArray]:
    """Return the number of every face's plane among those of its block, and the first face of every plane."""
    sizes = np.bincount(rows, minlength=count)
    start, most = np.cumsum(sizes) - sizes, int(sizes.max(initial=0))
    place = np.arange(len(rows)) - start[rows]
    leader = np.arange(len(rows))
    for k in range(most):  # the k-th face of every block takes those after it that are parallel
        lead = start[rows] + k
        later = (place > k) & (leader == np.arange(len(rows)))
        lead = np.where(later, lead, 0)
        leads = leader[lead] == lead
        near = np.abs(normal - normal[lead]).max(axis=1) < PARALLEL
        leader = np.where(later & leads & near, lead, leader)
    first = np.flatnonzero(leader == np.arange(len(rows)))
    number = np.zeros(len(rows), np.int64)
    number[first] = np.arange(len(first))
    of_row = np.bincount(rows[first], minlength=count)
    plane = number[leader] - (np.cumsum(of_row) - of_row)[rows]
    return plane, first


def _spans(corners: FloatArray, row: IntArray, count: int) -> FloatArray:
    """Return the greatest distance between corners of the same row, (count,) [m]."""
    order = np.argsort(row, kind="stable")
    corners, sizes = corners[order], np.bincount(row, minlength=count)
    start, span = np.cumsum(sizes) - sizes, np.zeros(count)
    for k in range(int(sizes.max(initial=0))):  # the k-th corner of every row with all others of it
        other = corners[np.minimum(start + k, len(corners) - 1)][row[order]]
        distance = np.where(sizes[row[order]] > k, np.linalg.norm(corners - other, axis=1), 0.0)
        np.maximum.at(span, row[order], distance)
    return span


def _depths(blocks: Polyhedra, block: IntArray, centre: FloatArray, outward: FloatArray) -> FloatArray:
    """Return how deep blocks reach behind points, against directions, (n,) [m]."""
    row = np.full(blocks.count, -1)
    row[block] = np.arange(len(block))
    corner_face = owner_of_corner(blocks.face_offsets)
    depth = np.zeros(len(block))
    unit = outward / np.maximum(np.linalg.norm(outward, axis=1), 1e-300)[:, None]
    for side in (0, 1):
        of = np.where(blocks.face_blocks[:, side] >= 0, row[blocks.face_blocks[:, side]], -1)[corner_face]
        chosen = np.flatnonzero(of >= 0)
        arm = centre[of[chosen]] - blocks.vertices[blocks.face_vertices[chosen]]
        np.maximum.at(depth, of[chosen], np.einsum("ij,ij->i", arm, unit[of[chosen]]))
    return depth
