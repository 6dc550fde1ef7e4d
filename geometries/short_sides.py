"""Short sides of blocks closed: slivers go, at the price of a small bend in a joint, as one draws a mesh by hand."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

import numpy as np

from bsm_mesh.geometries.cutting.block_cut import BlockCut
from bsm_mesh.geometries.cutting.faces import Faces
from bsm_mesh.geometries.cutting.pieces import IntArray
from bsm_mesh.geometries.errors import GeometryError

ON_LINE = 1e-6  # m: a point this near to an outline lies on it
MOST_HALVINGS = 6


def close_short_sides(cut: BlockCut, shortest: float, outlines: Any) -> BlockCut:
    """Return the blocks with the ends of every short side made one point; blocks without area are left out.

    The point that stays is a corner of the outlines, else one on an outline, else the mean of the ends. Where a block
    would cross itself, all are closed to half that length instead, and so on.

    Parameters
    ----------
    cut : BlockCut
        Blocks without holes.
    shortest : float
        Sides shorter than this are closed [m].
    outlines : shapely.Geometry
        Polygons whose outlines and corners stay where they are.

    Raises
    ------
    GeometryError
        Where blocks cross themselves even so.
    """
    for halving in range(MOST_HALVINGS):
        closed = _close(cut, shortest / 2**halving, outlines)
        if _valid(closed):
            return closed
    raise GeometryError(f"sides of {shortest:g} m and less cannot be closed; move the joints a little")


def _valid(cut: BlockCut) -> bool:
    """Return whether all blocks are simple and lie on the left of their outlines."""
    import shapely

    rings = shapely.linearrings(cut.points[cut.corners], indices=np.repeat(np.arange(cut.count), np.diff(cut.rings)))
    return bool(np.all(shapely.is_valid(shapely.polygons(rings)) & shapely.is_ccw(rings)))


def _close(cut: BlockCut, shortest: float, outlines: Any) -> BlockCut:
    faces = Faces(corners=cut.corners, rings=cut.rings, faces=cut.faces)
    number, points = _join(cut, faces, shortest, outlines)
    corner = number[cut.corners]
    kept = corner != corner[faces.following]
    owner = faces.owner
    count = np.bincount(owner[kept], minlength=cut.count)
    there = count >= 3
    inside = kept & there[owner]
    old_to_new = np.cumsum(there) - 1
    return dataclasses.replace(
        cut,
        points=points,
        corners=corner[inside],
        rings=np.concatenate([[0], np.cumsum(count[there])]),
        faces=np.arange(int(there.sum()) + 1),
        rock=cut.rock[there],
        excavations={name: old_to_new[blocks[there[blocks]]] for name, blocks in cut.excavations.items()},
        joints=_renumber(cut.joints, number),
        boundaries=_renumber(cut.boundaries, number),
        dead={},
    )


def _join(cut: BlockCut, faces: Faces, shortest: float, outlines: Any) -> tuple[IntArray, Any]:
    """Return the new number of every point, and the new points."""
    import shapely
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    start, end = cut.corners, cut.corners[faces.following]
    short = np.hypot(*(cut.points[end] - cut.points[start]).T) < shortest
    size = len(cut.points)
    links = coo_array((np.ones(int(short.sum())), (start[short], end[short])), shape=(size, size))
    count, number = connected_components(links, directed=False)
    where = shapely.points(cut.points)
    lines, corners = shapely.boundary(outlines), shapely.multipoints(shapely.get_coordinates(outlines))
    rank = (shapely.distance(where, lines) < ON_LINE).astype(int) + (shapely.distance(where, corners) < ON_LINE)
    best = np.zeros(count, dtype=int)
    np.maximum.at(best, number, rank)
    chosen = rank == best[number]
    share = np.bincount(number[chosen], minlength=count)
    points = np.stack([np.bincount(number[chosen], x, minlength=count) / share for x in cut.points[chosen].T], axis=1)
    return number.astype(np.int64), points


def _renumber(groups: Mapping[str, IntArray], number: IntArray) -> dict[str, IntArray]:
    """Return the edges that are left of each group; one that has become another's stays with the first."""
    found: dict[str, IntArray] = {}
    size, taken = int(number.max()) + 1, np.zeros(0, dtype=np.int64)
    for name, edges in groups.items():
        ends = np.sort(number[edges], axis=1)
        key = np.unique(ends[ends[:, 0] != ends[:, 1]] @ np.array([size, 1]))
        key = key[~np.isin(key, taken)]
        taken = np.concatenate([taken, key])
        if key.size:
            found[name] = np.stack([key // size, key % size], axis=1)
    return found
