"""Paints faces in space as they are seen, nearest ones over others, with their edges and the body's outline.

Faces are found by a depth buffer. VTK crashes on a machine without an X server, EGL and OSMesa (D0001). The order of
Matplotlib's own 3D axes, by mean distance, is wrong for faces of different size.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.pictures.look import Look
from bsm_mesh.pictures.raster import seen_faces, shade
from bsm_mesh.three_d.blocks.polygons import vector_areas

FINE = 2  # points of the grid a pixel
MOST_POINTS = 6_000_000  # of the grid
DARKEST = 0.72  # of a colour, where a face is seen from its side
STEP = 0.02  # of the picture's width: where what lies behind is farther than this there is an outline
LIGHT = np.array([-0.35, 0.45, -0.82])  # towards it: to the right, up, ahead


@dataclass(frozen=True, eq=False, kw_only=True)
class Layer:
    """Faces that are painted.

    Attributes
    ----------
    corners : (n_corners, 3) float64 [m]
        Where they are, face after face.
    offsets : (n + 1,) int
        Face f owns ``corners[offsets[f]:offsets[f + 1]]``.
    part : (n,) int
        Number of the block of each face: edges are drawn between two.
    colours : (n, 3) float64
        Red, green and blue.
    edge : (3,) float64 or None
        Colour of edges; None: there are none.
    hatched : bool
        Whether they are hatched.
    """

    corners: FloatArray
    offsets: IntArray
    part: IntArray
    colours: FloatArray
    edge: FloatArray | None
    hatched: bool = False


@dataclass(eq=False, kw_only=True)
class Painter:
    """Faces on their way into a picture.

    Attributes
    ----------
    look : Look
        From where they are seen.
    view : (x0, y0, x1, y1) [m]
        The part of the picture's plane that is shown.
    width : int
        Pixels of it.
    layers : list of Layer
        Layers to be painted; the nearest faces of all are visible.
    """

    look: Look
    view: tuple[float, float, float, float]
    width: int
    layers: list[Layer] = field(default_factory=list)

    def paint(self, axes: Any) -> Seen | None:
        """Paint all layers on axes, and return the visible faces; None: nothing is there."""
        seen = self.seen()
        if seen is None:
            return None
        x0, y0, x1, y1 = self.view
        axes.imshow(_image(seen, self.layers), extent=(x0, x1, y0, y1), origin="lower", zorder=2, aspect="equal")
        return seen

    def seen(self) -> Seen | None:
        """Return the visible faces; None: nothing is there."""
        if not self.layers:
            return None
        x0, y0, x1, y1 = self.view
        columns = FINE * self.width
        rows = columns * (y1 - y0) / (x1 - x0)
        smaller = min(1.0, float(np.sqrt(MOST_POINTS / (rows * columns)))) / FINE
        shape = FINE * max(1, round(smaller * rows)), FINE * max(1, round(smaller * columns))
        sizes = np.concatenate([np.diff(layer.offsets) for layer in self.layers])
        offsets = np.concatenate([[0], np.cumsum(sizes)])
        corners = np.concatenate([layer.corners for layer in self.layers])
        place = (self.look.flat(corners) - (x0, y0)) * np.array([shape[1] / (x1 - x0), shape[0] / (y1 - y0)]) - 0.5
        grid = np.column_stack([place, self.look.distance(corners)])
        face, depth = seen_faces(grid, offsets, shape)
        vector = vector_areas(corners, offsets) @ self.look.axes.T
        vector /= np.maximum(np.linalg.norm(vector, axis=1), 1e-300)[:, None]
        vector *= np.where(vector[:, 2] > 0, -1.0, 1.0)[:, None]  # to the viewer
        part = np.concatenate([layer.part for layer in self.layers]).astype(np.int64)
        return Seen(face=face, depth=depth, normal=vector, part=part, view=self.view)


@dataclass(frozen=True, eq=False, kw_only=True)
class Seen:
    """Visible face of every point of a grid.

    Attributes
    ----------
    face : (rows, columns) int
        Number of the face, of all layers one after the other; -1: none.
    depth : (rows, columns) float64 [m]
        How far it lies ahead.
    normal : (n, 3) float64
        Unit normals of the faces: to the right, up, ahead; to the viewer.
    part : (n,) int
        Block of each face.
    view : (x0, y0, x1, y1) [m]
        The part of the picture's plane.
    """

    face: IntArray
    depth: FloatArray
    normal: FloatArray
    part: IntArray
    view: tuple[float, float, float, float]

    @property
    def point(self) -> float:
        """Width of a point of the grid [m]."""
        return float((self.view[2] - self.view[0]) / self.face.shape[1])

    def in_front(self, place: FloatArray, distance: FloatArray) -> BoolArray:
        """Return which points, at places (k, 2) of the picture and distances (k,), no face hides."""
        rows, columns = self.face.shape
        x0, y0, x1, y1 = self.view
        at = ((place - (x0, y0)) / (x1 - x0, y1 - y0) * (columns, rows)).astype(np.int64)
        column, row = np.clip(at[:, 0], 0, columns - 1), np.clip(at[:, 1], 0, rows - 1)
        clear: BoolArray = distance <= self.depth[row, column] + 3 * self.point
        return clear

    def middles(self) -> tuple[IntArray, FloatArray, FloatArray]:
        """Return the blocks that are seen (k,), the middle (k, 2) and the size (k,) of the visible part [m]."""
        rows, columns = np.nonzero(self.face >= 0)
        part, row = np.unique(self.part[self.face[rows, columns]], return_inverse=True)
        count = np.bincount(row)
        place = np.stack([np.bincount(row, columns) / count, np.bincount(row, rows) / count], axis=1)
        middle = (place + 0.5) * self.point + np.array(self.view[:2])
        return part, middle, np.sqrt(count) * self.point


def _image(seen: Seen, layers: list[Layer]) -> Any:
    """Return red, green, blue and opacity of every pixel, (rows, columns, 4)."""
    bright = DARKEST + (1 - DARKEST) * np.clip(seen.normal @ LIGHT, 0.0, 1.0)
    sizes = [len(layer.part) for layer in layers]
    none = np.full(3, -1.0)
    rows, columns = seen.face.shape
    image = np.empty((rows, columns, 4), dtype=np.float32)
    shade(
        seen.face,
        seen.depth,
        seen.normal,
        seen.part,
        np.concatenate([layer.colours for layer in layers]) * bright[:, None],
        np.repeat([none if layer.edge is None else layer.edge for layer in layers], sizes, axis=0),
        np.repeat(np.array([layer.hatched for layer in layers], dtype=np.int64), sizes),
        STEP * (seen.view[2] - seen.view[0]),
        image,
    )
    return sum(image[i::FINE, j::FINE] for i in range(FINE) for j in range(FINE)) / FINE**2
