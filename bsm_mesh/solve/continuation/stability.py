"""Stability of an equilibrium: blocks balanced on corners are in equilibrium too, and Newton's method finds them."""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.solve.contacts.forces import Evaluation, elastic_tangent
from bsm_mesh.solve.step.equations import StepEquations

SHIFT, NEUTRAL = 4.0, 1e-3  # shift, and negative eigenvalue that counts as none, over the block size
ITERATIONS = 12


def instability_rate(step: StepEquations, position: FloatArray, at: Evaluation, tolerance: float) -> float:
    """Return the magnitude of the lowest negative eigenvalue of K x = w M x [1/m]; 0 if none, or without equilibrium.

    An equilibrium is stable where the elastic tangent K is positive definite. Where it is not, power iteration on the
    shifted inverse gives the lowest eigenvalue; a Rayleigh quotient is never below it, so that no stable equilibrium is
    taken for unstable.
    """
    system, size = step.system, step.system.outlines.size
    static = step.static_problem_at(position, NEUTRAL / size)
    max_norm, _ = static.residual_norms(static.residual(position, at.forces), system.weight(at))
    if system.mean_weight == 0 or max_norm >= tolerance:
        return 0.0
    if step.factors.is_positive_definite(static.complete(_stiffest(static, at), position)):
        return 0.0
    shifted = step.static_problem_at(position, SHIFT / size)
    if not shifted.factorize(_stiffest(shifted, at), position):
        return 0.0
    lowest = _lowest_eigenvalue(shifted)
    return -lowest if lowest < -NEUTRAL / size else 0.0


def _stiffest(static: StepEquations, at: Evaluation) -> FloatArray:
    pattern = static.pattern
    return elastic_tangent(static.contacts, at, pattern.place, len(pattern.column), static.system.outlines.size)


def _lowest_eigenvalue(shifted: StepEquations) -> float:
    """Return an upper bound of the lowest eigenvalue, at most 0, of the factorized matrix without its shift."""
    mass = shifted.system.mass
    vector = np.random.default_rng(0).normal(size=mass.shape) * shifted.system.scale
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
