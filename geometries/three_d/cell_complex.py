"""A complex of convex cells that planes cut: neighbours share whole faces at every moment, so nothing is searched.

A plane cuts edges first, then faces, then cells. A new point is put on an edge in all faces round it, also in those of
cells that are not cut (joints that end): the complex stays conforming.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from bsm_mesh.geometries.errors import GeometryError
from bsm_mesh.geometries.three_d.rows import Growing, IntArray, Rows, any_in_row, following, spread

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]
SNAP = 1e-9  # of the size of the box: points nearer to a plane lie on it
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
        self.cell_low, self.cell_high = Growing(np.array([[x, y, z]])), Growing(np.array([[X, Y, Z]]))
        self.tolerance = SNAP * max(X - x, Y - y, Z - z)

    @property
    def count(self) -> int:
        """Number of cells."""
        return len(self.cell_low)

    def centres(self) -> FloatArray:
        """Return a point inside every cell, (n, 3) [m]: the mean of the corners of its faces."""
        faces, count = self.cell_faces.take(np.arange(self.count))
        corners, sizes = self.loops.take(faces)
        cell = np.repeat(np.repeat(np.arange(self.count), count), sizes)
        total = np.bincount(cell, minlength=self.count)
        return np.stack([np.bincount(cell, x) / total for x in self.points.values[corners].T], axis=1)

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
        """Cut cells by a plane, and return the cells that were cut; the parts below it are new cells, in the same order.

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
        """Return the faces of cells, each once and in order; the place of each cell's faces among them; their numbers."""
        faces, sizes = self.cell_faces.take(cells)
        unique, place = np.unique(faces, return_inverse=True)
        return unique, place.reshape(-1), sizes


