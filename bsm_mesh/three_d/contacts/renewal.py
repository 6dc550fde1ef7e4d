"""Renewal of contact polygons: clipped again where blocks have slid by a part of them, or have come to other faces.

Within a polygon the lever arms of its forces are wrong by the slide since it was found; a part of its size is the
accuracy. Shear forces, slip and failures continue in the new polygons of the same two blocks.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.contact.rules import RULES
from bsm_mesh.model.edges import pairs_of
from bsm_mesh.movements import turned
from bsm_mesh.three_d.blocks.polygons import sums
from bsm_mesh.three_d.contacts.contact_set import ContactSet, contacts_of, gathered
from bsm_mesh.three_d.contacts.history import PointHistory, PolygonPoints, faces_of, polygons_of
from bsm_mesh.three_d.contacts.meetings import Meetings
from bsm_mesh.three_d.contacts.properties import PolygonCatalogue
from bsm_mesh.three_d.contacts.surfaces import Surfaces

SLID = 0.05  # of a polygon's size: with more slide it is found again


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Renewal:
    """Constants of the renewal of polygons.

    Attributes
    ----------
    surfaces, catalogue : Surfaces, PolygonCatalogue
        Faces of the blocks; properties of points.
    given : PolygonPoints
        Points as given.
    contacts : ContactSet
        Their contact set.
    held : (n,) bool
        Blocks that supports hold.
    meetings : Meetings
        Blocks whose edges may meet.
    block_size : (n,) float64 [m]
        Size of every block.
    size, band : float [m]
        Size of a block, and distance within which faces are found.
    """

    surfaces: Surfaces
    catalogue: PolygonCatalogue
    given: PolygonPoints
    contacts: ContactSet
    held: BoolArray
    meetings: Meetings
    block_size: FloatArray
    size: float
    band: float

    def contacts_at(self, history: PointHistory, position: FloatArray, *, first: bool) -> ContactSet:
        """Return the contact points at a position with their history; at the start (`first`) all are intact."""
        found = self._found_at(history, position, first=first)
        return replace(found, meeting=self.meetings.left(found, position, SLID))

    def _found_at(self, history: PointHistory, position: FloatArray, *, first: bool) -> ContactSet:
        points, contacts = self.given, self.contacts
        if len(history.renewed.key):
            kept = ~np.isin(polygons_of(points.key), polygons_of(history.renewed.key))
            points = points.some(kept).with_more(history.renewed)
            contacts = contacts_of(points, history.renewed, self.catalogue)
        before = gathered(contacts, history, position, self.size, first=first)
        stale = self._stale(points, before, position)
        moves = self._moving(position)
        moves[points.block_a[stale]] = moves[points.block_b[stale]] = True
        if first or not moves.any():
            return before
        found = self.surfaces.polygons(position, moves, self.held, self.band, RULES.min_overlap * self.size)
        found = found.some(~self._behind(found, before, position) & self.catalogue.have_stiffness(found))
        fresh = found.some(~np.isin(polygons_of(found.key), polygons_of(points.key[~stale])))
        gone = before.candidates.history < 0  # such polygons of the given geometry are stale at every search
        gone &= ~np.isin(polygons_of(points.key), polygons_of(found.key))
        stale |= _on_faces_of(points, (fresh, points.some(stale & ~gone)), moves)
        new = found.some(~np.isin(polygons_of(found.key), polygons_of(points.key[~stale])))
        if not (stale.any() or len(new.key)):
            return before
        number = np.isin(history.renewed.key, points.key[~stale])
        renewed = history.renewed.some(number).with_more(new)
        own = contacts_of(new, PolygonPoints.none(), self.catalogue)
        rows = inherited(before, np.flatnonzero(stale), own, new, position)
        left = history.some(np.flatnonzero(~np.isin(history.key, points.key[stale]))).with_more(rows)
        whole = contacts_of(points.some(~stale).with_more(new), renewed, self.catalogue)
        return gathered(whole, replace(left, renewed=renewed), position, self.size, first=first)

    def passed(self, contacts: ContactSet, position: FloatArray) -> tuple[IntArray, FloatArray]:
        """Return the pairs of blocks (k, 2) whose faces passed each other without contact, and depths [m]."""
        moves = self._moving(position)
        if not moves.any():
            return np.zeros((0, 2), np.int32), np.zeros(0)
        found = self.surfaces.polygons(position, moves, self.held, self.band, RULES.min_overlap * self.size)
        found = found.some(self._behind(found, contacts, position) & self.catalogue.have_stiffness(found))
        both = np.sort(np.column_stack([found.block_a, found.block_b]), axis=1)
        pairs, number = np.unique(both, axis=0, return_inverse=True)
        depth = np.zeros(len(pairs))
        np.maximum.at(depth, number.reshape(-1), -found.found_gap)
        return pairs, depth

    def _stale(self, points: PolygonPoints, contacts: ContactSet, position: FloatArray) -> BoolArray:
        """Return the points (m,) of polygons whose points moved by a part of their size since they were found."""
        _, place, *_ = contacts.frames(position)
        along = np.linalg.norm(contacts.along(place), axis=1)
        moved = np.hypot(along, contacts.gaps(place) - points.found_gap)
        _, polygon = np.unique(polygons_of(points.key), return_inverse=True)
        area = np.bincount(polygon, points.area)
        farthest = np.zeros(len(area))
        np.maximum.at(farthest, polygon, moved)
        least = RULES.min_overlap * self.size
        stale: BoolArray = (farthest > np.maximum(SLID * np.sqrt(area), least))[polygon]
        return stale

    def _behind(self, new: PolygonPoints, before: ContactSet, position: FloatArray) -> BoolArray:
        """Return the points (k,) of polygons without a key before that begin deep: faces that were passed.

        Where two blocks touch, new polygons begin as deep as the points that they have.
        """
        c = before.candidates
        _, place, *_ = before.frames(position)
        pressed = c.history >= 0
        of_new, of_old, pairs = _pairs(before, np.flatnonzero(pressed), new)
        deepest = np.zeros(pairs)
        np.minimum.at(deepest, of_old, before.gaps(place)[pressed])
        behind: BoolArray = _least_gaps(new) < deepest[of_new] - RULES.initial_penetration * self.size
        return behind & ~np.isin(polygons_of(new.key), polygons_of(before.key))

    def _moving(self, position: FloatArray) -> BoolArray:
        """Return the blocks (n,) that have come so far that they may touch others than as given."""
        turn = np.linalg.norm(position[:, 3:], axis=1) * self.block_size
        least = self.meetings.searched_from(SLID) * self.block_size
        moves: BoolArray = np.linalg.norm(position[:, :3], axis=1) + turn > least
        return moves


def points_apart(surfaces: Surfaces, start: FloatArray, held: BoolArray, band: float, size: float) -> PolygonPoints:
    """Return the points of blocks as given (n, 6) that share no face, where they lie apart or touch.

    They touch on parts of faces, in edges or in corners. Blocks that meet in a node of the mesh have others between,
    unless both faces are free.
    """
    found = surfaces.polygons(start, ~held, held, band, RULES.min_overlap * size)
    faces, least = faces_of(found.key), _least_gaps(found)
    flat = -_least(found, -found.found_gap) <= RULES.rounding * size
    between = surfaces.share_corners(*faces) & ~surfaces.are_free(*faces)
    touch = (np.abs(least) <= RULES.rounding * size) & (flat | ~between) & (faces[0] != faces[1])
    return found.some((least > RULES.rounding * size) | touch)


def touching_points(apart: PolygonPoints, size: float) -> PolygonPoints:
    """Return those of the points of `points_apart` that touch."""
    return apart.some(np.abs(apart.found_gap) <= RULES.rounding * size)


def _least_gaps(points: PolygonPoints) -> FloatArray:
    """Return the least gap of the polygon of every point (k,) [m]."""
    return _least(points, points.found_gap)


def _least(points: PolygonPoints, values: FloatArray) -> FloatArray:
    """Return the least of values (k,) in the polygon of every point, (k,)."""
    _, polygon = np.unique(polygons_of(points.key), return_inverse=True)
    least = np.full(len(points.key), np.inf)
    np.minimum.at(least, polygon, values)
    of_each: FloatArray = least[polygon]
    return of_each


def _on_faces_of(points: PolygonPoints, others: tuple[PolygonPoints, ...], moves: BoolArray) -> BoolArray:
    """Return the points (m,) on faces of blocks that move (n,) with points of others on them.

    Polygons of one face are found together, so that they cover it once.
    """
    touched = [_sides(other) for other in others]
    faces = np.concatenate([side[moves[side >> 32]] for sides in touched for side in sides])
    on: BoolArray = np.any([np.isin(side, faces) for side in _sides(points)], axis=0)
    return on


def _sides(points: PolygonPoints) -> tuple[IntArray, IntArray]:
    """Return a number of the block and its face of points, on both sides, (m,) int64 each."""
    face_a, face_b = faces_of(points.key)
    return (points.block_a.astype(np.int64) << 32) | face_a, (points.block_b.astype(np.int64) << 32) | face_b


def inherited(
    before: ContactSet, stale: IntArray, own: ContactSet, new: PolygonPoints, position: FloatArray
) -> PointHistory:
    """Return the history of points of new polygons, in their order, from the stale ones of the same blocks.

    Of those that bore, the shear force goes to where the new ones press; what most of them are, by area, the new ones
    are. Points of blocks that did not touch before have failed, and are without force where they are found.
    """
    of_new, of_old, pairs = _pairs(before, stale, new)
    c, bore = before.candidates, before.candidates.history[stale] >= 0
    weight = np.where(bore, c.length[stale], 0.0)
    whole = np.bincount(of_old, weight, pairs)
    share = np.divide(weight, whole[of_old], out=np.zeros_like(weight), where=whole[of_old] > 0)
    sign, of_sign = (
        np.where(a < b, 1.0, -1.0)[:, None]
        for a, b in ((c.block_a[stale], c.block_b[stale]), (new.block_a, new.block_b))
    )
    turn = position[c.block_b[stale], 3:]
    force = sums(of_old, np.where(bore[:, None], sign * turned(before.old_shear[stale], turn), 0.0), pairs)
    slid = np.nan_to_num(before.along(before.old_place - before.first_place)[stale])
    slide = sums(of_old, share[:, None] * sign * turned(slid, turn), pairs)[of_new]
    offset, failed, mated, path = (
        sums(of_old, share * values[stale], pairs)[of_new]
        for values in (before.offset, before.failed.astype(float), before.mated.astype(float), before.slip_path)
    )
    known = whole[of_new] > 0
    back = -position[new.block_b, 3:]
    pressing = np.where(known, own.normal_stiffness * np.maximum(offset - new.found_gap, 0.0), 0.0)
    total = np.bincount(of_new, pressing, pairs)[of_new]
    part = np.divide(pressing, total, out=np.zeros_like(pressing), where=total > 0)
    place = new.found_gap[:, None] * new.geometry[:, 6:9]
    return PointHistory(
        key=new.key,
        block_a=new.block_a,
        block_b=new.block_b,
        closed=pressing > 0,
        shear=own.along(turned(of_sign * part[:, None] * force[of_new], back)),
        place=place,
        first_place=place - own.along(turned(of_sign * slide, back)),
        offset=offset,
        failed=~known | (failed > 0.5),
        mated=known & (mated > 0.5),
        slip_path=np.where(known, path, 0.0),
        renewed=PolygonPoints.none(),
    )


def _pairs(before: ContactSet, stale: IntArray, new: PolygonPoints) -> tuple[IntArray, IntArray, int]:
    """Return the pair of blocks of every new point and of every stale one, and how many pairs there are."""
    c = before.candidates
    ends = (np.concatenate([new.block_a, c.block_a[stale]]), np.concatenate([new.block_b, c.block_b[stale]]))
    pair, number = np.unique(pairs_of(*ends), return_inverse=True)
    return number[: len(new.key)], number[len(new.key) :], len(pair)
