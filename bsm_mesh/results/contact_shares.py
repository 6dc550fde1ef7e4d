"""The part of a face that a contact represents, in the given geometry, and which two contacts make a face."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.model.edges import pairs_of
from bsm_mesh.model.faces import Faces
from bsm_mesh.movements import turned
from bsm_mesh.results.movement import as_given, displacement_of
from bsm_mesh.results.records import ContactForces

PARALLEL = 0.1  # sine: edges within 6 degrees lie along each other, as in the contact rules
JOINED = 0.5  # of the shorter of two shares: by so much their ends may miss each other, as blocks slide and turn
BESIDE = 0.05  # of a given face: what lies further from its line is on another face of the two blocks


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Shares:
    """The part of a face of each contact, in the given geometry, with the pair's lower block behind it.

    Attributes
    ----------
    first, last : (m, 2) float64 [m]
        Its ends, along `direction`; one of them is the contact's point, but for a corner in the middle of a face. They
        are in the given geometry of block a.
    frames : ((m, 2), (m, 2)) of two pairs of float64 [m]
        Both ends in the given geometry of the pair's lower block, and in that of the higher one.
    direction : (m, 2) float64
        Unit vector along the face.
    side : (m,) int8
        1 where the share continues from the point along `direction`, -1 against it, 0 to both sides.
    """

    first: FloatArray
    last: FloatArray
    frames: tuple[tuple[FloatArray, FloatArray], tuple[FloatArray, FloatArray]]
    direction: FloatArray
    side: IntArray

    @property
    def centre(self) -> FloatArray:
        """The middle, (m, 2) [m]."""
        middle: FloatArray = (self.first + self.last) / 2
        return middle


def shares_of_contacts(blocks: Blocks, contacts: ContactForces, moved: FloatArray, *, in_rows: int) -> Shares:
    """Return the part of a face that each contact represents.

    Parameters
    ----------
    blocks : Blocks
        As they were given.
    contacts : ContactForces
        The m contacts.
    moved : (n, 3) float64 [m, m, rad]
        Displacement of every block since it was given.
    in_rows : {0, 2, 3}
        How many rows are the contacts of one face: two at its ends or at Gauss points within, or three, one in the
        middle; 0: they are in no order. Contacts of blocks that met later are in no order, behind the others.
    """
    point, direction = _in_block(blocks, contacts, moved, contacts.block_a)
    other, in_row = _others_in_rows(contacts, in_rows)
    side = np.sign(((point[other] - point) * direction).sum(axis=1)).astype(np.int8)
    ahead = (side + 1) / 2
    if not in_row.all():
        side, ahead = (np.where(in_row, *of) for of in zip((side, ahead), _sides(blocks, contacts, moved), strict=True))
    first = point + ((ahead - 1) * contacts.length)[:, None] * direction
    last = point + (ahead * contacts.length)[:, None] * direction
    if in_rows == 2:
        middle = (point[other] + point) / 2
        outer = middle - (side * contacts.length)[:, None] * direction
        inner = [np.where((side == s)[:, None], outer, middle) for s in (1, -1)]
        first, last = (np.where(in_row[:, None], *of) for of in zip(inner, (first, last), strict=True))
    first_b, last_b = (_in_b(blocks, contacts, moved, end) for end in (first, last))
    lower = (contacts.block_a < contacts.block_b)[:, None]
    low = np.where(lower, first, first_b), np.where(lower, last, last_b)
    high = np.where(lower, first_b, first), np.where(lower, last_b, last)
    return Shares(first=first, last=last, frames=(low, high), direction=direction, side=side)


def _in_b(blocks: Blocks, contacts: ContactForces, moved: FloatArray, point: FloatArray) -> FloatArray:
    """Return points (m, 2) of blocks a in the given geometry of blocks b, where both are now."""
    at = point + displacement_of(blocks, moved, contacts.block_a, point)
    return as_given(blocks, moved, contacts.block_b, at)


def _others_in_rows(contacts: ContactForces, in_rows: int) -> tuple[IntArray, BoolArray]:
    """Return the row of the other end of each contact's face, and which contacts are in rows at all, (m,) each.

    The ends of a face have the same length.
    """
    row = np.arange(len(contacts.length))
    if not in_rows:
        return row, np.zeros(len(row), dtype=bool)
    place = row % in_rows
    begins = row - place
    whole = begins + in_rows <= len(row)
    other = np.where(whole, begins + (in_rows - 1 - place), row)  # of the middle itself
    last = np.where(whole, begins + in_rows - 1, row)
    for values in (contacts.block_a, contacts.block_b, contacts.length):
        whole &= values[begins] == values[last]
    return np.where(whole, other, row), whole


def _in_block(
    blocks: Blocks, contacts: ContactForces, moved: FloatArray, block: IntArray
) -> tuple[FloatArray, FloatArray]:
    """Return points of contacts and directions of their faces in the given geometry of a block each, (m, 2) both."""
    sign = np.where(contacts.block_a < contacts.block_b, 1.0, -1.0)
    point = as_given(blocks, moved, block, contacts.point)
    return point, turned(contacts.normal * sign[:, None], np.pi / 2 - moved[block, 2])


def _sides(blocks: Blocks, contacts: ContactForces, moved: FloatArray) -> tuple[IntArray, FloatArray]:
    """Return to which side of its corner each contact's face lies, and the part of it ahead of the corner, (m,) each.

    It lies where the block has a parallel edge. At a corner in the middle of a straight edge there are faces to both
    sides: of two contacts each has one. A single contact there reaches half as far as both blocks do.
    """
    if not len(contacts.length):
        return np.zeros(0, np.int8), np.zeros(0)
    corner, _, reach = _reaches(blocks, contacts, moved, contacts.block_a)
    side = np.sign(np.sign(reach[1]) - np.sign(reach[0]))
    flat = np.flatnonzero((reach > 0).all(axis=0))
    pair = pairs_of(contacts.block_a, contacts.block_b)
    flat = flat[np.lexsort((contacts.length[flat], corner[flat], pair[flat]))]
    _, offset, of_b = _reaches(blocks, contacts, moved, contacts.block_b)
    common = np.minimum(reach, np.maximum(of_b + np.stack([-offset, offset]), 0.0))[:, flat]
    ends = common <= JOINED * contacts.length[flat] / 2
    side[flat] = ends[0].astype(int) - ends[1]
    single = common.sum(axis=0) > 0
    ahead = (side + 1) / 2
    ahead[flat[single]] = (common[1] / np.where(single, common.sum(axis=0), 1.0))[single]
    shorter, longer = flat[:-1], flat[1:]
    two = (corner[shorter] == corner[longer]) & (pair[shorter] == pair[longer])
    ahead_of_longer = np.where(reach[1] >= reach[0], 1, -1)[longer[two]]
    side[longer[two]], side[shorter[two]] = ahead_of_longer, -ahead_of_longer
    for row in (longer[two], shorter[two]):
        ahead[row] = (side[row] + 1) / 2
    return side.astype(np.int8), ahead


def _reaches(
    blocks: Blocks, contacts: ContactForces, moved: FloatArray, block: IntArray
) -> tuple[IntArray, FloatArray, FloatArray]:
    """Return the corner nearest to each contact, and its place and edges along the contact's face.

    The second array, (m,) [m], has the distance of the corner ahead of the contact. The third, (2, m) [m], has the
    lengths of the parallel edges behind the corner and ahead of it.
    """
    point, direction = _in_block(blocks, contacts, moved, block)
    corner = _nearest_corners(blocks, block, point)
    before = np.where(corner == blocks.offsets[block], blocks.offsets[block + 1], corner) - 1
    reach = np.zeros((2, len(point)))
    for vector in (blocks.edge_vectors[corner], -blocks.edge_vectors[before]):
        length = np.hypot(*vector.T)
        sine, cosine = (_cross(vector, direction) / length, (vector * direction).sum(axis=1) / length)
        parallel = np.abs(sine) <= PARALLEL
        for way, ahead in enumerate((cosine < 0, cosine > 0)):
            reach[way] = np.where(parallel & ahead, length, reach[way])
    return corner, ((blocks.vertices[corner] - point) * direction).sum(axis=1), reach


def _nearest_corners(blocks: Blocks, block: IntArray, point: FloatArray) -> IntArray:
    """Return the corner of each block that is nearest to its point, (m,)."""
    row, corner = _ranges(blocks.offsets[block], blocks.offsets[block + 1])
    distance = np.hypot(*(blocks.vertices[corner] - point[row]).T)
    nearest: IntArray = corner[_least(distance, row)]
    return nearest


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Cover:
    """How contacts cover the given faces of their two blocks.

    Attributes
    ----------
    face : (m,) int64
        The given face that each contact covers most of; -1 where there is none.
    length : (k,) float64 [m]
        Length of every given face that contacts represent.
    middle : (k, 2) float64 [m]
        The middle of that.
    """

    face: IntArray
    length: FloatArray
    middle: FloatArray


def cover_of(blocks: Blocks, given: Faces, contacts: ContactForces, shares: Shares) -> Cover:
    """Return how contacts cover the given faces: as the lower block of a pair shows it, or the higher one if more.

    A block that slid over a longer face of the other one is covered as before; the other one is covered less.
    """
    low, high = (_cover(blocks, given, contacts, *ends) for ends in shares.frames)
    more = high.length > low.length
    return Cover(
        face=np.where(low.face >= 0, low.face, high.face),
        length=np.where(more, high.length, low.length),
        middle=np.where(more[:, None], high.middle, low.middle),
    )


def _cover(blocks: Blocks, given: Faces, contacts: ContactForces, first: FloatArray, last: FloatArray) -> Cover:
    """Return how shares with the ends given, (m, 2) each, cover the given faces."""
    of_face = pairs_of(blocks.owner[given.edge_a], blocks.owner[given.edge_b])
    order = np.argsort(of_face, kind="stable")
    pair, count = pairs_of(contacts.block_a, contacts.block_b), len(of_face)
    low, high = (np.searchsorted(of_face[order], pair, side=side) for side in ("left", "right"))
    row, place = _ranges(low, high)
    face = order[place]
    start, along = given.start[face], (given.end - given.start)[face]
    length = np.hypot(*along.T)
    unit = along / length[:, None]
    one, other = (((ends[row] - start) * unit).sum(axis=1) for ends in (first, last))
    begin, end = np.maximum(np.minimum(one, other), 0), np.minimum(np.maximum(one, other), length)
    beside = np.abs(_cross(unit, (first + last)[row] / 2 - start)) > BESIDE * length
    covered = np.where(beside, 0.0, np.maximum(end - begin, 0.0))
    found = np.full(len(pair), -1)
    if len(row):
        most = _least(-covered, row)
        most = most[covered[most] > 0]
        found[row[most]] = face[most]
    middle = start + ((begin + end) / 2)[:, None] * unit
    total = np.bincount(face, covered, minlength=count).astype(np.float64)
    mean = np.stack([np.bincount(face, covered * x, minlength=count) for x in middle.T], axis=1)
    return Cover(face=found, length=total, middle=mean / np.where(total > 0, total, 1.0)[:, None])


def joined_shares(contacts: ContactForces, shares: Shares, face: IntArray) -> tuple[IntArray, IntArray]:
    """Return the contacts that make faces: `one` and, where two shares meet, `other` behind it, else -1; (k,) each."""
    along = (shares.centre * shares.direction).sum(axis=1)
    pair = pairs_of(contacts.block_a, contacts.block_b)
    order = np.lexsort((along, face, pair))
    k, n = order[:-1], order[1:]
    gap = ((shares.first[n] - shares.last[k]) * shares.direction[k]).sum(axis=1)
    meet = (pair[k] == pair[n]) & (face[k] == face[n]) & (shares.side[k] == 1) & (shares.side[n] == -1)
    meet &= (shares.direction[k] * shares.direction[n]).sum(axis=1) > 1 - PARALLEL**2
    meet &= np.abs(gap) <= JOINED * np.minimum(contacts.length[k], contacts.length[n])
    other = np.full(len(order), -1)
    other[:-1][meet] = n[meet]
    is_second = np.zeros(len(order), dtype=bool)
    is_second[1:][meet] = True
    return order[~is_second], other[~is_second]


def _cross(one: FloatArray, other: FloatArray) -> FloatArray:
    """Return the cross products of plane vectors (k, 2)."""
    cross: FloatArray = one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0]
    return cross


def _ranges(first: IntArray, last: IntArray) -> tuple[IntArray, IntArray]:
    """Return the row and the number of everything in ``first[row]:last[row]``, row after row."""
    count = (last - first).astype(np.int64)
    row = np.repeat(np.arange(len(count)), count)
    return row, np.arange(len(row)) - np.repeat(np.cumsum(count) - count, count) + first[row]


def _least(values: FloatArray, row: IntArray) -> IntArray:
    """Return where each row's least value is; `row` ascends."""
    order = np.lexsort((values, row))
    return order[np.flatnonzero(np.diff(row[order], prepend=-1))]
