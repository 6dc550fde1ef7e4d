"""Newton's method on the few blocks that are far out of balance, the rest held: between factorizations of the whole.

Where few contacts still change, the line search of the whole system would take short steps for their sake, each with
a factorization of the whole. Here the blocks around them are solved on their own, every cluster with its own line
search. The step stays one problem: what the clusters leave out of balance around them, the whole system takes up.
"""

from __future__ import annotations

import numba as nb
import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.errors import SingularMatrixError
from bsm_mesh.solve.linear_solvers import LinearSolver, make_linear_solver
from bsm_mesh.solve.newton import MOST_HALVINGS, softened_tangent, softness_at
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
    pattern = step.pattern
    if (sizes > threshold).sum() > MOST_BLOCKS * len(sizes):
        return position
    flagged = _grown(pattern.row_start, pattern.column, sizes > threshold, step.moving.driven, RINGS)
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
        row_start, column, self.place = _rows_of(whole.row_start, whole.column, flagged, self.block)
        count = len(self.block)
        diagonal = np.flatnonzero(column == np.repeat(np.arange(count), np.diff(row_start))).astype(np.int32)
        self.pattern = BlockPattern(
            row_start=row_start, column=column, diagonal=diagonal, place=np.zeros(0, np.int32), symmetric=False
        )
        graph = csr_array((np.ones(len(column), np.int8), column, row_start), shape=(count, count))
        self.clusters, self.cluster = connected_components(graph, directed=False)
        options, centroid = step.factors.options, step.anchor[self.block, :2]
        self.solver: LinearSolver = make_linear_solver(options.linear_solver, self.pattern, centroid, options.threads)

    def relax(self, position: FloatArray, forces: FloatArray, weight: float, tolerance: float) -> FloatArray:
        """Return where Newton's method on the clusters ends."""
        for _ in range(MOST_ITERATIONS):
            size = np.abs(self.step.moving.free(forces, self.step.supports)[self.block]).max() / weight
            if size < tolerance:
                break
            at = self.step.evaluate(position)
            data = self.step.complete(softened_tangent(self.step, at, softness_at(size)), position)
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


@nb.njit(cache=True)
def _grown(
    row_start: IntArray, column: IntArray, flagged: BoolArray, held: BoolArray, rings: int
) -> BoolArray:  # pragma: no cover - compiled
    """Return the flagged blocks and those that are so many contacts away at most, not counted across held ones."""
    for _ in range(rings):
        wider = flagged.copy()
        for i in range(flagged.size):
            if flagged[i]:
                for p in range(row_start[i], row_start[i + 1]):
                    wider[column[p]] |= not held[column[p]]
        flagged = wider
    return flagged


@nb.njit(cache=True)
def _rows_of(
    row_start: IntArray, column: IntArray, flagged: BoolArray, block: IntArray
) -> tuple[IntArray, IntArray, IntArray]:  # pragma: no cover - compiled
    """Return row starts and columns of the flagged blocks' part of a pattern, and the places that it takes over."""
    number = np.full(flagged.size, -1, np.int32)
    for k in range(block.size):
        number[block[k]] = k
    start = np.zeros(block.size + 1, np.int32)
    for k in range(block.size):
        start[k + 1] = start[k]
        for p in range(row_start[block[k]], row_start[block[k] + 1]):
            start[k + 1] += flagged[column[p]]
    inner, place = np.empty(start[-1], np.int32), np.empty(start[-1], np.int32)
    used = 0
    for k in range(block.size):
        for p in range(row_start[block[k]], row_start[block[k] + 1]):
            if flagged[column[p]]:
                inner[used], place[used] = number[column[p]], p
                used += 1
    return start, inner, place
