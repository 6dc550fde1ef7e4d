"""Hidden surfaces by a depth buffer: the nearest of many triangles in every point of a grid."""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.compiled import njit
from bsm_mesh.three_d.blocks.moments import fan_triangles

FLAT = 0.985  # cosine: faces of a block that bend less have no edge between them
STRIPE = 14  # points of the grid between the lines of a hatch


@njit()
def fill(
    corners: FloatArray, face: IntArray, owner: IntArray, depth: FloatArray
) -> None:  # pragma: no cover - compiled
    """Write the nearest triangle's face into the points of a grid that it covers, and its distance.

    Parameters
    ----------
    corners : (t, 3, 3) float64
        Column and row in the grid, and distance from the viewer, of the corners of each triangle.
    face : (t,) int64
        The number that is written.
    owner : (rows, columns) int64
        The nearest face so far; -1: none.
    depth : (rows, columns) float64
        Its distance; infinite: none.
    """
    rows, columns = owner.shape
    for t in range(corners.shape[0]):
        x0, y0, z0 = corners[t, 0]
        x1, y1, z1 = corners[t, 1]
        x2, y2, z2 = corners[t, 2]
        twice = (x1 - x0) * (y2 - y0) - (x2 - x0) * (y1 - y0)
        if twice == 0.0:
            continue
        low = max(0, int(np.ceil(min(y0, y1, y2))))
        high = min(rows - 1, int(np.floor(max(y0, y1, y2))))
        left = max(0, int(np.ceil(min(x0, x1, x2))))
        right = min(columns - 1, int(np.floor(max(x0, x1, x2))))
        for row in range(low, high + 1):
            for column in range(left, right + 1):
                first = ((x1 - column) * (y2 - row) - (x2 - column) * (y1 - row)) / twice
                second = ((x2 - column) * (y0 - row) - (x0 - column) * (y2 - row)) / twice
                third = 1.0 - first - second
                if first < 0.0 or second < 0.0 or third < 0.0:
                    continue
                away = first * z0 + second * z1 + third * z2
                if away <= depth[row, column]:  # of faces in one place the last
                    depth[row, column] = away
                    owner[row, column] = face[t]


@njit()
def shade(
    face: IntArray,
    depth: FloatArray,
    normal: FloatArray,
    part: IntArray,
    colour: FloatArray,
    ink: FloatArray,
    hatched: IntArray,
    step: float,
    image: FloatArray,
) -> None:  # pragma: no cover - compiled
    """Write the colour and the opacity of every point of a grid.

    Parameters
    ----------
    face : (rows, columns) int64
        The face that is seen; -1: none.
    depth : (rows, columns) float64
        Its distance.
    normal : (n, 3) float64
        Unit normals of the faces.
    part : (n,) int64
        Block of each face.
    colour, ink : (n, 3) float64
        Colour of the faces and of edges on them; a negative ink: no edges.
    hatched : (n,) int64
        Which are hatched.
    step : float
        Neighbours whose distance differs by more have an outline between them.
    image : (rows, columns, 4) float32
        Red, green, blue, opacity.
    """
    rows, columns = face.shape
    for row in range(rows):
        for column in range(columns):
            f = face[row, column]
            outline, edge = False, False
            for k in range(4):
                y, x = row + (k == 0) - (k == 1), column + (k == 2) - (k == 3)
                if y < 0 or x < 0 or y == rows or x == columns or face[y, x] == f:
                    continue
                g = face[y, x]
                if f < 0 or g < 0 or abs(depth[y, x] - depth[row, column]) > step:
                    outline = True
                elif ink[f, 0] >= 0 and ink[g, 0] >= 0:
                    cosine = normal[f, 0] * normal[g, 0] + normal[f, 1] * normal[g, 1] + normal[f, 2] * normal[g, 2]
                    edge |= part[f] != part[g] or cosine < FLAT
            for k in range(3):
                if outline:
                    image[row, column, k] = 0.0
                elif f < 0:
                    image[row, column, k] = 1.0
                elif edge:
                    image[row, column, k] = ink[f, k]
                else:
                    dark = 0.55 if hatched[f] and (column - row) % STRIPE < 3 else 1.0
                    image[row, column, k] = dark * colour[f, k]
            image[row, column, 3] = 1.0 if outline or f >= 0 else 0.0


def seen_faces(corners: FloatArray, offsets: IntArray, shape: tuple[int, int]) -> tuple[IntArray, FloatArray]:
    """Return which of convex faces is seen in every point of a grid, -1 where none is, and how far it lies.

    Parameters
    ----------
    corners : (n_corners, 3) float64
        Column, row and distance of every corner, face after face.
    offsets : (n_faces + 1,) int
        Face f owns ``corners[offsets[f]:offsets[f + 1]]``.
    shape : (rows, columns)
        Of the grid.
    """
    owner, depth = np.full(shape, -1, dtype=np.int64), np.full(shape, np.inf)
    triangles, face = fan_triangles(np.asarray(offsets))
    fill(np.ascontiguousarray(corners[triangles]), face.astype(np.int64), owner, depth)
    return owner, depth
