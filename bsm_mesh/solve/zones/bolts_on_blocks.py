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
    return _blocks_of(tangent + sp.diags(np.kron(turning, (0.0, 0.0, 1.0))))


def _rows(body: IntArray, parts: tuple[FloatArray, ...], count: int) -> sp.csr_matrix:
    """Return the displacements (bodies, 3 n) of bodies in one direction, by the movements of their blocks."""
    column = 3 * body[:, None] + np.arange(3)
    row = np.repeat(np.arange(len(body)), 3)
    return sp.csr_matrix((np.stack(parts, axis=1).ravel(), (row, column.ravel())), shape=(len(body), 3 * count))


def _blocks_of(matrix: sp.csr_matrix) -> tuple[IntArray, FloatArray]:
    """Return row and column (l, 2) of the blocks of 3 x 3 of a matrix that are not zero, and the blocks."""
    parts = matrix.tocoo()
    pair, number = np.unique(np.stack([parts.row // 3, parts.col // 3], axis=1), axis=0, return_inverse=True)
    blocks = np.zeros((len(pair), 3, 3))
    np.add.at(blocks, (number.ravel(), parts.row % 3, parts.col % 3), parts.data)
    there = blocks.any(axis=(1, 2))
    return pair[there].astype(np.int32), blocks[there]
