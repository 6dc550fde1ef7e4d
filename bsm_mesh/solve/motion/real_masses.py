"""Real masses of blocks that are shaken, and the time step with which no wave grows."""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.model.base_motion import GRAVITY
from bsm_mesh.model.shaking import Shaking
from bsm_mesh.solve.motion.energy import real_masses
from bsm_mesh.solve.motion.masses import Masses, MotionSettings, Weighed
from bsm_mesh.solve.step.equations import StepEquations


class RealMasses(Masses):
    """Masses over the square of a time step: the real ones, or heavier by `Shaking.mass_scaling` at most.

    The time step follows from all contacts that blocks may get within a window, and never grows in a stage.

    Parameters
    ----------
    step : StepEquations
        The equations.
    settings : MotionSettings
        How blocks are moved.
    weighed : tuple of arrays
        The contacts, as `update` takes them.
    shaking : Shaking
        What is given.
    stable : float [s]
        The largest time step that was stable so far.

    Attributes
    ----------
    real : (n, 3) float64 [kg/m, kg/m, kg m]
        Real masses.
    stable : float [s]
        The largest time step that is stable with all contacts so far.
    """

    def __init__(
        self, step: StepEquations, settings: MotionSettings, weighed: Weighed, shaking: Shaking, stable: float
    ) -> None:
        self._system, self._settings, self._shaking = step.system, settings, shaking
        model = step.system.model
        weights = np.where(step.system.prescribed_blocks & (model.weights == 0), 1.0, model.weights)  # never moves
        self.real = real_masses(weights, model.blocks)
        self.stable = stable
        self.weigh(weighed)
        self.set_time_step(self.stable)

    def weigh(self, weighed: Weighed) -> None:
        """Reduce the stable time step to that of contacts: blocks a, b (k,) and columns (k,)."""
        free = ~self._system.prescribed_blocks
        self._least_masses = self._least(weighed) / self._shaking.time_step**2
        needed = (self._least_masses / self._shaking.mass_scaling / self.real)[free].max(initial=0.0)
        d, window = self._system.d, self._settings.window
        # Without contacts: no block falls by more than a window in a time step.
        steps = (1 / np.sqrt(needed) if needed > 0 else np.inf, np.sqrt(2 * window * d / GRAVITY))
        self.stable = min(self.stable, *map(float, steps))

    def set_time_step(self, time_step: float) -> None:
        """Set the masses over the square of a time step [s], none greater than stable."""
        self.inverse_rate = 1 / (GRAVITY * time_step**2)
        real = self.real / time_step**2
        free = ~self._system.prescribed_blocks[:, None]
        self.mass = np.where(free, np.maximum(real, self._least_masses), real)

    def update(self, weighed: Weighed) -> None:
        """Do nothing: `weigh` and `set_time_step` are called instead."""

    @property
    def heavier(self) -> FloatArray:
        """Masses over the real ones, (n,): the greatest of a block."""
        found: FloatArray = (self.mass / (GRAVITY * self.inverse_rate) / self.real).max(axis=1)
        return found
