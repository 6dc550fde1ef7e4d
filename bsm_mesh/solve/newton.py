"""Newton's method on the exact laws of a step: semismooth, coupled, its corrections capped and halved."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.solve.brittle import breaking
from bsm_mesh.solve.moving import Evaluation, first_tangent, tangent_stiffness
from bsm_mesh.solve.step import Step, moved_by

MOST_ITERATIONS = 12
STALLED = 0.7  # of the 2-norm: with more left after an iteration, contacts are looked at whose laws jump
MOST_HALVINGS = 6
SOFTEST = 0.1  # of their stiffness: what open and slipping contacts keep in a softened tangent


@dataclass(frozen=True, eq=False, slots=True)
class Found:
    """A position, its contact forces, and whether they solve the step's equations."""

    position: FloatArray
    at: Evaluation
    converged: bool


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
        Greatest force out of balance over the reference weight.
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
    at = step.evaluate(position)
    forces = step.unbalanced(position, at.forces)
    greatest, norm = step.sizes(forces, step.moving.weight(at))
    for iteration in range(most + 1):
        if greatest < tolerance and (iteration or not step.driven):
            return Found(position, at, converged=True)
        if iteration == most:
            break
        places = step.pattern.place, len(step.pattern.column)
        if from_rest and iteration == 0:
            data = first_tangent(step.contacts, at, *places)
        else:
            data = tangent_stiffness(step.contacts, at, *places, softness_at(greatest) if softened else 0.0)
        if not step.factorize(data, position):
            break
        correction = step.solve(forces)
        if not np.isfinite(correction).all():
            break
        before = norm
        position, at, forces = _halved(step, position, correction, norm)
        greatest, norm = step.sizes(forces, step.moving.weight(at))
        if norm > STALLED * before and greatest >= tolerance:
            caught = breaking(step, position, at, forces, correction)
            if caught.size:
                step.break_contacts(caught)
                at = step.evaluate(position)
                forces = step.unbalanced(position, at.forces)
                greatest, norm = step.sizes(forces, step.moving.weight(at))
                continue
        if norm > contraction * before and greatest >= tolerance:
            break
    return Found(position, at, converged=False)


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


def _halved(
    step: Step, position: FloatArray, correction: FloatArray, norm: float
) -> tuple[FloatArray, Evaluation, FloatArray]:
    """Return the best of the corrections halved until the 2-norm falls.

    The greatest residual as merit needs many times the iterations.
    """
    size = step.movement(correction)
    part = min(1.0, step.longest / size) if size > 0 else 1.0
    best: tuple[float, FloatArray, Evaluation, FloatArray] | None = None
    for _ in range(MOST_HALVINGS + 1):
        trial = moved_by(position, part * correction)
        at = step.evaluate(trial)
        forces = step.unbalanced(trial, at.forces)
        found = step.sizes(forces, step.moving.weight(at))[1]
        if best is None or found < best[0]:
            best = found, trial, at, forces
        if found < (1 - 1e-3 * part) * norm:
            break
        part /= 2
    assert best is not None
    return best[1], best[2], best[3]
