"""Whether an equilibrium is stable: blocks balanced on corners are in equilibrium too, and Newton finds them."""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.solve.moving import Evaluation, elastic_tangent
from bsm_mesh.solve.step import Step

SHIFT, BALANCED = 4.0, 1e-3  # over the block size
ITERATIONS = 12


def fall_rate(step: Step, position: FloatArray, at: Evaluation, tolerance: float) -> float:
    """Return how fast blocks fall out of an equilibrium, as a lam [1/m]; 0 where it is none, or a stable one.

    The lowest eigenvalue of the tangent over the mass, from power iteration on the shifted inverse, tells: a Rayleigh
    quotient is never below it, so that nothing stable is taken for unstable.
    """
    moving = step.moving
    static = Step(moving, step.factors, step.contacts, position, SHIFT / moving.outlines.size)
    greatest, _ = static.sizes(static.unbalanced(position, at.forces), moving.weight(at))
    if moving.reference == 0 or greatest >= tolerance:
        return 0.0
    pattern = static.pattern
    data = elastic_tangent(step.contacts, at, pattern.place, len(pattern.column), moving.outlines.size)
    if not static.factorize(data, position):
        return 0.0
    vector = np.random.default_rng(0).normal(size=position.shape) * moving.scale
    lowest = 0.0
    for k in range(ITERATIONS):
        pushed = moving.mass * vector
        found = static.solve(pushed)
        square = float((found * moving.mass * found).sum())
        if not (np.isfinite(square) and square > 0):
            return 0.0
        if k:
            lowest = min(lowest, float((found * pushed).sum()) / square - static.lam)
        vector = found / np.sqrt(square)
    return -lowest if lowest < -BALANCED / moving.outlines.size else 0.0