class Section:
    """What a plane cuts of a complex: the cells with corners on both sides, and the faces and edges that it divides.

    Parameters
    ----------
    whole : CellComplex
        The complex.
    normal, offset : array, float
        The plane.
    cells : (k,) int64
        The cells that it may cut.
    """

    def __init__(self, whole: CellComplex, normal: FloatArray, offset: float, cells: IntArray) -> None:
        self.whole, self.normal, self.offset = whole, normal, offset
        faces, place, sizes = whole.faces_of(cells)
        above, below = self._sides(faces)
        both = any_in_row(above[place], sizes) & any_in_row(below[place], sizes)
        self.cells = cells[both]
        self.faces, self.place, self.sizes = whole.faces_of(self.cells)
        again = np.searchsorted(faces, self.faces)
        self.above, self.divided = above[again], above[again] & below[again]
        corners, sizes = whole.loops.take(self.faces[self.divided])
        distance = self.distance(corners)
        ahead = following(sizes)
        first, last = corners, corners[ahead]
        crossing = self.sign(distance) * self.sign(distance[ahead]) < 0
        key, number = np.unique(self.key(first[crossing], last[crossing]), return_index=True)
        self.edges = key
        start, end, near, far = (v[crossing][number] for v in (first, last, distance, distance[ahead]))
        turned = start > end  # the same point from whichever side
        start, end = np.where(turned, end, start), np.where(turned, start, end)
        near, far = np.where(turned, far, near), np.where(turned, near, far)
        points = whole.points.values
        share = (near / (near - far))[:, None] if len(near) else np.empty((0, 1))
        self.new_points = points[start] + (points[end] - points[start]) * share

    def distance(self, corners: IntArray) -> FloatArray:
        """Return the distances of points from the plane [m], the same for a point wherever it stands in the array."""
        x, y, z = self.whole.points.values[corners].T
        height: FloatArray = x * self.normal[0] + y * self.normal[1] + z * self.normal[2] - self.offset
        return height

    def sign(self, distance: FloatArray) -> IntArray:
        """Return 1 above the plane, -1 below, 0 on it."""
        tolerance = self.whole.tolerance
        return (distance > tolerance).astype(np.int64) - (distance < -tolerance)

    def key(self, first: IntArray, last: IntArray) -> IntArray:
        """Return one number for an edge, whichever way it is passed."""
        keys: IntArray = (np.minimum(first, last) << 32) + np.maximum(first, last)
        return keys

    def _sides(self, faces: IntArray) -> tuple[BoolArray, BoolArray]:
        """Return which faces have corners above and below the plane."""
        corners, sizes = self.whole.loops.take(faces)
        sign = self.sign(self.distance(corners))
        return any_in_row(sign > 0, sizes), any_in_row(sign < 0, sizes)

    def centres(self) -> FloatArray:
        """Return the centre of every cell's section, (k, 3) [m]: the mean of the chords' middles."""
        corners, sizes = self.whole.loops.take(self.faces[self.divided])
        ahead, face = following(sizes), np.repeat(np.arange(len(sizes)), sizes)
        sign = self.sign(self.distance(corners))
        crossing, on = sign * sign[ahead] < 0, sign == 0
        number = np.searchsorted(self.edges, self.key(corners, corners[ahead])[crossing])
        ends = np.concatenate([self.new_points[number], self.whole.points.values[corners[on]]])
        owner = np.concatenate([face[crossing], face[on]])
        chords = np.bincount(owner, minlength=len(sizes))
        middle = np.stack([np.bincount(owner, x, len(sizes)) for x in ends.T], axis=1) / np.maximum(chords, 1)[:, None]
        divided = self.divided[self.place]
        cell = np.repeat(np.arange(len(self.cells)), self.sizes)[divided]
        of_chord = middle[(np.cumsum(self.divided) - 1)[self.place[divided]]]
        total = np.bincount(cell, minlength=len(self.cells))
        return np.stack([np.bincount(cell, x, len(self.cells)) / total for x in of_chord.T], axis=1)

    def apply(self, joint: int, beside: IntArray) -> None:
        """Divide edges, faces and cells; cells `beside` may share edges that are divided."""
        first_point = len(self.whole.points)
        self.whole.points.add(self.new_points)
        others, _, _ = self.whole.faces_of(beside)
        others = np.setdiff1d(others, self.faces[self.divided], assume_unique=True)
        self._put_on_edges(others, first_point, anywhere=True)
        upper, chords = self._divide_faces(first_point)
        self._divide_cells(upper, chords, joint)

    def _put_on_edges(
        self, faces: IntArray, first_point: int, *, anywhere: bool = False
    ) -> tuple[IntArray, IntArray, IntArray]:
        """Put the new points into the loops of faces; return these loops, their signs and sizes."""
        corners, sizes = self.whole.loops.take(faces)
        key = self.key(corners, corners[following(sizes)])
        number = np.minimum(np.searchsorted(self.edges, key), max(len(self.edges) - 1, 0))
        added = self.edges[number] == key if len(self.edges) else np.zeros(len(key), dtype=bool)
        owner = np.repeat(np.arange(len(sizes)), sizes)
        if anywhere:  # most faces beside the cut have no edge that is cut
            some = np.bincount(owner[added], minlength=len(sizes)) > 0
            kept = some[owner]
            faces, sizes, corners, added, number = faces[some], sizes[some], corners[kept], added[kept], number[kept]
            owner = np.repeat(np.arange(len(sizes)), sizes)
        place = np.arange(len(corners)) + np.cumsum(added) - added
        loops, sign = np.empty((2, len(corners) + int(added.sum())), np.int64)
        loops[place], loops[place[added] + 1] = corners, first_point + number[added]
        sign[place], sign[place[added] + 1] = self.sign(self.distance(corners)), 0
        sizes = sizes + np.bincount(owner[added], minlength=len(sizes))
        if anywhere:
            self.whole.loops.replace(faces, loops, sizes)
        return loops, sign, sizes

    def _divide_faces(self, first_point: int) -> tuple[IntArray, IntArray]:
        """Divide the faces: the part above keeps the number. Return the numbers of the parts below, and the chords."""
        whole, faces = self.whole, self.faces[self.divided]
        loops, sign, sizes = self._put_on_edges(faces, first_point)
        ahead, start = following(sizes), np.cumsum(sizes) - sizes
        rises, falls = (sign <= 0) & (sign[ahead] > 0), (sign >= 0) & (sign[ahead] < 0)
        owner = np.repeat(np.arange(len(sizes)), sizes)
        once = np.ones(len(sizes), np.int64)
        if not all(np.array_equal(np.bincount(owner[turn], minlength=len(sizes)), once) for turn in (rises, falls)):
            raise self._too_near()
        shift = (ahead[rises] - start)[owner]
        turned = start[owner] + (np.arange(len(loops)) - start[owner] + shift) % sizes[owner]
        loops, sign = loops[turned], sign[turned]  # above first, then on the plane, below, on the plane
        above = np.bincount(owner[sign > 0], minlength=len(sizes))
        leaving, coming = loops[start + above], loops[start + sizes - 1]
        if (sign[start + above] != 0).any() or (sign[start + sizes - 1] != 0).any():
            raise self._too_near()
        upper_sizes = above + 2
        upper = spread(start - 1, upper_sizes)
        upper[np.cumsum(upper_sizes) - upper_sizes] = start + sizes - 1
        whole.loops.replace(faces, loops[upper], upper_sizes)
        lower = whole.loops.add(loops[spread(start + above, sizes - above)], sizes - above)
        for values in (whole.face_cells, whole.face_joint, whole.face_side):
            values.add(values.values[faces])
        return lower, np.stack([leaving, coming], axis=1)

    def _divide_cells(self, lower: IntArray, chords: IntArray, joint: int) -> None:
        """Divide the cells by new faces: the part above keeps the number."""
        whole, count = self.whole, len(self.cells)
        new_cells = np.arange(whole.count, whole.count + count)
        cell, face, divided = np.repeat(np.arange(count), self.sizes), self.faces[self.place], self.divided[self.place]
        part = lower[(np.cumsum(self.divided) - 1)[self.place[divided]]]
        loops, sizes = self._section_loops(cell, chords)
        new_faces = whole.loops.add(loops, sizes)
        beside = self._beside_divided(lower)
        whole.face_cells.add(np.stack([new_cells, self.cells], axis=1))
        whole.face_joint.add(np.full(count, joint))
        whole.face_side.add(np.full(count, -1))
        above = self.above[self.place]
        moved_cell = np.concatenate([cell[~above], cell[divided]])
        moved_face = np.concatenate([face[~above], part])
        for side in (0, 1):
            here = whole.face_cells.values[moved_face, side] == self.cells[moved_cell]
            whole.face_cells.values[moved_face[here], side] = new_cells[moved_cell[here]]
        upper = _rows(np.concatenate([cell[above], np.arange(count)]), np.concatenate([face[above], new_faces]), count)
        whole.cell_faces.replace(self.cells, *upper)
        below = _rows(
            np.concatenate([moved_cell, np.arange(count)]), np.concatenate([moved_face, new_faces]), count
        )
        whole.cell_faces.add(*below)
        whole.cell_low.add(whole.cell_low.values[self.cells])
        whole.cell_high.add(whole.cell_high.values[self.cells])
        self._give_parts(*beside)
        self._set_boxes(np.concatenate([self.cells, new_cells]))

    def _beside_divided(self, lower: IntArray) -> tuple[IntArray, IntArray]:
        """Return the cells that are not cut and share divided faces, and the new parts of these faces."""
        pairs = self.whole.face_cells.values[self.faces[self.divided]]
        cut = np.zeros(self.whole.count + 1, dtype=bool)
        cut[self.cells], cut[-1] = True, True  # the last for -1, no cell
        row, side = np.nonzero(~cut[pairs])
        return pairs[row, side], lower[row]

    def _give_parts(self, cells: IntArray, faces: IntArray) -> None:
        """Add faces to cells that are not cut."""
        if not len(cells):
            return
        whole, (unique, number) = self.whole, np.unique(cells, return_inverse=True)
        old, sizes = whole.cell_faces.take(unique)
        owner = np.concatenate([np.repeat(np.arange(len(unique)), sizes), number.reshape(-1)])
        whole.cell_faces.replace(unique, *_rows(owner, np.concatenate([old, faces]), len(unique)))

    def _set_boxes(self, cells: IntArray) -> None:
        whole = self.whole
        faces, count = whole.cell_faces.take(cells)
        corners, sizes = whole.loops.take(faces)
        total = np.add.reduceat(sizes, np.cumsum(count) - count)
        points, first = whole.points.values[corners], np.cumsum(total) - total
        whole.cell_low.values[cells] = np.minimum.reduceat(points, first)
        whole.cell_high.values[cells] = np.maximum.reduceat(points, first)

    def _section_loops(self, cell: IntArray, chords: IntArray) -> tuple[IntArray, IntArray]:
        """Return the loops of the sections, counter-clockwise seen from above, and their sizes.

        A loop consists of the edges that only one face of the part above passes: chords, and edges on the plane.
        """
        whole, divided = self.whole, self.divided[self.place]
        chord = chords[(np.cumsum(self.divided) - 1)[self.place[divided]]]
        first, last = chord.T
        owner, face = cell[divided], self.faces[self.place[divided]]
        flat_owner, flat_face, start, end = self._edges_on_plane(cell)
        owner, face = np.concatenate([owner, flat_owner]), np.concatenate([face, flat_face])
        first, last = np.concatenate([first, start]), np.concatenate([last, end])
        outward = whole.face_cells.values[face, 0] == self.cells[owner]
        first, last = np.where(outward, first, last), np.where(outward, last, first)
        many = len(whole.points)
        key, back = (owner * many + first) * many + last, (owner * many + last) * many + first
        single = ~np.isin(key, back)
        owner, first, last = owner[single], first[single], last[single]
        order = np.argsort(owner * many + first, kind="stable")
        owner, first, last = owner[order], first[order], last[order]
        sizes = np.bincount(owner, minlength=len(self.cells))
        after = np.searchsorted(owner * many + first, owner * many + last)
        place = self._in_order(after, sizes)
        return first[place], sizes

    def _edges_on_plane(self, cell: IntArray) -> tuple[IntArray, IntArray, IntArray, IntArray]:
        """Return cell, face, start and end of the edges on the plane of faces above it."""
        whole, upper = self.whole, self.above & ~self.divided
        chosen = upper[self.place]
        corners, sizes = whole.loops.take(self.faces[upper])
        ahead = following(sizes)
        on = self.sign(self.distance(corners)) == 0
        flat = on & on[ahead]
        number = np.repeat(np.arange(len(sizes)), sizes)[flat]
        if not len(number):
            none = np.empty(0, np.int64)
            return none, none, none, none
        edges = np.bincount(number, minlength=len(sizes))
        begin = np.cumsum(edges) - edges
        of_pair = (np.cumsum(upper) - 1)[self.place[chosen]]  # a face belongs to one or two of the cells
        pick = spread(begin[of_pair], edges[of_pair])
        owner = np.repeat(cell[chosen], edges[of_pair])
        return owner, self.faces[upper][number[pick]], corners[flat][pick], corners[ahead][flat][pick]

    def _in_order(self, after: IntArray, sizes: IntArray) -> IntArray:
        """Return the edges of loops in order, from which edge follows each; every loop has to close."""
        start = np.cumsum(sizes) - sizes
        if (sizes < 3).any() or (after >= len(after)).any():
            raise self._too_near()
        place = np.empty(len(after), np.int64)
        current, seen = start.copy(), np.zeros(len(after), dtype=bool)
        for k in range(int(sizes.max())):
            going = sizes > k
            place[(start + k)[going]] = current[going]
            seen[current[going]] = True
            current[going] = after[current[going]]
        if not seen.all() or not np.array_equal(current, start):
            raise self._too_near()
        return place

    def _too_near(self) -> GeometryError:
        x, y, z = self.normal * self.offset
        return GeometryError(
            f"a plane through ({x:g}, {y:g}, {z:g}) m passes corners of blocks at a distance of {SNAP:g} of the "
            "model's size; move it a little"
        )


def _rows(owner: IntArray, values: IntArray, count: int) -> tuple[IntArray, IntArray]:
    """Return values ordered by their owners, and how many each has."""
    return values[np.argsort(owner, kind="stable")], np.bincount(owner, minlength=count)
