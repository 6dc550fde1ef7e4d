"""Blocks divided into few triangles, with no node on an outline but the corners that are there."""

from __future__ import annotations

import numpy as np

from bsm_mesh.geometries.cutting.block_cut import BlockCut
from bsm_mesh.geometries.cutting.faces import Faces, find_points
from bsm_mesh.geometries.cutting.pieces import BoolArray, IntArray
from bsm_mesh.geometries.joint_sets import FloatArray

THINNEST = 1e-10  # area over perimeter squared: a fan with a thinner triangle is no fan


def divide_faces(cut: BlockCut) -> tuple[FloatArray, IntArray, IntArray]:
    """Return points, triangles and the block of each triangle, in the order of the blocks.

    A block is a fan of triangles around its centroid where that sees all of the outline. The others, with a hole or
    strongly concave, get a constrained Delaunay triangulation.
    """
    faces = Faces(corners=cut.corners, rings=cut.rings, faces=cut.faces)
    owner, following = faces.owner, faces.following
    centre = _centroids(cut, faces)
    a, b, c = cut.points[cut.corners], cut.points[cut.corners[following]], centre[owner]
    fan = (np.diff(cut.faces) == 1) & np.logical_and.reduceat(_thick(a, b, c), cut.rings[cut.faces[:-1]])
    number = len(cut.points) + np.cumsum(fan) - 1
    inside = fan[owner]
    fans = np.stack([cut.corners, cut.corners[following], number[owner]], axis=1)[inside]
    others, of_block = delaunay_triangles(cut, faces, np.flatnonzero(~fan))
    block = np.concatenate([owner[inside], of_block])
    order = np.argsort(block, kind="stable")
    return np.concatenate([cut.points, centre[fan]]), np.concatenate([fans, others])[order], block[order]


def _thick(a: FloatArray, b: FloatArray, c: FloatArray) -> BoolArray:
    area = ((b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])) / 2
    perimeter = np.hypot(*(b - a).T) + np.hypot(*(c - b).T) + np.hypot(*(a - c).T)
    thick: BoolArray = area > THINNEST * perimeter**2
    return thick


def _centroids(cut: BlockCut, faces: Faces) -> FloatArray:
    owner = faces.owner
    origin = cut.points[cut.corners[cut.rings[cut.faces[:-1]]]]
    a = cut.points[cut.corners] - origin[owner]
    b = a[faces.following]
    cross = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    moments = [np.bincount(owner, cross * (a[:, k] + b[:, k])) for k in (0, 1)]
    centroid: FloatArray = origin + np.stack(moments, axis=1) / (3 * np.bincount(owner, cross))[:, None]
    return centroid


def delaunay_triangles(cut: BlockCut, faces: Faces, blocks: IntArray) -> tuple[IntArray, IntArray]:
    """Return the constrained Delaunay triangles of some blocks between their corners, and the block of each."""
    import shapely

    found = shapely.constrained_delaunay_triangles(faces.polygons(cut.points)[blocks])
    parts, owner = shapely.get_parts(found, return_index=True)
    corners = shapely.get_coordinates(shapely.orient_polygons(parts)).reshape(-1, 4, 2)[:, :3]
    order = np.lexsort(cut.points.T)
    number = order[find_points(corners.reshape(-1, 2), cut.points[order])]
    return number.reshape(-1, 3), blocks[owner]
