"""Contact history in space: state variables of the contact points, committed by an accepted step."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class PointHistory:
    """State variables of the contact points, in rising order of their keys.

    Attributes
    ----------
    key : (k,) int64
        Face and corner, as `point_keys`.
    block_a, block_b : (k,) int32
        Their blocks.
    closed : (k,) bool
        Whether each touches; what does not is as contacts that arise later.
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
        )

    def rows_of(self, key: IntArray) -> tuple[IntArray, BoolArray]:
        """Return the row of every contact point (m,) by its key, and whether it is known."""
        if not self.count:
            return np.zeros(len(key), np.int64), np.zeros(len(key), bool)
        row = np.minimum(np.searchsorted(self.key, key), self.count - 1)
        return row, self.key[row] == key

    def some(self, chosen: IntArray) -> PointHistory:
        """Return some of the points."""
        return replace(self, **{field.name: getattr(self, field.name)[chosen] for field in fields(self)})
