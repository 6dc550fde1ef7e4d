"""Forces in contact points of polyhedra: the record of a stage."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.model.submodel import SubModel
from bsm_mesh.results.records import ContactForces


@dataclass(frozen=True, eq=False, repr=False, slots=True, kw_only=True)
class PointForces3D(ContactForces):
    """Forces in contact points, one row each: as in the plane, with vectors of three numbers.

    Attributes
    ----------
    length : (m,) float64 [m2]
        Area that each point stands for.
    shear_force : (m,) float64 [N]
        Magnitude of the shear force.
    shear : (m, 3) float64 [N]
        Shear force on `block_b`, across the normal.
    face, point_face : (m,) int32
        Faces of `block_b` and `block_a` on which each point lies: one face as given, two where blocks have moved on.
    """

    shear: FloatArray
    face: IntArray
    point_face: IntArray

    def in_whole(self, part: SubModel) -> PointForces3D:
        """Return a part's contacts in the numbers of the whole."""
        blocks = {name: part.block[getattr(self, name)] for name in ("block_a", "block_b")}
        return replace(self, **blocks, face=part.corner[self.face], point_face=part.corner[self.point_face])

    def on_given_faces(self, row: IntArray) -> PointForces3D:
        """Return the points on faces that both their blocks share as given: those with a row (n_faces,) there."""
        chosen = np.flatnonzero((self.face == self.point_face) & (row[self.face] >= 0))
        return replace(self, **{field.name: getattr(self, field.name)[chosen] for field in fields(self)})

    @property
    def force(self) -> FloatArray:
        """Force on `block_b`, (m, 3) [N]."""
        force: FloatArray = self.normal_force[:, None] * self.normal + self.shear
        return force
