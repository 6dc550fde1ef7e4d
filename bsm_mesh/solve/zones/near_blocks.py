"""The continuum where the blocks reached rest: a second start, where joints that break leave several equilibria."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.results.movement import displacement_of
from bsm_mesh.solve.zones.equilibrium import Equations
from bsm_mesh.solve.zones.mesh import ContinuumMesh


def moved_with_blocks(blocks: Blocks, mesh: ContinuumMesh, basis: Any, position: FloatArray) -> FloatArray:
    """Return the displacements (N,) [m] of nodes that move as parts of their rigid blocks, at a position (n, 3).

    Where blocks without a joint share a node it moves with one of them.
    """
    u = np.zeros(basis.N)
    for x, y in zip(basis.element_dofs[::2], basis.element_dofs[1::2], strict=True):
        moved = displacement_of(blocks, position, mesh.block, basis.doflocs[:, x].T)
        u[x], u[y] = moved.T
    return u


def broken_at(equations: Equations, u: FloatArray) -> Equations:
    """Return equations whose joints have failed where displacements u (N,) break them."""
    if equations.joints is None or equations.history is None:
        return equations
    history, there = equations.history, equations.joints.evaluate(u, equations.history)
    broken = replace(history, failed=history.failed | there.failed, parted=history.parted | there.parted)
    return replace(equations, history=broken)
