"""Strategies for a step: the order in which methods are tried at the start, near rest, and while blocks move."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.solve.contacts.forces import ContactSet
from bsm_mesh.solve.continuation.acceptance import MAX_RESIDUAL_MOVING, Acceptance
from bsm_mesh.solve.methods.interior_point import interior_point
from bsm_mesh.solve.methods.newton import MAX_ITERATIONS, elastic_position, newton
from bsm_mesh.solve.methods.regularized_newton import WORTHWHILE, regularized_newton
from bsm_mesh.solve.methods.subdomain_newton import is_local_disturbance
from bsm_mesh.solve.motion.relaxation import damp_to_rest
from bsm_mesh.solve.motion.sliding import can_follow_dynamically, follow_dynamically, is_fast
from bsm_mesh.solve.step.attempt import Attempt
from bsm_mesh.solve.step.equations import Step

MAX_MOVING = 6  # iterations of Newton's method in a moving step
MAX_POLISHING = 3  # iterations of Newton's method after the interior point method in a moving step
MAX_FAILURES = 2  # of a moving step, before frozen friction
MAX_PAUSE = 32  # moving steps with frozen friction after failures,
MAX_PAUSE_FOLLOWED = 4  # and in which slow blocks are followed dynamically
CRAWLING = 30.0  # lam d, above which blocks hardly move in a first step
REST_FACTOR = 1.9  # tolerance of damped motion over that of the step, which is at least half of that of rest
NEAR_REST = 1e-3  # tolerance of a step, below which few contacts still change and slow convergence is accepted
SWITCH_RESIDUAL = 1e-2  # exact residual at which the interior point method is followed by Newton's


class MovingSteps:
    """Strategy of the moving steps, which remembers failures of former ones.

    With Coulomb's coupling of pressure and friction a step may have no solution nearby: a contact that slides would
    stick, and sticking it would slide. Then blocks are followed dynamically (`sliding.py`), for some steps and for as
    long as they are fast. Where bolts or moving supports forbid that, friction is frozen: the step is a convex
    problem then, and has a solution. That is the last resort, because friction lags by a step: where shorter steps fail
    as well, and for some steps after.

    After an excavation few blocks move, and the others need not be solved again: a step may end with a residual of few
    blocks (`Acceptance`). So may the first one, where few of all blocks are set free.

    Parameters
    ----------
    excavated : bool
        The start was in equilibrium before a change (excavation).
    """

    def __init__(self, *, excavated: bool) -> None:
        self._excavated = excavated
        self._wait, self._pause = 0, 1

    def solve(self, step: Step, inner: float, *, from_rest: bool, failures: int) -> Attempt:
        """Return the attempt at a step, to a tolerance `inner`.

        Parameters
        ----------
        step : Step
            The equations.
        inner : float
            Maximum norm of the residual over the mean weight.
        from_rest : bool
            The first step: contacts have no forces, or those before an excavation. So begin with every contact within
            tolerance closed, and freeze friction only where blocks would hardly move: at the pressures of the elastic
            solution.
        failures : int
            Failures of this step with other regularisations.
        """
        near_rest, contacts = inner < NEAR_REST, step.contacts
        # at rest explicit motion would end without a cycle, and confirm nothing
        followed = step.velocity is not None and step.residual_at(step.start).max_norm >= inner
        if followed and failures == 0 and (is_fast(step) or self._wait > 0):
            self._wait = max(0, self._wait - 1)
            return follow_dynamically(step, inner)
        if not from_rest or (self._excavated and is_local_disturbance(step, inner)):
            found = self._nearby_equilibrium(step, inner, failures, near_rest=near_rest)
            if found is not None:
                self._pause = 1 if followed else self._pause
                return found
            step.contacts = contacts
        if from_rest or near_rest:
            most, contraction = (MAX_ITERATIONS, np.inf) if near_rest else (MAX_MOVING, WORTHWHILE)
            found = newton(step, step.start, inner, from_rest=from_rest, max_iterations=most, contraction=contraction)
            if found.converged:
                return found
            step.contacts = contacts
        if near_rest and not (followed or (failures and self._may_follow(step))):
            return newton_from_interior_point(step, step.start, inner, MAX_MOVING)
        if from_rest:
            return self._from_rest(step, inner, failures)
        return self._in_motion(step, inner, failures)

    def _nearby_equilibrium(self, step: Step, inner: float, failures: int, *, near_rest: bool) -> Attempt | None:
        """Return an attempt at an equilibrium near the start, or None."""
        contacts = step.contacts
        leftover = Acceptance(step) if self._excavated and not near_rest else None
        enough = None if leftover is None else leftover.accepts
        found = regularized_newton(
            step, step.start, inner, use_interior_point=True, subdomain_corrections=self._excavated, enough=enough
        )
        if found.converged:
            return found
        if leftover is not None and leftover.is_localized(here := step.residual_at(found.position)):
            if failures and leftover.accepts(here, shortened=True):
                return replace(found, converged=True)
            if failures < MAX_FAILURES:  # a shorter step costs less than other methods
                return found
        if not near_rest:
            return None
        calmed = _damped_to_rest(step, found.position, contacts, inner, patient=failures > 0)
        if calmed is not None:
            return calmed
        step.contacts = contacts
        holds = failures > 0 and not self._may_follow(step)
        frozen = _with_frozen_friction(step, step.anchor, inner) if holds else None
        return frozen if frozen is not None and frozen.converged else None

    def _from_rest(self, step: Step, inner: float, failures: int) -> Attempt:
        """Return the attempt at a first step without a solution by Newton's method.

        With the smallest regularisation there is mostly none. Where one that lets a free block move by a step length
        does not help either, blocks are followed dynamically.
        """
        if self._may_follow(step) and failures != 1:
            return follow_dynamically(step, inner) if failures else _failed(step)
        if step.lam * step.system.d > CRAWLING:
            return _with_frozen_friction(step, elastic_position(step), inner)
        return newton_from_interior_point(step, step.start, inner, MAX_MOVING)

    def _in_motion(self, step: Step, inner: float, failures: int) -> Attempt:
        """Return the attempt at a moving step that Newton's method does not solve: dynamic, or with frozen friction."""
        may_follow = self._may_follow(step)
        followed = may_follow and step.velocity is not None
        if self._wait == 0 and not followed and failures < (1 if may_follow else MAX_FAILURES):
            return newton_from_interior_point(step, step.start, inner, MAX_MOVING)
        if self._wait == 0:
            self._wait = self._pause
            self._pause = min(2 * self._pause, MAX_PAUSE_FOLLOWED if may_follow else MAX_PAUSE)
        if may_follow:
            return follow_dynamically(step, inner)
        self._wait -= 1
        return _with_frozen_friction(step, step.anchor, inner)

    def _may_follow(self, step: Step) -> bool:
        return can_follow_dynamically(step) and not self._excavated


