"""Volumes by which polyhedra have passed into each other at a stage's end, from the places of their corners alone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.contact.rules import CONTACT_TOLERANCE
from bsm_mesh.movements import carried, lengths, translations, turned, turns
from bsm_mesh.results.records import StageResult
from bsm_mesh.three_d.blocks.cell_sides import sides_of_cells
from bsm_mesh.three_d.blocks.polygons import spread
from bsm_mesh.three_d.blocks.polyhedra import Polyhedra
from bsm_mesh.three_d.contacts.clipping import near_blocks

LEAST = CONTACT_TOLERANCE  # of the smaller block's size: less relative movement, or depth, is contact
AT_ONCE = 2_000_000  # products of faces and corners in one array


@dataclass(frozen=True, eq=False, slots=True)
class _Cells:
    """Half spaces and corners of all cells where they are, cell after cell."""

    normal: FloatArray
    height: FloatArray
    first_face: IntArray
    corner: FloatArray
    first_corner: IntArray


def unexplained_overlap(blocks: Polyhedra, stage: StageResult) -> float:
    """Return the overlapping volume less the closure of the contacts times their areas, over the median volume.

    It is that of the worst pair: a sum would grow with the number of blocks. Blocks that moved together, or
    less than a thousandth of their size against each other, overlap no more than as given.
    """
    movement = stage.origin + stage.displacement
    cells = _placed(blocks, movement)
    pairs = _moved_pairs(blocks, stage, movement, cells)
    pairs = pairs[_depths(cells, pairs) > LEAST * blocks.moments.size[blocks.cell_block[pairs]].min(axis=1)]
    shared: dict[tuple[int, int], float] = {}
    for one, other in pairs.tolist():
        a, b = sorted(blocks.cell_block[[one, other]].tolist())
        shared[a, b] = shared.get((a, b), 0.0) + _shared_volume(cells, one, other)
    contacts = stage.contacts
    closed = np.maximum(-contacts.opening, 0.0) * contacts.length
    ends = np.sort(np.column_stack([contacts.block_a, contacts.block_b]), axis=1)
    excess = [volume - float(closed[(ends == pair).all(axis=1)].sum()) for pair, volume in shared.items()]
    return max([0.0, *excess]) / float(np.median(blocks.moments.volume))


def _placed(blocks: Polyhedra, movement: FloatArray) -> _Cells:
    """Return the cells where a movement (n, 6) has brought them."""
    sides, centroid = sides_of_cells(blocks), blocks.moments.centroid
    block = blocks.cell_block[sides.cell]
    normal = turned(sides.normal, movement[block, 3:])
    point = sides.point + carried(sides.point - centroid[block], movement[block])
    sizes = np.diff(blocks.face_offsets)[sides.face]
    corner = blocks.vertices[blocks.face_vertices[spread(blocks.face_offsets[sides.face], sizes)]]
    owner = np.repeat(block, sizes)
    return _Cells(
        normal=normal,
        height=np.einsum("ij,ij->i", normal, point),
        first_face=sides.start,
        corner=corner + carried(corner - centroid[owner], movement[owner]),
        first_corner=np.append(0, np.cumsum(sizes))[sides.start],
    )


def _moved_pairs(blocks: Polyhedra, stage: StageResult, movement: FloatArray, cells: _Cells) -> IntArray:
    """Return the pairs of cells (p, 2) with boxes that meet, of blocks displaced against each other."""
    size, block = blocks.moments.size, blocks.cell_block
    far = lengths(translations(movement)) + lengths(turns(movement)) * size > LEAST * size
    low, high = (bound.reduceat(cells.corner, cells.first_corner[:-1]) for bound in (np.minimum, np.maximum))
    pairs: IntArray = near_blocks(low, high, far[block], 0.0)
    a, b = block[pairs].T
    pairs = pairs[(a != b) & stage.present[a] & stage.present[b]]
    a, b = block[pairs].T
    arm = blocks.moments.centroid[b] - blocks.moments.centroid[a]
    apart = lengths(translations(movement)[b] - carried(arm, movement[a]))
    apart += lengths(turns(movement)[b] - turns(movement)[a]) * size[b]
    chosen: IntArray = pairs[apart > LEAST * np.minimum(size[a], size[b])]
    return chosen


def _depths(cells: _Cells, pairs: IntArray) -> FloatArray:
    """Return by how much pairs of cells overlap along the face normals of either, the least of all, (p,) [m]."""
    faces, corners = np.diff(cells.first_face), np.diff(cells.first_corner)
    depth = np.full(len(pairs), np.inf)
    for one, other in (pairs.T, pairs.T[::-1]):
        products = faces[one] * corners[other]
        part = np.cumsum(products) // AT_ONCE
        for k in np.unique(part):
            rows = np.flatnonzero(part == k)
            of_face = np.repeat(rows, faces[one[rows]])
            face = spread(cells.first_face[one[rows]], faces[one[rows]])
            count = corners[other[of_face]]
            corner = spread(cells.first_corner[other[of_face]], count)
            over = np.einsum("ij,ij->i", cells.corner[corner], np.repeat(cells.normal[face], count, axis=0))
            least = np.minimum.reduceat(over, np.cumsum(count) - count)
            np.minimum.at(depth, of_face, cells.height[face] - least)
    return depth


def _shared_volume(cells: _Cells, one: int, other: int) -> float:
    """Return the volume that two cells share [m3]: their half spaces intersected round the centre of a ball inside."""
    from scipy.optimize import linprog
    from scipy.spatial import ConvexHull, HalfspaceIntersection

    rows = np.concatenate([np.arange(cells.first_face[k], cells.first_face[k + 1]) for k in (one, other)])
    normal = cells.normal[rows]
    middle = cells.corner[cells.first_corner[one] : cells.first_corner[one + 1]].mean(axis=0)
    height = cells.height[rows] - normal @ middle
    size = float(np.abs(height).max())
    ball = linprog(
        (0, 0, 0, -1),
        A_ub=np.column_stack([normal, np.ones(len(rows))]),
        b_ub=height,
        bounds=[(None, None)] * 3 + [(0, None)],
    )
    if ball.status != 0 or ball.x[3] <= 1e-9 * size:
        return 0.0
    points = HalfspaceIntersection(np.column_stack([normal, -height]), ball.x[:3]).intersections
    return float(ConvexHull(points).volume)
