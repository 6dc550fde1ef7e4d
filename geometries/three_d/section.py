"""Section of a complex of cells by a plane: it divides edges, then faces, then cells."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from bsm_mesh.geometries.errors import GeometryError
from bsm_mesh.geometries.three_d.rows import (
    BoolArray,
    FloatArray,
    Growing,
    IntArray,
    Rows,
    any_in_row,
    following,
    spread,
)

SNAP = 1e-9  # of the size of the box: points nearer to a plane lie on it


class Complex(Protocol):
    """The complex: a `bsm_mesh.geometries.three_d.cell_complex.CellComplex`."""

    points: Growing
    loops: Rows
    face_cells: Growing
    face_joint: Growing
    face_side: Growing
    cell_faces: Rows
    cell_tag: Growing
    cell_low: Growing
    cell_high: Growing
    tolerance: float

    @property
    def count(self) -> int:
        """Number of cells."""

    def faces_of(self, cells: IntArray) -> tuple[IntArray, IntArray, IntArray]:
        """Return the faces of cells."""


class Section:
    """Section of a complex by a plane: the cells with corners on both sides, and the faces and edges that it divides.

    Parameters
    ----------
    whole : Complex
        The complex.
    normal, offset : array, float
        The plane.
    cells : (k,) int64
        The cells that it may cut.
    """

    def __init__(self, whole: Complex, normal: FloatArray, offset: float, cells: IntArray) -> None:
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
        """Return the distances of points from the plane [m], the same for a point wherever it is in the array."""
        x, y, z = self.whole.points.values[corners].T
        height: FloatArray = x * self.normal[0] + y * self.normal[1] + z * self.normal[2] - self.offset
        return height

    def sign(self, distance: FloatArray) -> IntArray:
        """Return 1 above the plane, -1 below, 0 on it."""
        tolerance = self.whole.tolerance
        sign: IntArray = (distance > tolerance).astype(np.int64) - (distance < -tolerance)
        return sign

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
        below = _rows(np.concatenate([moved_cell, np.arange(count)]), np.concatenate([moved_face, new_faces]), count)
        whole.cell_faces.add(*below)
        for values in (whole.cell_tag, whole.cell_low, whole.cell_high):
            values.add(values.values[self.cells])
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
