"""Explicit motion in any number of dimensions: the state between windows of cycles.

A cycle has unit time; masses are the real ones in a time that suits the stiffest of them, or as small as stability
allows (`Masses`). How a window of cycles is computed is the business of the system's own motion.
"""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray
from bsm_mesh.model.joint_laws import wear_length_of
from bsm_mesh.solve.motion.masses import Masses, MotionSettings
from bsm_mesh.solve.motion.window_columns import ExtremeLines, strength_lines
from bsm_mesh.solve.step.equations import Residual, StepEquations
from bsm_mesh.solve.step.system import Contacts


class Cycles(ABC):
    """Blocks in explicit motion from where a step starts.

    Parameters
    ----------
    step : StepEquations
        The equations; their regularisation plays no part.
    settings : MotionSettings
        How blocks are moved.
    velocity : (n, axes) float64 [sqrt(m), rad / sqrt(m)], optional
        Where it begins: the root of twice the height of a fall to it.
    ramp : int
        Cycles in which the residual at the start is brought on; 0: it acts at once.

    Attributes
    ----------
    residual : Residual
        Where blocks are, and their residual there.
    contacts : ContactSet
        With what slipped and broke on the way.
    contacted : (m,) bool
        Contacts that were closed at any time since the last search.
    cycles, searches : int
        So far.
    diverged : bool
        Whether the last window ended nowhere; where blocks are is from before it.
    """

    _extreme: ExtremeLines | None = None

    def __init__(
        self, step: StepEquations, settings: MotionSettings, *, velocity: FloatArray | None = None, ramp: int = 0
    ) -> None:
        self._settings, self._ramp = settings, ramp
        self._step = step.with_regularization(0.0).with_system_of_its_own()
        self.system = self._step.system
        self.cycles, self.searches, self.diverged = 0, 0, False
        self.residual: Residual = self._step.residual_at(step.anchor)
        self._searched = self.residual.position
        self.contacted = self.residual.at.closed.copy()
        self._ramped_load = self.residual.forces if ramp else np.zeros_like(step.start)
        self._begin()
        given = np.zeros_like(step.start) if velocity is None else velocity
        self._masses = self._begin_masses(given)
        self._velocity = given / np.sqrt(self._masses.inverse_rate)
        self._prescribed, self._prescribed_cycles = self._prescribed_per_cycle(step)

    def _begin_masses(self, velocity: FloatArray) -> Masses:
        """Return the masses for a velocity at the start (n, axes), as `velocity`."""
        return Masses(self._step, self._settings, self._sums(), velocity)

    def _begin_window(self, cycles: int) -> int:
        """Set the masses for the contacts there are, and return how many of the cycles the window may have."""
        self._masses.update(self._sums())
        return cycles

    @abstractmethod
    def _begin(self) -> None:
        """Prepare the contacts for the windows to come."""

    @abstractmethod
    def _sums(self) -> FloatArray:
        """Return the stiffness sums of springs at every block, (n, axes)."""

    @abstractmethod
    def _may_wear(self) -> BoolArray:
        """Return which contacts (m,) slip may take strength from in a window."""

    def _strength(self) -> dict[str, FloatArray]:
        """Return the strength of the contacts at the reference of a window, as `strength_lines`."""
        contacts, laws = self.contacts, self.system.catalogue.laws
        if self._extreme is None or not self._extreme.hold_for(contacts):
            self._extreme = ExtremeLines(contacts, laws)
        return strength_lines(contacts, self.residual.at, laws, self._extreme)

    def _window(self) -> float:
        """Return how far a block moves in a window at most [m]: less where slip would wear strength off meanwhile."""
        share, contacts, catalogue = self._settings.window, self.contacts, self.system.catalogue
        whole = share * self.system.d
        if not catalogue.wears:
            return whole
        wears = self._may_wear()
        for law, rows in contacts.by_law:
            wear_length = wear_length_of(catalogue.laws[law])
            if wear_length is not None:
                room = wear_room(share, wear_length, contacts.slip_path[rows][wears[rows]])
                whole = min(whole, float(room.min(initial=whole)))
        return whole

    @abstractmethod
    def advance(self, max_cycles: int | None = None) -> None:
        """Go through a window, of `max_cycles` at most, and keep what slips, breaks and yields in it."""

    @property
    def equations(self) -> StepEquations:
        """The step's equations, regularisation apart, with the contacts as they are."""
        return self._step

    @property
    def contacts(self) -> Contacts:
        """The contacts, with what slipped and broke so far."""
        return self._step.contacts

    @property
    def velocity(self) -> FloatArray:
        """Velocity (n, axes), its square twice the height of a free fall to it [sqrt(m), rad / sqrt(m)]."""
        velocity: FloatArray = self._velocity * np.sqrt(self._masses.inverse_rate)
        return velocity

    @property
    def kinetic_energy(self) -> float:
        """Kinetic energy of the blocks, their masses and time those of cycles [N]."""
        return float(np.einsum("ij,ij,ij", self._masses.mass, self._velocity, self._velocity) / 2)

    @property
    def fall_cycles(self) -> float:
        """In how many cycles a block falls freely by a step length."""
        return float(np.sqrt(2 * self.system.d * self._masses.inverse_rate))

    @property
    def loading_cycles(self) -> int:
        """Cycles after which the ramp is over, and supports have arrived."""
        return max(self._ramp, self._prescribed_cycles)

    @property
    def is_loaded(self) -> bool:
        """Whether all loads act, and supports have arrived."""
        return self.cycles >= self.loading_cycles

    @property
    def passed(self) -> float:
        """How far blocks have passed each other, or moved, since contacts were searched for [m]."""
        moved = self.residual.position - self._searched
        return max(self._step.max_relative_movement(moved), self._step.movement(moved))

    def search(self) -> None:
        """Accept what slipped and broke, and search for contacts again."""
        step, position = self._step, self.residual.position
        history, _ = self.system.commit(step.contacts, self.residual.at, position)
        self._step = step.updated(self.system.gather(history, position, first=False), position)
        self.residual, self._searched = self._step.residual_at(position), position
        self.searches += 1
        self.contacted = self.residual.at.closed.copy()
        self._begin()

    def _cycles_of_window(self, max_cycles: int | None) -> int:
        """Return how many cycles a window has at most."""
        cycles = min(self._settings.cycles, max_cycles or self._settings.cycles)
        # A window may end early: what its supports have not moved would be lost.
        if self.cycles < self._prescribed_cycles:
            cycles = min(cycles, self._prescribed_cycles - self.cycles)
        return cycles

    def _acting(self) -> FloatArray:
        """Return the forces at the reference without the bolts', (n, axes)."""
        acting: FloatArray = self.system.loads_at(self.residual.position) + self.residual.at.forces
        return acting

    def _unramped_fraction(self, cycles: int) -> FloatArray:
        """Return the part of the residual at the start that does not act yet in every cycle, (cycles,)."""
        if self.cycles >= self._ramp:
            return np.zeros(cycles)
        time = np.minimum(np.arange(self.cycles + 1, self.cycles + cycles + 1) / self._ramp, 1.0)
        unramped_fraction: FloatArray = 0.5 + 0.5 * np.cos(np.pi * time)
        return unramped_fraction

    def _prescribed_per_cycle(self, step: StepEquations) -> tuple[FloatArray, int]:
        """Return by what supports move their blocks in a cycle, (n, axes), and in how many: as fast as blocks fall."""
        prescribed = step.start - step.anchor
        size = step.movement(prescribed)
        if not step.supports_move or size == 0:
            return np.zeros_like(prescribed), 0
        cycles = max(1, int(2 * self.fall_cycles * size / self.system.d))
        return prescribed / cycles, cycles

    def _prescribed_in(self, cycles: int) -> FloatArray:
        left = min(cycles, max(self._prescribed_cycles - self.cycles, 0))
        return self._prescribed * (left / cycles)


def wear_room(window: float, wear_length: float, slip_path: FloatArray) -> FloatArray:
    """Return how far contacts that have slid (k,) [m] slide in a window at most, (k,) [m].

    As of a step length, so of the slip in which strength changes markedly.
    """
    return window * (wear_length + slip_path)
