"""A complex of convex cells that planes cut: neighbours share whole faces at every moment, so nothing is searched.

A plane cuts edges first, then faces, then cells. A new point is put on an edge in all faces round it, also in those of
cells that are not cut (joints that end): the complex stays conforming.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from bsm_mesh.geometries.three_d.rows import BoolArray, FloatArray, Growing, IntArray, Rows
from bsm_mesh.geometries.three_d.section import SNAP, Section

SIDES = ("bottom", "top", "south", "east", "north", "west")
BOX = ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7))  # in the order of SIDES


class CellComplex:
    """A box, and the cells that planes have cut from it.

    Parameters
    ----------
    low, high : (3,) array_like [m]
        Corners of the box.

    Attributes
    ----------
    points : Growing
        Points, (n, 3) [m].
    loops : Rows
        Points of every face, counter-clockwise seen from outside its first cell.
    face_cells : Growing
        The two cells of every face, (n, 2); -1 for none.
    face_joint : Growing
        Number of every face's joint, or -1.
    face_side : Growing
        Side of the box, as in `SIDES`, on which a face lies, or -1.
    cell_faces : Rows
        Faces of every cell.
    cell_tag : Growing
        A number that the parts of a cell inherit; -1 at first.
    cell_low, cell_high : Growing
        The box around every cell, (n, 3) [m].
    """

    def __init__(self, low: npt.ArrayLike, high: npt.ArrayLike) -> None:
        (x, y, z), (X, Y, Z) = np.asarray(low, dtype=np.float64), np.asarray(high, dtype=np.float64)
        corners = [(x, y, z), (X, y, z), (X, Y, z), (x, Y, z), (x, y, Z), (X, y, Z), (X, Y, Z), (x, Y, Z)]
        self.points = Growing(np.array(corners))
        self.loops = Rows(np.array(BOX).reshape(-1), np.full(6, 4))
        self.face_cells = Growing(np.tile([[0, -1]], (6, 1)))
        self.face_joint = Growing(np.full(6, -1))
        self.face_side = Growing(np.arange(6))
        self.cell_faces = Rows(np.arange(6), np.array([6]))
        self.cell_tag = Growing(np.array([-1]))
        self.cell_low, self.cell_high = Growing(np.array([[x, y, z]])), Growing(np.array([[X, Y, Z]]))
        self.tolerance = SNAP * max(X - x, Y - y, Z - z)

    @property
    def count(self) -> int:
        """Number of cells."""
        return len(self.cell_low)

    def centres(self, cells: IntArray) -> FloatArray:
        """Return a point inside each of some cells, (k, 3) [m]: the mean of the corners of its faces."""
        faces, count = self.cell_faces.take(cells)
        corners, sizes = self.loops.take(faces)
        owner = np.repeat(np.repeat(np.arange(len(cells)), count), sizes)
        total = np.bincount(owner, minlength=len(cells))
        return np.stack([np.bincount(owner, x, len(cells)) / total for x in self.points.values[corners].T], axis=1)

    def straddling(self, normal: FloatArray, offset: float, low: FloatArray, high: FloatArray) -> BoolArray:
        """Return the cells whose boxes meet a plane, and the box from `low` to `high`."""
        bottom, top = self.cell_low.values, self.cell_high.values
        middle, reach = ((bottom + top) / 2) @ normal - offset, ((top - bottom) / 2) @ np.abs(normal)
        meets: BoolArray = np.abs(middle) <= reach + self.tolerance
        within: BoolArray = (bottom <= high + self.tolerance).all(axis=1) & (top >= low - self.tolerance).all(axis=1)
        return meets & within

    def cut(
        self,
        normal: npt.ArrayLike,
        offset: float,
        joint: int = -1,
        *,
        within: BoolArray | None = None,
        near: tuple[FloatArray, FloatArray] | None = None,
        choose: Callable[[FloatArray], BoolArray] | None = None,
    ) -> IntArray:
        """Cut cells by a plane, and return those that were cut; the parts below it are new cells, in the same order.

        Parameters
        ----------
        normal : (3,) array_like
            Unit normal.
        offset : float [m]
            The plane is ``normal @ x = offset``.
        joint : int
            Joint of the new faces; -1 for none.
        within : (n_cells,) bool, optional
            The cells that may be cut; all where not given.
        near : pair of (3,) array, optional
            Corners of a box [m]; cells whose boxes lie outside stay whole.
        choose : callable, optional
            Takes the centres of the sections (k, 3) [m], and returns which of these cells are cut (k,).

        Raises
        ------
        GeometryError
            If points lie so near the plane that a face cannot be divided.
        """
        direction = np.asarray(normal, dtype=np.float64)
        low, high = near if near is not None else (np.full(3, -np.inf), np.full(3, np.inf))
        may = self.straddling(direction, offset, low, high)
        if within is not None:
            may &= within
        section = Section(self, direction, offset, np.flatnonzero(may))
        if choose is not None and len(section.cells):
            section = Section(self, direction, offset, section.cells[choose(section.centres())])
        if len(section.cells):
            all_cells = within is None and near is None and choose is None
            section.apply(joint, self._beside(section) if not all_cells else np.empty(0, np.int64))
        return section.cells

    def _beside(self, section: Section) -> IntArray:
        """Return the cells, not cut themselves, that edges which are cut may belong to."""
        points = section.new_points
        if not len(points):
            return np.empty(0, np.int64)
        may = self.straddling(section.normal, section.offset, points.min(axis=0), points.max(axis=0))
        may[section.cells] = False
        return np.flatnonzero(may)

    def faces_of(self, cells: IntArray) -> tuple[IntArray, IntArray, IntArray]:
        """Return the faces of cells, each once and in order; the place of each cell's faces there; their numbers."""
        faces, sizes = self.cell_faces.take(cells)
        unique, place = np.unique(faces, return_inverse=True)
        return unique, place.reshape(-1), sizes
