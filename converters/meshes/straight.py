"""Lines of a mesh made straight again, whose nodes the digits of a file moved.

A file of another program has its coordinates to a few digits, and a map's coordinates leave a nanometre to a double. So
nodes on one joint lie near its line, and faces of one plane are not parallel: by a hair, but two faces that are not
parallel wedge whatever slides between them, and no mechanism is proved. What lies on one line to the digits of the file
is put on it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray, rounding_of
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.model.edges import LongArray
from bsm_mesh.model.polygons import next_corner, polygon_moments

EPSILON = float(np.finfo(np.float64).eps)
OFF_LINE = 3.0  # half units of the last digit: a node and both its neighbours are each up to 1.4 beside their places
PART = 1e-3  # of the shorter edge at a node: kinks beyond are meant, and coarser digits are those of a grid
FIRM, PASSES = 1e6, 20  # weight of points where three lines or more cross; fits, of which four are usual
CROSSING = 1e-3  # least square of the sine of two lines in whose crossing a node is put
MESHED = 3e-3  # of the merge tolerance: what meshers leave of points on a line
SHRINKS = 0.5  # of its area: what a block keeps at least
MOST_DECIMALS = 17


@dataclass(frozen=True, slots=True)
class Precision:
    """How exactly the coordinates of a mesh are known.

    Attributes
    ----------
    digits : float [m]
        Half a unit of the last digit of the greatest coordinates in the file.
    rounding : float [m]
        What computing with such coordinates leaves.
    """

    digits: float
    rounding: float

    @classmethod
    def of(cls, coordinates: FloatArray, unit: float = 1.0, tolerance: float = 0.0) -> Precision:
        """Return the precision of coordinates, any shape, as a file has them, in a unit [m].

        Decimals of the greatest ones count: of numbers with as many digits each, smaller ones have more. No digits
        count that are far below the `tolerance` [m], within which points are one: a mesher leaves its own.
        """
        size = np.abs(np.unique(coordinates))
        greatest = float(size.max(initial=0.0))
        large = size[size >= greatest / 10]
        rounding = rounding_of(size)
        digits = greatest * 2.0**-25 if np.array_equal(large, large.astype(np.float32)) else 0.0  # of single precision
        for decimals in range(MOST_DECIMALS):
            units = large * 10.0**decimals
            if np.abs(units - np.rint(units)).max(initial=0.0) <= 2 * EPSILON * greatest * 10.0**decimals:
                digits = max(digits, 0.5 * 10.0**-decimals)
                break
        return cls(digits=max(digits * unit, MESHED * tolerance), rounding=rounding * unit)


def straightened(blocks: Blocks, edges: LongArray, precision: Precision) -> Blocks:
    """Return blocks whose edges in one line, to the digits of their coordinates, are in one line to rounding.

    Parameters
    ----------
    blocks : Blocks
        The blocks; corners at one point move together.
    edges : (k,) int64
        Their edges that bound a block of the model.
    precision : Precision
        Of their coordinates.
    """
    _, first, corner = np.unique(blocks.nodes, return_index=True, return_inverse=True)
    corner = corner.reshape(-1)  # the point of every corner
    points = straight_points(blocks.vertices[first], corner, blocks.offsets, edges, precision)
    if np.array_equal(points, blocks.vertices[first]):
        return blocks
    return replace(blocks, vertices=points[corner])


def straight_points(
    points: FloatArray, corners: IntArray, offsets: IntArray, edges: LongArray, precision: Precision
) -> FloatArray:
    """Return points (n, 2) so moved that edges in one line, to the digits of their coordinates, are so to rounding.

    Parameters
    ----------
    points : (n, 2) float64 [m]
        Where corners of outlines are.
    corners, offsets : (m,), (k + 1,) int
        Outline b has the corners ``corners[offsets[b]:offsets[b + 1]]``, counter-clockwise.
    edges : (e,) int64
        Which edges, by the number of the corner where they begin.
    precision : Precision
        Of the coordinates.
    """
    middle = points[corners].mean(axis=0)
    here = points - middle
    ends = np.sort(np.column_stack([corners[edges], corners[next_corner(offsets)[edges]]]), axis=1)
    ends, beside = np.unique(ends, axis=0, return_counts=True)
    there = here + _moves(here, _split(here, ends.astype(np.int64), beside == 1, precision), precision)
    there = _without_inversions(corners, offsets, here, there)
    return np.where(there != here, there + middle, points)


def _split(points: FloatArray, ends: LongArray, alone: BoolArray, precision: Precision) -> LongArray:
    """Return edges with ends (k, 2), those that are `alone`, (k,), in parts where a corner of others lies on them."""
    import shapely

    edge = np.flatnonzero(alone)
    if not len(edge):
        return ends
    start, along = points[ends[edge, 0]], points[ends[edge, 1]] - points[ends[edge, 0]]
    length = np.hypot(*along.T)
    reach = np.maximum(np.minimum(OFF_LINE * precision.digits, PART * length), precision.rounding)
    near = np.unique(ends[edge])
    tree = shapely.STRtree(shapely.points(points[near]))
    lines = shapely.linestrings(np.stack([start, start + along], axis=1))
    which, point = tree.query(lines, predicate="dwithin", distance=reach)
    point = near[point]
    place = ((points[point] - start[which]) * along[which]).sum(axis=1) / length[which]
    within = (place > reach[which]) & (place < length[which] - reach[which])
    which, point, place = which[within], point[within], place[within]
    if not len(which):
        return ends
    cut = np.unique(which)
    rows = np.concatenate([which, cut, cut])  # of every cut edge its points and both its ends, in their order
    nodes = np.concatenate([point, ends[edge[cut], 0], ends[edge[cut], 1]])
    order = np.lexsort([np.concatenate([place, np.zeros(len(cut)), length[cut]]), rows])
    rows, nodes = rows[order], nodes[order]
    follows = rows[1:] == rows[:-1]
    parts = np.column_stack([nodes[:-1], nodes[1:]])[follows]
    return np.unique(np.concatenate([np.delete(ends, edge[cut], axis=0), np.sort(parts, axis=1)]), axis=0)


def _moves(points: FloatArray, ends: LongArray, precision: Precision) -> FloatArray:
    """Return by how much points (n, 2) move on to the lines on which edges with ends (k, 2) lie.

    Lines through a point where three or more cross are fitted anew through where it was put.
    """
    of_edge, count = _lines(points, ends, precision)
    line, point = np.unique(np.column_stack([np.repeat(of_edge, 2), ends.reshape(-1)]), axis=0).T
    farthest, is_line = np.zeros(count), np.bincount(line, minlength=count) > 2
    np.maximum.at(farthest, line, np.abs(_fitted(points, line, point, count)[1]))
    longest = np.zeros(count)
    np.maximum.at(longest, of_edge, np.hypot(*(points[ends[:, 1]] - points[ends[:, 0]]).T))
    allowed = np.minimum(OFF_LINE * precision.digits, PART * longest)
    straight = is_line & (farthest <= np.maximum(allowed, precision.rounding))
    point, line = point[straight[line]], line[straight[line]]
    crossings = np.bincount(point, minlength=len(points))
    needless = np.zeros(count, dtype=np.bool_)  # of two edges, where longer lines say where their point is
    needless[line[(crossings[point] > 2) & (np.bincount(line, minlength=count)[line] == 3)]] = True
    point, line = point[~needless[line]], line[~needless[line]]
    there = points.copy()
    if (farthest[line] <= precision.rounding).all():
        return there - points
    weight = np.where(np.bincount(point, minlength=len(points)) > 2, FIRM, 1.0)
    for _ in range(PASSES):
        normal, distance = _fitted(there, line, point, count, weight)
        if np.abs(distance).max() <= EPSILON * np.abs(points).max():
            break
        there += _on_lines(point, normal[line], distance, len(points))
    return there - points


def _lines(points: FloatArray, ends: LongArray, precision: Precision) -> tuple[LongArray, int]:
    """Return the line of every edge, (k,), and their number: edges that go straight on at a point have the same."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    at = np.concatenate([ends[:, 0], ends[:, 1]])
    to = np.concatenate([ends[:, 1], ends[:, 0]])
    edge = np.tile(np.arange(len(ends)), 2)
    order = np.argsort(at, kind="stable")
    at, to, edge = at[order], to[order], edge[order]
    arm = points[to] - points[at]
    length = np.hypot(*arm.T)
    allowed = OFF_LINE * precision.digits
    pairs: list[tuple[LongArray, LongArray]] = []
    for one, other in _pairs_at(at):
        u, v = arm[one], arm[other]
        off = np.abs(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]) / np.hypot(*(u - v).T)
        most = np.maximum(np.minimum(allowed, PART * np.minimum(length[one], length[other])), precision.rounding)
        on = ((u * v).sum(axis=1) < 0) & (off <= most)
        pairs.append((edge[one[on]], edge[other[on]]))
    first, second = (np.concatenate(part) for part in zip(*pairs, strict=True)) if pairs else (edge[:0], edge[:0])
    graph = coo_array((np.ones(len(first), dtype=np.int8), (first, second)), shape=(len(ends), len(ends)))
    count, line = connected_components(graph, directed=False)
    return line.astype(np.int64), int(count)


