"""The tangent of the bolts on its own: the blocks of their matrix that are not zero."""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.solve.algebra.block_matrix import whole_pattern
from bsm_mesh.solve.bolts.evaluation import BoltEvaluation
from bsm_mesh.solve.bolts.installed import InstalledBolts


def bolt_tangent(bolts: InstalledBolts, at: BoltEvaluation, *, turning: bool) -> tuple[IntArray, FloatArray]:
    """Return row and column (l, 2) of the blocks of the bolts' tangent, and the blocks (l, axes, axes).

    `turning`: with the turning of the bolts under their tension, which small displacements leave out.
    """
    axes = at.forces.shape[1]
    if not len(bolts.alive):
        return np.zeros((0, 2), np.int32), np.zeros((0, axes, axes))
    pattern = whole_pattern(len(at.forces), *bolts.pairs)
    data = np.zeros((len(pattern.column), axes, axes))
    bolts.add_tangent(at, bolts.places(pattern), data, turning=turning)
    row = np.repeat(np.arange(pattern.rows, dtype=np.int32), np.diff(pattern.row_start))
    there = data.any(axis=(1, 2))
    return np.column_stack([row, pattern.column])[there], data[there]
