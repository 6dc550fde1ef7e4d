"""Real masses of blocks that are shaken, and the time step with which no wave grows."""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.model.base_motion import GRAVITY
from bsm_mesh.model.shaking import Shaking
from bsm_mesh.solve.motion.contact_columns import SingleArray
from bsm_mesh.solve.motion.energy import real_masses
from bsm_mesh.solve.motion.masses import Masses, MotionSettings, Weighed, spring_sums
from bsm_mesh.solve.motion.quiet_ends import QuietEnds
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
        The shaking as given.
    stable : float [s]
        The largest time step that was stable so far.
    ends : QuietEnds, optional
        Of quiet boundaries.

    Attributes
    ----------
    real : (n, 3) float64 [kg/m, kg/m, kg m]
        Real masses.
    stable : float [s]
        The largest time step that is stable with all contacts so far.
    """

    def __init__(
        self,
        step: StepEquations,
        settings: MotionSettings,
        weighed: Weighed,
        shaking: Shaking,
        stable: float,
        ends: QuietEnds | None = None,
    ) -> None:
        self._system, self._settings, self._shaking, self._ends = step.system, settings, shaking, ends
        model = step.system.model
        weights = np.where(step.system.prescribed_blocks & (model.weights == 0), 1.0, model.weights)  # never moves
        self.real = real_masses(weights, model.blocks)
        self.stable = stable
        self.weigh(weighed)
        self.set_time_step(self.stable)

    def weigh(self, weighed: Weighed) -> None:
        """Reduce the stable time step to that of contacts: blocks a, b (k,) and columns (k,)."""
        free = ~self._system.prescribed_blocks
        self._sums = spring_sums(self._system, weighed, self._settings.heavier_bolts)
        if self._ends is not None:
            self._sums = self._sums + self._ends.sums(self._sums)
        self._least_masses = self._settings.heavier * self._sums / self._shaking.time_step**2
        needed = (self._least_masses / self._shaking.mass_scaling / self.real)[free].max(initial=0.0)
        d, window = self._system.d, self._settings.window
        # Without contacts: no block falls by more than a window in a time step.
        needed = max(needed, self._needed_by_dashpots(weighed))
        if self._ends is not None:
            needed = max(needed, self._ends.needed / self._shaking.time_step**2)
        steps = (1 / np.sqrt(needed) if needed > 0 else np.inf, np.sqrt(2 * window * d / GRAVITY))
        self.stable = min(self.stable, *map(float, steps))

    @property
    def step_of_block(self) -> FloatArray:
        """The time step that each block allows (n,) [s], by its springs alone; infinite where it is fixed or free."""
        free = ~self._system.prescribed_blocks[:, None]
        needed = np.where(free, self._least_masses / self._shaking.mass_scaling / self.real, 0.0).max(axis=1)
        with np.errstate(divide="ignore"):
            return np.asarray(1 / np.sqrt(needed), dtype=np.float64)

    def _needed_by_dashpots(self, weighed: Weighed) -> float:
        """Return the least inverse square of the time step [1/s2] with which dashpots let no wave grow; 0: none.

        A dashpot c (over a cycle) with springs of the sum S is stable with masses m where ``m / S - 1 >= 2 c / k``.
        With ``c = z 2 sqrt(k m')``, m' of both blocks, that is a square equation of the inverse of the time step.
        """
        a, b, columns = weighed
        damping, fixed = self._shaking.dashpots, self._system.prescribed_blocks
        if damping == 0 or not len(a):
            return 0.0
        stiffness = columns["normal_stiffness"].astype(np.float64)
        inverse = np.where(fixed, 0.0, 1 / self.real[:, 0])
        with np.errstate(divide="ignore"):
            linear = 4 * damping / np.sqrt(stiffness * np.maximum(inverse[a] + inverse[b], np.finfo(float).tiny))
            square = (self.real / self._sums).min(axis=1)
        square[fixed] = np.inf
        square = np.minimum(square[a], square[b])
        moves = np.isfinite(square)
        linear, square = linear[moves], square[moves]
        root = (linear + np.sqrt(linear**2 + 4 * square)) / (2 * square)
        return float((root**2).max(initial=0.0)) / self._shaking.time_step**2

    def dashpots(self, a: IntArray, b: IntArray, normal_stiffness: SingleArray | FloatArray) -> SingleArray:
        """Return the dashpots of contacts (k,): `Shaking.dashpots` times the critical ones."""
        if self._shaking.dashpots == 0:
            return np.zeros(len(a), np.float32)
        inverse = np.where(self._system.prescribed_blocks, 0.0, 1 / self.mass[:, 0])
        critical = critical_dashpots(normal_stiffness.astype(np.float64), inverse[a] + inverse[b])
        dashpots: SingleArray = (self._shaking.dashpots * critical).astype(np.float32)
        return dashpots

    def set_time_step(self, time_step: float) -> None:
        """Set the masses over the square of a time step [s], none greater than stable."""
        self.inverse_rate = 1 / (GRAVITY * time_step**2)
        real = self.real / time_step**2
        free = ~self._system.prescribed_blocks[:, None]
        self.mass = np.where(free, np.maximum(real, self._least_masses), real)

    def update(self, sums: FloatArray) -> None:
        """Do nothing: `weigh` and `set_time_step` are called instead."""

    @property
    def heavier(self) -> FloatArray:
        """Masses over the real ones, (n,): the greatest of a block."""
        found: FloatArray = (self.mass / (GRAVITY * self.inverse_rate) / self.real).max(axis=1)
        return found


def critical_dashpots(stiffness: FloatArray, inverse_masses: FloatArray) -> FloatArray:
    """Return critical dashpots of contacts (k,) of a stiffness and the sum of both blocks' inverse masses.

    Examples
    --------
    >>> critical_dashpots(np.array([8.0, 8.0]), np.array([0.5, 0.0])).tolist()
    [8.0, 0.0]
    """
    critical: FloatArray = 2 * np.sqrt(stiffness / np.where(inverse_masses > 0, inverse_masses, np.inf))
    return critical
