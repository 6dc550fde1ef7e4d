"""The few blocks that are far out of balance solved on their own, the rest held: between factorizations of the whole.

Where few contacts still change, the line search of the whole system would take short steps for their sake, each with
a factorization of the whole. Here the blocks around them are solved by Newton's method, every cluster with its own line
search, and by the interior point method where that does not end. The step stays one problem: what the clusters leave
out of balance around them, the whole system takes up.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_array

from bsm_mesh.arrays import BoolArray, FloatArray
from bsm_mesh.solve.algebra.block_matrix import BlockPattern
from bsm_mesh.solve.methods.brittle import break_caught
from bsm_mesh.solve.methods.interior_point import interior_point
from bsm_mesh.solve.methods.newton import MOST_HALVINGS, STALLED, newton, softness_at
from bsm_mesh.solve.step.attempt import Found
from bsm_mesh.solve.step.equations import Balance, Step, moved_by
from bsm_mesh.solve.step.subproblem import LocalStep

FLAGGED = 3e-3  # of the greatest force out of balance: blocks above this are solved on their own
RINGS, AROUND = 5, 25  # of blocks around them that move with them until they rest, and in a correction
MOST_BLOCKS = 0.25  # of all blocks: beyond, solving them apart saves nothing;
RAISED = 3.0  # times the force above which blocks are flagged, until they are fewer
MOST_ITERATIONS = 12
GAIN = 0.1  # the clusters' forces out of balance are shrunk to this part of what flags a block
ENOUGH = 0.1  # of their greatest force out of balance: with more left, the interior point method is tried
WORSE = 1.2  # the 2-norm of the whole may grow by this, else the phase is taken back


def relax_locally(
    step: Step,
    position: FloatArray,
    tolerance: float,
    *,
    inside: bool = False,
    rings: int = RINGS,
    worse: float = WORSE,
    flagged: float = FLAGGED,
    fewer: bool = False,
) -> FloatArray:
    """Return a position at which the blocks worst out of balance are relaxed; the same one where that does not help.

    Parameters
    ----------
    step : Step
        The equations.
    position : (n, 3) float64
        Where most blocks are in balance.
    tolerance : float
        Greatest force out of balance that is wanted, over the mean weight.
    inside : bool
        By the interior point method as well, where Newton's does not end; the step keeps whether it jammed.
    rings : int
        Of blocks around the worst ones that move with them.
    worse : float
        By how much the 2-norm may grow: around what slides far it grows until all blocks have followed.
    flagged : float
        Of the greatest force out of balance: blocks above this are the worst.
    fewer : bool
        Where those are too many, the worst of them.
    """
    sizes, weight = _out_of_balance(step, position)
    threshold = _threshold(sizes, tolerance, flagged)
    most = MOST_BLOCKS * len(sizes)
    if not fewer and (sizes > threshold).sum() > most:
        return position
    worst = _grown(step.pattern, sizes > threshold, step.moving.driven, rings)
    while fewer and worst.sum() > most and RAISED * threshold < sizes.max():
        threshold *= RAISED
        worst = _grown(step.pattern, sizes > threshold, step.moving.driven, rings)
    if not worst.any() or worst.sum() > most:
        return position
    local = LocalStep(step, worst, position)
    before = sizes.max() if inside else np.inf
    try:
        relaxed, jammed = _relaxed(local, weight, GAIN * threshold, before)
    finally:
        local.close()
    step.jammed |= jammed
    return _taken(step, local, position, local.whole(relaxed), sizes, worse)


def correct_locally(step: Step, position: FloatArray, tolerance: float) -> Found | None:
    """Return where a softened correction leads that only the blocks far around the worst ones make, or None.

    What those lack is hardly felt farther away, so a correction of all blocks would lead to much the same, and take ten
    times as long. None where too many blocks would move, or none.
    """
    moves = _far_around_worst(step, position, tolerance)
    if not 0 < moves.sum() <= MOST_BLOCKS * len(moves):
        return None
    local = LocalStep(step, moves, position)
    try:
        found = newton(local, local.start, tolerance, softened=True, most=1)
    finally:
        local.close()
    step.break_contacts(local.rows[_broken(step, local)])
    there = step.balance_at(local.whole(found.position))
    return Found(there.position, there.at, converged=there.greatest < tolerance)


def begins_with_few(step: Step, tolerance: float) -> bool:
    """Return whether the blocks worst out of balance at a step's start, with those far around them, are few of all."""
    moves = _far_around_worst(step, step.start, tolerance)
    return bool(moves.sum() <= MOST_BLOCKS * len(moves))


