"""Semismooth Newton method on the contact laws, globalised by a line search on the 2-norm of the residual.

With a regularised tangent open and slipping contacts keep a part of their stiffness in it, so that a correction does
not throw blocks with few closed contacts. The part is proportional to the residual: near the solution the tangent is
exact.

In a large model few blocks keep a large residual, and with it the regularisation of all, after the others have
converged. Where no contact has carried a force yet, they are solved apart, before and between corrections of the whole.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.solve.algebra.mixed_precision import WORTH_REPEATING
from bsm_mesh.solve.methods.corrections import chord_method, line_search, newton_correction, tangent_regularization
from bsm_mesh.solve.methods.subdomain_newton import SETTINGS as SUBDOMAIN
from bsm_mesh.solve.methods.subdomain_newton import block_residuals, subdomain_correction
from bsm_mesh.solve.step.attempt import FEW_CHANGE, Attempt, Goal, Iterate, Outcome
from bsm_mesh.solve.step.equations import Residual, StepEquations
from bsm_mesh.solve.step.subproblem import SubdomainEquations


@dataclass(frozen=True, slots=True, kw_only=True)
class NewtonSettings:
    """Until when it continues.

    Attributes
    ----------
    max_corrections : int
        Of the exact tangent, at most: it converges quadratically once its contacts and bolts no longer change, and
        before that as slowly as they do.
    max_updates : int
        Of the contacts, at most: a list that still changes then has no equilibrium nearby.
    shrinking : float
        Part to which two regularised corrections must reduce the 2-norm of the residual, or it has stalled.
    """

    max_corrections: int = 12
    max_updates: int = 6
    shrinking: float = 0.25


SETTINGS = NewtonSettings()


class RegularizedNewton:
    """Newton's method with a regularised tangent, from the step's start."""

    name = "regularized Newton"

    def applies(self, equations: StepEquations, at: Iterate, goal: Goal) -> bool:
        """Return True: it costs little where it fails."""
        return True

    def solve(self, equations: StepEquations, at: Iterate, goal: Goal) -> Attempt:
        """Return the result."""
        return newton(equations, equations.start, goal.max_residual)


class ExactNewton:
    """Newton's method with the exact tangent, near rest, where it converges quadratically."""

    name = "Newton"

    def applies(self, equations: StepEquations, at: Iterate, goal: Goal) -> bool:
        """Return whether few contacts change in the step."""
        return goal.max_residual < FEW_CHANGE

    def solve(self, equations: StepEquations, at: Iterate, goal: Goal) -> Attempt:
        """Return the result from the step's start."""
        attempt = newton(equations, equations.start, goal.max_residual, exact=True)
        for _ in range(SETTINGS.max_updates):  # where the way goes beyond the range of the contact search
            if attempt.outcome is not Outcome.SOLVED or attempt.equations.within_search_range(attempt.position):
                break
            attempt = newton(*_part_of_the_way(attempt), goal.max_residual, exact=True)
        return attempt


def _part_of_the_way(attempt: Attempt) -> tuple[StepEquations, FloatArray]:
    """Return the step with its contacts searched as far on the way to an equilibrium as they reached, and that place.

    The way is one turn about an instant centre: a block that rocks stays on its corner.
    """
    step = attempt.equations
    begin = step.searched
    part = (1 - 1e-9) * step.max_movement / step.movement(attempt.position - begin)  # but for rounding
    way = step.system.movement_between(begin, attempt.position)
    position = step.moved_by(begin, part * way)
    return step.with_contacts_at(position), position


class _Descent:
    """The 2-norms of the residual on the way of Newton's method.

    The norm falls with every correction, or it may rise to twice its least value so far. A block on one corner at its
    strength turns until another corner touches. Until then no force changes, and no part of a correction reduces the
    norm.

    References
    ----------
    Grippo, Lampariello & Lucidi (1986), A nonmonotone line search technique for Newton's method, SIAM J. Numer. Anal.
    23(4), 707-716.
    """

    def __init__(self, here: Residual, shrinking: float, *, exact: bool, may_rise: bool) -> None:
        self.least, self._shrinking, self._exact, self._may_rise = here, shrinking, exact, may_rise
        self._within = SETTINGS.max_corrections if may_rise else 2
        self._norms = [np.inf] * self._within + [here.l2_norm]

    @property
    def corrections(self) -> int:
        """Number of corrections so far."""
        return len(self._norms) - self._within - 1

    @property
    def most(self) -> float:
        """The norm that the next correction may have at most [N/m]."""
        return self.least.l2_norm / (WORTH_REPEATING if self._may_rise else 1.0)

    @property
    def has_stalled(self) -> bool:
        """Whether two corrections brought too little; if the norm may rise, as many as exact ones at most nothing."""
        if self._exact:
            return self.corrections == SETTINGS.max_corrections
        now, then = self._norms[-1], self._norms[-1 - self._within]
        return not (now < then if self._may_rise else now <= self._shrinking * then)  # so does a number that is none

    def add(self, here: Residual) -> None:
        """Add the residual after a correction."""
        self.least = here if not self._may_rise or here.l2_norm < self.least.l2_norm else self.least
        self._norms.append(self.least.l2_norm)