def _damped_to_rest(
    step: Step, position: FloatArray, contacts: ContactSet, inner: float, *, patient: bool
) -> Attempt | None:
    """Return the result of damped motion from a position if its residual is smaller than at the start, or from there.

    `contacts`: those of the start; `patient` as in `damp_to_rest`, from the start, which is nearly in equilibrium:
    other methods may lead to one farther away.
    """
    if step.residual_at(position).max_norm < step.residual_at(step.start).max_norm:
        found = damp_to_rest(step, position, REST_FACTOR * inner)
        if found is not None:
            return found
    step.contacts = contacts
    return damp_to_rest(step, step.start, REST_FACTOR * inner, patient=patient)


def _with_frozen_friction(step: Step, position: FloatArray, inner: float) -> Attempt:
    """Return the attempt at a moving step with frozen friction: strengths at the pressures of a position.

    A residual below a weight is accepted, where contacts entered or left edges on the way.
    """
    frozen = step.with_frozen_friction(step.evaluate(position).pressure)
    near = interior_point(frozen, step.start, SWITCH_RESIDUAL)
    if near is None:
        return _failed(step)
    better = newton(frozen, near, inner, max_iterations=MAX_POLISHING)
    if better.converged:
        return better
    there = frozen.residual_at(near)
    return Attempt(near, there.at, converged=there.max_norm < MAX_RESIDUAL_MOVING)


def newton_from_interior_point(
    step: Step, elastic: FloatArray, tolerance: float, max_iterations: int, barriers: tuple[float, ...] = (1.0,)
) -> Attempt:
    """Return the result of Newton's method from the end of the interior point method."""
    for barrier in barriers:
        near = interior_point(step, elastic, SWITCH_RESIDUAL, barrier=barrier)
        if near is not None:
            contacts = step.contacts
            found = regularized_newton(step, near, tolerance)
            if not found.converged:
                step.contacts = contacts
                found = newton(step, near, tolerance, max_iterations=max_iterations)
            return found
    return _failed(step)


def _failed(step: Step) -> Attempt:
    return Attempt(step.start, step.evaluate(step.start), converged=False)
