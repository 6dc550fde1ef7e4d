"""Newton's method on the exact laws of a step: semismooth, coupled, its corrections capped and halved."""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.solve.contacts.forces import first_tangent
from bsm_mesh.solve.methods.brittle import break_caught
from bsm_mesh.solve.step.attempt import Found
from bsm_mesh.solve.step.equations import Balance, Step, moved_by

MOST_ITERATIONS = 12
STALLED = 0.7  # of the 2-norm: with more left after an iteration, contacts are looked at whose laws jump
MOST_HALVINGS = 6
CHORD = 0.5  # of greatest force or 2-norm: with more left by the last factors, new ones are wanted
SOFTEST = 0.1  # of their stiffness: what open and slipping contacts keep in a softened tangent


def newton(
    step: Step,
    position: FloatArray,
    tolerance: float,
    *,
    from_rest: bool = False,
    softened: bool = False,
    contraction: float = np.inf,
    most: int = MOST_ITERATIONS,
) -> Found:
    """Return where Newton's method ends.

    Parameters
    ----------
    step : Step
        The equations.
    position : (n, 3) float64
        Where to begin.
    tolerance : float
        Greatest force out of balance over the mean weight.
    from_rest : bool
        Begin with every touching contact closed and sticking: with none of them bearing anything yet, the tangent
        would be empty.
    softened : bool
        Leave open and slipping contacts a part of their stiffness in the tangent.
    contraction : float
        Give up after an iteration that does not shrink the 2-norm to this part of it.
    most : int
        Iterations at most.
    """
    here = step.balance_at(position)
    for iteration in range(most + 1):
        if here.greatest < tolerance and (iteration or not step.driven):
            return Found(here.position, here.at, converged=True)
        if iteration == most:
            break
        if from_rest and iteration == 0:
            data = first_tangent(step.contacts, here.at, step.pattern.place, len(step.pattern.column))
        else:
            data = step.tangent(here.at, softness_at(here.greatest) if softened else 0.0)
        if not step.factorize(data, here.position):
            break
        correction = step.solve(here.forces)
        if not np.isfinite(correction).all():
            break
        before, here = here.norm, _halved(step, here, correction)
        if here.greatest >= tolerance and here.norm > STALLED * before and break_caught(step, here, correction):
            here = step.balance_at(here.position)
        elif here.greatest >= tolerance and here.norm > contraction * before:
            break
    return Found(here.position, here.at, converged=False)


def chord_method(step: Step, position: FloatArray, tolerance: float) -> FloatArray:
    """Return where Newton's method with the last factors, whatever they are of, ends: it goes on while it pays.

    Near the end the 2-norm is that of rounding in all blocks, and only the greatest force still falls.
    """
    here, pays = step.balance_at(position), True
    while pays and here.greatest >= tolerance:
        there = step.balance_at(moved_by(here.position, step.solve(here.forces)))
        if not (there.greatest <= here.greatest and there.norm <= here.norm):
            break
        pays = there.greatest < CHORD * here.greatest or there.norm < CHORD * here.norm
        here = there
    return here.position


def softness_at(greatest: float) -> float:
    """Return the part of their stiffness that open and slipping contacts keep, falling with what is out of balance."""
    return SOFTEST * min(1.0, greatest)


def elastic_position(step: Step) -> FloatArray:
    """Return where the step's forces bring the blocks with every touching contact closed and sticking, (n, 3).

    It is not halved: the laws may be far from satisfied there.
    """
    at = step.evaluate(step.start)
    forces = step.unbalanced(step.start, at.forces)
    data = first_tangent(step.contacts, at, step.pattern.place, len(step.pattern.column))
    if not step.factorize(data, step.start):
        return step.start
    movement = step.solve(forces)
    return moved_by(step.start, movement) if np.isfinite(movement).all() else step.start


def _halved(step: Step, here: Balance, correction: FloatArray) -> Balance:
    """Return the best of the corrections halved until the 2-norm falls.

    The greatest residual as merit needs many times the iterations.
    """
    size = step.movement(correction)
    part = min(1.0, step.longest / size) if size > 0 else 1.0
    best: Balance | None = None
    for _ in range(MOST_HALVINGS + 1):
        there = step.balance_at(moved_by(here.position, part * correction))
        if best is None or there.norm < best.norm:
            best = there
        if there.norm < (1 - 1e-3 * part) * here.norm:
            break
        part /= 2
    assert best is not None
    return best
