"""Which blocks lie over each other: an outline may touch its neighbours but not enter them.

Around the region that two blocks share there is, somewhere, an edge without a partner of opposite
direction (`EdgeTable.unpaired`): were every edge of it paired, the blocks there would be covered only
once. So only the blocks that own such an edge, the rim, are compared with the blocks near them. In a
conforming mesh these are few, which makes the test cheap for a million elements.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray, rounding_of
from bsm_mesh.errors import place
from bsm_mesh.model.edges import EdgeTable, LongArray
from bsm_mesh.model.polygons import owner_of_corner

SMALLEST_SHARE = 1e-6  # of the smaller block's area: less is rounding at a corner on a neighbour's edge
GRID = 1e-10  # of the smallest block's size: to what overlaps are rounded, if coordinates are not coarser


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Overlaps:
    """Pairs of blocks that share area.

    Attributes
    ----------
    pairs : (n, 2) int64
        Block numbers, the lower first.
    area : (n,) float64 [m2]
        Of their overlap.
    place : (n, 2) float64 [m]
        Centre of the shared area.
    """

    pairs: LongArray
    area: FloatArray
    place: FloatArray

    def faults(self, numbers: LongArray | None = None, thing: str = "blocks") -> list[str]:
        """Return one sentence for every pair.

        Parameters
        ----------
        numbers : (n_blocks,) int64, optional
            How the blocks are numbered for the reader, if not from 0.
        thing : str
            The reader's word for them.
        """
        named = self.pairs if numbers is None else numbers[self.pairs]
        return [
            f"{thing} {a} and {b} overlap by {area:.3g} m2 near {place((x, y))}; "
            "remove one of them or make their outlines meet"
            for (a, b), area, (x, y) in zip(named, self.area, self.place, strict=True)
        ]


def find_overlaps(vertices: FloatArray, offsets: IntArray, nodes: IntArray, table: EdgeTable | None = None) -> Overlaps:
    """Return the pairs of blocks that overlap by more than a millionth of the smaller one's area.

    Outlines that cross themselves, which `Blocks` refuses, are passed over.

    Parameters
    ----------
    vertices : (n_vertices, 2) float64 [m]
        Corners, counter-clockwise, block after block.
    offsets : (n_blocks + 1,) int32
        Block b owns ``vertices[offsets[b]:offsets[b + 1]]``.
    nodes : (n_vertices,) int32
        Number of the point at which each corner lies.
    table : EdgeTable, optional
        The edges of these blocks, if already sorted.
    """
    table = EdgeTable.of(nodes, offsets) if table is None else table
    rim = np.zeros(len(offsets) - 1, dtype=np.bool_)
    rim[owner_of_corner(offsets)[table.unpaired()]] = True
    low = np.minimum.reduceat(vertices, offsets[:-1], axis=0)
    high = np.maximum.reduceat(vertices, offsets[:-1], axis=0)
    looked_at = np.flatnonzero(_boxes_near(low, high, rim))
    return _shared_areas(vertices, offsets, looked_at, rim[looked_at])


def _boxes_near(low: FloatArray, high: FloatArray, rim: BoolArray) -> BoolArray:
    """Return which boxes meet a grid cell that a rim box meets, (n_blocks,)."""
    n_side = max(1, int(np.sqrt(len(rim))))
    origin = low.min(axis=0)
    cell = np.maximum((high.max(axis=0) - origin) / n_side, np.finfo(np.float64).tiny)
    first = np.clip(((low - origin) / cell).astype(np.int64) - 1, 0, n_side - 1)
    last = np.clip(((high - origin) / cell).astype(np.int64) + 1, 0, n_side - 1) + 1
    i0, j0, i1, j1 = first[:, 0], first[:, 1], last[:, 0], last[:, 1]
    change = np.zeros((n_side + 1, n_side + 1), dtype=np.int64)
    for i, j, sign in ((i0, j0, 1), (i1, j1, 1), (i0, j1, -1), (i1, j0, -1)):
        np.add.at(change, (i[rim], j[rim]), sign)
    marked = change.cumsum(axis=0).cumsum(axis=1)[:n_side, :n_side] > 0
    below = np.zeros((n_side + 1, n_side + 1), dtype=np.int64)  # marked cells below and left of each grid point
    below[1:, 1:] = marked.cumsum(axis=0).cumsum(axis=1)
    near: BoolArray = below[i1, j1] - below[i0, j1] - below[i1, j0] + below[i0, j0] > 0
    return near


def _shared_areas(vertices: FloatArray, offsets: IntArray, blocks: LongArray, rim: BoolArray) -> Overlaps:
    """Return the overlaps of the rim among `blocks` with any of `blocks`."""
    import shapely

    middle = vertices.mean(axis=0)  # about which areas are exact, wherever the blocks lie
    outlines = polygons_of(vertices - middle, offsets, blocks)
    valid = shapely.is_valid(outlines)
    outlines, blocks, rim = outlines[valid], blocks[valid], rim[valid]
    shapely.prepare(outlines)
    left, right = shapely.STRtree(outlines).query(outlines[rim], predicate="intersects")
    left = np.flatnonzero(rim)[left]
    twice = left >= right  # each block with itself, and a pair of rim blocks found from either side
    twice &= rim[right]
    left, right = left[~twice], right[~twice]
    entered = ~shapely.touches(outlines[left], outlines[right])
    left, right = left[entered], right[entered]
    smaller = np.minimum(shapely.area(outlines[left]), shapely.area(outlines[right]))
    # Snapped to a grid: where edges differ by rounding alone GEOS has returned a whole triangle as the shared area.
    grid = max(GRID * float(np.sqrt(smaller.min(initial=np.inf))), rounding_of(vertices))
    shared = shapely.intersection(outlines[left], outlines[right], grid_size=grid if np.isfinite(grid) else None)
    area = shapely.area(shared)
    real = area > SMALLEST_SHARE * smaller
    centre = shapely.centroid(shared[real])
    pairs = np.sort(np.stack([blocks[left[real]], blocks[right[real]]], axis=1), axis=1)
    order = np.lexsort(pairs.T[::-1])
    place = np.stack([shapely.get_x(centre), shapely.get_y(centre)], axis=1) + middle
    return Overlaps(pairs=pairs[order], area=area[real][order], place=place[order])


def polygons_of(vertices: FloatArray, offsets: IntArray, blocks: LongArray) -> Any:
    """Return the outlines of some blocks as an array of shapely polygons."""
    import shapely

    sizes = np.diff(offsets)[blocks]
    within = np.arange(sizes.sum()) - np.repeat(np.cumsum(sizes) - sizes, sizes)
    corners = vertices[np.repeat(offsets[blocks], sizes) + within]
    return shapely.polygons(shapely.linearrings(corners, indices=np.repeat(np.arange(len(blocks)), sizes)))
