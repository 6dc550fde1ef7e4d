"""Subdomain Newton: the blocks with the largest residual and their neighbours solved alone, all others fixed.

Nonlinear elimination: where few contacts still change, a global line search would take short steps for their sake, each
with a global factorization. Here their subdomain is solved by Newton's method, every cluster with its own line search,
and by the interior point method where that fails. The residual that this leaves around the clusters is left to the
global iteration.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_array

from bsm_mesh.arrays import BoolArray, FloatArray
from bsm_mesh.solve.algebra.block_matrix import BlockPattern
from bsm_mesh.solve.methods.brittle import release_brittle_contacts
from bsm_mesh.solve.methods.interior_point import interior_point
from bsm_mesh.solve.methods.newton import MAX_HALVINGS, STALLED, newton, tangent_regularization
from bsm_mesh.solve.step.attempt import Attempt
from bsm_mesh.solve.step.equations import Residual, Step, moved_by
from bsm_mesh.solve.step.subproblem import LocalStep

RESIDUAL_CUTOFF = 3e-3  # over the maximum norm: blocks with a larger residual are in the subdomain
OVERLAP_LAYERS, INFLUENCE_LAYERS = 5, 25  # of neighbours added to it for a solution, and for a correction
MAX_BLOCKS = 0.25  # of all: a larger subdomain saves nothing;
RAISED = 3.0  # factor on the cutoff until the subdomain is smaller
MAX_ITERATIONS = 12
GAIN = 0.1  # tolerance of the subdomain over the cutoff residual
ENOUGH = 0.1  # part of its maximum norm left, above which the interior point method is tried
MAX_GROWTH = 1.2  # of the global 2-norm; beyond, the solution is rejected


def subdomain_newton(
    step: Step,
    position: FloatArray,
    tolerance: float,
    *,
    use_interior_point: bool = False,
    layers: int = OVERLAP_LAYERS,
    max_growth: float = MAX_GROWTH,
    cutoff: float = RESIDUAL_CUTOFF,
    fewer: bool = False,
) -> FloatArray:
    """Return a position with the subdomain of the largest residuals solved; the same one where that does not help.

    Parameters
    ----------
    step : Step
        The equations.
    position : (n, 3) float64
        Where most blocks are in equilibrium.
    tolerance : float
        Maximum norm of the residual that is wanted, over the mean weight.
    use_interior_point : bool
        Try the interior point method where Newton's fails; the step keeps whether it stalled.
    layers : int
        Layers of neighbours around those with a large residual.
    max_growth : float
        Factor by which the 2-norm may grow: around blocks that slide far it grows until all have followed.
    cutoff : float
        Over the maximum norm: blocks with a larger residual are in the subdomain.
    fewer : bool
        Where those are too many, raise the cutoff.
    """
    sizes, weight = _block_residuals(step, position)
    threshold = _threshold(sizes, tolerance, cutoff)
    most = MAX_BLOCKS * len(sizes)
    if not fewer and (sizes > threshold).sum() > most:
        return position
    worst = _with_layers(step.pattern, sizes > threshold, step.system.prescribed_blocks, layers)
    while fewer and worst.sum() > most and RAISED * threshold < sizes.max():
        threshold *= RAISED
        worst = _with_layers(step.pattern, sizes > threshold, step.system.prescribed_blocks, layers)
    if not worst.any() or worst.sum() > most:
        return position
    local = LocalStep(step, worst, position)
    before = sizes.max() if use_interior_point else np.inf
    try:
        relaxed, stalled = _solve_subdomain(local, weight, GAIN * threshold, before)
    finally:
        local.close()
    step.interior_point_stalled |= stalled
    return _accepted_by_cluster(step, local, position, local.whole(relaxed), sizes, max_growth)


def subdomain_correction(step: Step, position: FloatArray, tolerance: float) -> Attempt | None:
    """Return the result of a regularised correction of the influence region alone, or None.

    The residual is hardly felt farther away, so a global correction would be much the same at ten times the cost. None
    where the region is empty or too large.
    """
    moves = _influence_region(step, position, tolerance)
    if not 0 < moves.sum() <= MAX_BLOCKS * len(moves):
        return None
    local = LocalStep(step, moves, position)
    try:
        found = newton(local, local.start, tolerance, regularized=True, max_iterations=1)
    finally:
        local.close()
    step.fail_contacts(local.rows[_newly_failed(step, local)])
    there = step.residual_at(local.whole(found.position))
    return Attempt(there.position, there.at, converged=there.max_norm < tolerance)


def is_local_disturbance(step: Step, tolerance: float) -> bool:
    """Return whether the influence region of the largest residuals at a step's start is a small part of all blocks."""
    moves = _influence_region(step, step.start, tolerance)
    return bool(moves.sum() <= MAX_BLOCKS * len(moves))


def _influence_region(step: Step, position: FloatArray, tolerance: float) -> BoolArray:
    """Return the blocks with the largest residuals and `INFLUENCE_LAYERS` of neighbours, (n,)."""
    sizes = _block_residuals(step, position)[0]
    large = sizes > _threshold(sizes, tolerance, RESIDUAL_CUTOFF)
    return _with_layers(step.pattern, large, step.system.prescribed_blocks, INFLUENCE_LAYERS)


