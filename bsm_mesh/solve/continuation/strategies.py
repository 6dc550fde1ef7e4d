"""How the equations of one step are solved: Newton's method, and what helps it where too many contacts change.

At the start, where a model at rest is one step from its equilibrium; near rest, where few contacts still change; and
while blocks move, where only the verdict counts and the path is viscous anyway.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.solve.contacts.forces import MovingContacts
from bsm_mesh.solve.continuation.acceptance import UNPOLISHED, Leftover
from bsm_mesh.solve.methods.interior_point import interior_point
from bsm_mesh.solve.methods.newton import MOST_ITERATIONS, elastic_position, newton
from bsm_mesh.solve.methods.regularized_newton import WORTHWHILE, softened_newton
from bsm_mesh.solve.methods.subdomain_newton import begins_with_few
from bsm_mesh.solve.motion.relaxation import calm
from bsm_mesh.solve.motion.sliding import can_slide, slide, slides
from bsm_mesh.solve.step.attempt import Found
from bsm_mesh.solve.step.equations import Step

MOST_MOVING = 6  # iterations of Newton's method in a moving step, while it is worthwhile
MOST_POLISHING = 3  # iterations of Newton's method after the interior point method in a moving step
MOST_FAILURES = 2  # of a moving step, from which on shear strengths are held
LONGEST_PAUSE = 32  # moving steps for which they are held after failures,
LONGEST_FOLLOWED = 4  # and for which slow blocks are followed by cycles
CRAWLING = 30.0  # of lam d: a first step with more would take blocks nowhere
CALM_ENOUGH = 1.9  # of a step's tolerance, at least half of what counts as rest: what explicit cycles may leave
NEAR_REST = 1e-3  # tolerance of a step below which few contacts still change: Newton's method is given time
HAND_OVER = 1e-2  # residual by the exact laws at which the interior point method hands over to Newton's


class MovingSteps:
    """Solves the steps in which blocks move, one after the other, and learns from them.

    With Coulomb's coupling of pressure and friction a step may have no solution close by: a contact that slides
    would stick, and sticking it would slide. Then cycles follow the blocks (`sliding.py`), for some steps and for as
    long as they are fast. Where bolts or moving supports forbid that, shear strengths are held: the step is a convex
    problem then, and has a solution. That is the last resort, because friction lags by a step: where shorter steps fail
    as well, and for some steps after.

    After an excavation few blocks move, and the others need not be solved again for what those lack: a step ends though
    they lack a part of their weight. So does the first one, where it set few of all blocks free.

    Parameters
    ----------
    excavated : bool
        The start was at rest until something was changed.
    """

    def __init__(self, *, excavated: bool) -> None:
        self._excavated = excavated
        self._wait, self._pause = 0, 1

    def solve(self, step: Step, inner: float, *, from_rest: bool, failures: int) -> Found:
        """Return the end of a step to a tolerance `inner`.

        Parameters
        ----------
        step : Step
            The equations.
        inner : float
            Greatest force out of balance, over the mean weight.
        from_rest : bool
            The first step: contacts bear nothing yet, or what they bore before an excavation; so begin with every
            touching contact closed, and hold no strength unless blocks would crawl: then that of the pressures which
            closed contacts would bear.
        failures : int
            How often this step failed with other regularisations.
        """
        near_rest, contacts = inner < NEAR_REST, step.contacts
        # at rest a slide would end without a cycle, and confirm nothing
        followed = step.velocity is not None and step.balance_at(step.start).greatest >= inner
        if followed and failures == 0 and (slides(step) or self._wait > 0):
            self._wait = max(0, self._wait - 1)
            return slide(step, inner)
        if not from_rest or (self._excavated and begins_with_few(step, inner)):
            found = self._next_to_start(step, inner, failures, near_rest=near_rest)
            if found is not None:
                self._pause = 1 if followed else self._pause
                return found
            step.contacts = contacts
        if from_rest or near_rest:
            most, contraction = (MOST_ITERATIONS, np.inf) if near_rest else (MOST_MOVING, WORTHWHILE)
            found = newton(step, step.start, inner, from_rest=from_rest, most=most, contraction=contraction)
            if found.converged:
                return found
            step.contacts = contacts
        if near_rest and not (followed or (failures and self._may_slide(step))):
            return from_inside(step, step.start, inner, MOST_MOVING)
        if from_rest:
            return self._from_rest(step, inner, failures)
        return self._in_motion(step, inner, failures)

    def _next_to_start(self, step: Step, inner: float, failures: int, *, near_rest: bool) -> Found | None:
        """Return the end of a step by what serves where blocks had come to some balance before; None if none does."""
        contacts = step.contacts
        leftover = Leftover(step) if self._excavated and not near_rest else None
        enough = None if leftover is None else leftover.is_little
        found = softened_newton(step, step.start, inner, inside=True, locally=self._excavated, enough=enough)
        if found.converged:
            return found
        if leftover is not None and leftover.is_of_few(here := step.balance_at(found.position)):
            if failures and leftover.is_little(here, shortened=True):
                return replace(found, converged=True)
            if failures < MOST_FAILURES:  # a shorter step costs less than all else
                return found
        if not near_rest:
            return None
        calmed = _calmed(step, found.position, contacts, inner, patient=failures > 0)
        if calmed is not None:
            return calmed
        step.contacts = contacts
        holds = failures > 0 and not self._may_slide(step)
        held = _with_friction_held(step, step.anchor, inner) if holds else None
        return held if held is not None and held.converged else None

    def _from_rest(self, step: Step, inner: float, failures: int) -> Found:
        """Return the end of a first step that Newton's method does not find.

        With the least regularisation there is mostly none, and where one that lets a free block move by a step length
        does not help either, blocks slide.
        """
        if self._may_slide(step) and failures != 1:
            return slide(step, inner) if failures else Found(step.start, step.evaluate(step.start), converged=False)
        if step.lam * step.moving.d > CRAWLING:
            return _with_friction_held(step, elastic_position(step), inner)
        return from_inside(step, step.start, inner, MOST_MOVING)

    def _in_motion(self, step: Step, inner: float, failures: int) -> Found:
        """Return the end of a moving step that Newton's method does not find: by cycles, or with strengths held."""
        may_slide = self._may_slide(step)
        followed = may_slide and step.velocity is not None
        if self._wait == 0 and not followed and failures < (1 if may_slide else MOST_FAILURES):
            return from_inside(step, step.start, inner, MOST_MOVING)
        if self._wait == 0:
            self._wait = self._pause
            self._pause = min(2 * self._pause, LONGEST_FOLLOWED if may_slide else LONGEST_PAUSE)
        if may_slide:
            return slide(step, inner)
        self._wait -= 1
        return _with_friction_held(step, step.anchor, inner)

    def _may_slide(self, step: Step) -> bool:
        return can_slide(step) and not self._excavated


