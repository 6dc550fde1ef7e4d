"""Volumes by which polyhedra have passed into each other at a stage's end, from the places of their corners alone."""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.contact.rules import CONTACT_TOLERANCE
from bsm_mesh.movements import carried, lengths, translations, turns
from bsm_mesh.results.records import StageResult
from bsm_mesh.three_d.blocks.cell_sides import sides_of_cells
from bsm_mesh.three_d.blocks.placed_cells import PlacedCells
from bsm_mesh.three_d.blocks.polyhedra import Polyhedra
from bsm_mesh.three_d.contacts.clipping import near_blocks

LEAST = CONTACT_TOLERANCE  # of the smaller block's size: less relative movement, or depth, is contact


def unexplained_overlap(blocks: Polyhedra, stage: StageResult) -> float:
    """Return the overlapping volume less the closure of the contacts times their areas, over the median volume.

    It is that of the worst pair: a sum would grow with the number of blocks. Blocks that moved together, or
    less than a thousandth of their size against each other, overlap no more than as given.
    """
    movement = stage.origin + stage.displacement
    cells = PlacedCells.of(blocks, sides_of_cells(blocks), movement)
    pairs = _moved_pairs(blocks, stage, movement, cells)
    pairs = pairs[cells.depths(pairs) > LEAST * blocks.moments.size[blocks.cell_block[pairs]].min(axis=1)]
    shared: dict[tuple[int, int], float] = {}
    for one, other in pairs.tolist():
        a, b = sorted(blocks.cell_block[[one, other]].tolist())
        shared[a, b] = shared.get((a, b), 0.0) + _shared_volume(cells, one, other)
    contacts = stage.contacts
    closed = np.maximum(-contacts.opening, 0.0) * contacts.length
    ends = np.sort(np.column_stack([contacts.block_a, contacts.block_b]), axis=1)
    excess = [volume - float(closed[(ends == pair).all(axis=1)].sum()) for pair, volume in shared.items()]
    return max([0.0, *excess]) / float(np.median(blocks.moments.volume))


def _moved_pairs(blocks: Polyhedra, stage: StageResult, movement: FloatArray, cells: PlacedCells) -> IntArray:
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


def _shared_volume(cells: PlacedCells, one: int, other: int) -> float:
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
