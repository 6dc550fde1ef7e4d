"""Newton's method on the few blocks that are far out of balance, the rest held: between factorizations of the whole.

Where few contacts still change, the line search of the whole system would take short steps for their sake, each with
a factorization of the whole. Here the blocks around them are solved on their own, every cluster with its own line
search. The step stays one problem: what the clusters leave out of balance around them, the whole system takes up.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from bsm_mesh.arrays import BoolArray, FloatArray
from bsm_mesh.errors import SingularMatrixError
from bsm_mesh.solve.linear_solvers import LinearSolver, make_linear_solver
from bsm_mesh.solve.moving import tangent_stiffness
from bsm_mesh.solve.newton import MOST_HALVINGS, softness_at
from bsm_mesh.solve.pattern import BlockPattern
from bsm_mesh.solve.step import Step, moved_by

FLAGGED = 3e-3  # of the greatest force out of balance: blocks above this are solved on their own
RINGS = 5  # of blocks around them that move with them
MOST_BLOCKS = 0.25  # of all blocks: beyond, solving them apart saves nothing
MOST_ITERATIONS = 12
GAIN = 0.1  # the clusters' forces out of balance are shrunk to this part of what flags a block
WORSE = 1.2  # the 2-norm of the whole may grow by this, else the phase is taken back


def relax_locally(step: Step, position: FloatArray, tolerance: float) -> FloatArray:
    """Return a position at which the blocks worst out of balance are relaxed; the same one where that does not help.

    Parameters
    ----------
    step : Step
        The equations.
    position : (n, 3) float64
        Where most blocks are in balance.
    tolerance : float
        Greatest force out of balance that is wanted, over the reference weight.
    """
    forces, sizes, weight = _out_of_balance(step, position)
    threshold = max(FLAGGED * sizes.max(), 3 * tolerance)
    if (sizes > threshold).sum() > MOST_BLOCKS * len(sizes):
        return position
    flagged = _grown(step.pattern, sizes > threshold, step.moving.driven)
    if not flagged.any() or flagged.sum() > MOST_BLOCKS * len(flagged):
        return position
    clusters = _Clusters(step, flagged)
    try:
        relaxed = clusters.relax(position, forces, weight, GAIN * threshold)
    finally:
        clusters.close()
    after = _out_of_balance(step, relaxed)[1]
    return relaxed if np.sqrt((after**2).sum()) <= WORSE * np.sqrt((sizes**2).sum()) else position


def _out_of_balance(step: Step, position: FloatArray) -> tuple[FloatArray, FloatArray, float]:
    """Return the forces out of balance (n, 3), their greatest component for each block over the weight, the weight."""
    at = step.evaluate(position)
    forces = step.unbalanced(position, at.forces)
    weight = step.moving.weight(at)
    return forces, np.abs(step.moving.free(forces, step.supports)).max(axis=1) / weight, weight


class _Clusters:
    """Blocks that are solved on their own.

    Parameters
    ----------
    step : Step
        The equations.
    flagged : (n,) bool
        The blocks.
    """

    def __init__(self, step: Step, flagged: BoolArray) -> None:
        self.step, self.block = step, np.flatnonzero(flagged)
        whole = step.pattern
        places = csr_array((np.arange(1, len(whole.column) + 1), whole.column, whole.row_start))
        part = places[self.block][:, self.block]
        part.sort_indices()
        self.place = part.data - 1  # counted from 1 above: a 0 would be no entry of the graph
        row_start, column = part.indptr.astype(np.int32), part.indices.astype(np.int32)
        row = np.repeat(np.arange(len(self.block)), np.diff(row_start))
        self.pattern = BlockPattern(
            row_start=row_start,
            column=column,
            diagonal=np.flatnonzero(column == row).astype(np.int32),
            place=np.zeros(0, np.int32),
            symmetric=False,
        )
        self.clusters, self.cluster = connected_components(part, directed=False)
        options, centroid = step.factors.options, step.anchor[self.block, :2]
        self.solver: LinearSolver = make_linear_solver(options.linear_solver, self.pattern, centroid, options.threads)

    def relax(self, position: FloatArray, forces: FloatArray, weight: float, tolerance: float) -> FloatArray:
        """Return where Newton's method on the clusters ends."""
        for _ in range(MOST_ITERATIONS):
            size = np.abs(self.step.moving.free(forces, self.step.supports)[self.block]).max() / weight
            if size < tolerance:
                break
            at = self.step.evaluate(position)
            places = self.step.pattern.place, len(self.step.pattern.column)
            tangent = tangent_stiffness(self.step.contacts, at, *places, softness_at(size))
            data = self.step.complete(tangent, position)
            try:
                self.solver.factorize(data[self.place])
            except SingularMatrixError:
                break
            movement = np.zeros_like(position)
            movement[self.block] = self.solver.solve(self.step.supports.free_part(forces)[self.block])
            if not np.isfinite(movement).all():
                break
            position, forces = self._searched(position, forces, self.step.supports.expand(movement))
        return position

    def _searched(
        self, position: FloatArray, forces: FloatArray, movement: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Return the position and forces after the best part of a movement, another one for every cluster."""
        before = self._merit(forces)
        part, best_part = np.ones(self.clusters), np.ones(self.clusters)
        best, halve = np.full(self.clusters, np.inf), np.ones(self.clusters, dtype=bool)
        for _ in range(MOST_HALVINGS + 1):
            merit = self._merit(self._forces(self._moved(position, movement, part)))
            better = halve & (merit < best)
            best[better], best_part[better] = merit[better], part[better]
            halve &= merit >= (1 - 1e-3 * part) ** 2 * before
            if not halve.any():
                break
            part[halve] /= 2
        position = self._moved(position, movement, best_part)
        return position, self._forces(position)

    def _moved(self, position: FloatArray, movement: FloatArray, part: FloatArray) -> FloatArray:
        moved = position.copy()
        moved[self.block] = moved_by(position[self.block], part[self.cluster, None] * movement[self.block])
        return moved

    def _forces(self, position: FloatArray) -> FloatArray:
        return self.step.unbalanced(position, self.step.evaluate(position).forces)

    def _merit(self, forces: FloatArray) -> FloatArray:
        """Return the square of the 2-norm of every cluster."""
        free = self.step.moving.free(forces, self.step.supports)[self.block]
        return np.bincount(self.cluster, weights=(free**2).sum(axis=1), minlength=self.clusters).astype(float)

    def close(self) -> None:
        """Give the factors' memory back."""
        self.solver.close()


def _grown(pattern: BlockPattern, flagged: BoolArray, held: BoolArray) -> BoolArray:
    """Return the flagged blocks and those that are at most `RINGS` contacts away, not counted across held ones."""
    near = csr_array((np.ones(len(pattern.column), np.float32), pattern.column, pattern.row_start))
    for _ in range(RINGS):
        flagged = flagged | ((near @ flagged.astype(np.float32) > 0) & ~held)
    return flagged
