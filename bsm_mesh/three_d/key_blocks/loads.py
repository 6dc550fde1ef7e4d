"""The loads on blocks of a rock before one of them moves: weights, loads of the model and water."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray
from bsm_mesh.model.kinds import in_space
from bsm_mesh.model.model import Model
from bsm_mesh.model.water import Water
from bsm_mesh.three_d.loads.external import ExternalLoads
from bsm_mesh.three_d.loads.water import WaterOnPolyhedra
from bsm_mesh.three_d.model.parts import some_polyhedra


class RockLoads:
    """The loads of a model of polyhedra on those of its blocks that are there.

    Water in a joint presses where both blocks of a face are there; that below a plane of head presses on all faces.

    Parameters
    ----------
    model : Model
        The rock.
    gravity : (float, float, float), optional
        Force over weight, instead of the model's.
    joint_pressure : mapping of str to float, optional [Pa]
        Water pressure in joints, besides the model's and instead of the same ones.
    """

    def __init__(
        self,
        model: Model,
        gravity: Sequence[float] | None = None,
        joint_pressure: Mapping[str, float] | None = None,
    ) -> None:
        assert in_space(model.blocks)
        self._blocks, self._default_joint = model.blocks, model.default_joint
        water = model.water
        if joint_pressure:
            water = water or Water()
            water = replace(water, joint_pressure={**water.joint_pressure, **joint_pressure})
        self._water = water
        self._dead = ExternalLoads(model.replace(water=None)).at(np.zeros((model.blocks.count, 6)))
        if gravity is not None:
            self._dead[:, :3] += model.weights[:, None] * (np.array(gravity) - model.gravity_vector)

    def on_blocks(self, present: BoolArray) -> FloatArray:
        """Return forces and moments about centroids on the blocks that are `present`, (n, 6) [N, N m]; others: 0."""
        there, _ = some_polyhedra(self._blocks, present)
        wet, _ = WaterOnPolyhedra(there, self._water, self._default_joint).on_blocks(np.zeros((there.count, 6)))
        loads = np.zeros_like(self._dead)
        loads[present] = self._dead[present] + wet
        return loads
