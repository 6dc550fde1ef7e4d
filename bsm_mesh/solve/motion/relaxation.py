"""Dynamic relaxation: explicit damped motion to rest, with path-dependent slip.

Where thousands of contacts slip, the implicit equations of a step are hard to solve: strength follows pressure, and the
tangent is nearly singular. Incremental slip dissipates energy and converges. So the residual is applied in a ramp, in
explicit cycles of unit time with the smallest stable masses (Underwood 1983) and local damping (Cundall 1987). Time has
no meaning; a slow ramp leads where small static load steps would.

A cycle costs some thousandths of a factorization. Numbers of cycles are in wave transits: a wave crosses a model of n
blocks in about sqrt(n) cycles.
"""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.solve.motion.damped_motion import DampedMotion, cycles_at_once, wave_transit_cycles
from bsm_mesh.solve.step.attempt import Attempt
from bsm_mesh.solve.step.equations import Step

DAMPING, DAMPING_NEAR_REST = 0.5, 0.95  # part of the residual against the velocity: on the way, and near rest
RAMP_TRANSITS = 20.0  # wave transits over which the residual is applied
WINDOW_TRANSITS, HALVED = 10.0, 0.5  # after which the residual is compared, and the part to which it must have fallen
REFINED = (3e-2, 1e-3, 1e-5)  # rms residual over the weight: contacts are searched again at each; the last ends it
FALLING = 1.0  # the same, above which blocks may have been thrown: the motion is rejected
PASSED = 0.5  # relative movement over the step length, after which contacts are searched again
MAX_SEARCHES = 12
DAMPING_TRANSITS, CHECK_TRANSITS = 2.0, 0.25  # wave transits of damping near rest, and between checks of the residual;
PATIENT_TRANSITS = 20.0  # the same with patience: continued while so many halve the residual


def can_relax(step: Step) -> bool:
    """Return whether explicit motion is possible: it has no forces of bolts."""
    return not len(step.system.bolts.alive)


def relax(step: Step, tolerance: float) -> Step | None:
    """Return the step from the position of rest (of all but few blocks), or from the last position, with its velocity.

    Slip and failures on the way are committed, and contacts updated there. None where explicit motion is not possible,
    or the residual is so large that waves or overlaps may have thrown blocks.

    Parameters
    ----------
    step : Step
        The equations at the start; not changed.
    tolerance : float
        Maximum norm of the residual over the mean weight, at which it ends.
    """
    if not can_relax(step):
        return None
    transit, at_once = wave_transit_cycles(step), cycles_at_once(step)
    ramp, window = int(RAMP_TRANSITS * transit), int(WINDOW_TRANSITS * transit)
    motion, refined = DampedMotion(step, ramp, DAMPING), list(REFINED)
    before, until = np.inf, ramp + window
    while refined and motion.searches < MAX_SEARCHES:
        motion.advance(at_once)
        left = motion.residual.l2_norm
        if not np.isfinite(left) or (motion.done >= until and left > HALVED * before):
            break
        if motion.done >= until:
            before, until = left, until + window
        if motion.is_at_rest(refined[0], tolerance):
            motion.search()
            if motion.is_at_rest(refined[0], tolerance):
                del refined[0]
        elif motion.passed > PASSED * step.system.d:
            motion.search()
    here = motion.residual
    return motion.accepted(at_rest=step.is_localized(here)) if step.is_localized(here, FALLING) else None


def damp_to_rest(step: Step, position: FloatArray, tolerance: float, *, patient: bool = False) -> Attempt | None:
    """Return the state of rest, to a tolerance, near a position (n, 3) almost at rest; None if not within few cycles.

    Where thousands of contacts are at their strength, the active set of Newton's method may cycle between sticking and
    slipping. The step keeps slip and failures. `patient`: continue while the residual falls.
    """
    if step.supports_move or not can_relax(step):
        return None
    transit = wave_transit_cycles(step)
    motion = DampedMotion(step, 1, DAMPING_NEAR_REST, position)
    window = (PATIENT_TRANSITS if patient else DAMPING_TRANSITS) * transit
    before, until = motion.residual.l2_norm, window
    while True:
        motion.advance(max(1, int(CHECK_TRANSITS * transit)))
        residual = motion.residual
        if residual.max_norm < tolerance:
            step.contacts = motion.contacts
            return Attempt(residual.position, residual.at, converged=True)
        if not np.isfinite(residual.l2_norm):
            return None
        if motion.done >= until:
            if not patient or residual.l2_norm > HALVED * before:
                return None
            before, until = residual.l2_norm, until + window
