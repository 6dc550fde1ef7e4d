"""Properties of contact points: stiffness of rock and joint in series, joint law, strength."""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.contact.properties import ContactProperties, LawCatalogue
from bsm_mesh.model.face_stiffness import LEAST_DEPTH, compliance
from bsm_mesh.model.kinds import in_space
from bsm_mesh.three_d.contacts.history import PolygonPoints


class PolygonCatalogue(LawCatalogue):
    """Looks up stiffness and law of contact polygons.

    Parameters
    ----------
    model : Model
        The model; its blocks are polyhedra.
    """

    def have_stiffness(self, points: PolygonPoints) -> BoolArray:
        """Return which points have a joint, or a rock that is not rigid, (m,)."""
        blocks = self._model.blocks
        soft = np.isfinite(self._moduli[:, 0])[blocks.rock]
        found: BoolArray = (self._joint_of(points) >= 0) | soft[points.block_a] | soft[points.block_b]
        return found

    def _joint_of(self, points: PolygonPoints) -> IntArray:
        joint: IntArray = np.where(points.joint >= 0, self._number[points.joint], self._default)
        return joint

    def properties(self, points: PolygonPoints) -> ContactProperties:
        """Return the properties of points.

        Raises
        ------
        ModelError
            Where two rigid rocks meet without a joint.
        """
        blocks = self._model.blocks
        assert in_space(blocks)
        joint = self._joint_of(points)
        least = LEAST_DEPTH * blocks.moments.volume / blocks.surfaces

        def rock(block: IntArray, depth: FloatArray) -> tuple[FloatArray, FloatArray]:
            return np.maximum(depth, least[block])[:, None], self._moduli[blocks.rock[block]]

        sides = rock(points.block_a, points.depth[:, 0]), rock(points.block_b, points.depth[:, 1])
        of_joint = np.vstack([self._joint_stiffness, np.full((1, 2), np.inf)])[joint]  # the last: rock
        in_series = compliance(*sides[0], *sides[1], of_joint)
        self.refuse_rigid(in_series[:, 0] == 0, points.block_a, points.block_b)
        kind = self.kind_of(joint, points.block_a, points.block_b)
        return ContactProperties(
            normal_stiffness=1 / in_series[:, 0],
            shear_stiffness=np.where(self.smooth[self._law[kind]], 0.0, 1 / in_series[:, 1]),
            joint=joint.astype(np.int32),
            law=self._law[kind],
            tension=self._tension[kind],
            residual_tension=self._residual_tension[kind],
        )
