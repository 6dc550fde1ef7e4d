"""Semismooth Newton method on the contact laws, globalised by a line search on the 2-norm of the residual."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.solve.step.attempt import FEW_CHANGE, Attempt, Goal, Iterate, Outcome
from bsm_mesh.solve.step.equations import Residual, StepEquations, moved_by


@dataclass(frozen=True, slots=True, kw_only=True)
class NewtonSettings:
    """How far Newton's method goes.

    Attributes
    ----------
    max_iterations : int
        Corrections: it converges quadratically or, where contacts flicker, not at all.
    max_halvings : int
        Of a correction, at most: to a sixty-fourth.
    chord : float
        Part of either norm left by a chord iteration, above which it ends: rounding is near.
    regularization : float
        Part of their stiffness that open and slipping contacts keep in a regularised tangent where the residual is
        that of the weight. Less throws blocks with few contacts, more takes more corrections.
    """

    max_iterations: int = 12
    max_halvings: int = 6
    chord: float = 0.5
    regularization: float = 0.1


SETTINGS = NewtonSettings()


class ExactNewton:
    """Newton's method with the exact tangent, near rest, where it converges quadratically."""

    name = "Newton"

    def applies(self, equations: StepEquations, at: Iterate, goal: Goal) -> bool:
        """Return whether few contacts change in the step."""
        return goal.max_residual < FEW_CHANGE

    def solve(self, equations: StepEquations, at: Iterate, goal: Goal) -> Attempt:
        """Return the result from the step's start."""
        return newton(equations, equations.start, goal.max_residual)


def newton(
    step: StepEquations,
    position: FloatArray,
    tolerance: float,
    *,
    regularized: bool = False,
    max_iterations: int = SETTINGS.max_iterations,
    weight: float | None = None,
) -> Attempt:
    """Return the result of Newton's method.

    Parameters
    ----------
    step : StepEquations
        The equations.
    position : (n, 3) float64
        Initial position.
    tolerance : float
        Maximum norm of the residual over the mean weight.
    regularized : bool
        Use the regularised tangent (`tangent_regularization`).
    max_iterations : int
        Largest number of iterations.
    weight : float, optional
        Instead of the mean weight of the step [N/m].
    """
    here, outcome = step.residual_at(position, weight), Outcome.STALLED
    for iteration in range(max_iterations + 1):
        if here.max_norm < tolerance and (iteration or not step.supports_move):
            outcome = Outcome.SOLVED
            break
        if iteration == max_iterations:
            break
        data = step.tangent(here.at, tangent_regularization(here.max_norm) if regularized else 0.0)
        correction = step.solve(here.forces) if step.factorize(data, here.position) else None
        if correction is None or not np.isfinite(correction).all():
            outcome = Outcome.SINGULAR
            break
        here = _line_search(step, here, correction)
    return Attempt(equations=step, position=here.position, outcome=outcome)


def chord_method(step: StepEquations, position: FloatArray, tolerance: float) -> FloatArray:
    """Return the result of the chord method (Newton with the last factors), continued while it reduces a norm enough.

    Near the end the 2-norm is that of rounding in all blocks, and only the maximum norm still falls.
    """
    here, reduces = step.residual_at(position), True
    while reduces and here.max_norm >= tolerance:
        there = step.residual_at(moved_by(here.position, step.solve(here.forces)))
        if not (there.max_norm <= here.max_norm and there.l2_norm <= here.l2_norm):
            break
        reduces = there.max_norm < SETTINGS.chord * here.max_norm or there.l2_norm < SETTINGS.chord * here.l2_norm
        here = there
    return here.position


def tangent_regularization(max_norm: float) -> float:
    """Return the part of their stiffness that open and slipping contacts keep, proportional to the residual."""
    return SETTINGS.regularization * min(1.0, max_norm)


def _line_search(step: StepEquations, here: Residual, correction: FloatArray) -> Residual:
    """Return the best of the corrections halved until the 2-norm falls (backtracking).

    The maximum norm as merit function needs many times the iterations.
    """
    size = step.movement(correction)
    part = min(1.0, step.max_movement / size) if size > 0 else 1.0
    tried = []
    for _ in range(SETTINGS.max_halvings + 1):
        there = step.residual_at(moved_by(here.position, part * correction), here.weight)
        tried.append(there)
        if there.l2_norm < here.l2_norm:
            return there
        part /= 2
    return min(tried, key=lambda residual: np.nan_to_num(residual.l2_norm, nan=np.inf))