def _pairs_at(at: LongArray) -> Iterator[tuple[LongArray, LongArray]]:
    """Return all pairs of rows with the same number in a sorted column, those k rows apart for every k."""
    rows = np.arange(len(at))
    for apart in range(1, len(at)):
        one = rows[:-apart]
        one = one[at[one] == at[one + apart]]
        if not len(one):
            return
        yield one, one + apart


def _fitted(
    points: FloatArray, line: LongArray, point: LongArray, count: int, weight: FloatArray | None = None
) -> tuple[FloatArray, FloatArray]:
    """Return unit normals of lines fitted to their points (count, 2), and how far each point (k,) is off its line [m].

    Least squares of the distances, of points with weights (n,); `line` and `point` (k,) say which is on which line.
    """
    w = np.ones(len(point)) if weight is None else weight[point]

    def sums(values: FloatArray) -> FloatArray:
        return np.bincount(line, w * values, minlength=count).astype(np.float64)

    whole = np.maximum(sums(np.ones(len(point))), 1.0)
    x, y = points[point].T
    x, y = x - (sums(x) / whole)[line], y - (sums(y) / whole)[line]
    xx, xy, yy = sums(x * x), sums(x * y), sums(y * y)
    angle = 0.5 * np.arctan2(2 * xy, xx - yy)
    normal = np.column_stack([-np.sin(angle), np.cos(angle)])
    distance = x * normal[line, 0] + y * normal[line, 1]
    # once more: the sums of squares know the angle to the root of rounding
    along = x * normal[line, 1] - y * normal[line, 0]
    turn = sums(along * distance) / np.maximum(sums(along * along), np.finfo(np.float64).tiny)
    normal = normal - turn[:, None] * np.column_stack([normal[:, 1], -normal[:, 0]])
    normal /= np.hypot(*normal.T)[:, None]
    return normal, x * normal[line, 0] + y * normal[line, 1]


