"""Stresses along a line through the blocks."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.model.blocks import Blocks

Point = tuple[float, float]


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Section:
    """Stress in some blocks by both methods, in the order in which the blocks were named.

    Attributes
    ----------
    block : (k,) int32
        The blocks.
    area : (k,) float64 [m2]
        Their areas.
    centroid : (k, 2) float64 [m]
        Where they are.
    bsm, fem : (k, 2, 2) float64 [Pa]
        Average stress of the blocks, tension positive.
    """

    block: IntArray
    area: FloatArray
    centroid: FloatArray
    bsm: FloatArray
    fem: FloatArray


def blocks_on_line(blocks: Blocks, start: Point, end: Point) -> IntArray:
    """Return the blocks that the straight line between two points crosses, from its start to its end.

    Parameters
    ----------
    blocks : Blocks
        Where to look.
    start, end : (x, y) [m]
        Ends of the line. Blocks that it only touches, along an edge or at a corner, count as well.

    Examples
    --------
    >>> row = Blocks.from_polygons([[(x, 0), (x + 1, 0), (x + 1, 1), (x, 1)] for x in (2, 0, 1)], rock="granite")
    >>> blocks_on_line(row, (0.5, 0.5), (9.0, 0.5))
    array([1, 2, 0], dtype=int32)
    """
    import shapely

    polygons = shapely.polygons(shapely.linearrings(blocks.vertices, indices=blocks.owner))
    crossed = shapely.STRtree(polygons).query(shapely.linestrings([start, end]), predicate="intersects")
    along = (blocks.moments.centroid[crossed] - start) @ (np.array(end) - start)
    ordered: IntArray = crossed[np.argsort(along)].astype(np.int32)
    return ordered
