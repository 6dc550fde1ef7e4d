"""Weights, loads and water on polyhedra, wherever these are."""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.model.kinds import in_space
from bsm_mesh.model.loads import point_forces_of
from bsm_mesh.model.model import Model
from bsm_mesh.movements import cross, turned
from bsm_mesh.three_d.loads.water import WaterOnPolyhedra


class ExternalLoads:
    """All that acts on polyhedra from outside.

    Loads keep their direction and follow their point on the block; water pressure follows the position.

    Parameters
    ----------
    model : Model
        The model.
    """

    def __init__(self, model: Model) -> None:
        applied = point_forces_of(model.acting_loads, model.blocks)
        assert in_space(model.blocks)
        self.block, self.force = applied.block, applied.force
        self._arm = applied.point - model.blocks.moments.centroid[self.block]
        self.water = WaterOnPolyhedra(model.blocks, model.water, model.default_joint)
        self._dead = model.gravity_forces
        np.add.at(self._dead, self.block, self.force)

    @property
    def are_weights(self) -> bool:
        """Whether nothing but weights acts."""
        return not len(self.block) and not self.water.acts

    def at(self, position: FloatArray) -> FloatArray:
        """Return weights, loads and water on every block, moments about centroids, (n, 6) [N, N m]."""
        loads, _ = self.water.on_blocks(position)
        loads[:, :3] += self._dead
        np.add.at(loads[:, 3:], self.block, cross(self.arms(position), self.force))
        return loads

    def arms(self, position: FloatArray) -> FloatArray:
        """Return the arms from centroids to the points of the loads, (k, 3) [m]."""
        return turned(self._arm, position[self.block, 3:])

    def stiffness(self, position: FloatArray) -> FloatArray | None:
        """Return the derivatives of minus `at` by the movement of every block, (n, 6, 6); None: all are zero.

        A moment ``arm x force`` changes with the turn of its arm by ``(turn x arm) x force``. That of water, which is
        small compared with the stiffness of contacts, is left out.
        """
        if not len(self.block):
            return None
        arm, force = self.arms(position), self.force
        stiffness = np.zeros((len(position), 6, 6))
        work = (arm * force).sum(axis=1)[:, None, None] * np.eye(3)
        np.add.at(stiffness[:, 3:, 3:], self.block, work - arm[:, :, None] * force[:, None, :])
        return stiffness
