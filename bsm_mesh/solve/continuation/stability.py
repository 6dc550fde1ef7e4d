"""Stability of an equilibrium: blocks balanced on corners are in equilibrium too, and Newton's method finds them."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.solve.step.equations import StepEquations
from bsm_mesh.solve.step.system import Evaluation

NEUTRAL = 1e-3  # over the block size: a negative eigenvalue nearer to zero counts as none
SHIFT = 4.0  # over the block size: below all eigenvalues; a block balanced on a corner has about -1


def falling_mode(step: StepEquations, position: FloatArray, at: Evaluation, tolerance: float) -> FloatArray | None:
    """Return the movement (n, axes) by which blocks leave an equilibrium, 1 m at most; None if they stay or have none.

    An equilibrium is stable where the elastic tangent K is positive definite. Where it is not, Lanczos's method on the
    shifted inverse gives the lowest mode of K x = w M x; a Rayleigh quotient is never below its w, so that no stable
    equilibrium is taken for unstable. The mode points where the forces at the start of the step led.
    """
    system, size = step.system, step.system.size
    static = step.static_problem_at(position, NEUTRAL / size, is_symmetric=True)
    max_norm, _ = static.residual_norms(static.residual(position, at.forces), system.weight(at))
    if system.mean_weight == 0 or max_norm >= tolerance:
        return None
    if step.factors.is_positive_definite(static.complete(static.elastic_tangent(at), position)):
        return None
    shifted = step.static_problem_at(position, SHIFT / size, is_symmetric=True)
    if not shifted.factorize(shifted.elastic_tangent(at), position):
        return None
    lowest, mode = _lowest_mode(shifted)
    if mode is None or lowest >= -NEUTRAL / size:
        return None
    forces = step.residual(step.start, step.evaluate(step.start).forces)
    return mode / step.movement(mode) * (-1.0 if (forces * mode).sum() < 0 else 1.0)


def _lowest_mode(shifted: StepEquations) -> tuple[float, FloatArray | None]:
    """Return a bound, at most 0, of the lowest eigenvalue of a factorized matrix without its shift, and the mode.

    The mode is sought by Lanczos's method on the inverse (ARPACK), until its eigenvalue is known to `NEUTRAL`.
    """
    from scipy.sparse.linalg import ArpackError, LinearOperator, eigsh  # few runs come by an unstable equilibrium

    mass = shifted.system.mass

    def operator(product: Callable[[FloatArray], FloatArray]) -> LinearOperator:
        return LinearOperator(
            (mass.size, mass.size), matvec=lambda x: product(x.reshape(mass.shape)).ravel(), dtype=float
        )

    weights, inverse = operator(lambda x: mass * x), operator(shifted.solve)
    begin = np.random.default_rng(0).normal(size=mass.size) * shifted.system.scale.ravel()
    try:
        _, vector = eigsh(weights, 1, weights, -shifted.lam, OPinv=inverse, v0=begin, tol=NEUTRAL / SHIFT)
    except ArpackError:  # it finds none, or a solution is not a number
        return 0.0, None
    pushed = mass * vector.reshape(mass.shape)
    mode = shifted.solve(pushed)
    lowest = float((mode * pushed).sum()) / float((mode * mass * mode).sum()) - shifted.lam
    return (lowest, mode) if np.isfinite(lowest) else (0.0, None)
