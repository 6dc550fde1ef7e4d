"""Blocks thinner than the tolerance, joined to a neighbour: one engine may close such a triangle that another opens."""

from __future__ import annotations

import numpy as np

from bsm_mesh.geometries.cutting.faces import Faces, enclose_faces
from bsm_mesh.geometries.cutting.graph import Graph
from bsm_mesh.geometries.cutting.pieces import BoolArray, IntArray, Pieces
from bsm_mesh.geometries.joint_sets import FloatArray
from bsm_mesh.geometries.rock_mass import RockMass

THINNEST = 2.0  # tolerances: mean width of a sliver, by which two lines that each may move by one touch
MOST_ROUNDS = 5  # of joining slivers to slivers


def join_slivers(
    graph: Graph, faces: Faces, region: IntArray, points: FloatArray, pieces: Pieces, mass: RockMass
) -> tuple[Graph, Faces, IntArray, int]:
    """Return graph, faces and their regions without slivers, and how many these were.

    The longest side of a sliver that is a trace with rock on both sides is taken away. Outlines of regions stay, and
    slivers that have nothing else.
    """
    count = 0
    for _ in range(MOST_ROUNDS):
        edges = _sides_to_open(graph, faces, points, pieces, mass.grid)
        if not edges.size:
            break
        before = faces.count
        graph = graph.without(edges)
        faces, region = enclose_faces(graph, mass)
        count += before - faces.count
    return graph, faces, region, count


def _sides_to_open(graph: Graph, faces: Faces, points: FloatArray, pieces: Pieces, grid: float) -> IntArray:
    """Return the longest side of every sliver that may be taken away."""
    thin = 2 * faces.areas(points) < THINNEST * grid * faces.perimeters(points)
    if not thin.any():
        return np.empty(0, np.int64)
    edge, owner = faces.edge_faces(graph)
    of_trace: BoolArray = np.bincount(graph.edge, pieces.region[graph.piece] >= 0, minlength=len(graph.edges)) == 0
    shared = np.bincount(edge, minlength=len(graph.edges)) == 2
    mine = thin[owner] & (of_trace & shared)[edge]
    edge, owner = edge[mine], owner[mine]
    length = np.hypot(*(points[graph.edges[edge, 1]] - points[graph.edges[edge, 0]]).T)
    order = np.lexsort([-length, owner])
    _, first = np.unique(owner[order], return_index=True)
    return np.unique(edge[order[first]])
