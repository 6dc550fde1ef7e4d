"""The first step: the equilibrium next to the start, where most models at rest are found in a step.

Newton's method with the contacts as they are at the start; where too many of them change for it, along a path of
smoothed laws. Contacts change with the movement: corners pass edges' ends, shared lengths grow and shrink. So they are
updated to where that led, and the same is done again from there, until an update changes nothing any more. Where blocks
settle by more than a step length the path is not followed to its end with contacts that are not theirs: each of them
leads a part of the way. Where it is slow, dynamic relaxation leads to where the step begins anew, or to where blocks
slide on.
"""

from __future__ import annotations

from copy import copy
from dataclasses import replace
from functools import partial

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.solve.contacts.history import commit, recall
from bsm_mesh.solve.contacts.smoothed_forces import typical_smoothing
from bsm_mesh.solve.continuation.acceptance import FEW_MOVE, Leftover
from bsm_mesh.solve.continuation.strategies import from_inside
from bsm_mesh.solve.methods.newton import MOST_ITERATIONS, chord_method, elastic_position, newton
from bsm_mesh.solve.methods.regularized_newton import NEARLY, SHRINKING, WORTHWHILE, softened_newton
from bsm_mesh.solve.methods.smoothing_path import FEW_LEFT, fitting_smoothing, follow_path
from bsm_mesh.solve.methods.subdomain_newton import begins_with_few
from bsm_mesh.solve.motion.relaxation import relax
from bsm_mesh.solve.motion.sliding import can_slide
from bsm_mesh.solve.step.attempt import Found
from bsm_mesh.solve.step.equations import SCATTERED, Step

MOST_UPDATES = 6  # of the contacts
FIRST_TOLERANCE, FIRST_SCATTERED = 1e-3, 1e-3  # before they are updated: greatest force, or root mean square
UPDATED = 0.03  # of the forces out of balance after an update: the next one leaves about as much
CONFIRMED = 0.99  # of the tolerance: with less out of balance, a step has only to confirm it
ROUGH = 0.5  # of a weight: root mean square out of balance to which a path is followed before the first update,
ROUGHER, LEAST_ROUGH = 0.1, 1e-3  # and part of what an update leaves before the next one; with less, to the end
BARRIERS = (1.0, 10.0)  # what the interior point method begins with after an excavation, one after the other


def first_step(step: Step, tolerance: float, *, excavated: bool) -> tuple[Step, Found]:
    """Return the equilibrium next to the start, and the step with the contacts that it was found with.

    Nothing is committed between updates: what slides still remembers where it began to, so that Newton's method need
    not find that out again. The least regularisation bears as much as the tolerance where a wall of a million bricks
    settles; with an update it begins anew. Where all but few blocks have come to rest, the step is taken as it is: what
    those lack is for the steps to come, in which they move.

    Parameters
    ----------
    step : Step
        The equations at the start.
    tolerance : float
        Greatest force out of balance over the mean weight that counts as rest.
    excavated : bool
        The start was at rest until something was changed.
    """
    inner = 0.5 * tolerance
    rest = newton(step, step.start, inner, most=0)
    if rest.converged:  # the in-situ state: what is in equilibrium must not move by rounding either
        return step, rest
    del rest  # forces in all contacts, which nobody asks for again
    if excavated and _is_stressed(step) and begins_with_few(step, inner):
        return step, _begun_with_few(step, max(FIRST_TOLERANCE, inner))
    found = solve_at_once(step, max(FIRST_TOLERANCE, inner), excavated=excavated)
    few_lack = FEW_MOVE if excavated else FEW_LEFT
    rough = ROUGH
    for update in range(MOST_UPDATES):
        step.make_room(found.position)
        near = found.converged or (not excavated and step.is_scattered(step.balance_at(found.position), rough))
        if not (near and step.takes(found.position)):
            break
        updated = _updated(step, found)
        left = updated.balance_at(found.position)
        if left.greatest < CONFIRMED * tolerance:
            return updated, _polished(updated, Found(left.position, left.at, converged=True))
        most = FIRST_TOLERANCE if update < MOST_UPDATES - 1 else inner
        enough = max(inner, min(most, UPDATED * left.greatest))
        again = solve_updated(updated, found.position, enough, excavated=excavated, was_solved=found.converged)
        if not again.converged and not _is_nearly(updated, again, few_lack):
            break
        step, found, rough = updated, again, FEW_LEFT
    if not found.converged and _is_nearly(step, found, FEW_MOVE if excavated else SCATTERED):
        return step, Found(found.position, found.at, converged=True)
    return step, _polished(step, found)


def _begun_with_few(step: Step, tolerance: float) -> Found:
    """Return where few blocks of many begin to move that an excavation set free.

    Whatever they lack, within the limits of a moving step, the steps to come take up, with contacts as they are then.
    """
    elastic = elastic_position(step)
    step.make_room(elastic)
    leftover = Leftover(step)
    found = softened_newton(step, elastic, tolerance, enough=leftover.is_little, locally=True)
    here = step.balance_at(found.position)
    return replace(found, converged=step.takes(found.position) and leftover.is_little(here))


