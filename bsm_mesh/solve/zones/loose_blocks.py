"""Parts of blocks with zones that neither supports nor joints hold."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from bsm_mesh.arrays import BoolArray
from bsm_mesh.solve.zones.equilibrium import Equations, Iterate
from bsm_mesh.solve.zones.moving_points import MovingPoints
from bsm_mesh.solve.zones.system import LoosePart, loose_parts

if TYPE_CHECKING:
    from bsm_mesh.solve.zones.stages import Continuum


def loose(of: Continuum, equations: Equations, at: Iterate, present: BoolArray) -> list[LoosePart]:
    """Return the parts of blocks that are there (n,) that neither supports nor joints hold."""
    joints, history = equations.joints, equations.history
    cells = np.flatnonzero(present[of.mesh.block]).astype(np.int32)
    here = np.zeros(of.basis.N, dtype=bool)
    here[of.basis.element_dofs[:, cells]] = True
    ties = of.ties[:, here[of.ties].all(axis=0)]
    if isinstance(joints, MovingPoints) and history is not None:
        ties = joints.unknown[history.present][:, [0, 2]].T
    return loose_parts(equations.free.supports, of.basis, cells, ties, at.residual)