def _on_lines(point: LongArray, normal: FloatArray, distance: FloatArray, count: int) -> FloatArray:
    """Return the least moves (count, 2) of points on to their lines; of two, to where they cross."""
    a, b, c = (np.bincount(point, normal[:, i] * normal[:, j], minlength=count) for i, j in ((0, 0), (0, 1), (1, 1)))
    right = np.column_stack([np.bincount(point, -distance * normal[:, k], minlength=count) for k in (0, 1)])
    determinant = a * c - b * b
    crosses = determinant > CROSSING * (a + c) ** 2 / 4
    safe = np.where(crosses, determinant, 1.0)
    both = np.column_stack([c * right[:, 0] - b * right[:, 1], a * right[:, 1] - b * right[:, 0]]) / safe[:, None]
    one = right / np.maximum(a + c, 1.0)[:, None]
    moves: FloatArray = np.where(crosses[:, None], both, one)
    return moves


def _without_inversions(corners: IntArray, offsets: IntArray, points: FloatArray, moved: FloatArray) -> FloatArray:
    """Return moved points (n, 2), those of outlines that would lose much of their area left where they were."""
    if np.array_equal(moved, points):
        return points
    least = SHRINKS * polygon_moments(points[corners], offsets).area
    while (thin := polygon_moments(moved[corners], offsets).area < least).any():
        kept = np.zeros(len(points), dtype=np.bool_)
        kept[corners[np.repeat(thin, np.diff(offsets))]] = True
        if not (moved[kept] != points[kept]).any():
            return points
        moved = np.where(kept[:, None], points, moved)
    return moved
