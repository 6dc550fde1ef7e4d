"""Explicit motion: blocks accelerated cycle by cycle by their residual.

The one method that needs no solution nearby and no factorization. A cycle has unit time; masses are the real ones in
a time that suits the stiffest of them (`real_masses`), or as small as stability allows (Underwood 1983). A part of each
force acts against the velocity (Cundall 1987): it takes nothing from what stands still. Contacts keep what slips and
breaks, bolts what yields, as it comes.

A *window* of cycles has one reference: forces and laws are worked out exactly there, their changes within (see
`contact_kernels`). It ends when a block has moved by an eighth of a step length.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.contact.forces import ContactSet
from bsm_mesh.contact.history import commit, slip_path_after, worn
from bsm_mesh.model.joint_laws import wear_length_of
from bsm_mesh.solve.motion.bolt_kernels import bolt_arrays
from bsm_mesh.solve.motion.contact_columns import column_of
from bsm_mesh.solve.motion.masses import Masses, MotionSettings, Weighed, projectors
from bsm_mesh.solve.motion.threads import Share, advance_window, strips
from bsm_mesh.solve.motion.window_columns import Columns, columns_of, near, share_of, strength_lines
from bsm_mesh.solve.step.block_system import BlockSystem
from bsm_mesh.solve.step.equations import Residual, StepEquations


class ExplicitMotion:
    """Blocks in explicit motion from where a step starts.

    Parameters
    ----------
    step : StepEquations
        The equations; their regularisation plays no part.
    settings : MotionSettings
        How blocks are moved.
    velocity : (n, 3) float64 [sqrt(m), sqrt(m), rad / sqrt(m)], optional
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

    def __init__(
        self, step: StepEquations, settings: MotionSettings, *, velocity: FloatArray | None = None, ramp: int = 0
    ) -> None:
        self._settings, self._ramp = settings, ramp
        self._step = step.with_regularization(0.0).with_system_of_its_own()
        self.system: BlockSystem = self._step.system
        self.cycles, self.searches, self.diverged = 0, 0, False
        self.residual: Residual = self._step.residual_at(step.anchor)
        self._searched = self.residual.position
        self.contacted = self.residual.at.closed.copy()
        self._ramped_load = self.residual.forces if ramp else np.zeros_like(step.start)
        self._strips = strips(self.system.outlines.centroid, step.factors.options.threads)
        self._rows, self._columns = self._near()
        given = np.zeros_like(step.start) if velocity is None else velocity
        self._masses = self._begin_masses(given)
        self._velocity = given / np.sqrt(self._masses.inverse_rate)
        self._prescribed, self._prescribed_cycles = self._prescribed_per_cycle(step)

    def _begin_masses(self, velocity: FloatArray) -> Masses:
        """Return the masses for a velocity at the start (n, 3), as `velocity`."""
        return Masses(self._step, self._settings, self._weighed(), velocity)

    @property
    def equations(self) -> StepEquations:
        """The step's equations, regularisation apart, with the contacts as they are."""
        return self._step

    @property
    def contacts(self) -> ContactSet:
        """The contacts, with what slipped and broke so far."""
        return self._step.contacts

    @property
    def velocity(self) -> FloatArray:
        """Velocity (n, 3), its square twice the height of a free fall to it [sqrt(m), sqrt(m), rad / sqrt(m)]."""
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
        history, _ = commit(step.contacts, self.residual.at, position, self.system.outlines.size)
        self._step = step.updated(self.system.gather(history, position, first=False), position)
        self.residual, self._searched = self._step.residual_at(position), position
        self.searches += 1
        self.contacted = self.residual.at.closed.copy()
        self._rows, self._columns = self._near()

    def advance(self, max_cycles: int | None = None) -> None:
        """Go through a window, of `max_cycles` at most, and keep what slips, breaks and yields in it."""
        cycles = self._begin_window(min(self._settings.cycles, max_cycles or self._settings.cycles))
        contacts, at, rows, supports = self.contacts, self.residual.at, self._rows, self._step.supports
        columns = self._columns | {"dashpot": self._masses.dashpots(self._weighed())}
        shaken = self._shaken()
        share = share_of(contacts, at, self.system.catalogue, rows, columns, works=shaken is not None)
        # A window may end early: what its supports have not moved would be lost.
        if self.cycles < self._prescribed_cycles:
            cycles = min(cycles, self._prescribed_cycles - self.cycles)
        went, moved, self._velocity = advance_window(
            share,
            self._strips,
            cycles,
            self._window(),
            supports=(supports.block, projectors(supports, self._masses.mass), self._prescribed_in(cycles)),
            bolts=bolt_arrays(self.system, self.residual.position),
            loads=(self._acting(), self._ramped_load, self._unramped_fraction(cycles)),
            constants=(1 / self._masses.mass, self.system.scale, self._settings.damping),
            velocity=self._velocity,
            shaken=shaken,
        )
        self.cycles += went
        self.diverged = not np.isfinite(moved).all()
        if self.diverged:
            return
        self._keep(self.residual.position + moved, share)
        self._rows, self._columns = self._near()

    def _begin_window(self, cycles: int) -> int:
        """Set the masses for the contacts there are, and return how many of the cycles the window may have."""
        self._masses.update(self._weighed())
        return cycles

    def _shaken(self) -> tuple[FloatArray, FloatArray] | None:
        """Return drag (n, 3) and room for work (n, 5) of shaken blocks, as `move_shaken` takes them; or None."""
        return None

    def _window(self) -> float:
        """Return how far a block moves in a window at most [m]: less where slip would wear strength off meanwhile."""
        whole, contacts = self._settings.window * self.system.d, self.contacts
        if not self.system.catalogue.wears:
            return whole
        slides = np.zeros(contacts.count, dtype=bool)
        slides[self._rows] = ~self.residual.at.failed[self._rows]
        for law, rows in contacts.by_law:
            wear_length = wear_length_of(self.system.catalogue.laws[law])
            if wear_length is not None:
                room = wear_room(self._settings.window, wear_length, contacts.slip_path[rows][slides[rows]])
                whole = min(whole, float(room.min(initial=whole)))
        return whole

    def _weighed(self) -> Weighed:
        candidates, rows = self.contacts.candidates, self._rows
        return candidates.block_a[rows], candidates.block_b[rows], self._columns

    def _near(self) -> tuple[IntArray, Columns]:
        """Return the contacts (k,) that may close within a window, and their columns."""
        contacts, at, d = self.contacts, self.residual.at, self.system.d
        rows = near(contacts, at, 3 * self._settings.window * d)
        lines = strength_lines(contacts, at, self.system.catalogue.laws)
        return rows, columns_of(contacts, at, lines, rows)

    def _acting(self) -> FloatArray:
        """Return the forces at the reference without the bolts', (n, 3)."""
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
        """Return by what supports move their blocks in a cycle, (n, 3), and in how many: as fast as blocks fall."""
        prescribed = step.start - step.anchor
        size = step.movement(prescribed)
        if not step.supports_move or size == 0:
            return np.zeros_like(prescribed), 0
        cycles = max(1, int(2 * self.fall_cycles * size / self.system.d))
        return prescribed / cycles, cycles

    def _prescribed_in(self, cycles: int) -> FloatArray:
        left = min(cycles, max(self._prescribed_cycles - self.cycles, 0))
        return self._prescribed * (left / cycles)

    def _keep(self, position: FloatArray, share: Share) -> None:
        """Keep where blocks are, and what slipped, broke, failed and yielded on the way."""
        step, contacts, rows = self._step, self.contacts, self._rows
        before = self.residual.at
        contacted, failing, broken = (share.happened(name) for name in ("contacted", "failed", "broken"))
        self.contacted[rows] |= contacted
        failed, mated = contacts.failed.copy(), contacts.mated.copy()
        failed[rows] |= broken | failing
        mated[rows] &= ~broken
        left = np.where(mated, np.minimum(contacts.tension, contacts.residual_tension), 0.0)
        tension = np.where(failed, left, contacts.tension)
        shear, along = np.zeros(contacts.count), np.full(contacts.count, np.nan)
        shear[rows] = column_of(share.contacts, "carried", len(rows))
        along[rows] = before.tangential[rows] + column_of(share.contacts, "along", len(rows))
        touched = ~np.isnan(contacts.old_tangential)
        touched[rows] |= contacted
        pressure = np.full(contacts.count, np.nan)
        if len(share.growths):
            pressure[rows] = column_of(share.growths, "last_pressure", len(rows))
        here = replace(
            contacts,
            old_shear=shear,
            old_pressure=pressure,
            old_tangential=np.where(touched, along, np.nan),
        )
        path = contacts.slip_path
        if len(share.slips):
            path = path.copy()
            path[rows] += column_of(share.slips, "slid", len(rows))
            offset = contacts.dilating.opened(contacts.offset, contacts.slip_path, path)
            here = replace(here, slip_path=path, offset=offset, failed=failed, mated=mated, tension=tension)
        at = step.system.evaluate(here, position)
        if not len(share.slips):  # told, and nothing more
            path = slip_path_after(contacts, before.springs, at.closed, shear, along)
        # What is open has no shear to come back to, and is anchored where it closes.
        contacts = replace(
            here,
            old_shear=np.where(at.closed, shear, 0.0),
            old_pressure=at.pressure,
            old_tangential=np.where(at.closed & ~np.isnan(along), along, np.where(touched, at.tangential, np.nan)),
            failed=failed,
            mated=mated,
            slip_path=path,
            tension=tension,
        )
        if len(share.slips):  # by the last movement too, after which no cycle asked
            contacts = worn(contacts, at)
        bolts = self.system.bolts
        if len(bolts.alive):
            self.system.bolts = bolts.commit(bolts.evaluate(position))
        self._step = step.with_contacts(contacts)
        self.residual = self._step.residual_at(position)


def wear_room(window: float, wear_length: float, slip_path: FloatArray) -> FloatArray:
    """Return how far contacts that have slid (k,) [m] slide in a window at most, (k,) [m].

    As of a step length, so of the slip in which strength changes markedly.
    """
    return window * (wear_length + slip_path)
