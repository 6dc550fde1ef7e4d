"""The surfaces of blocks as given: plane parts of several faces, and edges at which a surface turns inwards."""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.model.polygons import next_corner, owner_of_corner
from bsm_mesh.three_d.blocks.polygons import sums, vector_areas
from bsm_mesh.three_d.blocks.polyhedra import Polyhedra

FLAT = 1e-6  # of both areas: faces whose normals have a smaller product lie in one plane


def flat_areas(blocks: Polyhedra) -> FloatArray:
    """Return the area of the plane part of both blocks' surfaces in which every face lies, (n_faces, 2) [m2].

    It is 0 where a face has no block on that side, and for faces between cells of one block.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    (one, other), _ = _neighbours(blocks)
    outward = _outward(blocks)
    flat = _in_one_plane(outward, one, other)
    count = len(outward)
    graph = coo_array((np.ones(flat.sum()), (one[flat], other[flat])), shape=(count, count))
    _, plane = connected_components(graph, directed=False)
    bare = _are_bare(blocks)
    whole = np.bincount(plane, np.where(bare.reshape(-1), np.linalg.norm(outward, axis=1), 0.0))
    found: FloatArray = np.where(bare, whole[plane].reshape(-1, 2), 0.0)
    return found


def inner_corners(blocks: Polyhedra) -> BoolArray:
    """Return the corners of faces at which the surface of a block turns inwards, both blocks of each, (k, 2).

    The rock of such a block continues beyond the corner, as at the foot of a step. Rows are those of
    ``blocks.face_vertices``.
    """
    parts, edges = _neighbours(blocks)
    inwards = _heights(blocks, parts, edges) > 0
    following = next_corner(blocks.face_offsets)
    found = np.zeros((len(following), 2), dtype=bool)
    for part, row in zip(parts, edges, strict=True):
        for corner in (row, following[row]):
            found[corner[inwards], part[inwards] % 2] = True
    return found


def _are_bare(blocks: Polyhedra) -> BoolArray:
    """Return which sides of faces (n_faces, 2) are the surface of a block."""
    block = blocks.face_blocks
    bare: BoolArray = (block >= 0) & (block[:, :1] != block[:, 1:])
    return bare


def _outward(blocks: Polyhedra) -> FloatArray:
    """Return the outward areas of both sides of faces, one after the other, (2 n_faces, 3) [m2]."""
    area = vector_areas(blocks.vertices[blocks.face_vertices], blocks.face_offsets)
    outward: FloatArray = np.repeat(area, 2, axis=0) * np.tile([[1.0], [-1.0]], (len(area), 1))
    return outward


def _neighbours(blocks: Polyhedra) -> tuple[tuple[IntArray, IntArray], tuple[IntArray, IntArray]]:
    """Return the pairs of sides of a block's faces that share an edge, and the corner of each where it begins."""
    point, offsets, block = blocks.face_vertices, blocks.face_offsets, blocks.face_blocks
    owner, following = owner_of_corner(offsets), next_corner(offsets)
    corner, side = np.nonzero(_are_bare(blocks)[owner])
    ends = np.sort(np.column_stack([point, point[following]]), axis=1)[corner]
    part = 2 * owner[corner] + side
    key = np.column_stack([block[owner[corner], side], ends])
    order = np.lexsort(key.T)
    part, key, corner = part[order], key[order], corner[order]
    same = (key[1:] == key[:-1]).all(axis=1)
    return (part[:-1][same], part[1:][same]), (corner[:-1][same], corner[1:][same])


def _heights(blocks: Polyhedra, parts: tuple[IntArray, IntArray], edges: tuple[IntArray, IntArray]) -> FloatArray:
    """Return how high the second of pairs of sides lies over the first, times its area [m3]; 0 in one plane."""
    (one, other), outward, offsets = parts, _outward(blocks), blocks.face_offsets
    owner, point = owner_of_corner(offsets), blocks.vertices[blocks.face_vertices]
    middle = sums(owner, point, len(offsets) - 1) / np.diff(offsets)[:, None]
    height = np.einsum("ij,ij->i", middle[other // 2] - point[edges[0]], outward[one])
    found: FloatArray = np.where(_in_one_plane(outward, one, other), 0.0, height)
    return found


def _in_one_plane(outward: FloatArray, one: IntArray, other: IntArray) -> BoolArray:
    """Return which pairs of sides lie in one plane, by their outward areas (2 n_faces, 3)."""
    size = np.linalg.norm(outward, axis=1)
    across = np.linalg.norm(np.cross(outward[one], outward[other]), axis=1)
    along = np.einsum("ij,ij->i", outward[one], outward[other])
    flat: BoolArray = (across < FLAT * size[one] * size[other]) & (along > 0)
    return flat
