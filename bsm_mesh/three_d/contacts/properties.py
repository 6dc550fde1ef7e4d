"""Properties of contact points: stiffness of rock and joint in series, joint law, strength."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.contact.properties import LawCatalogue
from bsm_mesh.errors import ModelError
from bsm_mesh.model.face_stiffness import LEAST_DEPTH, compliance
from bsm_mesh.model.kinds import in_space
from bsm_mesh.model.polygons import owner_of_corner
from bsm_mesh.three_d.blocks.contact_polygons import ContactPoints, ContactPolygons

SLOTS = 1 << 20  # more than corners of a polygon; the last is its centroid


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class PointProperties:
    """Properties of contact points, (m,) each: as `ContactProperties`, per area.

    Attributes
    ----------
    normal_stiffness, shear_stiffness : (m,) float64 [Pa/m]
        Rock and joint in series.
    joint, law : (m,) int32
        Number of the joint in ``model.joints`` (-1: unjointed rock) and of the law in the catalogue.
    tension, residual_tension : (m,) float64 [Pa]
        Tensile strength while it has not been broken, and what slip leaves of it.
    """

    normal_stiffness: FloatArray
    shear_stiffness: FloatArray
    joint: IntArray
    law: IntArray
    tension: FloatArray
    residual_tension: FloatArray


class PolygonCatalogue(LawCatalogue):
    """Looks up stiffness and law of contact polygons.

    Parameters
    ----------
    model : Model
        What is given; its blocks are polyhedra.
    """

    def properties(self, polygons: ContactPolygons, polygon: IntArray) -> PointProperties:
        """Return the properties of points of polygons (m,).

        Raises
        ------
        ModelError
            Where two rigid rocks meet without a joint.
        """
        blocks = self._model.blocks
        assert in_space(blocks)
        joint = np.where(polygons.joint >= 0, self._number[polygons.joint], self._default)
        least = LEAST_DEPTH * blocks.moments.volume / blocks.surfaces

        def rock(block: IntArray) -> tuple[FloatArray, FloatArray]:
            arm = polygons.centroid - blocks.moments.centroid[block]
            depth = np.abs(np.einsum("ij,ij->i", arm, polygons.normal))
            return np.maximum(depth, least[block])[:, None], self._moduli[blocks.rock[block]]

        of_joint = np.vstack([self._joint_stiffness, np.full((1, 2), np.inf)])[joint]  # the last: rock
        in_series = compliance(*rock(polygons.block_a), *rock(polygons.block_b), of_joint)
        if (stiff := np.flatnonzero(in_series[:, 0] == 0)).size:
            a, b = int(polygons.block_a[stiff[0]]), int(polygons.block_b[stiff[0]])
            raise ModelError(
                f"blocks {a} and {b} meet without a joint and their rocks are rigid; give the rock young and poisson, "
                "or default_joint = ... for faces without one"
            )
        kind = self.kind_of(joint, polygons.block_a, polygons.block_b)
        smooth = self.smooth[self._law[kind]]
        return PointProperties(
            normal_stiffness=(1 / in_series[:, 0])[polygon],
            shear_stiffness=np.where(smooth, 0.0, 1 / in_series[:, 1])[polygon],
            joint=joint.astype(np.int32)[polygon],
            law=self._law[kind][polygon],
            tension=self._tension[kind][polygon],
            residual_tension=self._residual_tension[kind][polygon],
        )


def point_keys(polygons: ContactPolygons, points: ContactPoints) -> IntArray:
    """Return a number of every contact point: that of its face, and of its corner on it or the centroid, (k,)."""
    corners = len(polygons.corners)
    slot = np.full(points.count, SLOTS - 1, dtype=np.int64)
    owner = owner_of_corner(polygons.offsets)
    slot[:corners] = np.arange(corners) - polygons.offsets[:-1][owner]
    key: IntArray = polygons.face[points.polygon].astype(np.int64) * SLOTS + slot
    return key
