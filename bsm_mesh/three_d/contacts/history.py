"""Contact history in space: state variables of the contact points, committed by an accepted step.

With it go the points of polygons that were renewed: the given geometry does not have them.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray

SLOTS = 1 << 12  # more than corners of a polygon; the last is its centroid
FACES = 1 << 25  # more than faces of all blocks


def keys_of(face_a: IntArray, face_b: IntArray, slot: IntArray) -> IntArray:
    """Return a number of every contact point: that of both faces, and of its corner on the polygon, (k,)."""
    key: IntArray = (face_b.astype(np.int64) * FACES + face_a) * SLOTS + slot
    return key


def faces_of(key: IntArray) -> tuple[IntArray, IntArray]:
    """Return the faces of block a and of block b of contact points, (k,) int32 each."""
    face_b, face_a = np.divmod(key // SLOTS, FACES)
    return face_a.astype(np.int32), face_b.astype(np.int32)


def polygons_of(key: IntArray) -> IntArray:
    """Return a number of the polygon of every contact point, whichever block the point lies on, (k,)."""
    face_a, face_b = faces_of(key)
    number: IntArray = np.maximum(face_a, face_b).astype(np.int64) * FACES + np.minimum(face_a, face_b)
    return number


def renumbered_keys(key: IntArray, number: IntArray) -> IntArray:
    """Return keys with the faces renumbered (n_faces,)."""
    face_a, face_b = faces_of(key)
    return keys_of(number[face_a], number[face_b], key % SLOTS)


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class PolygonPoints:
    """Where contact points lie on their blocks, in rising order of their keys.

    Attributes
    ----------
    key : (k,) int64
        As `keys_of`.
    block_a, block_b : (k,) int32
        Block with the point, block with the face.
    geometry : (k, 12) float64 [m; -; m]
        As `relative_positions` takes it.
    found_gap : (k,) float64 [m]
        Gap where the polygon was found; its points lay over each other there.
    reach : (k,) float64 [m]
        Tangential movement with which the point has left its polygon.
    area : (k,) float64 [m2]
        The area that it stands for.
    depth : (k, 2) float64 [m]
        From the polygon to the centroids of a and b, across it.
    joint : (k,) int32
        Number in ``blocks.joint_names``; -1 for none.
    """

    key: IntArray
    block_a: IntArray
    block_b: IntArray
    geometry: FloatArray
    found_gap: FloatArray
    reach: FloatArray
    area: FloatArray
    depth: FloatArray
    joint: IntArray

    @classmethod
    def none(cls) -> PolygonPoints:
        """Return no points."""
        none, number = np.zeros(0), np.zeros(0, np.int32)
        return cls(
            key=np.zeros(0, np.int64),
            block_a=number,
            block_b=number,
            geometry=np.zeros((0, 12)),
            found_gap=none,
            reach=none,
            area=none,
            depth=np.zeros((0, 2)),
            joint=number,
        )

    def some(self, chosen: IntArray | BoolArray) -> PolygonPoints:
        """Return some of the points."""
        return replace(self, **{field.name: getattr(self, field.name)[chosen] for field in fields(self)})

    def turned_over(self, chosen: BoolArray, normal: FloatArray) -> PolygonPoints:
        """Return the points, the `chosen` (k,) of them on the other block.

        `normal` (k, 3) points into that block, in the frame of the block of the point.
        """
        over, (face_a, face_b) = chosen[:, None], faces_of(self.key)
        back = np.hstack([self.geometry[:, 3:6], self.geometry[:, :3], normal, -self.geometry[:, 9:]])
        return replace(
            self,
            key=np.where(chosen, keys_of(face_b, face_a, self.key % SLOTS), self.key),
            block_a=np.where(chosen, self.block_b, self.block_a),
            block_b=np.where(chosen, self.block_a, self.block_b),
            geometry=np.where(over, back, self.geometry),
            depth=np.where(over, self.depth[:, ::-1], self.depth),
        )

    def with_more(self, more: PolygonPoints) -> PolygonPoints:
        """Return these points and more, in rising order of their keys."""
        order = np.argsort(np.concatenate([self.key, more.key]), kind="stable")
        columns = {
            field.name: np.concatenate([getattr(self, field.name), getattr(more, field.name)])[order]
            for field in fields(self)
        }
        return replace(self, **columns)


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class PointHistory:
    """State variables of the contact points, in rising order of their keys.

    Attributes
    ----------
    key : (k,) int64
        As `keys_of`.
    block_a, block_b : (k,) int32
        Their blocks.
    closed : (k,) bool
        Whether each touches; the others are treated as contacts that arise later.
    shear : (k, 3) float64 [N]
        Shear force on block a, in the frame of block b.
    place, first_place : (k, 3) float64 [m]
        Movement against the face at that shear force, and at first contact.
    offset : (k,) float64 [m]
        Gap at zero pressure.
    failed, mated : (k,) bool
        As in the plane.
    slip_path : (k,) float64 [m]
        How far each has slid, elastic part apart.
    renewed : PolygonPoints
        The points of renewed polygons among them.
    """

    key: IntArray
    block_a: IntArray
    block_b: IntArray
    closed: BoolArray
    shear: FloatArray
    place: FloatArray
    first_place: FloatArray
    offset: FloatArray
    failed: BoolArray
    mated: BoolArray
    slip_path: FloatArray
    renewed: PolygonPoints

    @property
    def count(self) -> int:
        """Number of contact points."""
        return len(self.key)

    @classmethod
    def none(cls) -> PointHistory:
        """Return the empty history of the start."""
        whole, vectors, flags = np.zeros(0, np.int64), np.zeros((0, 3)), np.zeros(0, bool)
        return cls(
            key=whole,
            block_a=np.zeros(0, np.int32),
            block_b=np.zeros(0, np.int32),
            closed=flags,
            shear=vectors,
            place=vectors,
            first_place=vectors,
            offset=np.zeros(0),
            failed=flags,
            mated=flags,
            slip_path=np.zeros(0),
            renewed=PolygonPoints.none(),
        )

    def rows_of(self, key: IntArray) -> tuple[IntArray, BoolArray]:
        """Return the row of every contact point (m,) by its key, and whether it is known."""
        if not self.count:
            return np.zeros(len(key), np.int64), np.zeros(len(key), bool)
        row = np.minimum(np.searchsorted(self.key, key), self.count - 1)
        return row, self.key[row] == key

    def some(self, chosen: IntArray) -> PointHistory:
        """Return some of the points."""
        rows = {name: getattr(self, name)[chosen] for name in _names()}
        return PointHistory(**rows, renewed=self.renewed.some(np.isin(self.renewed.key, rows["key"])))

    def with_more(self, more: PointHistory) -> PointHistory:
        """Return these points and more, in rising order of their keys; `renewed` stays."""
        order = np.argsort(np.concatenate([self.key, more.key]), kind="stable")
        rows = {name: np.concatenate([getattr(self, name), getattr(more, name)])[order] for name in _names()}
        return PointHistory(**rows, renewed=self.renewed)

    def renumbered(self, face: IntArray, block: IntArray) -> PointHistory:
        """Return the same points with faces (n_faces,) and blocks (n,) renumbered in their order."""
        blocks = {name: block[getattr(self, name)] for name in ("block_a", "block_b")}
        of_renewed = {name: block[getattr(self.renewed, name)] for name in ("block_a", "block_b")}
        renewed = replace(self.renewed, key=renumbered_keys(self.renewed.key, face), **of_renewed)
        return replace(self, key=renumbered_keys(self.key, face), **blocks, renewed=renewed)


def _names() -> list[str]:
    """Return the columns of a history."""
    return [field.name for field in fields(PointHistory) if field.name != "renewed"]
