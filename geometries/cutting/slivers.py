"""Blocks thinner than the tolerance, joined to a neighbour: one engine may close such a triangle that another opens."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bsm_mesh.geometries.cutting.faces import Faces, enclose_faces
from bsm_mesh.geometries.cutting.graph import Graph
from bsm_mesh.geometries.cutting.pieces import BoolArray, IntArray, Pieces
from bsm_mesh.geometries.joint_sets import FloatArray
from bsm_mesh.geometries.rock_mass import RockMass

# Tolerances: mean width of a sliver, by which two lines that each may move by one touch. Measured in performance.md.
THINNEST = 2.0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Joined:
    """The slivers that were joined or left.

    Attributes
    ----------
    count : int
        How many were joined to a neighbour.
    lengths : (n_joints,) float64 [m]
        Length of the sides taken away, of each joint: they lie on another joint, to the tolerance.
    """

    count: int
    lengths: FloatArray


def join_slivers(
    graph: Graph, faces: Faces, region: IntArray, points: FloatArray, pieces: Pieces, mass: RockMass
) -> tuple[Graph, Faces, IntArray, Joined]:
    """Return graph, faces and their regions without slivers, and the joined regions.

    The longest side of a sliver that is a trace with rock on both sides is taken away. Outlines of regions stay, and
    slivers that have nothing else.
    """
    count, lengths = 0, np.zeros(len(pieces.joint_names))
    while (edges := _sides_to_open(graph, faces, points, pieces, mass.grid)).size:  # slivers may join to a sliver
        before = faces.count
        here = np.isin(graph.edge, edges)
        ends = points[graph.edges[graph.edge[here]]]
        np.add.at(lengths, pieces.joint[graph.piece[here]], np.hypot(*(ends[:, 1] - ends[:, 0]).T))
        graph = graph.without(edges)
        faces, region = enclose_faces(graph, mass)
        count += before - faces.count
    return graph, faces, region, Joined(count=count, lengths=lengths)


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
