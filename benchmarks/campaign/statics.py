"""Limit analysis that shares nothing with the program: contacts found from polygons alone, and a linear program.

It asks how much of the loads no contact forces within friction can balance. Every corner that touches an edge from
outside counts, both ways where two corners meet; only parallel edges that share no length carry nothing. So what it
calls out of balance cannot be at rest; what it can balance may or may not be.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import linprog
from scipy.sparse import coo_array, eye_array, hstack

from benchmarks.campaign.scene import FloatArray, IntArray, polygon_area, polygon_centre

ANGLE = 0.02  # radians by which an edge may lean into another that it lies on
NO_OVERLAP = 1e-4  # of a block's size: parallel edges that share less carry nothing


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Touching:
    """Corners that touch edges, one row each.

    Attributes
    ----------
    corner_block, edge_block : (m,) int64
        The two blocks.
    point, normal : (m, 2) float64
        Where, and the outward unit normal of the edge.
    length : (m,) float64 [m]
        Of the edge: more than what the contact can represent.
    """

    corner_block: IntArray
    edge_block: IntArray
    point: FloatArray
    normal: FloatArray
    length: FloatArray


def touching(polygons: Sequence[FloatArray], reach: float, size: float) -> Touching:
    """Return all corners within `reach` of an edge of another block [m]; `size` is that of a block."""
    import shapely

    tree = shapely.STRtree([shapely.Polygon(polygon) for polygon in polygons])
    a, b = tree.query(tree.geometries, predicate="dwithin", distance=reach)
    a, b = a[a != b], b[a != b]
    sides = np.array([len(polygon) for polygon in polygons])
    first = np.concatenate([[0], np.cumsum(sides)])
    corners = np.concatenate(polygons)
    following = np.concatenate([np.roll(polygon, -1, axis=0) for polygon in polygons])
    before = np.concatenate([np.roll(polygon, 1, axis=0) for polygon in polygons])
    pair, corner = _expand(np.arange(len(a)), first[a], sides[a])
    row, edge = _expand(np.arange(len(pair)), first[b[pair]], sides[b[pair]])
    pair, corner = pair[row], corner[row]
    along = following[edge] - corners[edge]
    length = np.hypot(*along.T)
    t = along / length[:, None]
    n = np.column_stack([t[:, 1], -t[:, 0]])
    off = corners[corner] - corners[edge]
    gap, station = (off * n).sum(axis=1), (off * t).sum(axis=1)
    no_overlap = min(reach, NO_OVERLAP * size)
    lean = ANGLE + 2 * reach / size
    ahead, behind = following[corner] - corners[corner], before[corner] - corners[corner]
    outside = np.ones(len(corner), dtype=bool)
    for side in (ahead, behind):
        across, size_of_side = (side * n).sum(axis=1), np.hypot(*side.T)
        outside &= across >= -lean * size_of_side
        leads_away = np.where(station < length / 2, -1, 1) * (side * t).sum(axis=1) > 0
        at_end = (station <= no_overlap) | (station >= length - no_overlap)
        outside &= ~(
            at_end & leads_away & (np.abs(across) <= lean * size_of_side)
        )  # parallel, and they share no length
    convex = ahead[:, 0] * behind[:, 1] - ahead[:, 1] * behind[:, 0] > 0
    kept = outside & convex & (np.abs(gap) <= reach) & (station >= -reach) & (station <= length + reach)
    return Touching(
        corner_block=a[pair][kept],
        edge_block=b[pair][kept],
        point=corners[corner][kept],
        normal=n[kept],
        length=length[kept],
    )


def _expand(row: IntArray, first: IntArray, count: IntArray) -> tuple[IntArray, IntArray]:
    """Return every row as often as it counts, and running numbers from its first."""
    repeated = np.repeat(row, count)
    start = np.repeat(np.cumsum(count) - count, count)
    return repeated, np.repeat(first, count) + np.arange(len(repeated)) - start


def unbalanced(
    polygons: Sequence[FloatArray],
    loads: FloatArray,
    free: IntArray,
    *,
    friction: float,
    cohesion: float = 0.0,
    reach: float,
    size: float,
) -> float:
    """Return the least sum of loads that contact forces leave out of balance, over the mean load of a free block.

    Parameters
    ----------
    polygons : sequence of (k, 2) float64 [m]
        All blocks that are there.
    loads : (n, 3) float64 [N/m, N/m, N]
        On each of them, moments about its centroid.
    free : (k,) int64
        Blocks that must be in balance.
    friction, cohesion : float [degrees, Pa]
        Of all contacts.
    reach : float [m]
        What is nearer touches.
    size : float [m]
        Of a block: moments count over it.
    """
    contacts = touching(polygons, reach, size)
    centre = np.array([polygon_centre(polygon) for polygon in polygons])
    scale = np.hypot(*loads[free, :2].T).mean() if len(free) else 0.0
    if scale == 0:
        return 0.0
    columns = _columns(contacts, centre, np.tan(np.radians(friction)), size, is_cohesive=cohesion > 0)
    rows = (3 * free[:, None] + np.arange(3)).reshape(-1)
    balance = columns.tocsr()[rows]
    right = -((loads * (1.0, 1.0, 1 / size))[free] / scale).reshape(-1)
    slack = eye_array(len(rows), format="csr")
    whole = hstack([balance, slack, -slack], format="csr")
    most = cohesion * contacts.length / scale
    bounds = [(0.0, None)] * (2 * len(contacts.length))
    bounds += [(-limit, limit) for limit in most.tolist()] if cohesion > 0 else []
    bounds += [(0.0, None)] * (2 * len(rows))
    cost = np.zeros(whole.shape[1])
    cost[balance.shape[1] :] = 1.0
    answer = linprog(cost, A_eq=whole, b_eq=right, bounds=bounds, method="highs")
    if answer.status != 0:
        raise RuntimeError(f"the linear program of statics was not solved: {answer.message}")
    return float(answer.fun)


def _columns(contacts: Touching, centre: FloatArray, slope: float, size: float, *, is_cohesive: bool) -> coo_array:
    """Return what unit forces along both edges of each friction cone, and shears, give the blocks (3n rows)."""
    n = contacts.normal
    tangent = n[:, ::-1] * (-1.0, 1.0)
    directions = [slope * tangent - n, -slope * tangent - n, *([tangent] if is_cohesive else [])]
    m = len(n)
    rows, cols, values = [], [], []
    for k, direction in enumerate(directions):
        for block, sign in ((contacts.edge_block, 1.0), (contacts.corner_block, -1.0)):
            arm = contacts.point - centre[block]
            moment = (arm[:, 0] * direction[:, 1] - arm[:, 1] * direction[:, 0]) / size
            rows.append(3 * block[:, None] + np.arange(3))
            cols.append(np.repeat((k * m + np.arange(m))[:, None], 3, axis=1))
            values.append(sign * np.column_stack([direction, moment]))
    row, col, value = (np.concatenate(part).reshape(-1) for part in (rows, cols, values))
    return coo_array((value, (row, col)), shape=(3 * len(centre), len(directions) * m))


def weights(polygons: Sequence[FloatArray], unit_weight: float, degrees: float) -> FloatArray:
    """Return the weights as loads, (n, 3)."""
    down = np.array([np.cos(np.radians(degrees)), np.sin(np.radians(degrees)), 0.0])
    areas = np.array([polygon_area(polygon) for polygon in polygons])
    return np.asarray(unit_weight * areas[:, None] * down, dtype=np.float64)
