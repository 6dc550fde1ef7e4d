"""Dynamic relaxation: blocks come to rest by damped motion, and slip is kept as it comes.

Where thousands of contacts slip, the equations of a whole step, in which shear forces follow from where a contact has
come to and not from how, hardly let themselves be solved: friction follows pressure, and their tangent is next to
singular. Slip that happens little by little loses energy, and finds its end. So what is out of balance is brought on in
a ramp, in explicit cycles of unit time with masses as small as stability allows (Underwood 1983), damped by a part of
the force against the velocity (Cundall 1987), which takes no force from what stands still. There is nothing to choose:
time means nothing, and slowly brought on the loads lead where small steps of statics would.

A cycle costs some thousandths of a factorization. Waves cross the model in about as many cycles as it has blocks
across, so that cycles are counted in those: a model of n blocks has the square root of n.
"""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.solve.motion.damped_motion import DampedMotion, blocks_across, cycles_at_once
from bsm_mesh.solve.step.attempt import Found
from bsm_mesh.solve.step.equations import Step

DAMPING, CALMING = 0.5, 0.95  # of the force out of balance, against the velocity: on the way, and near rest
RAMP = 20.0  # times the blocks across: cycles in which what is out of balance is brought on
WINDOW, HALVED = 10.0, 0.5  # the same, and to what part it must have fallen after that many more
REFINED = (3e-2, 1e-3, 1e-5)  # root mean square [weights]: contacts are looked for again at each; the last ends it
FALLING = 1.0  # the same, of blocks that fall: with more, some may have been thrown, and a slide begins anew
PASSED = 0.5  # of the step length: how far blocks pass each other before contacts are looked for again
MOST_SEARCHES = 12
CALMED, CALMED_EVERY = 2.0, 0.25  # times the blocks across: cycles that calm what is nearly at rest, judged after each;
PATIENTLY = 20.0  # the same, with patience: they go on while so many leave half as much


def can_relax(step: Step) -> bool:
    """Return whether cycles can be used: bolts are stiff, and known to them only from before them."""
    return not len(step.moving.bolts.alive)


def relax(step: Step, tolerance: float) -> Step | None:
    """Return the step from where blocks come to rest, all but few of them; from where they do not, with their velocity.

    What slipped and broke on the way is accepted: the step begins there, with contacts as they are there. None where
    cycles cannot be used, and where so much is out of balance that waves or overlaps may have thrown blocks.

    Parameters
    ----------
    step : Step
        The equations from where it begins; it is left as it is.
    tolerance : float
        Greatest force out of balance, over the mean weight, below which nothing is left to do.
    """
    if not can_relax(step):
        return None
    across, at_once = blocks_across(step), cycles_at_once(step)
    ramp, window = int(RAMP * across), int(WINDOW * across)
    motion, refined = DampedMotion(step, ramp, DAMPING), list(REFINED)
    before, until = np.inf, ramp + window
    while refined and motion.searches < MOST_SEARCHES:
        motion.go_on(at_once)
        left = motion.balance.norm
        if not np.isfinite(left) or (motion.done >= until and left > HALVED * before):
            break
        if motion.done >= until:
            before, until = left, until + window
        if motion.is_calm(refined[0], tolerance):
            motion.search()
            if motion.is_calm(refined[0], tolerance):
                del refined[0]
        elif motion.passed > PASSED * step.moving.d:
            motion.search()
    here = motion.balance
    return motion.accepted(at_rest=step.is_scattered(here)) if step.is_scattered(here, FALLING) else None


def calm(step: Step, position: FloatArray, tolerance: float, *, patient: bool = False) -> Found | None:
    """Return where blocks nearly at rest at a position (n, 3) come to rest to a tolerance; None if not in few cycles.

    Where thousands of contacts are at their strength, Newton's method lets some stick and others slide with every
    correction, and none is the last. The step keeps what slipped and broke on the way. `patient`: cycles go on for as
    long as they lead nearer to rest.
    """
    if step.driven or not can_relax(step):
        return None
    across = blocks_across(step)
    motion = DampedMotion(step, 1, CALMING, position)
    window = (PATIENTLY if patient else CALMED) * across
    before, until = motion.balance.norm, window
    while True:
        motion.go_on(max(1, int(CALMED_EVERY * across)))
        balance = motion.balance
        if balance.greatest < tolerance:
            step.contacts = motion.contacts
            return Found(balance.position, balance.at, converged=True)
        if not np.isfinite(balance.norm):
            return None
        if motion.done >= until:
            if not patient or balance.norm > HALVED * before:
                return None
            before, until = balance.norm, until + window
