"""Explicit motion in time: central differences with real masses, the base's acceleration as a force on every block.

The kernels are those of explicit motion, without local damping and dashpots of impacts. Displacements are relative to
the base. Velocities are those of half a time step before, which central differences have; where the time step changes
they follow to the new half.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from bsm_mesh.arrays import ROUNDING, FloatArray, IntArray
from bsm_mesh.model.base_motion import BaseMotion
from bsm_mesh.model.shaking import Shaking
from bsm_mesh.solve.motion.contact_columns import column_of
from bsm_mesh.solve.motion.energy import spring_energy
from bsm_mesh.solve.motion.explicit import ExplicitMotion
from bsm_mesh.solve.motion.following import FREE
from bsm_mesh.solve.motion.masses import projectors
from bsm_mesh.solve.motion.real_masses import RealMasses
from bsm_mesh.solve.motion.shaken_kernels import ACCELERATION, BASE, BOLTS, DRAG, SPEED
from bsm_mesh.solve.motion.shaking_faults import divergence
from bsm_mesh.solve.motion.shaking_memory import SUMS, ShakingMemory
from bsm_mesh.solve.motion.threads import Share
from bsm_mesh.solve.motion.window_columns import Columns
from bsm_mesh.solve.step.equations import Residual, StepEquations

UNDAMPED = replace(FREE, damps_impacts=False)  # its local damping plays no part: the kernels of shaken blocks have none


class ShakenMotion(ExplicitMotion):
    """Blocks that are shaken, from where a step starts.

    Parameters
    ----------
    step : StepEquations
        The equations; their regularisation plays no part.
    shaking : Shaking
        The shaking as given.
    base : BaseMotion
        The movement of the base by it.
    memory : ShakingMemory
        Where the stage has come to.

    Attributes
    ----------
    memory : ShakingMemory
        Where it has come to now.
    """

    _masses: RealMasses

    def __init__(self, step: StepEquations, shaking: Shaking, base: BaseMotion, memory: ShakingMemory) -> None:
        self._shaking, self._base, self.memory = shaking, base, memory
        self._velocity = memory.velocity * memory.time_step  # contacts are asked with it
        super().__init__(step, UNDAMPED)
        free = (~self.system.prescribed_blocks).astype(float)
        self._axis = np.append(base.axis, 0.0) * free[:, None] * (shaking.boundary is None)
        self._velocity = memory.velocity * memory.time_step
        self._work = np.zeros((len(free), 5))
        self._until = memory.time
        self._begun: tuple[Residual, FloatArray, FloatArray, FloatArray]
        self._end_state, self._end_work, self._end_rates = np.zeros((0, 2)), np.zeros((0, 2)), np.zeros(2)
        self._slip_energy, self._damped, self._time_step = np.zeros_like(memory.slip_energy), 0.0, memory.time_step

    def _begin_masses(self, velocity: FloatArray) -> RealMasses:
        return RealMasses(
            self._step, self._settings, self._weighed(), self._shaking, self.memory.stable, self.memory.quiet
        )

    def go_on(self, until: float) -> None:
        """Go on until a time [s], or until blocks have passed each other so far that contacts are to be searched for.

        It ends as well where the position is not finite (`diverged`).
        """
        self._until = until
        while self.memory.time < until and not self.diverged and self.passed <= self.system.d:
            self.advance()

    @property
    def fault(self) -> str:
        """Reason where it diverged, in words."""
        return divergence(self.memory, self._shaking)

    @property
    def stable(self) -> float:
        """The time step with the present contacts [s]: a part of the stable one."""
        return self._masses.stable

    def steps_of_blocks(self, mass_scaling: float) -> FloatArray:
        """Return the time step that each block allows under a `mass_scaling` (n,) [s], as `RealMasses` does."""
        return self._masses.steps_of_blocks(mass_scaling)

    def steps_to(self, until: float) -> int:
        """Return the number of time steps to a time [s], with the present contacts."""
        return max(1, int(np.ceil((until - self.memory.time) / self.stable * (1 - 1e-9))))

    @property
    def settled_velocity(self) -> FloatArray:
        """Velocity (n, 3) at the present time [m/s, m/s, rad/s], not half a time step before."""
        found: FloatArray = self._at_half(self._velocity, 0.0) / self.memory.time_step
        return found

    def _begin_window(self, cycles: int) -> int:
        """Set time step and masses, and return how many cycles the window may have: to the time that is to be met."""
        masses, memory = self._masses, self.memory
        masses.weigh(self._weighed())
        count = self.steps_to(self._until)
        self._time_step = (self._until - memory.time) / count
        masses.set_time_step(self._time_step)
        velocity = memory.velocity * self._time_step
        self._velocity = self._at_half(velocity, self._time_step, before=memory.time_step)
        self._work[:] = 0.0
        self._ramped_load = self._axis * masses.mass
        self._begun = self.residual, self._bolt_forces(), self._velocity, self._push()
        if memory.quiet is not None:
            given, before = self._given(1)[0], memory.time_step or self._time_step
            self.memory = replace(memory, quiet=memory.quiet.at_half(given, before, self._time_step))
            self._end_rates = self._rates_of_ends()
        speed = self._step.movement(self._velocity)
        return min(cycles, count, max(1, int(self._window() / speed))) if speed > 0 else min(cycles, count)

    def _near(self, lines: Mapping[str, FloatArray]) -> tuple[IntArray, Columns]:
        """Return the contacts (k,) that may close within a window, and their columns: the last cycle's gaps too."""
        rows, columns = super()._near(lines)
        if self._shaking.dashpots > 0:
            position, contacts = self.residual.position, self.contacts
            before, now = (contacts.relative_positions(where)[:2] for where in (position - self._velocity, position))
            for name, sign, one, other in zip(("gap", "last"), (1, -1), before, now, strict=True):
                columns[name] = (sign * (one - other))[rows].astype(np.float32)
        return rows, columns

    def _at_half(self, velocity: FloatArray, time_step: float, before: float | None = None) -> FloatArray:
        """Return the velocity half a time step [s] before now, from one half another (`before`) before: in cycles.

        The base's change in between is that of its record; other forces are the present ones.
        """
        step = self._time_step
        before = step if before is None else before
        if time_step == before:
            return velocity
        time, halves = self.memory.time, np.array([time_step, before]) / 2
        gained = float(np.diff(self._base.velocity_at(time - halves)[::-1])[0])
        pushed = self._forces() / self._masses.mass * (before - time_step) / (2 * step)
        pushed -= gained * step * self._axis
        return velocity + self._onto_free_axes(pushed)

    def _onto_free_axes(self, movement: FloatArray) -> FloatArray:
        """Return movements (n, 3) with those of supported blocks along their free axes only."""
        supports = self._step.supports
        moved = movement.copy()
        projector = projectors(supports, self._masses.mass)
        moved[supports.block] = np.einsum("kij,kj->ki", projector, movement[supports.block])
        return moved

    def _base_accelerations(self, cycles: int) -> FloatArray:
        """Return the acceleration of the base in cycles from now on, (cycles,) [m]: over the square of a time step."""
        time = self.memory.time + self._time_step * np.arange(cycles, dtype=np.float64)
        accelerations: FloatArray = self._base.acceleration_at(time, self._time_step) * self._time_step**2
        return accelerations

    def _unramped_fraction(self, cycles: int) -> FloatArray:
        return self._base_accelerations(cycles)

    def _forces(self) -> FloatArray:
        """Return the forces on blocks now, those of quiet boundaries among them, (n, 3) [N/m, N/m, N]."""
        quiet, position = self.memory.quiet, self.residual.position
        return self.residual.forces if quiet is None else self.residual.forces + quiet.forces(position)

    def _given(self, cycles: int) -> FloatArray:
        """Return velocity [m/s] or stress [Pa] of the wave in cycles from now on, (cycles,)."""
        return self._base.velocity_at(self.memory.time + self._time_step * np.arange(cycles, dtype=np.float64))

    def _ends(self, cycles: int) -> tuple[Any, ...] | None:
        quiet, step = self.memory.quiet, self._time_step
        if quiet is None:
            return None
        made = np.column_stack([quiet.dashpot / step, quiet.spring, step**2 / quiet.mass, quiet.push])
        self._end_state = np.column_stack([quiet.stretch, quiet.velocity * step])
        self._end_work = np.zeros((len(quiet.block), 2))
        along = quiet.along(self.residual.position)
        return quiet.block, along, made, self._end_state, self._end_work, self._given(cycles)

    def _shaken(self) -> tuple[FloatArray, FloatArray]:
        return np.full_like(self._axis, self._shaking.drag * self._time_step), self._work

    def advance(self, max_cycles: int | None = None) -> None:
        """Go through a window, of `max_cycles` at most, and keep the energies of its parts."""
        cycles = self.cycles
        super().advance(max_cycles)
        if self.diverged:
            return
        memory, masses, went, step = self.memory, self._masses, self.cycles - cycles, self._time_step
        heavier = np.where(self.system.prescribed_blocks, 1.0, masses.heavier)
        peaks = np.sqrt(self._work[:, [SPEED, ACCELERATION]]) / step ** np.array([1, 2])
        time = memory.time + went * step
        memory = replace(
            memory,
            time=self._until if self._until - time < step / 2 else time,
            time_step=step,
            velocity=self._velocity / step,
            stable=masses.stable,
            peaks=np.maximum(memory.peaks, peaks),
            heavier=memory.heavier | (heavier > 1 + ROUNDING),
            heaviest=max(memory.heaviest, float(heavier.max(initial=1.0))),
            least_step=min(memory.least_step, step),
            cycles=memory.cycles + went,
            windows=memory.windows + 1,
        )
        if memory.quiet is not None:
            stretch, velocity = self._end_state.T
            memory = replace(memory, quiet=replace(memory.quiet, stretch=stretch, velocity=velocity / step))
        self.memory = memory
        work = self._window_work() + self._work_of_ends()
        self.memory = replace(memory, sums=memory.sums + work, slip_energy=memory.slip_energy + self._slip_energy)

    def _window_work(self) -> FloatArray:
        """Return the work of the last window by `SUMS`, (7,) [N]: by the trapezoidal rule, halves at both its ends."""
        begin, bolts, velocity, push = self._begun
        moved = self.residual.position - begin.position
        base = self._work[:, BASE].sum() + ((push * velocity).sum() - (self._push() * self._velocity).sum()) / 2
        of_bolts = self._work[:, BOLTS].sum()
        of_bolts += ((self._bolt_forces() * self._velocity).sum() - (bolts * velocity).sum()) / 2
        loads = (self.system.loads_at(begin.position) * moved).sum()
        drag = self._work[:, DRAG].sum()
        return np.array([base, loads, -of_bolts, self._slip_energy.sum(), self._damped, drag, 0.0])

    def _work_of_ends(self) -> FloatArray:
        """Return the work at quiet boundaries in the last window by `SUMS`, (7,) [N], by the same rule."""
        found = np.zeros(len(SUMS))
        if self.memory.quiet is not None:
            halves = (self._rates_of_ends() - self._end_rates) * self._time_step / 2
            found[[SUMS.index("input"), SUMS.index("quiet")]] = self._end_work.sum(axis=0) + halves
        return found

    def _rates_of_ends(self) -> FloatArray:
        assert self.memory.quiet is not None
        return self.memory.quiet.rates(self._given(1)[0], self._time_step)

    def _push(self) -> FloatArray:
        """Return the force of the base's acceleration on blocks now, (n, 3) [N/m, N/m, N], turned over."""
        push: FloatArray = self._base_accelerations(1)[0] * self._ramped_load
        return push

    def _bolt_forces(self) -> FloatArray:
        bolts = self.system.bolts
        if not len(bolts.alive):
            return np.zeros_like(self._axis)
        return bolts.evaluate(self.residual.position).forces

    def _keep(self, position: FloatArray, share: Share) -> None:
        """Keep where blocks are, and what slip and dashpots took in the window."""
        assert share.works is not None
        names = "dissipated", "damped"
        slip, damped = (column_of(share.works, name, len(self._rows)).astype(np.float64) for name in names)
        super()._keep(position, share)
        if len(share.growths) or self._shaking.dashpots > 0:
            slip = slip + self._lost_at_end(share)
        joint = self.contacts.joint[self._rows]  # -1, the last: of rock
        joints = len(self.memory.slip_energy)
        self._slip_energy = np.bincount(joint % joints, slip, joints).astype(np.float64)
        self._damped = float(damped.sum())

    def _lost_at_end(self, share: Share) -> FloatArray:
        """Return what shear springs of contacts in the window lose at its end, (k,) [N].

        Within a window shear stiffness grows no further than masses allow; at its end it follows the pressure. There
        the pressure of a dashpot holds no shear force either.
        """
        at, count = self.residual.at, len(self._rows)
        shear_after = at.shear[self._rows]
        stiffness, shear = (column_of(share.contacts, name, count) for name in ("shear_stiffness", "carried"))
        before, after = stiffness.astype(np.float64), at.springs.stiffness[self._rows]
        springs = at.closed[self._rows] & (before > 0) & (after > 0)
        lost: FloatArray = np.zeros(count)
        stored = shear.astype(np.float64)[springs] ** 2 / before[springs] - shear_after[springs] ** 2 / after[springs]
        lost[springs] = stored / 2
        return lost

    @property
    def stored(self) -> float:
        """Kinetic energy, and that in springs of contacts, now [N]."""
        return self._kinetic() + spring_energy(self.contacts, self.residual.at)

    def _kinetic(self) -> float:
        """Return the kinetic energy now [N]: of the velocities half a time step before and after."""
        mass = np.where(self.system.prescribed_blocks[:, None], 0.0, self._masses.mass)
        pushed = self._onto_free_axes((self._forces() - self._push()) / self._masses.mass)
        return float((mass * self._velocity * (self._velocity + pushed)).sum() / 2)

    def keep_record(self) -> None:
        """Add a row to the records: the present time, acceleration of the base and energies."""
        memory, base = self.memory, 0.0  # where a wave enters, supports are at rest
        if self._shaking.boundary is None:
            base = self._base_accelerations(1)[0] / self._time_step**2
        in_ends = 0.0 if memory.quiet is None else memory.quiet.stored(self._given(1)[0], self._time_step)
        springs = spring_energy(self.contacts, self.residual.at)
        self.memory = memory.with_record(base, self._kinetic(), springs, in_ends)