def relaxed_step(step: Step, tolerance: float) -> tuple[Step, Found] | None:
    """Return the step from where damped motion leads blocks, and its equilibrium; None where it leads nowhere.

    Where Newton's method does not find that from so near, what few blocks lack is for the steps to come. Blocks that
    slide on are followed by cycles in those, with the velocity that they have come to; too few for cycles are not.
    """
    inner = 0.5 * tolerance
    relaxed = relax(step, inner)
    if relaxed is None:
        return None
    contacts, left = relaxed.contacts, relaxed.balance_at(relaxed.start)
    if relaxed.velocity is not None:
        on = Found(relaxed.start, left.at, converged=True, velocity=relaxed.velocity)
        return (relaxed, on) if can_slide(relaxed) else None
    found = softened_newton(relaxed, relaxed.start, inner)
    if found.converged:
        return relaxed, _polished(relaxed, found)
    here = relaxed.balance_at(found.position)
    if not (here.norm < left.norm and relaxed.is_scattered(here)):
        if not relaxed.is_scattered(left):  # supports that move on from there
            return None
        relaxed.contacts, found = contacts, Found(relaxed.start, left.at, converged=False)
    return relaxed, replace(found, converged=True)


def solve_at_once(step: Step, tolerance: float, *, excavated: bool = False) -> Found:
    """Return the equilibrium next to the start with the contacts as they are there, or what is known of it.

    `excavated`: the start was at rest until something was changed. What a path leads to lies farther from there than
    where moving steps come to rest, so none is followed; and what a few blocks lack, which then move, is not looked for
    with all others.
    """
    elastic = elastic_position(step)
    step.make_room(elastic)
    contacts = step.contacts
    stressed = _is_stressed(step)
    shrinking = SHRINKING if stressed else WORTHWHILE  # no stress before: no path to keep to
    after_stress = excavated and stressed
    scattered = partial(step.is_scattered, most=FIRST_SCATTERED if tolerance >= FIRST_TOLERANCE else 0.0)
    found = softened_newton(step, elastic, tolerance, shrinking=shrinking, enough=scattered, locally=after_stress)
    if found.converged or (after_stress and _is_nearly(step, found, FEW_MOVE)):
        return found
    step.contacts = contacts  # whole again: what broke on a way that led nowhere need not break on the next
    if after_stress:
        return from_inside(step, elastic, tolerance, MOST_ITERATIONS, BARRIERS)
    weight = step.moving.weight(step.evaluate(elastic))
    rough = ROUGH if step.movement(elastic - step.start) > step.moving.d else 0.0
    smoothing = typical_smoothing(contacts, elastic, weight)
    return _along_path(step, step.start, smoothing, tolerance, rough)


def solve_updated(
    step: Step,
    position: FloatArray,
    tolerance: float,
    *,
    excavated: bool = False,
    was_solved: bool = True,
) -> Found:
    """Return the equilibrium next to a position at which the step's contacts were updated.

    `excavated` as `first_step` takes it; `was_solved`: it was one before the update, not only a part of the way.
    """
    left = step.balance_at(position)
    if excavated or was_solved:
        contacts = step.contacts
        found = softened_newton(step, position, tolerance, locally=excavated)
        if found.converged or excavated:
            return found
        step.contacts, here = contacts, step.balance_at(found.position)
        left = here if here.norm < left.norm else left
    rough = min(SCATTERED, ROUGHER * left.norm / (left.weight * float(np.sqrt(len(position)))))
    rough = rough if rough > LEAST_ROUGH else 0.0
    smoothing = fitting_smoothing(step, left.position)
    return _along_path(step, left.position, smoothing, tolerance, rough)


def _along_path(step: Step, position: FloatArray, smoothing: float, tolerance: float, rough: float) -> Found:
    """Return what is found along the path that begins at a position with a smoothing [N], and from its end."""
    found = follow_path(step, position, smoothing, tolerance, rough=rough)
    end = step.balance_at(found.position)
    if found.converged or end.greatest > NEARLY or step.is_scattered(end, rough):
        return found
    contacts = step.contacts
    better = softened_newton(step, found.position, tolerance)
    if better.converged or step.balance_at(better.position).norm < end.norm:
        return better
    step.contacts = contacts
    return found


def _is_stressed(step: Step) -> bool:
    """Return whether any contact bore a force before the step."""
    return bool((step.contacts.candidates.history >= 0).any())


def _is_nearly(step: Step, found: Found, most: float) -> bool:
    """Return whether a step may end where it led with less than `most` out of balance (root mean square) [weights]."""
    return step.takes(found.position) and step.is_scattered(step.balance_at(found.position), most)


def _updated(step: Step, found: Found) -> Step:
    """Return the step with its contacts as they are where it led, before anything is committed."""
    size = step.moving.outlines.size
    history, _ = commit(step.contacts, found.at, found.position, size)
    contacts = step.moving.gather(history, found.position, first=False)
    updated = copy(step)
    updated.renew(recall(contacts, step.contacts, found.at, size), found.position)
    return updated


def _polished(step: Step, found: Found) -> Found:
    """Return what the last factors still gain beyond the tolerance: closed forms of small models hold to rounding."""
    if not (found.converged and step.factors.ready):
        return found
    position = chord_method(step, found.position, 0.0)
    return Found(position, step.evaluate(position), converged=True)
