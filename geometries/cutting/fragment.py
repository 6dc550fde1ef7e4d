"""The Gmsh engine: outlines and traces fragmented by Open CASCADE, each child curve known by its parent."""

from __future__ import annotations

from typing import Any

import numpy as np

from bsm_mesh.geometries.cutting.ends import Lines
from bsm_mesh.geometries.cutting.graph import Graph
from bsm_mesh.geometries.cutting.pieces import IntArray
from bsm_mesh.geometries.joint_sets import FloatArray
from bsm_mesh.geometries.session import gmsh_session


def node_by_gmsh(lines: Lines, tolerance: float) -> Graph:
    """Return the graph of the pieces; curves are identified by the map of children that `fragment` returns."""
    options = {"Geometry.Tolerance": tolerance, "Geometry.ToleranceBoolean": tolerance}
    with gmsh_session("joints", options) as gmsh:
        occ = gmsh.model.occ
        curves, parent = _add_lines(occ, lines)
        _, children = occ.fragment(curves[:1], curves[1:])
        occ.synchronize()
        at = {tag: np.array(gmsh.model.getValue(0, tag, []))[:2] for _, tag in gmsh.model.getEntities(0)}
        found, owner = _curves_of_pieces(gmsh, children, parent)
    points = np.array([at[tag] for tag in sorted(at)])
    number = {tag: k for k, tag in enumerate(sorted(at))}
    pairs = np.array([(number[a], number[b]) for a, b in found], dtype=np.int64).reshape(-1, 2)
    return _as_graph(points, pairs, np.array(owner, dtype=np.int64), tolerance)


def _add_lines(occ: Any, lines: Lines) -> tuple[list[tuple[int, int]], list[int]]:
    """Add a line between each two vertices of a piece; return them, and the piece of each."""
    places, number = np.unique(lines.vertices, axis=0, return_inverse=True)
    tags = [occ.addPoint(x, y, 0.0) for x, y in places]
    at = [tags[k] for k in number.reshape(-1)]
    follows = np.flatnonzero((lines.owner[1:] == lines.owner[:-1]) & (number[1:] != number[:-1]).reshape(-1))
    return [(1, occ.addLine(at[k], at[k + 1])) for k in follows], lines.owner[follows].tolist()


def _curves_of_pieces(
    gmsh: Any, children: list[list[tuple[int, int]]], parent: list[int]
) -> tuple[list[tuple[int, int]], list[int]]:
    """Return the end points of each child curve, and the piece that it is a part of."""
    ends: dict[int, tuple[int, int]] = {}
    curves, owner = [], []
    for piece, parts in zip(parent, children, strict=True):
        for dimension, tag in parts:
            if dimension != 1:
                continue
            if tag not in ends:
                first, last = (t for _, t in gmsh.model.getBoundary([(1, tag)], oriented=False))
                ends[tag] = (first, last)
            curves.append(ends[tag])
            owner.append(piece)
    return curves, owner


def _as_graph(points: FloatArray, pairs: IntArray, owner: IntArray, tolerance: float) -> Graph:
    """Return the graph; its points on the cutter's grid, so that both engines number and place them alike."""
    import shapely

    on_grid = shapely.get_coordinates(shapely.set_precision(shapely.points(points), tolerance))
    _, number = np.unique(on_grid[:, ::-1], axis=0, return_inverse=True)  # by y, then x, as the cutter numbers them
    found = np.empty((number.max() + 1, 2))
    found[number.reshape(-1)] = on_grid
    ends = np.sort(number.reshape(-1)[pairs], axis=1)
    longer = ends[:, 0] != ends[:, 1]
    edges, edge = np.unique(ends[longer], axis=0, return_inverse=True)
    key = np.unique(edge.reshape(-1) * (owner.max() + 1) + owner[longer])
    return Graph(points=found, edges=edges, edge=key // (owner.max() + 1), piece=key % (owner.max() + 1))
