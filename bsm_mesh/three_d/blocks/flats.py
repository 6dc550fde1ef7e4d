"""The plane parts of the surfaces of blocks: neighbouring faces of a block that lie in one plane."""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.model.polygons import next_corner, owner_of_corner
from bsm_mesh.three_d.blocks.polygons import vector_areas
from bsm_mesh.three_d.blocks.polyhedra import Polyhedra

FLAT = 1e-6  # of both areas: faces whose normals have a smaller product lie in one plane


def flat_areas(blocks: Polyhedra) -> FloatArray:
    """Return the area of the plane part of both blocks' surfaces in which every face lies, (n_faces, 2) [m2].

    It is 0 where a face has no block on that side, and for faces between cells of one block.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    point, offsets, block = blocks.face_vertices, blocks.face_offsets, blocks.face_blocks
    count = len(block)
    owner, following = owner_of_corner(offsets), next_corner(offsets)
    bare = (block >= 0) & (block[:, :1] != block[:, 1:])
    corner, side = np.nonzero(bare[owner])
    ends = np.sort(np.column_stack([point, point[following]]), axis=1)[corner]
    part = 2 * owner[corner] + side
    key = np.column_stack([block[owner[corner], side], ends])
    order = np.lexsort(key.T)
    part, key = part[order], key[order]
    same = (key[1:] == key[:-1]).all(axis=1)
    one, other = part[:-1][same], part[1:][same]
    area = vector_areas(blocks.vertices[point], offsets)
    outward = np.repeat(area, 2, axis=0) * np.tile([[1.0], [-1.0]], (count, 1))
    size = np.linalg.norm(outward, axis=1)
    across = np.linalg.norm(np.cross(outward[one], outward[other]), axis=1)
    along = np.einsum("ij,ij->i", outward[one], outward[other])
    flat = (across < FLAT * size[one] * size[other]) & (along > 0)
    graph = coo_array((np.ones(flat.sum()), (one[flat], other[flat])), shape=(2 * count, 2 * count))
    _, plane = connected_components(graph, directed=False)
    whole = np.bincount(plane, np.where(bare.reshape(-1), size, 0.0))
    found: FloatArray = np.where(bare, whole[plane].reshape(-1, 2), 0.0)
    return found
