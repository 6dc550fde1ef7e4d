"""The shapely engine: pieces divided where they meet, on a grid, for very many joints.

Snap rounding (Hobby 1999), by GEOS: points nearer than the grid are made to touch, so that no two joints leave a
gap or a block thinner than the grid. The grid settles who meets whom; the points then go back onto the pieces.
"""

from __future__ import annotations

import numpy as np

from bsm_mesh.geometries.cutting.ends import Lines
from bsm_mesh.geometries.cutting.graph import Graph, match_edges
from bsm_mesh.geometries.cutting.pieces import IntArray
from bsm_mesh.geometries.joint_sets import FloatArray

REACH = 0.75  # tolerances: half the diagonal of a cell of the grid, as far as an edge may lie off its piece


def node_by_shapely(lines: Lines, tolerance: float) -> Graph:
    """Return the graph of the pieces, its points on a grid of the tolerance."""
    import shapely

    drawn = shapely.linestrings(lines.vertices, indices=lines.owner)
    noded = shapely.get_parts(shapely.unary_union(drawn, grid_size=tolerance))
    noded = noded[shapely.get_type_id(noded) == shapely.GeometryType.LINESTRING]
    coordinates, line = shapely.get_coordinates(noded, return_index=True)
    follows = line[1:] == line[:-1]
    points, edges = number_points(np.stack([coordinates[:-1][follows], coordinates[1:][follows]], axis=1))
    edge, piece = match_edges(points[edges], lines.pieces, REACH * tolerance)
    return Graph(points=points, edges=edges, edge=edge, piece=piece)


def number_points(ends: FloatArray) -> tuple[FloatArray, IntArray]:
    """Return the distinct points of edges given by their ends, and the edges by point, each once."""
    flat = ends.reshape(-1, 2)
    order = np.lexsort(flat.T)
    new = np.any(flat[order][1:] != flat[order][:-1], axis=1)
    number = np.empty(len(flat), dtype=np.int64)
    number[order] = np.concatenate([[0], np.cumsum(new)])
    points = flat[order][np.concatenate([[True], new])]
    edges = np.sort(number.reshape(-1, 2), axis=1)
    return points, np.unique(edges[edges[:, 0] != edges[:, 1]], axis=0)
