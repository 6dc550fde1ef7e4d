"""Volumes that polyhedra share, as given or at the end of a stage, from the places of their corners alone."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.contact.rules import CONTACT_TOLERANCE
from bsm_mesh.errors import place
from bsm_mesh.model.overlap import SMALLEST_SHARE
from bsm_mesh.movements import carried, lengths, translations, turns
from bsm_mesh.results.records import StageResult
from bsm_mesh.three_d.blocks.cell_sides import sides_of_cells
from bsm_mesh.three_d.blocks.placed_cells import PlacedCells
from bsm_mesh.three_d.blocks.polyhedra import Polyhedra
from bsm_mesh.three_d.contacts.clipping import near_blocks

LEAST = CONTACT_TOLERANCE  # of the smaller block's size: less relative movement, or depth, is contact


@lru_cache(maxsize=1)  # trials of a factor of safety have the same blocks
def overlap_faults(blocks: Polyhedra) -> tuple[str, ...]:
    """Return a sentence for every two blocks that lie in each other as they were given.

    Around a volume that two cells share there is a face with one cell alone. So only cells with such faces are
    compared with those near them. Less than a millionth of the smaller block's volume is rounding. A depth below a
    thousandth of its size is contact.
    """
    cells = PlacedCells.of(blocks, sides_of_cells(blocks), np.zeros((blocks.count, blocks.axes)))
    rim = np.zeros(len(blocks.cell_block), dtype=np.bool_)
    rim[blocks.face_cells[blocks.face_cells[:, 1] < 0, 0]] = True
    found = _shared_volumes(blocks, cells, _near_pairs(blocks, cells, rim))
    least = SMALLEST_SHARE * blocks.moments.volume
    return tuple(
        f"blocks {a} and {b} overlap by {volume:.3g} m3 near {place(middle)}; "
        "remove one of them or make their faces meet"
        for (a, b), (volume, middle) in sorted(found.items())
        if volume > min(least[a], least[b])
    )


def unexplained_overlap(blocks: Polyhedra, stage: StageResult) -> float:
    """Return the overlapping volume less the closure of the contacts times their areas, over the median volume.

    It is that of the worst pair: a sum would grow with the number of blocks. Blocks that moved together, or
    less than a thousandth of their size against each other, overlap no more than as given.
    """
    movement = stage.origin + stage.displacement
    cells = PlacedCells.of(blocks, sides_of_cells(blocks), movement)
    pairs = _moved_pairs(blocks, stage, movement, cells)
    shared = _shared_volumes(blocks, cells, pairs)
    contacts = stage.contacts
    closed = np.maximum(-contacts.opening, 0.0) * contacts.length
    ends = np.sort(np.column_stack([contacts.block_a, contacts.block_b]), axis=1)
    excess = [volume - float(closed[(ends == pair).all(axis=1)].sum()) for pair, (volume, _) in shared.items()]
    return max([0.0, *excess]) / float(np.median(blocks.moments.volume))


def _moved_pairs(blocks: Polyhedra, stage: StageResult, movement: FloatArray, cells: PlacedCells) -> IntArray:
    """Return the pairs of cells (p, 2) with boxes that meet, of blocks displaced against each other."""
    size, block = blocks.moments.size, blocks.cell_block
    far = lengths(translations(movement)) + lengths(turns(movement)) * size > LEAST * size
    pairs = _near_pairs(blocks, cells, far[block])
    a, b = block[pairs].T
    pairs = pairs[stage.present[a] & stage.present[b]]
    a, b = block[pairs].T
    arm = blocks.moments.centroid[b] - blocks.moments.centroid[a]
    apart = lengths(translations(movement)[b] - carried(arm, movement[a]))
    apart += lengths(turns(movement)[b] - turns(movement)[a]) * size[b]
    chosen: IntArray = pairs[apart > LEAST * np.minimum(size[a], size[b])]
    return chosen


def _near_pairs(blocks: Polyhedra, cells: PlacedCells, chosen: BoolArray) -> IntArray:
    """Return the pairs of cells (p, 2) of two blocks with boxes that meet, one of each `chosen` (n_cells,)."""
    low, high = (bound.reduceat(cells.corner, cells.first_corner[:-1]) for bound in (np.minimum, np.maximum))
    pairs = near_blocks(low, high, chosen, 0.0)
    a, b = blocks.cell_block[pairs].T
    of_two: IntArray = pairs[a != b]
    return of_two


def _shared_volumes(
    blocks: Polyhedra, cells: PlacedCells, pairs: IntArray
) -> dict[tuple[int, int], tuple[float, FloatArray]]:
    """Return the volume that two blocks share [m3], and a place in it, of pairs of cells deeper than contact."""
    pairs = pairs[cells.depths(pairs) > LEAST * blocks.moments.size[blocks.cell_block[pairs]].min(axis=1)]
    shared: dict[tuple[int, int], tuple[float, FloatArray]] = {}
    for one, other in pairs.tolist():
        a, b = sorted(blocks.cell_block[[one, other]].tolist())
        volume, middle = _shared_volume(cells, one, other)
        before, middle = shared.get((a, b), (0.0, middle))
        shared[a, b] = before + volume, middle
    return shared


def _shared_volume(cells: PlacedCells, one: int, other: int) -> tuple[float, FloatArray]:
    """Return the volume that two cells share [m3], and the mean of its corners.

    Their half spaces are intersected round the centre of a ball inside.
    """
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
        return 0.0, middle
    points = HalfspaceIntersection(np.column_stack([normal, -height]), ball.x[:3]).intersections
    hull = ConvexHull(points)
    return float(hull.volume), middle + points[hull.vertices].mean(axis=0)
