"""The first step: the equilibrium near the start, which is the end of most models at rest.

Newton's method with the contacts of the start; where too many of them change for it, the smoothing path. Contacts
change with the movement: corners pass ends of edges, overlaps grow and shrink. So the contact set is updated, and the
equations are solved again from there, until an update changes nothing. Where blocks settle by more than a step length,
the path is followed only in part before an update. Where it is slow, dynamic relaxation leads to a new start of the
step, or to blocks that slide on.
"""

from __future__ import annotations

from copy import copy
from dataclasses import replace
from functools import partial

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.solve.contacts.history import commit, restore_history
from bsm_mesh.solve.contacts.smoothed_forces import typical_mu
from bsm_mesh.solve.continuation.acceptance import FEW_MOVE, Acceptance
from bsm_mesh.solve.continuation.strategies import newton_from_interior_point
from bsm_mesh.solve.methods.newton import MAX_ITERATIONS, chord_method, elastic_position, newton
from bsm_mesh.solve.methods.regularized_newton import NEARLY, SHRINKING, WORTHWHILE, regularized_newton
from bsm_mesh.solve.methods.smoothing_path import FEW_LEFT, follow_path, initial_mu
from bsm_mesh.solve.methods.subdomain_newton import is_local_disturbance
from bsm_mesh.solve.motion.relaxation import relax
from bsm_mesh.solve.motion.sliding import can_follow_dynamically
from bsm_mesh.solve.step.attempt import Attempt
from bsm_mesh.solve.step.equations import LOCALIZED_RMS, Step

MAX_UPDATES = 6  # of the contact set
FIRST_TOLERANCE, FIRST_RMS = 1e-3, 1e-3  # before an update: maximum norm, or rms residual over the weight
UPDATED = 0.03  # tolerance over the residual after an update: the next update leaves about as much
CONFIRMED = 0.99  # of the tolerance: a smaller residual is at rest
ROUGH = 0.5  # rms residual over the weight to which the path is followed before the first update,
ROUGHER, MIN_ROUGH = 0.1, 1e-3  # its part of the residual before the next ones; below the latter, to the end
BARRIERS = (1.0, 10.0)  # initial barriers of the interior point method after an excavation, in turn


def first_step(step: Step, tolerance: float, *, excavated: bool) -> tuple[Step, Attempt]:
    """Return the equilibrium near the start, and the step with its updated contacts.

    Nothing is committed between updates, so that slip is still relative to the start. The smallest regularisation force
    is as large as the tolerance where a wall of a million bricks settles; an update resets it. Where all but few blocks
    are at rest, the step is accepted: those few move in the following steps.

    Parameters
    ----------
    step : Step
        The equations at the start.
    tolerance : float
        Maximum norm of the residual at rest, over the mean weight.
    excavated : bool
        The start was in equilibrium before a change (excavation).
    """
    inner = 0.5 * tolerance
    rest = newton(step, step.start, inner, max_iterations=0)
    if rest.converged:  # the in-situ state must not move, not even by rounding
        return step, rest
    del rest  # the forces in all contacts, not needed again
    if excavated and _has_initial_forces(step) and is_local_disturbance(step, inner):
        return step, _start_local_failure(step, max(FIRST_TOLERANCE, inner))
    found = solve_at_once(step, max(FIRST_TOLERANCE, inner), excavated=excavated)
    max_rms = FEW_MOVE if excavated else FEW_LEFT
    rough = ROUGH
    for update in range(MAX_UPDATES):
        step.allow_elastic_settlement(found.position)
        near = found.converged or (not excavated and step.is_localized(step.residual_at(found.position), rough))
        if not (near and step.within_search_range(found.position)):
            break
        updated = _updated(step, found)
        left = updated.residual_at(found.position)
        if left.max_norm < CONFIRMED * tolerance:
            return updated, _polished(updated, Attempt(left.position, left.at, converged=True))
        most = FIRST_TOLERANCE if update < MAX_UPDATES - 1 else inner
        enough = max(inner, min(most, UPDATED * left.max_norm))
        again = solve_updated(updated, found.position, enough, excavated=excavated, was_solved=found.converged)
        if not again.converged and not _is_nearly(updated, again, max_rms):
            break
        step, found, rough = updated, again, FEW_LEFT
    if not found.converged and _is_nearly(step, found, FEW_MOVE if excavated else LOCALIZED_RMS):
        return step, Attempt(found.position, found.at, converged=True)
    return step, _polished(step, found)


def _start_local_failure(step: Step, tolerance: float) -> Attempt:
    """Return the start of a local failure: few blocks of many are set free by an excavation.

    Their residual, within the limits of a moving step, is left to the following steps with updated contacts.
    """
    elastic = elastic_position(step)
    step.allow_elastic_settlement(elastic)
    leftover = Acceptance(step)
    found = regularized_newton(step, elastic, tolerance, enough=leftover.accepts, subdomain_corrections=True)
    here = step.residual_at(found.position)
    return replace(found, converged=step.within_search_range(found.position) and leftover.accepts(here))


