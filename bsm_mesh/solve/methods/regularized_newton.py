"""Newton's method with a regularised tangent, with subdomain and chord sweeps between its corrections.

Open and slipping contacts keep a part of their stiffness in the tangent, so that a correction does not throw blocks
with few closed contacts. The few blocks with the largest residual are solved as subdomains, without a global
factorization.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.solve.methods.newton import chord_method, newton
from bsm_mesh.solve.methods.subdomain_newton import MAX_GROWTH, OVERLAP_LAYERS, subdomain_correction, subdomain_newton
from bsm_mesh.solve.step.attempt import Attempt
from bsm_mesh.solve.step.equations import LOCALIZED_RMS, Residual, Step

SHRINKING = 0.25  # part to which two factorizations must reduce the 2-norm
MAX_FACTORIZATIONS = 30
MAX_ROUNDS, HALVED = 6, 0.5  # of sweeps, and the part of the 2-norm to which one must reduce it
NEAR_BALANCE = 0.1  # maximum norm up to which the chord method is used without a subdomain solution
NEARLY = 0.3  # maximum norm up to which slower convergence is accepted, and all is tried for the subdomain;
SPREAD = 10.0  # then the 2-norm may grow by this factor before the chord method corrects the blocks around it
FEW = 0.15  # rms residual over its maximum norm, below which few blocks are the cause
IDLE = 0.97  # part of the 2-norm left by a sweep and by a global correction, above which the next sweep is skipped
STUCK, MAX_LAYERS = 0.9, 4 * OVERLAP_LAYERS  # part left by a sweep, above which the overlap is doubled; most layers
WORTHWHILE = 0.7  # part to which corrections must reduce the 2-norm near equilibrium or from zero stress


def regularized_newton(
    step: Step,
    position: FloatArray,
    tolerance: float,
    *,
    use_interior_point: bool = False,
    shrinking: float = SHRINKING,
    enough: Callable[[Residual], bool] | None = None,
    subdomain_corrections: bool = False,
) -> Attempt:
    """Return the result of Newton's method with regularised tangents, with a sweep before and after each correction.

    `use_interior_point`: in subdomains too, which may lead to an equilibrium farther away.
    `shrinking`: the part to which two factorizations must reduce the 2-norm while the residual is large.
    `enough`: whether it may end with a residual, though few blocks exceed the tolerance.
    `subdomain_corrections`: where few blocks have a large residual, corrections move their influence region alone.
    """
    before = step.residual_at(position).l2_norm
    here = step.residual_at(subdomain_and_chord_sweep(step, position, tolerance, use_interior_point=use_interior_point))
    norms = [np.inf, np.inf, here.l2_norm]
    found = Attempt(here.position, here.at, converged=False)
    for _ in range(MAX_FACTORIZATIONS):
        if enough is not None and enough(here):
            return Attempt(here.position, here.at, converged=True)
        if norms[-1] > (WORTHWHILE if here.max_norm < NEARLY else shrinking) * norms[-3]:
            break
        contacts = step.contacts
        corrected = subdomain_correction(step, here.position, tolerance) if subdomain_corrections else None
        found = corrected or newton(step, here.position, tolerance, regularized=True, max_iterations=1)
        if found.converged:
            break
        idle, position = norms[-1] > IDLE * before, found.position
        before = step.residual_at(position).l2_norm
        if not (idle and before > IDLE * norms[-1]):
            position = subdomain_and_chord_sweep(step, position, tolerance, use_interior_point=use_interior_point)
        here = step.residual_at(position)
        norms.append(here.l2_norm)
        if step.contacts is not contacts:  # some were released: it is another problem
            norms = [np.inf, np.inf, here.l2_norm]
    return found


def subdomain_and_chord_sweep(
    step: Step, position: FloatArray, tolerance: float, *, use_interior_point: bool
) -> FloatArray:
    """Return a position after sweeps without a global factorization: subdomain Newton, then the chord method.

    The chord method, with the last global factors, corrects the residual that the subdomain solution leaves around it.
    Sweeps are repeated while they halve the 2-norm. With many large residuals the last factors are not used. With few,
    a sweep without gain is repeated with more layers of overlap.
    """
    here, layers = step.residual_at(position), OVERLAP_LAYERS
    for _ in range(MAX_ROUNDS):
        if here.max_norm < tolerance:
            break
        near, contacts = here.max_norm < NEARLY and step.factors.ready, step.contacts
        max_growth = SPREAD if near else MAX_GROWTH
        relaxed = subdomain_newton(
            step,
            here.position,
            tolerance,
            use_interior_point=near or (use_interior_point and not step.interior_point_stalled),
            layers=layers,
            max_growth=max_growth,
            fewer=_is_localized(step, here),
        )
        if step.factors.ready and (relaxed is not here.position or here.max_norm < NEAR_BALANCE):
            relaxed = chord_method(step, relaxed, tolerance)
        there = step.residual_at(relaxed)
        gained = there.l2_norm / here.l2_norm
        if gained > MAX_GROWTH:
            step.contacts = contacts  # contacts released by a rejected sweep
        else:
            here = there
        if gained > HALVED and not (near and gained > STUCK and layers < MAX_LAYERS):
            break
        layers = 2 * layers if gained > STUCK else layers
    return here.position


def _is_localized(step: Step, here: Residual) -> bool:
    """Return whether few blocks are the cause of the residual."""
    return step.is_localized(here, max(LOCALIZED_RMS, min(NEARLY, FEW * here.max_norm)))
