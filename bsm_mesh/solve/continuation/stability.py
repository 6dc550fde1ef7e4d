"""Whether an equilibrium is stable: blocks balanced on corners are in equilibrium too, and Newton finds them."""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.solve.contacts.forces import Evaluation, elastic_tangent
from bsm_mesh.solve.step.equations import Step

SHIFT, BALANCED = 4.0, 1e-3  # over the block size
ITERATIONS = 12


def fall_rate(step: Step, position: FloatArray, at: Evaluation, tolerance: float) -> float:
    """Return how fast blocks fall out of an equilibrium, as a lam [1/m]; 0 where it is none, or a stable one.

    An equilibrium is stable where the tangent has no eigenvalue over the mass below zero: where it is positive definite
    with that much added. Where it is not, power iteration on the shifted inverse tells the lowest one; a Rayleigh
    quotient is never below it, so that nothing stable is taken for unstable.
    """
    moving, size = step.moving, step.moving.outlines.size
    static = step.resting(position, BALANCED / size)
    greatest, _ = static.sizes(static.unbalanced(position, at.forces), moving.weight(at))
    if moving.mean_weight == 0 or greatest >= tolerance:
        return 0.0
    if step.factors.is_positive_definite(static.complete(_stiffest(static, at), position)):
        return 0.0
    shifted = step.resting(position, SHIFT / size)
    if not shifted.factorize(_stiffest(shifted, at), position):
        return 0.0
    lowest = _lowest_eigenvalue(shifted)
    return -lowest if lowest < -BALANCED / size else 0.0


def _stiffest(static: Step, at: Evaluation) -> FloatArray:
    pattern = static.pattern
    return elastic_tangent(static.contacts, at, pattern.place, len(pattern.column), static.moving.outlines.size)


def _lowest_eigenvalue(shifted: Step) -> float:
    """Return the lowest eigenvalue over the mass, 0 at most, of what was factorized, without its shift: or more."""
    mass = shifted.moving.mass
    vector = np.random.default_rng(0).normal(size=mass.shape) * shifted.moving.scale
    lowest = 0.0
    for k in range(ITERATIONS):
        pushed = mass * vector
        found = shifted.solve(pushed)
        square = float((found * mass * found).sum())
        if not (np.isfinite(square) and square > 0):
            return 0.0
        if k:
            lowest = min(lowest, float((found * pushed).sum()) / square - shifted.lam)
        vector = found / np.sqrt(square)
    return lowest