def _threshold(sizes: FloatArray, tolerance: float, cutoff: float) -> float:
    """Return the residual, of all blocks' (n,), above which a block is in the subdomain."""
    greatest = float(sizes.max())
    return max(cutoff * greatest, min(3 * tolerance, greatest / 3))


def _newly_failed(step: Step, local: LocalStep) -> BoolArray:
    """Return which contacts of the subdomain failed during its solution, (l,)."""
    broken: BoolArray = local.contacts.failed & ~step.contacts.failed[local.rows]
    return broken


def _accepted_by_cluster(
    step: Step, local: LocalStep, position: FloatArray, relaxed: FloatArray, before: FloatArray, max_growth: float
) -> FloatArray:
    """Return the subdomain solution where it helps, cluster by cluster, its surroundings included.

    `before`: residual of every block at the position, (n,).
    """
    contacts, broken = step.contacts, _newly_failed(step, local)
    step.fail_contacts(local.rows[broken])
    after = _block_residuals(step, relaxed)[0]
    helped = local.by_cluster(after**2) <= max_growth**2 * local.by_cluster(before**2)
    if not helped.all():
        step.contacts = contacts
        step.fail_contacts(local.rows[broken & helped[local.cluster_of_row]])
        stay, relaxed = local.blocks[local.block[~helped[local.cluster]]], relaxed.copy()
        relaxed[stay] = position[stay]
        after = _block_residuals(step, relaxed)[0]
    if not helped.any() or (after**2).sum() > max_growth**2 * (before**2).sum():
        step.contacts = contacts
        return position
    return relaxed


def _block_residuals(step: Step, position: FloatArray) -> tuple[FloatArray, float]:
    """Return the maximum norm of every block's residual over the mean weight (n,), and that weight."""
    at = step.evaluate(position)
    weight = step.system.weight(at)
    free = step.project(step.residual(position, at.forces))
    return np.abs(free).max(axis=1) / weight, weight


def _solve_subdomain(local: LocalStep, weight: float, tolerance: float, before: float) -> tuple[FloatArray, bool]:
    """Return where the local blocks are best in balance, and whether the interior point method stalled."""
    position, size = _ClusterSearch(local, weight).relax(tolerance)
    if not size > ENOUGH * before:
        return position, False
    near = interior_point(local, local.start, max(tolerance, ENOUGH * before))
    if near is None:
        return position, True
    found = newton(local, near, tolerance, max_iterations=MAX_ITERATIONS)
    better = local.residual_at(found.position, weight).max_norm < size
    return found.position if better else position, False


class _ClusterSearch:
    """Newton's method on a subdomain, with a line search for every cluster.

    Parameters
    ----------
    local : LocalStep
        Their equations.
    weight : float [N/m]
        The mean weight.
    """

    def __init__(self, local: LocalStep, weight: float) -> None:
        self.local, self.weight = local, weight

    def relax(self, tolerance: float) -> tuple[FloatArray, float]:
        """Return its result, and the maximum norm of the residual there."""
        local = self.local
        here = local.residual_at(local.start, self.weight)
        for _ in range(MAX_ITERATIONS):
            if here.max_norm < tolerance:
                break
            data = local.tangent(here.at, tangent_regularization(here.max_norm))
            if not local.factorize(data, here.position):
                break
            movement = local.solve(here.forces)
            if not np.isfinite(movement).all():
                break
            before, here = here.l2_norm, local.residual_at(self._line_search(here, movement), self.weight)
            stalled = here.max_norm >= tolerance and here.l2_norm > STALLED * before
            if stalled and release_brittle_contacts(local, here, movement):
                here = local.residual_at(here.position, self.weight)
        return here.position, here.max_norm

    def _line_search(self, here: Residual, movement: FloatArray) -> FloatArray:
        """Return the position after the best part of a movement, chosen for every cluster."""
        local, position = self.local, here.position
        before = self._merit(here.forces)
        part, best_part = np.ones(local.clusters), np.ones(local.clusters)
        best, halve = np.full(local.clusters, np.inf), np.ones(local.clusters, dtype=bool)
        for _ in range(MAX_HALVINGS + 1):
            trial = self._moved(position, movement, part)
            merit = self._merit(local.residual(trial, local.evaluate(trial).forces))
            better = halve & (merit < best)
            best[better], best_part[better] = merit[better], part[better]
            halve &= merit >= (1 - 1e-3 * part) ** 2 * before
            if not halve.any():
                break
            part[halve] /= 2
        return self._moved(position, movement, best_part)

    def _moved(self, position: FloatArray, movement: FloatArray, part: FloatArray) -> FloatArray:
        block, moved = self.local.block, position.copy()
        moved[block] = moved_by(position[block], part[self.local.cluster, None] * movement[block])
        return moved

    def _merit(self, forces: FloatArray) -> FloatArray:
        """Return the square of the 2-norm of every cluster's residual."""
        local, free = self.local, self.local.project(forces)
        return np.bincount(local.cluster, weights=(free**2).sum(axis=1), minlength=local.clusters).astype(float)


def _with_layers(pattern: BlockPattern, marked: BoolArray, fixed: BoolArray, layers: int) -> BoolArray:
    """Return the marked blocks and those at most `layers` contacts away, not counted across fixed ones."""
    near = csr_array((np.ones(len(pattern.column), np.float32), pattern.column, pattern.row_start))
    for _ in range(layers):
        marked = marked | ((near @ marked.astype(np.float32) > 0) & ~fixed)
    return marked
