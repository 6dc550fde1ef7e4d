"""Blocks that slide far, followed by cycles of damped motion from one step to the next.

Where thousands of contacts slide, the equations of a moving step take dozens of factorizations, if they have a
solution nearby at all. Cycles need none: blocks keep their velocity from step to step, contacts keep what slips and
breaks, and a step ends when blocks have moved by its length. Where blocks creep that takes long, and an implicit step
is quicker.
"""

from __future__ import annotations

from copy import copy

import numpy as np

from bsm_mesh.solve.motion.damped_motion import DampedMotion, blocks_across, cycles_at_once
from bsm_mesh.solve.motion.relaxation import RAMP, can_relax
from bsm_mesh.solve.step.attempt import Found
from bsm_mesh.solve.step.equations import Step

MANY = 100  # blocks
DAMPING = 0.05 * np.pi  # of the force out of balance: 5 % of critical, as rock in motion has (FLAC3D manual)
LONGEST_SLIDE = 60.0  # times the blocks across: cycles of a step at most
LIGHTEST = 0.5  # of the mean mass: what is lighter would fall too fast
AT_ONCE, LEAST_AT_ONCE = 0.125, 10  # of the step length: how far blocks go until contacts are worked out again; cycles


def slides(step: Step) -> bool:
    """Return whether blocks are so fast that cycles lead a step length on."""
    if step.velocity is None:
        return False
    return step.movement(step.velocity) * _most_cycles(step) > step.moving.d


def can_slide(step: Step) -> bool:
    """Return whether blocks may be followed by cycles, which know no bolts, and no supports that move.

    Of few blocks implicit steps are quick, and they let one that topples down roll, where cycles throw it off.
    """
    return len(step.start) >= MANY and can_relax(step) and not step.driven


def slide(step: Step, tolerance: float) -> Found:
    """Return where cycles lead in a step, with the velocity that blocks have there.

    The step keeps what slipped and broke on the way.

    Parameters
    ----------
    step : Step
        The equations.
    tolerance : float
        Greatest force out of balance, over the mean weight, with which the step ends early.
    """
    free, d = copy(step), step.moving.d
    free.lam = 0.0  # cycles need no regularisation
    ramp = int(RAMP * blocks_across(step)) if step.velocity is None else 1
    motion = DampedMotion(free, ramp, DAMPING, lightest=LIGHTEST)
    if step.velocity is not None:
        motion.velocity[:] = step.velocity
    at_once, most = cycles_at_once(step), _most_cycles(step)
    while motion.done < most and motion.balance.greatest >= tolerance:
        cycles = np.clip(_cycles_within(AT_ONCE * d, motion, step), LEAST_AT_ONCE, at_once)
        motion.go_on(int(cycles), margin=2 * AT_ONCE * d)
        if not np.isfinite(motion.balance.norm):
            return Found(step.start, step.evaluate(step.start), converged=False)
        if max(motion.passed, step.movement(motion.balance.position - step.start)) > d:
            break
    step.contacts, here = motion.contacts, motion.balance
    return Found(here.position, here.at, converged=True, velocity=motion.velocity, bore=motion.bore)


def _cycles_within(distance: float, motion: DampedMotion, step: Step) -> float:
    """Return after how many cycles a block may have gone a distance [m], by its velocity and by falling."""
    if not motion.least_mass.any():
        return 0.0
    velocity, free = step.movement(motion.velocity), ~step.moving.outlines.fixed
    fall = float((step.moving.mass / motion.least_mass)[free, :2].max(initial=0.0))
    return 2 * distance / (velocity + float(np.sqrt(velocity**2 + 2 * fall * distance)) + np.finfo(float).tiny)


def _most_cycles(step: Step) -> int:
    return int(LONGEST_SLIDE * blocks_across(step))
