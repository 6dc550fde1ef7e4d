"""Blocks followed by explicit motion from one step to the next, with their real masses.

The method of a moving step, whatever the model has: bolts, moving supports, water, an excavation before. A step ends
when a block has moved by its length. Blocks that begin to move may come to rest nearby and are damped strongly; those
that go on are hardly damped, or what slides would be dragged to a stop.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bsm_mesh.solve.motion.cycles import Cycles
from bsm_mesh.solve.motion.masses import MotionSettings
from bsm_mesh.solve.step.attempt import Attempt, Goal, Iterate, Outcome
from bsm_mesh.solve.step.equations import StepEquations

DAMPED = MotionSettings(damps_impacts=True, real_masses=True)
# Of blocks that go on: little, or what slides would be dragged to a stop; some, or what swings would never rest.
FREE = MotionSettings(damping=0.02, damps_impacts=True, real_masses=True)


@dataclass(frozen=True, slots=True, kw_only=True)
class FollowSettings:
    """How blocks are followed.

    Attributes
    ----------
    beginning, going_on : MotionSettings
        In the first steps and later. Rock hardly rebounds: impacts are damped critically.
    beginning_steps : int
        How many the first steps are: what comes to rest within as many step lengths does so damped.
    longest : float
        Cycles of a step at most, over those of a free fall through the step length: a slower block is near rest.
    """

    beginning: MotionSettings = DAMPED
    going_on: MotionSettings = FREE
    beginning_steps: int = 3
    longest: float = 6.0


SETTINGS = FollowSettings()


class FollowMotion:
    """Explicit motion with real masses for a step length."""

    name = "explicit motion"

    def applies(self, equations: StepEquations, at: Iterate, goal: Goal) -> bool:
        """Return True: it needs no solution nearby."""
        return True

    def solve(self, equations: StepEquations, at: Iterate, goal: Goal) -> Attempt:
        """Return where blocks have moved to, with their velocity."""
        begins = at.moving_steps < SETTINGS.beginning_steps
        settings = SETTINGS.beginning if begins else SETTINGS.going_on
        motion: Cycles = equations.system.in_motion(equations, settings, velocity=at.velocity)
        while motion.cycles < SETTINGS.longest * motion.fall_cycles:
            motion.advance()
            if motion.diverged:
                return Attempt(equations=equations, position=equations.start, outcome=Outcome.STALLED)
            if motion.passed > equations.system.d:
                break
            if motion.is_loaded and motion.residual.max_norm < goal.max_residual:
                break
        return Attempt(
            equations=motion.equations,
            position=motion.residual.position,
            outcome=Outcome.ACCEPTABLE,
            velocity=motion.velocity,
            contacted=motion.contacted,
        )


def is_fast(equations: StepEquations, at: Iterate) -> bool:
    """Return whether blocks are so fast that explicit motion leads a step length on."""
    if at.velocity is None:
        return False
    d = equations.system.d
    return equations.movement(at.velocity) * SETTINGS.longest * float(np.sqrt(2 * d)) > d


def accelerates(equations: StepEquations, at: Iterate) -> bool:
    """Return whether the unbalanced forces do work on the velocities: no equilibrium lies ahead.

    Statics knows no direction of motion. It may find an equilibrium whose friction is not opposite to the slip.
    """
    if at.velocity is None:
        return False
    forces = equations.residual_at(equations.start).forces
    return float(np.einsum("ij,ij->", forces, at.velocity)) > 0.0
