"""Semismooth Newton method on the exact contact laws, globalised by a line search on the 2-norm of the residual."""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.solve.contacts.forces import first_tangent
from bsm_mesh.solve.methods.brittle import release_brittle_contacts
from bsm_mesh.solve.step.attempt import Attempt
from bsm_mesh.solve.step.equations import Residual, Step, moved_by

MAX_ITERATIONS = 12
STALLED = 0.7  # part of the 2-norm left by an iteration, above which contacts at a strength drop are released
MAX_HALVINGS = 6
CHORD = 0.5  # part of either norm left by a chord iteration, above which it ends
MAX_REGULARIZATION = 0.1  # part of their stiffness that open and slipping contacts keep in a regularised tangent


def newton(
    step: Step,
    position: FloatArray,
    tolerance: float,
    *,
    from_rest: bool = False,
    regularized: bool = False,
    contraction: float = np.inf,
    max_iterations: int = MAX_ITERATIONS,
) -> Attempt:
    """Return the result of Newton's method.

    Parameters
    ----------
    step : Step
        The equations.
    position : (n, 3) float64
        Initial position.
    tolerance : float
        Maximum norm of the residual over the mean weight.
    from_rest : bool
        Begin with every contact within tolerance closed and sticking: without contact forces the tangent would be
        empty.
    regularized : bool
        Use the regularised tangent (`tangent_regularization`).
    contraction : float
        Stop after an iteration that reduces the 2-norm by less than to this part.
    max_iterations : int
        Largest number of iterations.
    """
    here = step.residual_at(position)
    for iteration in range(max_iterations + 1):
        if here.max_norm < tolerance and (iteration or not step.supports_move):
            return Attempt(here.position, here.at, converged=True)
        if iteration == max_iterations:
            break
        if from_rest and iteration == 0:
            data = first_tangent(step.contacts, here.at, step.pattern.place, len(step.pattern.column))
        else:
            data = step.tangent(here.at, tangent_regularization(here.max_norm) if regularized else 0.0)
        if not step.factorize(data, here.position):
            break
        correction = step.solve(here.forces)
        if not np.isfinite(correction).all():
            break
        before, here = here.l2_norm, _line_search(step, here, correction)
        stalled = here.max_norm >= tolerance and here.l2_norm > STALLED * before
        if stalled and release_brittle_contacts(step, here, correction):
            here = step.residual_at(here.position)
        elif here.max_norm >= tolerance and here.l2_norm > contraction * before:
            break
    return Attempt(here.position, here.at, converged=False)


def chord_method(step: Step, position: FloatArray, tolerance: float) -> FloatArray:
    """Return the result of the chord method (Newton with the last factors), continued while it reduces a norm enough.

    Near the end the 2-norm is that of rounding in all blocks, and only the maximum norm still falls.
    """
    here, reduces = step.residual_at(position), True
    while reduces and here.max_norm >= tolerance:
        there = step.residual_at(moved_by(here.position, step.solve(here.forces)))
        if not (there.max_norm <= here.max_norm and there.l2_norm <= here.l2_norm):
            break
        reduces = there.max_norm < CHORD * here.max_norm or there.l2_norm < CHORD * here.l2_norm
        here = there
    return here.position


def tangent_regularization(max_norm: float) -> float:
    """Return the part of their stiffness that open and slipping contacts keep, proportional to the residual."""
    return MAX_REGULARIZATION * min(1.0, max_norm)


def elastic_position(step: Step) -> FloatArray:
    """Return the elastic solution of the step: every contact within tolerance closed and sticking, (n, 3).

    No line search: the laws may be far from satisfied there.
    """
    at = step.evaluate(step.start)
    forces = step.residual(step.start, at.forces)
    data = first_tangent(step.contacts, at, step.pattern.place, len(step.pattern.column))
    if not step.factorize(data, step.start):
        return step.start
    movement = step.solve(forces)
    return moved_by(step.start, movement) if np.isfinite(movement).all() else step.start


def _line_search(step: Step, here: Residual, correction: FloatArray) -> Residual:
    """Return the best of the corrections halved until the 2-norm falls (backtracking line search).

    The maximum norm as merit function needs many times the iterations.
    """
    size = step.movement(correction)
    part = min(1.0, step.max_movement / size) if size > 0 else 1.0
    best: Residual | None = None
    for _ in range(MAX_HALVINGS + 1):
        there = step.residual_at(moved_by(here.position, part * correction))
        if best is None or there.l2_norm < best.l2_norm:
            best = there
        if there.l2_norm < (1 - 1e-3 * part) * here.l2_norm:
            break
        part /= 2
    assert best is not None
    return best
