"""Corrections of the semismooth Newton method on the contact laws: tangent, line search, and the last factors again."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.solve.algebra.line_search import Decrease
from bsm_mesh.solve.algebra.mixed_precision import WORTH_REPEATING
from bsm_mesh.solve.step.equations import Residual, StepEquations

ROUNDING = np.finfo(float).eps  # a residual of exactly zero would leave blocks without stiffness in a singular matrix


@dataclass(frozen=True, slots=True, kw_only=True)
class CorrectionSettings:
    """Form of a correction.

    Attributes
    ----------
    max_halvings : int
        Of a correction, at most: to a sixty-fourth.
    regularization : float
        Part of their stiffness that open and slipping contacts keep in a regularised tangent where the residual is
        that of the weight. Less throws blocks with few contacts, more takes more corrections.
    """

    max_halvings: int = 6
    regularization: float = 0.1


SETTINGS = CorrectionSettings()


def newton_correction(step: StepEquations, here: Residual, regularization: float) -> FloatArray | None:
    """Return the movement (n, axes) that the tangent gives under a residual; None where it is singular.

    Open and slipping contacts keep a part `regularization` of their stiffness in it.
    """
    if not step.factorize(step.tangent(here.at, regularization), here.position):
        return None
    correction = step.solve(here.forces)
    return correction if np.isfinite(correction).all() else None


def chord_method(step: StepEquations, position: FloatArray, tolerance: float) -> FloatArray:
    """Return the result of the chord method (Newton with the last factors), continued while it reduces a norm enough.

    Near the end the 2-norm is that of rounding in all blocks, and only the maximum norm still falls.
    """
    here, reduces = step.residual_at(position), True
    while reduces and here.max_norm >= tolerance:
        there = step.residual_at(step.moved_by(here.position, step.solve(here.forces)))
        if not (there.max_norm <= here.max_norm and there.l2_norm <= here.l2_norm):
            break
        reduces = there.max_norm < WORTH_REPEATING * here.max_norm or there.l2_norm < WORTH_REPEATING * here.l2_norm
        here = there
    return here.position


def tangent_regularization(max_norm: float) -> float:
    """Return the part of their stiffness that open and slipping contacts keep, proportional to the residual."""
    return SETTINGS.regularization * min(1.0, max(max_norm, ROUNDING))


def line_search(step: StepEquations, here: Residual, correction: FloatArray, most: float) -> Residual:
    """Return the best of the corrections halved until the 2-norm falls below a norm `most` [N/m] (backtracking).

    The maximum norm as merit function needs many times the iterations.
    """
    size = step.movement(correction)
    part = min(1.0, step.max_movement / size) if size > 0 else 1.0
    tried, decrease = [], Decrease(most)
    for _ in range(SETTINGS.max_halvings + 1):
        tried.append(step.residual_at(step.moved_by(here.position, part * correction), here.weight))
        if decrease.reached(tried[-1].l2_norm, part):
            break
        part /= 2
    return tried[decrease.chosen]