def _far_around_worst(step: Step, position: FloatArray, tolerance: float) -> BoolArray:
    """Return the blocks that are worst out of balance and those far around them, (n,)."""
    sizes = _out_of_balance(step, position)[0]
    return _grown(step.pattern, sizes > _threshold(sizes, tolerance, FLAGGED), step.moving.driven, AROUND)


def _threshold(sizes: FloatArray, tolerance: float, flagged: float) -> float:
    """Return above which force out of balance, of all blocks' (n,), a block is one of the worst."""
    greatest = float(sizes.max())
    return max(flagged * greatest, min(3 * tolerance, greatest / 3))


def _broken(step: Step, local: LocalStep) -> BoolArray:
    """Return which contacts of some blocks broke while those were solved on their own, (l,)."""
    broken: BoolArray = local.contacts.failed & ~step.contacts.failed[local.rows]
    return broken


def _taken(
    step: Step, local: LocalStep, position: FloatArray, relaxed: FloatArray, before: FloatArray, worse: float
) -> FloatArray:
    """Return the relaxed position where that helps, cluster by cluster, what is around each counted with it.

    `before`: what every block had out of balance at the position, (n,).
    """
    contacts, broken = step.contacts, _broken(step, local)
    step.break_contacts(local.rows[broken])
    after = _out_of_balance(step, relaxed)[0]
    helped = local.by_cluster(after**2) <= worse**2 * local.by_cluster(before**2)
    if not helped.all():
        step.contacts = contacts
        step.break_contacts(local.rows[broken & helped[local.cluster_of_row]])
        stay, relaxed = local.blocks[local.block[~helped[local.cluster]]], relaxed.copy()
        relaxed[stay] = position[stay]
        after = _out_of_balance(step, relaxed)[0]
    if not helped.any() or (after**2).sum() > worse**2 * (before**2).sum():
        step.contacts = contacts
        return position
    return relaxed


def _out_of_balance(step: Step, position: FloatArray) -> tuple[FloatArray, float]:
    """Return every block's greatest force out of balance over the mean weight (n,), and that weight."""
    at = step.evaluate(position)
    weight = step.moving.weight(at)
    free = step.free(step.unbalanced(position, at.forces))
    return np.abs(free).max(axis=1) / weight, weight


def _relaxed(local: LocalStep, weight: float, tolerance: float, before: float) -> tuple[FloatArray, bool]:
    """Return where the local blocks are best in balance, and whether the interior point method jammed."""
    position, size = _Search(local, weight).relax(tolerance)
    if not size > ENOUGH * before:
        return position, False
    near = interior_point(local, local.start, max(tolerance, ENOUGH * before))
    if near is None:
        return position, True
    found = newton(local, near, tolerance, most=MOST_ITERATIONS)
    better = local.balance_at(found.position, weight).greatest < size
    return found.position if better else position, False


class _Search:
    """Newton's method on the local blocks, with a line search for every cluster of them.

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
        """Return where it ends, and the greatest force out of balance there."""
        local = self.local
        here = local.balance_at(local.start, self.weight)
        for _ in range(MOST_ITERATIONS):
            if here.greatest < tolerance:
                break
            data = local.tangent(here.at, softness_at(here.greatest))
            if not local.factorize(data, here.position):
                break
            movement = local.solve(here.forces)
            if not np.isfinite(movement).all():
                break
            before, here = here.norm, local.balance_at(self._searched(here, movement), self.weight)
            if here.greatest >= tolerance and here.norm > STALLED * before and break_caught(local, here, movement):
                here = local.balance_at(here.position, self.weight)
        return here.position, here.greatest

    def _searched(self, here: Balance, movement: FloatArray) -> FloatArray:
        """Return the position after the best part of a movement, another one for every cluster."""
        local, position = self.local, here.position
        before = self._merit(here.forces)
        part, best_part = np.ones(local.clusters), np.ones(local.clusters)
        best, halve = np.full(local.clusters, np.inf), np.ones(local.clusters, dtype=bool)
        for _ in range(MOST_HALVINGS + 1):
            trial = self._moved(position, movement, part)
            merit = self._merit(local.unbalanced(trial, local.evaluate(trial).forces))
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
        """Return the square of the 2-norm of every cluster."""
        local, free = self.local, self.local.free(forces)
        return np.bincount(local.cluster, weights=(free**2).sum(axis=1), minlength=local.clusters).astype(float)


def _grown(pattern: BlockPattern, flagged: BoolArray, held: BoolArray, rings: int) -> BoolArray:
    """Return the flagged blocks and those that are at most `rings` contacts away, not counted across held ones."""
    near = csr_array((np.ones(len(pattern.column), np.float32), pattern.column, pattern.row_start))
    for _ in range(rings):
        flagged = flagged | ((near @ flagged.astype(np.float32) > 0) & ~held)
    return flagged
