"""Blocks divided into few triangles, with no node on an outline but the corners that are there."""

from __future__ import annotations

import numpy as np

from geometries.cutting.block_cut import BlockCut
from geometries.cutting.faces import Faces
from geometries.cutting.pieces import BoolArray, IntArray
from geometries.joint_sets import FloatArray

THINNEST = 1e-10  # area over perimeter squared: a fan with a thinner triangle is no fan
STRAIGHT = 1e-9  # of its neighbours' distance: a corner nearer to their line is left out of the triangulation


def divide_faces(cut: BlockCut) -> tuple[FloatArray, IntArray, IntArray]:
    """Return points, triangles and the block of each triangle, in the order of the blocks.

    A block is a fan of triangles around its centroid where that sees all of the outline. The others, with a hole or
    strongly concave, get a constrained Delaunay triangulation; corners in the middle of a straight side are put back
    as fans of the triangles there.
    """
    faces = Faces(corners=cut.corners, rings=cut.rings, faces=cut.faces)
    owner, following = faces.owner, faces.following
    centre = _centroids(cut, faces)
    a, b, c = cut.points[cut.corners], cut.points[cut.corners[following]], centre[owner]
    fan = (np.diff(cut.faces) == 1) & np.logical_and.reduceat(_thick(a, b, c), cut.rings[cut.faces[:-1]])
    number = len(cut.points) + np.cumsum(fan) - 1
    inside = fan[owner]
    triangles = [np.stack([cut.corners, cut.corners[following], number[owner]], axis=1)[inside]]
    points, block = [cut.points, centre[fan]], [owner[inside]]
    count = len(cut.points) + int(fan.sum())
    for face in np.flatnonzero(~fan).tolist():  # a few concave ones
        more, others = _delaunay(cut, face, count)
        count += len(more)
        points.append(more)
        triangles.append(others)
        block.append(np.full(len(others), face))
    of_triangle = np.concatenate(block)
    order = np.argsort(of_triangle, kind="stable")
    return np.concatenate(points), np.concatenate(triangles)[order], of_triangle[order]


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


def _delaunay(cut: BlockCut, face: int, first: int) -> tuple[FloatArray, IntArray]:
    """Return further points, numbered from `first`, and the triangles of one block."""
    import shapely

    straight: dict[tuple[int, int], list[int]] = {}  # side between two corners -> corners in the middle of it
    rings = []
    for ring in range(cut.faces[face], cut.faces[face + 1]):
        nodes = cut.corners[cut.rings[ring] : cut.rings[ring + 1]]
        kept = np.flatnonzero(_bends(cut.points[nodes]))
        for begin, end in zip(kept, np.append(kept[1:], kept[0] + len(nodes)), strict=True):
            run = np.take(nodes, range(begin, end + 1), mode="wrap").tolist()
            straight[run[0], run[-1]] = run[1:-1]
        rings.append(nodes[kept])
    at = {tuple(cut.points[node]): int(node) for ring in rings for node in ring}
    polygon = shapely.Polygon(cut.points[rings[0]], [cut.points[ring] for ring in rings[1:]])
    parts = shapely.get_parts(shapely.constrained_delaunay_triangles(polygon))
    points, triangles = [], []
    for part in shapely.orient_polygons(parts):
        corner = [at[tuple(xy)] for xy in shapely.get_coordinates(part)[:3]]
        sides = [(corner[k], corner[(k + 1) % 3]) for k in range(3)]
        outline = [node for side in sides for node in (side[0], *straight.get(side, []))]
        if len(outline) == 3:
            triangles.append(tuple(corner))
            continue
        points.append(cut.points[corner].mean(axis=0))
        centre = first + len(points) - 1
        triangles += [(a, b, centre) for a, b in zip(outline, [*outline[1:], outline[0]], strict=True)]
    return np.array(points).reshape(-1, 2), np.array(triangles, dtype=np.int64)


def _bends(points: FloatArray) -> BoolArray:
    """Return which corners of a ring lie off the line between their neighbours; all, of one that is next to flat."""
    before, after = np.roll(points, 1, axis=0), np.roll(points, -1, axis=0)
    vector, gap = after - before, points - before
    off = np.abs(vector[:, 0] * gap[:, 1] - vector[:, 1] * gap[:, 0])
    bends: BoolArray = off > STRAIGHT * np.einsum("nj,nj->n", vector, vector)
    return bends if bends.sum() > 2 else np.ones_like(bends)
