"""Dynamic relaxation: the loads brought on in a ramp, blocks damped to rest by explicit motion.

Where thousands of contacts slip, Coulomb's coupling of pressure and friction leaves the equations of a whole step next
to singular. Slip that happens little by little loses energy, and finds its end. So the residual at the start is brought
on in a ramp, with masses as small as stability allows (Underwood 1983), damped by a part of the force against the
velocity (Cundall 1987). The unit of time, called a transit, is as many cycles as blocks lie across a model, the square
root of their number (in space the cubic root): ramp and period are counted in those.

What comes to rest loses its kinetic energy; what slides on keeps it. The residual says less: slipping contacts make a
model soft, so that it halves more slowly than in an elastic one though every block comes to rest.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bsm_mesh.solve.motion.cycles import Cycles
from bsm_mesh.solve.motion.masses import MotionSettings
from bsm_mesh.solve.step.attempt import FEW_CHANGE, MAX_RMS, Attempt, Goal, Iterate, Outcome
from bsm_mesh.solve.step.equations import StepEquations

LIGHTEST = MotionSettings(damps_impacts=False, real_masses=False)


@dataclass(frozen=True, slots=True, kw_only=True)
class RelaxationSettings:
    """How loads are brought on, and what ends it. A transit is `System.blocks_across` cycles.

    Attributes
    ----------
    pressed : float
        Part of the elastic solution from which it begins where no contact carries a force yet. With 1 one verdict of
        211 changed.
    motion : MotionSettings
        How blocks are moved.
    ramp : float [transits]
        Of the loads. With 20, slopes near their limit come down that stand with 60.
    period : float [transits]
        That of the slowest wave; from one to the next kinetic energy must fall, or it has stalled. Masses are 1.5
        times the sum of a block's springs, so a wave goes 0.41 of a square block a cycle, and the slowest is four
        times as long as a model that is held on one side.
    levels : tuple of float [mean weights]
        Rms residuals: contacts are searched for at each, the last ends it.
    passed : float
        Of the step length: movement that one search for contacts serves. By so much blocks pass each other before the
        next, and so far away is the elastic solution from which it begins, at most (with 2 there no verdict of 211
        changed).
    max_searches : int
        How often, at most: what still moves then is followed.
    min_cycles : int
        In a window: more than a transit in small models, where a window costs more than its cycles.
    min_transit : float [cycles]
        Of small models: a few slender blocks bend and turn more slowly than waves cross them.
    """

    pressed: float = 0.1
    motion: MotionSettings = LIGHTEST
    ramp: float = 60.0
    period: float = 10.0
    levels: tuple[float, ...] = (MAX_RMS, FEW_CHANGE, 1e-5)
    passed: float = 0.5
    max_searches: int = 12
    min_cycles: int = 100
    min_transit: float = 30.0


SETTINGS = RelaxationSettings()


class Decay:
    """Whether kinetic energy falls: its mean over a period is below that over the period before.

    Within a period it swings, and where contacts begin to slip it rises for a while.

    Parameters
    ----------
    begins, period : int [cycles]
        The first period, and the length of each.
    """

    def __init__(self, begins: int, period: int) -> None:
        self._begins, self._period = begins, period
        self._ends, self._before = begins + period, np.inf
        self._energies: list[float] = []

    def goes_on(self, cycles: int, energy: float) -> bool:
        """Return whether it still falls, with the energy after so many cycles."""
        if cycles >= self._begins:
            self._energies.append(energy)
        if cycles < self._ends:
            return True
        mean = float(np.mean(self._energies))
        falls = mean < self._before
        self._ends, self._before, self._energies = self._ends + self._period, mean, []
        return falls


class RelaxToRest:
    """Explicit motion with ramped loads, damped to rest.

    Parameters
    ----------
    motion : MotionSettings
        How blocks are moved.
    """

    name = "dynamic relaxation"

    def __init__(self, motion: MotionSettings = SETTINGS.motion) -> None:
        self._motion = motion

    def applies(self, equations: StepEquations, at: Iterate, goal: Goal) -> bool:
        """Return whether blocks are at rest where the step begins."""
        return at.velocity is None

    def solve(self, equations: StepEquations, at: Iterate, goal: Goal) -> Attempt:
        """Return where blocks come to rest, all but few of them."""
        transit = _shear_slowness(equations) * max(SETTINGS.min_transit, equations.system.blocks_across)
        ramp = int(SETTINGS.ramp * transit)
        motion: Cycles = equations.system.in_motion(_pressed(equations), self._motion, ramp=ramp)
        decay, levels = Decay(motion.loading_cycles, int(SETTINGS.period * transit)), list(SETTINGS.levels)
        while levels and motion.searches < SETTINGS.max_searches:
            motion.advance(max(SETTINGS.min_cycles, int(transit)))
            if motion.diverged or not decay.goes_on(motion.cycles, motion.kinetic_energy):
                break
            if _is_below(motion, levels[0], goal.max_residual):
                motion.search()
                if _is_below(motion, levels[0], goal.max_residual):
                    del levels[0]
            elif motion.passed > SETTINGS.passed * equations.system.d:
                motion.search()
        if motion.diverged or motion.residual.rms > MAX_RMS:
            return Attempt(equations=equations, position=equations.start, outcome=Outcome.STALLED)
        motion.search()
        return Attempt(
            equations=motion.equations,
            position=motion.residual.position,
            outcome=Outcome.ACCEPTABLE,
            contacted=motion.contacted,
        )


def _pressed(equations: StepEquations) -> StepEquations:
    """Return the step from a part of its elastic solution, where no contact carries a force yet.

    Friction needs a pressure: what only a thrust holds that the load itself brings would fall before it is there.
    """
    if (equations.contacts.candidates.history >= 0).any():
        return equations
    movement = equations.elastic_position - equations.start
    farthest = SETTINGS.passed * equations.system.d
    part = min(SETTINGS.pressed, farthest / max(equations.movement(movement), farthest))
    return equations.static_problem_at(equations.start + part * movement, equations.lam)


def _shear_slowness(equations: StepEquations) -> float:
    """Return how many times as many cycles a wave of pressure takes where shear springs are stiffer than normal ones.

    Masses are those that the stiffer springs need.
    """
    normal, shear = equations.system.stiffness_sums(equations.contacts, equations.evaluate(equations.start))
    return float(np.sqrt(max(1.0, (normal + shear) / (2 * normal)))) if normal > 0 else 1.0


def _is_below(motion: Cycles, rms: float, max_residual: float) -> bool:
    """Return whether all loads act and the residual is below either norm."""
    return motion.is_loaded and (motion.residual.rms < rms or motion.residual.max_norm < max_residual)