def relaxed_step(step: Step, tolerance: float) -> tuple[Step, Attempt] | None:
    """Return the step after dynamic relaxation, and its equilibrium; None where that fails.

    Where Newton's method does not find it from there, the residual of few blocks is left to the following steps. Blocks
    that slide on keep their velocity and are followed dynamically, in models with enough blocks for it.
    """
    inner = 0.5 * tolerance
    relaxed = relax(step, inner)
    if relaxed is None:
        return None
    contacts, left = relaxed.contacts, relaxed.residual_at(relaxed.start)
    if relaxed.velocity is not None:
        on = Attempt(relaxed.start, left.at, converged=True, velocity=relaxed.velocity)
        return (relaxed, on) if can_follow_dynamically(relaxed) else None
    found = regularized_newton(relaxed, relaxed.start, inner)
    if found.converged:
        return relaxed, _polished(relaxed, found)
    here = relaxed.residual_at(found.position)
    if not (here.l2_norm < left.l2_norm and relaxed.is_localized(here)):
        if not relaxed.is_localized(left):  # with prescribed displacements still incomplete
            return None
        relaxed.contacts, found = contacts, Attempt(relaxed.start, left.at, converged=False)
    return relaxed, replace(found, converged=True)


def solve_at_once(step: Step, tolerance: float, *, excavated: bool = False) -> Attempt:
    """Return the equilibrium near the start with the contacts of the start, or the best attempt.

    `excavated`: the start was in equilibrium before a change. The end of a path is farther from there than the rest of
    moving steps, so no path is followed; and a residual of few moving blocks is accepted.
    """
    elastic = elastic_position(step)
    step.allow_elastic_settlement(elastic)
    contacts = step.contacts
    stressed = _has_initial_forces(step)
    shrinking = SHRINKING if stressed else WORTHWHILE  # from zero stress there is no path to keep to
    after_stress = excavated and stressed
    localized = partial(step.is_localized, max_rms=FIRST_RMS if tolerance >= FIRST_TOLERANCE else 0.0)
    found = regularized_newton(
        step, elastic, tolerance, shrinking=shrinking, enough=localized, subdomain_corrections=after_stress
    )
    if found.converged or (after_stress and _is_nearly(step, found, FEW_MOVE)):
        return found
    step.contacts = contacts  # intact again: failures of a rejected attempt
    if after_stress:
        return newton_from_interior_point(step, elastic, tolerance, MAX_ITERATIONS, BARRIERS)
    weight = step.system.weight(step.evaluate(elastic))
    rough = ROUGH if step.movement(elastic - step.start) > step.system.d else 0.0
    mu = typical_mu(contacts, elastic, weight)
    return _along_path(step, step.start, mu, tolerance, rough)


def solve_updated(
    step: Step,
    position: FloatArray,
    tolerance: float,
    *,
    excavated: bool = False,
    was_solved: bool = True,
) -> Attempt:
    """Return the equilibrium near a position at which the step's contacts were updated.

    `excavated` as `first_step` takes it; `was_solved`: the position was an equilibrium before the update.
    """
    left = step.residual_at(position)
    if excavated or was_solved:
        contacts = step.contacts
        found = regularized_newton(step, position, tolerance, subdomain_corrections=excavated)
        if found.converged or excavated:
            return found
        step.contacts, here = contacts, step.residual_at(found.position)
        left = here if here.l2_norm < left.l2_norm else left
    rough = min(LOCALIZED_RMS, ROUGHER * left.l2_norm / (left.weight * float(np.sqrt(len(position)))))
    rough = rough if rough > MIN_ROUGH else 0.0
    mu = initial_mu(step, left.position)
    return _along_path(step, left.position, mu, tolerance, rough)


def _along_path(step: Step, position: FloatArray, mu: float, tolerance: float, rough: float) -> Attempt:
    """Return the result of the smoothing path from a position with a mu [N], and of Newton's method from its end."""
    found = follow_path(step, position, mu, tolerance, rough=rough)
    end = step.residual_at(found.position)
    if found.converged or end.max_norm > NEARLY or step.is_localized(end, rough):
        return found
    contacts = step.contacts
    better = regularized_newton(step, found.position, tolerance)
    if better.converged or step.residual_at(better.position).l2_norm < end.l2_norm:
        return better
    step.contacts = contacts
    return found


def _has_initial_forces(step: Step) -> bool:
    """Return whether any contact had a force before the step."""
    return bool((step.contacts.candidates.history >= 0).any())


def _is_nearly(step: Step, found: Attempt, most: float) -> bool:
    """Return whether a step may end with an attempt: its rms residual over the weight is below `most`."""
    return step.within_search_range(found.position) and step.is_localized(step.residual_at(found.position), most)


def _updated(step: Step, found: Attempt) -> Step:
    """Return the step with contacts updated at an attempt, without a commit."""
    size = step.system.outlines.size
    history, _ = commit(step.contacts, found.at, found.position, size)
    contacts = step.system.gather(history, found.position, first=False)
    updated = copy(step)
    updated.rebase(restore_history(contacts, step.contacts, found.at, size), found.position)
    return updated


def _polished(step: Step, found: Attempt) -> Attempt:
    """Return an attempt improved by the chord method to rounding, for closed forms of small models."""
    if not (found.converged and step.factors.ready):
        return found
    position = chord_method(step, found.position, 0.0)
    return Attempt(position, step.evaluate(position), converged=True)
