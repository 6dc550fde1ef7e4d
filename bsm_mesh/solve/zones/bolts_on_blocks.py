"""The tangent of embedded bolts by the rigid movements of blocks, as certificates have it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import scipy.sparse as sp

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.solve.bolts.evaluation import BoltEvaluation
from bsm_mesh.solve.zones.embedded_bolts import EmbeddedBolts


def tangent_on_blocks(
    bolts: EmbeddedBolts, at: BoltEvaluation, u: FloatArray | None, centroid: FloatArray
) -> tuple[IntArray, FloatArray]:
    """Return row and column (l, 2) of the blocks of the tangent, and these blocks (l, 3, 3).

    Parameters
    ----------
    bolts : EmbeddedBolts
        The bolts.
    at : BoltEvaluation
        Their forces.
    u : (N,) float64 or None [m]
        Displacements of the rock with the bolts; None: these are at their given places.
    centroid : (n, 2) float64 [m]
        Of the blocks, likewise.
    """
    body, point = bolts.bodies
    arm = point - centroid[body] + (0.0 if u is None else np.stack([rows @ u for rows in bolts.rows], axis=1))
    one, none = np.ones(len(body)), np.zeros(len(body))
    x, y = (_rows(body, parts, len(centroid)) for parts in ((one, none, -arm[:, 1]), (none, one, arm[:, 0])))
    tangent = replace(bolts, rows=(x, y)).tangent(at)
    turning = np.bincount(body, (arm * at.forces[:, :2]).sum(axis=1), len(centroid))
    blocks = sp.bsr_matrix(tangent + sp.diags(np.kron(turning, (0.0, 0.0, 1.0))), blocksize=(3, 3))
    pair = np.column_stack([np.repeat(np.arange(len(centroid)), np.diff(blocks.indptr)), blocks.indices])
    return pair.astype(np.int32), blocks.data


def _rows(body: IntArray, parts: tuple[FloatArray, ...], count: int) -> sp.csr_matrix:
    """Return the displacements (bodies, 3 n) of bodies in one direction, by the movements of their blocks."""
    column = 3 * body[:, None] + np.arange(3)
    row = np.repeat(np.arange(len(body)), 3)
    return sp.csr_matrix((np.stack(parts, axis=1).ravel(), (row, column.ravel())), shape=(len(body), 3 * count))
