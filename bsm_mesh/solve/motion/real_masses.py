"""Real masses of blocks that are shaken, and the time step with which no wave grows."""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.model.base_motion import GRAVITY
from bsm_mesh.model.shaking import Shaking
from bsm_mesh.solve.motion.contact_columns import SingleArray, stiffness_sums
from bsm_mesh.solve.motion.energy import real_masses
from bsm_mesh.solve.motion.masses import WEIGHED, Masses, MotionSettings, Weighed, spring_sums
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
        self._sums = spring_sums(self._system, weighed, self._settings.heavier_bolts)
        if self._ends is not None:
            self._sums = self._sums + self._ends.sums(self._sums)
        self._dashpot_sums = self._sums_of_dashpots(weighed)
        self._least_masses = self._settings.heavier * self._sums / self._shaking.time_step**2
        needed = self._needed(self._shaking.mass_scaling).max(initial=0.0)
        d, window = self._system.d, self._settings.window
        if self._ends is not None:
            needed = max(needed, self._ends.needed / self._shaking.time_step**2)
        # Without contacts: no block falls by more than a window in a time step.
        steps = (1 / np.sqrt(needed) if needed > 0 else np.inf, np.sqrt(2 * window * d / GRAVITY))
        self.stable = min(self.stable, *map(float, steps))

    def steps_of_blocks(self, mass_scaling: float) -> FloatArray:
        """Return the time step that each block allows under a `mass_scaling` (n,) [s]; infinite if fixed or free."""
        with np.errstate(divide="ignore"):
            return np.asarray(1 / np.sqrt(self._needed(mass_scaling)), dtype=np.float64)

    def _needed(self, mass_scaling: float) -> FloatArray:
        """Return the least inverse squares of the time step with which no wave grows, (n,) [1/s2].

        Masses m over the square of a time step 1/x are stable with ``m x^2 >= S + 2 D x``, by the Gershgorin sums S of
        springs and D of dashpots.
        """
        needed = self._least_masses / mass_scaling / self.real
        dashpots = self._dashpot_sums
        if dashpots.any():
            most = mass_scaling * self.real
            root = (dashpots + np.sqrt(dashpots**2 + most * self._sums)) / most
            needed = np.maximum(needed, root**2 / self._shaking.time_step**2)
        of_block: FloatArray = np.where(self._system.prescribed_blocks[:, None], 0.0, needed).max(axis=1)
        return of_block

    def _sums_of_dashpots(self, weighed: Weighed) -> FloatArray:
        """Return the Gershgorin sums of dashpots, (n, 3) [N s/m2, N s/m2, N s].

        Across a face and along it a contact's dashpots have the same ratio to its springs: so have their sums.
        """
        a, b, columns = weighed
        if self._shaking.dashpots == 0:
            return np.zeros_like(self._sums)
        stiffness = columns["normal_stiffness"].astype(np.float64)
        over = self._dashpots(1 / self.real[:, 0], a, b, stiffness) / stiffness
        alike = {name: columns[name] for name in WEIGHED}
        alike |= {name: (columns[name] * over).astype(np.float32) for name in ("normal_stiffness", "shear_stiffness")}
        sums: FloatArray = stiffness_sums(a, b, *alike.values(), len(self._sums))
        return sums

    def _dashpots(self, inverse: FloatArray, a: IntArray, b: IntArray, stiffness: FloatArray) -> FloatArray:
        """Return the dashpots of contacts (k,) by inverse masses (n,): `Shaking.dashpots` times the critical ones."""
        inverse = np.where(self._system.prescribed_blocks, 0.0, inverse)
        return self._shaking.dashpots * critical_dashpots(stiffness, inverse[a] + inverse[b])

    def dashpots(self, a: IntArray, b: IntArray, normal_stiffness: SingleArray | FloatArray) -> SingleArray:
        """Return the dashpots of contacts (k,) by the real masses, whatever `Shaking.mass_scaling` is."""
        if self._shaking.dashpots == 0:
            return np.zeros(len(a), np.float32)
        inverse = 1 / (self.real[:, 0] * (GRAVITY * self.inverse_rate))
        return self._dashpots(inverse, a, b, normal_stiffness.astype(np.float64)).astype(np.float32)

    def set_time_step(self, time_step: float) -> None:
        """Set the masses over the square of a time step [s], none greater than stable."""
        self.inverse_rate = 1 / (GRAVITY * time_step**2)
        real, part = self.real / time_step**2, self._shaking.time_step
        least = np.maximum(self._least_masses, self._sums / part**2 + 2 * self._dashpot_sums / (part * time_step))
        free = ~self._system.prescribed_blocks[:, None]
        self.mass = np.where(free, np.maximum(real, least), real)

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
