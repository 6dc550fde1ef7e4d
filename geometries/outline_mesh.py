"""Triangles inside given outlines, of a given size, by Gmsh."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from bsm_mesh.geometries.errors import GeometryError
from bsm_mesh.geometries.session import gmsh_session

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int_]
LINE, TRIANGLE = 1, 2  # Gmsh's numbers of these elements


@dataclass(frozen=True, slots=True, kw_only=True)
class OutlineMesher:
    """Fills outlines with triangles.

    Attributes
    ----------
    size : float [m]
        Greatest side of the triangles, about. Lines of outlines are cut into equal parts no longer than that; none of
        them is ever merged.

    Raises
    ------
    GeometryError
        If the size is not positive.
    """

    size: float

    def __post_init__(self) -> None:
        if not 0 < self.size < np.inf:
            raise GeometryError(f"size = {self.size!r} must be a length above 0 m")

    def __call__(
        self, points: Floats, lines: Ints, sides: Ints, offsets: Ints
    ) -> tuple[Floats, Ints, Ints, Ints, Ints]:
        """Return the points and triangles inside outlines, and the points along every line.

        Parameters
        ----------
        points : (n, 2) float64 [m]
            Ends of lines.
        lines : (l, 2) int
            The different lines, by their ends.
        sides : (s,) int
            Lines of all outlines, one after the other, counted from 1; negative where run against their direction.
        offsets : (k + 1,) int
            Outline i has the sides ``offsets[i]:offsets[i + 1]``, counter-clockwise.

        Returns
        -------
        points : (m, 2) float64 [m]
            Of the mesh.
        triangles : (t, 3) int
            Their corners.
        outline : (t,) int
            The outline in which each lies.
        along : (a,) int
            Points along the lines, from the first end to the second, line after line.
        start : (l + 1,) int
            Line i has the points ``along[start[i]:start[i + 1]]``.

        Raises
        ------
        GeometryError
            If Gmsh cannot fill them.
        """
        length = np.hypot(*(points[lines[:, 1]] - points[lines[:, 0]]).T)
        parts = np.ceil(length / self.size * (1 - 1e-9)).astype(np.int64)
        with gmsh_session("outlines", {"Mesh.MeshSizeExtendFromBoundary": 1, "Mesh.MeshSizeMax": self.size}) as gmsh:
            geo = gmsh.model.geo
            for number, (x, y) in enumerate(points.tolist(), start=1):
                geo.addPoint(x, y, 0.0, self.size, number)
            for number, (first, last) in enumerate((lines + 1).tolist(), start=1):
                geo.addLine(first, last, number)
            for number, own in enumerate(np.split(sides, offsets[1:-1]), start=1):
                geo.addCurveLoop(own.tolist(), number)
                geo.addPlaneSurface([number], number)
            geo.synchronize()
            for number, count in enumerate(parts.tolist(), start=1):
                gmsh.model.mesh.setTransfiniteCurve(number, count + 1)
            gmsh.model.mesh.generate(2)
            tags, where, _ = gmsh.model.mesh.getNodes()
            of_lines, of_outlines = (
                [gmsh.model.mesh.getElementsByType(kind, number)[1] for number in range(1, count + 1)]
                for kind, count in ((LINE, len(lines)), (TRIANGLE, len(offsets) - 1))
            )
        place = np.zeros(int(tags.max()) + 1, dtype=np.int64)
        place[tags.astype(np.int64)] = np.arange(len(tags))
        counts = np.array([len(found) // 3 for found in of_outlines])
        triangles = place[np.concatenate(of_outlines).astype(np.int64)].reshape(-1, 3)
        pieces = place[np.concatenate(of_lines).astype(np.int64)].reshape(-1, 2)
        last = np.cumsum(parts)
        along = np.insert(pieces[:, 0], last, pieces[last - 1, 1])
        start = np.concatenate([[0], np.cumsum(parts + 1)])
        return where.reshape(-1, 3)[:, :2].copy(), triangles, np.repeat(np.arange(len(counts)), counts), along, start