def newton(
    step: StepEquations,
    position: FloatArray,
    tolerance: float,
    *,
    exact: bool = False,
    shrinking: float = SETTINGS.shrinking,
    max_rms: float = 0.0,
    localized: bool = False,
    sweeps: bool = False,
    may_rise: bool = False,
) -> Attempt:
    """Return the result of Newton's method.

    Parameters
    ----------
    step : StepEquations
        The equations.
    position : (n, axes) float64
        Initial position.
    tolerance : float
        Maximum norm of the residual, over the mean weight.
    exact : bool
        Use the exact tangent, not the regularised one (`tangent_regularization`).
    shrinking : float
        The part to which two regularised corrections must reduce the 2-norm.
    max_rms : float
        Rms residual with which it may end, though few blocks exceed the tolerance.
    localized : bool
        Corrections move the influence region of the largest residuals alone, where that is a small part of all.
    sweeps : bool
        Blocks with a large residual are solved apart, before the first correction and after each.
    may_rise : bool
        The 2-norm may rise on the way. It has stalled where `SETTINGS.max_corrections` brought none that is less.
    """
    here, outcome = step.residual_at(position), Outcome.SINGULAR
    here = _swept(step, here, tolerance) if sweeps else here
    descent = _Descent(here, shrinking, exact=exact, may_rise=may_rise)
    while True:
        if here.max_norm < tolerance and not (step.supports_move and descent.corrections == 0):
            outcome = Outcome.SOLVED
            break
        if here.rms < max_rms:
            outcome = Outcome.ACCEPTABLE
            break
        if descent.has_stalled:
            outcome = Outcome.STALLED
            break
        corrected = subdomain_correction(step, here.position) if localized else None
        if corrected is not None:
            here = step.residual_at(corrected)
        else:
            correction = newton_correction(step, here, 0.0 if exact else tangent_regularization(here.max_norm))
            if correction is None:
                break
            here = line_search(step, here, correction, descent.most)
            here = _swept(step, here, tolerance) if sweeps else here
        descent.add(here)
    return Attempt(equations=step, position=here.position, outcome=outcome)


def _swept(step: StepEquations, here: Residual, tolerance: float) -> Residual:
    """Return the residual after sweeps, without a factorization of the whole, while they halve its 2-norm.

    A sweep solves the blocks above the root mean square with all others fixed. What that leaves around them is
    corrected by the chord method, where there are factors. Others keep up to the root mean square: there are no sweeps
    where that alone leaves the regularisation as it is.
    """
    while here.max_norm >= tolerance and tangent_regularization(here.rms) < tangent_regularization(here.max_norm):
        sizes, _ = block_residuals(step, here.position)
        moves = sizes > here.rms
        if not 0 < moves.sum() <= SUBDOMAIN.max_share * len(moves):
            break
        local = SubdomainEquations(step, moves, here.position)
        try:
            solved = _solved_apart(local, FEW_CHANGE * here.max_norm)
        finally:
            local.close()
        reached = local.whole(solved.position)
        there = step.residual_at(chord_method(step, reached, tolerance) if step.factors.ready else reached)
        if not there.l2_norm < here.l2_norm:
            break
        before, here = here, there
        if here.l2_norm > WORTH_REPEATING * before.l2_norm:
            break
    return here


def _solved_apart(local: SubdomainEquations, tolerance: float) -> Attempt:
    """Return the result for blocks apart; where the norm cannot fall all the way, with corrections that let it rise."""
    found = newton(local, local.start, tolerance, shrinking=WORTH_REPEATING)
    if found.may_end:
        return found
    other = newton(local, local.start, tolerance, shrinking=WORTH_REPEATING, may_rise=True)
    return other if other.may_end else found