def _calmed(step: Step, position: FloatArray, contacts: MovingContacts, inner: float, *, patient: bool) -> Found | None:
    """Return where cycles lead from a position if less is out of balance there, or from the start, or None.

    `contacts`: those that the start has; `patient` as `calm` takes it, from the start, which is an equilibrium but for
    little: whatever else is tried may lead to one that is farther away.
    """
    if step.balance_at(position).greatest < step.balance_at(step.start).greatest:
        found = calm(step, position, CALM_ENOUGH * inner)
        if found is not None:
            return found
    step.contacts = contacts
    return calm(step, step.start, CALM_ENOUGH * inner, patient=patient)


def _with_friction_held(step: Step, position: FloatArray, inner: float) -> Found:
    """Return the end of a moving step with every shear strength held at that of the pressure at a position.

    It ends with less than a weight out of balance as well, where contacts came or went on the way.
    """
    held = step.with_friction_of(step.evaluate(position).pressure)
    near = interior_point(held, step.start, HAND_OVER)
    if near is None:
        return Found(step.start, step.evaluate(step.start), converged=False)
    better = newton(held, near, inner, most=MOST_POLISHING)
    if better.converged:
        return better
    there = held.balance_at(near)
    return Found(near, there.at, converged=there.greatest < UNPOLISHED)


def from_inside(
    step: Step, elastic: FloatArray, tolerance: float, most: int, barriers: tuple[float, ...] = (1.0,)
) -> Found:
    """Return what Newton's method finds from where the interior point method ends."""
    for barrier in barriers:
        near = interior_point(step, elastic, HAND_OVER, barrier=barrier)
        if near is not None:
            contacts = step.contacts
            found = softened_newton(step, near, tolerance)
            if not found.converged:
                step.contacts = contacts
                found = newton(step, near, tolerance, most=most)
            return found
    return Found(step.start, step.evaluate(step.start), converged=False)
