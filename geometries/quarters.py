"""Blocks divided into quadrilaterals around their centroids: a finite-element mesh that no mesher has to find.

Every corner of a block gives one quadrilateral: the corner, the middles of its two sides and the block's centroid; two
triangles where the outline goes straight on or turns to the right there. Neighbours divide a side that they share in
the same place, so the mesh conforms. Blocks whose centroid does not see their whole outline are divided into triangles.
"""

from __future__ import annotations

import dataclasses
import os
from pathlib import Path

import numpy as np

from bsm_mesh.geometries import physical_groups
from bsm_mesh.geometries.block_files import add_lines, add_surfaces, surface_groups
from bsm_mesh.geometries.cutting.block_cut import BlockCut
from bsm_mesh.geometries.cutting.faces import Faces
from bsm_mesh.geometries.cutting.fans import delaunay_triangles
from bsm_mesh.geometries.cutting.pieces import BoolArray, IntArray
from bsm_mesh.geometries.joint_sets import FloatArray
from bsm_mesh.geometries.session import gmsh_session, name_groups, write_mesh

TRIANGLE, QUADRANGLE = 2, 3  # Gmsh's numbers of element types
STRAIGHTEST = 0.05  # sine of the turn at a corner: less is taken as straight, else a quadrilateral would be too flat
THINNEST = 1e-3  # area of a fan's triangle over its longest side squared: below, the centroid hardly sees the side


def quarter_blocks(cut: BlockCut, path: str | os.PathLike[str]) -> Path:
    """Write the blocks as quadrilaterals around their centroids and return the path.

    Parameters
    ----------
    cut : BlockCut
        The blocks.
    path : path
        The file, ``.msh``; to be read with ``blocks = "elements"``, or ``"regions"`` for the blocks themselves.

    Raises
    ------
    GeometryError
        Where the file cannot be written.
    """
    sides, middle = _sides(cut)
    points, elements = _divide(cut, len(cut.points) + middle, len(sides))
    groups, of_block = surface_groups(cut)
    with gmsh_session("quarters") as gmsh:
        kinds = {shape: (nodes, of_block[block]) for shape, (nodes, block) in elements.items()}
        surfaces = add_surfaces(gmsh, points, groups, kinds)
        lines = {physical_groups.joint(name): edges for name, edges in cut.joints.items() if len(edges)}
        lines |= {physical_groups.boundary(name): edges for name, edges in cut.boundaries.items()}
        curves = {name: [add_lines(gmsh, _halves(edges, sides, len(cut.points)))] for name, edges in lines.items()}
        gmsh.model.mesh.reclassifyNodes()
        name_groups(surfaces | curves)
        return write_mesh(path)


def _sides(cut: BlockCut) -> tuple[IntArray, IntArray]:
    """Return the points at the ends of every side (k, 2), the lesser first, and the side that begins at each corner."""
    faces = Faces(corners=cut.corners, rings=cut.rings, faces=cut.faces)
    ends = np.sort(np.stack([cut.corners, cut.corners[faces.following]], axis=1), axis=1)
    sides, side = np.unique(ends, axis=0, return_inverse=True)
    return sides, side.reshape(-1)


def _halves(edges: IntArray, sides: IntArray, first: int) -> IntArray:
    """Return both halves (2 k, 2) of edges; the middle of side s is the point ``first + s``."""
    edges = np.sort(edges, axis=1)
    scale = int(sides.max()) + 1
    middle = first + np.searchsorted(sides[:, 0] * scale + sides[:, 1], edges[:, 0] * scale + edges[:, 1])
    return np.concatenate([np.stack([edges[:, 0], middle], axis=1), np.stack([middle, edges[:, 1]], axis=1)])


def _divide(cut: BlockCut, after: IntArray, sides: int) -> tuple[FloatArray, dict[int, tuple[IntArray, IntArray]]]:
    """Return all points, and the nodes and block of every quadrangle and triangle.

    Parameters
    ----------
    cut : BlockCut
        The blocks.
    after : (n_corners,) int64
        Point in the middle of the side that begins at each corner.
    sides : int
        Number of sides.
    """
    faces = Faces(corners=cut.corners, rings=cut.rings, faces=cut.faces)
    owner, following = faces.owner, faces.following
    before = np.empty_like(after)
    before[following] = after
    first = len(cut.points) + sides
    points = np.empty((first, 2))
    points[: len(cut.points)] = cut.points
    points[after] = (cut.points[cut.corners] + cut.points[cut.corners[following]]) / 2
    refined = dataclasses.replace(
        cut, points=points, corners=np.stack([cut.corners, after], axis=1).ravel(), rings=2 * cut.rings
    )
    centroid = _centroids(cut, faces)
    seen = _sees_all(cut, points, after, before, centroid)
    rest, of_rest = delaunay_triangles(
        refined,
        Faces(corners=refined.corners, rings=refined.rings, faces=refined.faces),
        np.flatnonzero(~seen),
    )
    centre = (first + np.cumsum(seen) - 1)[owner]
    whole, pair = seen[owner] & _turns_left(cut, following), seen[owner] & ~_turns_left(cut, following)
    quads = np.stack([centre, before, cut.corners, after], axis=1)[whole]
    halves = np.stack([centre, before, cut.corners, centre, cut.corners, after], axis=1)[pair].reshape(-1, 3)
    return np.concatenate([points, centroid[seen]]), {
        QUADRANGLE: (quads, owner[whole]),
        TRIANGLE: (np.concatenate([halves, rest]), np.concatenate([np.repeat(owner[pair], 2), of_rest])),
    }


def _centroids(cut: BlockCut, faces: Faces) -> FloatArray:
    import shapely

    centroids: FloatArray = shapely.get_coordinates(shapely.centroid(faces.polygons(cut.points)))
    return centroids


def _sees_all(cut: BlockCut, points: FloatArray, after: IntArray, before: IntArray, centroid: FloatArray) -> BoolArray:
    """Return whether the centroid of each block sees both halves of every corner well, and there is no hole."""
    faces = Faces(corners=cut.corners, rings=cut.rings, faces=cut.faces)
    owner = faces.owner
    corner = points[cut.corners]
    hidden = np.zeros(len(owner), dtype=bool)
    for a, b in ((points[before], corner), (corner, points[after])):
        p, q = a - centroid[owner], b - centroid[owner]
        longest = np.maximum((p**2).sum(axis=1), (q**2).sum(axis=1))
        hidden |= p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0] <= THINNEST * longest
    seen: BoolArray = (np.bincount(owner, hidden, minlength=cut.count) == 0) & (np.diff(cut.faces) == 1)
    return seen


def _turns_left(cut: BlockCut, following: IntArray) -> BoolArray:
    """Return whether the outline turns to the left at each corner, by more than a trifle."""
    points = cut.points[cut.corners]
    leaving = points[following] - points
    arriving = np.empty_like(leaving)
    arriving[following] = leaving
    turn = arriving[:, 0] * leaving[:, 1] - arriving[:, 1] * leaving[:, 0]
    left: BoolArray = turn > STRAIGHTEST * np.hypot(*arriving.T) * np.hypot(*leaving.T)
    return left
