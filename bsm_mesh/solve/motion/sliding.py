"""Large sliding followed dynamically: explicit motion, lightly damped, from step to step.

Where thousands of contacts slide, the implicit equations of a moving step take dozens of factorizations, if they have a
solution nearby at all. Explicit motion needs none: blocks keep their velocity from step to step, contacts their slip
and failures, and a step ends when a block has moved by the step length. For creeping blocks an implicit step is
quicker.
"""

from __future__ import annotations

from copy import copy

import numpy as np

from bsm_mesh.solve.motion.damped_motion import DampedMotion, cycles_at_once, wave_transit_cycles
from bsm_mesh.solve.motion.relaxation import RAMP_TRANSITS, can_relax
from bsm_mesh.solve.step.attempt import Attempt
from bsm_mesh.solve.step.equations import Step

MIN_BLOCKS = 100  # in a model, for explicit motion
DAMPING = 0.05 * np.pi  # part of the residual against the velocity: 5 % of critical, as of rock (FLAC3D manual)
MAX_TRANSITS = 60.0  # wave transits in a step
LIGHTEST = 0.5  # smallest mass over the mean mass: lighter blocks would fall too fast
AT_ONCE, MIN_AT_ONCE = 0.125, 10  # movement over the step length between evaluations of contacts; cycles


def is_fast(step: Step) -> bool:
    """Return whether the fastest block moves by a step length within the cycles of a step."""
    if step.velocity is None:
        return False
    return step.movement(step.velocity) * _most_cycles(step) > step.system.d


def can_follow_dynamically(step: Step) -> bool:
    """Return whether explicit motion is possible: without bolts and prescribed displacements, and with enough blocks.

    Of few blocks implicit steps are quick, and they let a toppling one roll, where explicit motion throws it off.
    """
    return len(step.start) >= MIN_BLOCKS and can_relax(step) and not step.supports_move


def follow_dynamically(step: Step, tolerance: float) -> Attempt:
    """Return the result of explicit motion in a step, with its velocity.

    The step keeps slip and failures.

    Parameters
    ----------
    step : Step
        The equations.
    tolerance : float
        Maximum norm of the residual over the mean weight, at which the step ends early.
    """
    free, d = copy(step), step.system.d
    free.lam = 0.0  # explicit motion needs no regularisation
    ramp = int(RAMP_TRANSITS * wave_transit_cycles(step)) if step.velocity is None else 1
    motion = DampedMotion(free, ramp, DAMPING, lightest=LIGHTEST)
    if step.velocity is not None:
        motion.velocity[:] = step.velocity
    at_once, most = cycles_at_once(step), _most_cycles(step)
    while motion.done < most and motion.residual.max_norm >= tolerance:
        cycles = np.clip(_cycles_within(AT_ONCE * d, motion, step), MIN_AT_ONCE, at_once)
        motion.advance(int(cycles), margin=2 * AT_ONCE * d)
        if not np.isfinite(motion.residual.l2_norm):
            return Attempt(step.start, step.evaluate(step.start), converged=False)
        if max(motion.passed, step.movement(motion.residual.position - step.start)) > d:
            break
    step.contacts, here = motion.contacts, motion.residual
    end, closed = motion.velocity, motion.contacted
    return Attempt(here.position, here.at, converged=True, velocity=end, contacted_during_step=closed)


def _cycles_within(distance: float, motion: DampedMotion, step: Step) -> float:
    """Return the number of cycles in which a block may move by a distance [m], by its velocity and in free fall."""
    if not motion.least_mass.any():
        return 0.0
    velocity, free = step.movement(motion.velocity), ~step.system.outlines.fixed
    fall = float((step.system.mass / motion.least_mass)[free, :2].max(initial=0.0))
    return 2 * distance / (velocity + float(np.sqrt(velocity**2 + 2 * fall * distance)) + np.finfo(float).tiny)


def _most_cycles(step: Step) -> int:
    return int(MAX_TRANSITS * wave_transit_cycles(step))
