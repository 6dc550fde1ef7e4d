"""Points and the edges between them, each edge with the pieces that it lies on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bsm_mesh.geometries.cutting.pieces import IntArray, Pieces
from bsm_mesh.geometries.joint_sets import FloatArray

SHARE = 0.4  # of the shortest edge at a point: it moves no further
LEAST_SINE = 1e-9  # of the angle of two lines that are taken to cross


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Graph:
    """The pieces, divided wherever they meet.

    Attributes
    ----------
    points : (n_points, 2) float64 [m]
        Where edges end.
    edges : (n_edges, 2) int64
        Points at the ends of each edge, the lower number first.
    edge, piece : (k,) int64
        Edge ``edge[i]`` lies on piece ``piece[i]``; sorted by edge, then piece.
    """

    points: FloatArray
    edges: IntArray
    edge: IntArray
    piece: IntArray

    @property
    def length(self) -> FloatArray:
        """Length of every edge [m]."""
        length: FloatArray = np.hypot(*(self.points[self.edges[:, 1]] - self.points[self.edges[:, 0]]).T)
        return length

    def without(self, edges: IntArray) -> Graph:
        """Return the graph without some edges; points keep their numbers."""
        left = np.ones(len(self.edges), dtype=np.bool_)
        left[edges] = False
        number, there = np.cumsum(left) - 1, left[self.edge]
        return Graph(points=self.points, edges=self.edges[left], edge=number[self.edge[there]], piece=self.piece[there])


def match_edges(ends: FloatArray, pieces: Pieces, tolerance: float) -> tuple[IntArray, IntArray]:
    """Return which edges lie on which pieces, sorted by edge, then piece.

    Parameters
    ----------
    ends : (n_edges, 2, 2) float64 [m]
        Both ends of every edge.
    pieces : Pieces
        The pieces.
    tolerance : float [m]
        Greatest distance of both ends of an edge from the piece that it lies on.
    """
    import shapely

    chunks, owner = pieces.chunks(4 * tolerance)
    tree = shapely.STRtree(shapely.points(ends.mean(axis=1)))
    chunk, edge = tree.query(shapely.linestrings(chunks), predicate="dwithin", distance=tolerance)
    piece = owner[chunk]
    relative = ends[edge] - pieces.ends[piece, 0][:, None]
    direction = pieces.direction[piece]
    along = np.einsum("nij,nj->ni", relative, direction)
    off = np.abs(relative[..., 0] * direction[:, None, 1] - relative[..., 1] * direction[:, None, 0])
    slack = pieces.length[piece] + tolerance
    good = (off.max(axis=1) <= tolerance) & (along.min(axis=1) >= -tolerance) & (along.max(axis=1) <= slack)
    key = np.unique(edge[good] * len(pieces.ends) + piece[good])
    return key // len(pieces.ends), key % len(pieces.ends)


def place_points(graph: Graph, pieces: Pieces, tolerance: float) -> tuple[FloatArray, FloatArray]:
    """Return the points where the pieces themselves cross, not where a grid has rounded them to, and on the grid.

    The second are as near to the grid as may be without a change of an outline.

    A point on two pieces goes to their intersection, one on a single piece onto that piece, a corner of an
    outline and a dead end to themselves, so that outlines keep their area.
    """
    import shapely

    key = np.unique(graph.edges[graph.edge].T.ravel() * len(pieces.ends) + np.tile(graph.piece, 2))
    node, piece = key // len(pieces.ends), key % len(pieces.ends)
    order = np.lexsort([piece, pieces.region[piece] < 0, node])  # outlines before traces
    node, piece = node[order], piece[order]
    begin = np.flatnonzero(np.concatenate([[True], node[1:] != node[:-1]]))
    first = np.repeat(piece[begin], np.diff(np.append(begin, len(node))))
    u, v = pieces.direction[first], pieces.direction[piece]
    sine = np.abs(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0])
    steepest = np.lexsort([sine, node])[np.append(begin[1:], len(node)) - 1]
    at, one, other = node[begin], piece[begin], piece[steepest]
    placed = graph.points.copy()
    foot = _foot(graph.points[at], pieces, one)
    crossing = _crossing(foot, pieces, one, other)
    # Lines on a grid that cross at a small angle meet further from where the lines themselves do.
    shortest = np.full(len(graph.points), np.inf)
    np.minimum.at(shortest, graph.edges.T.ravel(), np.tile(graph.length, 2))
    slant = np.minimum(1.5 * tolerance / np.maximum(sine[steepest], LEAST_SINE), SHARE * shortest[at])
    near = np.hypot(*(foot - graph.points[at]).T) <= 1.5 * tolerance
    placed[at[near]] = foot[near]
    rounded = graph.points.copy()
    near &= pieces.region[one] >= 0
    rounded[at[near]] = foot[near]
    near = np.hypot(*(crossing - graph.points[at]).T) <= np.maximum(slant, 1.5 * tolerance)
    placed[at[near]] = crossing[near]
    corners = np.concatenate([pieces.ends.reshape(-1, 2), pieces.ends[pieces.region >= 0, 0]])
    tree = shapely.STRtree(shapely.points(graph.points))
    corner, nearest = tree.query_nearest(shapely.points(corners), max_distance=1.5 * tolerance, all_matches=False)
    degree = np.bincount(graph.edges.ravel(), minlength=len(graph.points))
    kept = (degree[nearest] == 1) | (corner >= 2 * len(pieces.ends))
    placed[nearest[kept]] = rounded[nearest[kept]] = corners[corner[kept]]
    return placed, rounded


def _foot(points: FloatArray, pieces: Pieces, one: IntArray) -> FloatArray:
    """Return the nearest points of pieces `one`."""
    start, direction = pieces.ends[one, 0], pieces.direction[one]
    along = np.clip(np.einsum("nj,nj->n", points - start, direction), 0.0, pieces.length[one])
    foot: FloatArray = start + along[:, None] * direction
    return foot


def _crossing(foot: FloatArray, pieces: Pieces, one: IntArray, other: IntArray) -> FloatArray:
    """Return where pieces `one`, on which `foot` lies, cross pieces `other`; not-a-number where they do not."""
    u, v = pieces.direction[one], pieces.direction[other]
    cross = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    cross = np.where(np.abs(cross) < LEAST_SINE, np.nan, cross)
    gap = pieces.ends[other, 0] - foot
    crossing: FloatArray = foot + ((gap[:, 0] * v[:, 1] - gap[:, 1] * v[:, 0]) / cross)[:, None] * u
    return crossing
