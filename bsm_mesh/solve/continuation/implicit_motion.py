"""Implicit motion in time: the trapezoidal rule, with forces of contacts and bolts at the end of every time step.

The equations of a time step are those of every step of the loop, with inertia in the place of the regularisation
(`StepEquations.with_inertia`). Newton's method and its line search solve them. After a time step slip is committed and
contacts are searched for.

A time step from position q, velocity v and acceleration a, its length h, with the base's gain of velocity in it, w:

1. ``q' = q + h v + h^2 a / 4 - h w / 2``, where blocks would come without forces at its end;
2. Newton's method for the position at its end, of ``F = (4 m / h^2) (q1 - q')``;
3. ``a1 = 4 (q1 - q') / h^2``, ``v1 = v + h (a + a1) / 2 - w``: accelerations are those in space, velocities those
   relative to the base;
4. the energies. Where more of them is missing or left over than its share, the length is halved, and (1) is next.

References
----------
Newmark 1959, J. Eng. Mech. Div. ASCE 85(3), 67-94, with beta = 1/4, gamma = 1/2. Without slip and impacts it keeps the
energy of linear springs; closing contacts may gain some, so the balance of energies decides on the length.

Where contacts bounce every event asks for shorter time steps. The integrator gives up where halving adds more of them
within a second than the explicit integrator takes, which needs no matrix (`_gives_up`).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import ceil

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.errors import place
from bsm_mesh.model.base_motion import BaseMotion
from bsm_mesh.model.shaking import PART_OF_STABLE, Shaking
from bsm_mesh.movements import distances
from bsm_mesh.solve.continuation.implicit_work import (
    Instant,
    StepWork,
    damped_contacts,
    failed_contacts,
    restless_contact,
    work_of,
)
from bsm_mesh.solve.methods.corrections import ROUNDING
from bsm_mesh.solve.methods.newton import newton
from bsm_mesh.solve.motion.energy import real_masses, spring_energy
from bsm_mesh.solve.motion.masses import projectors
from bsm_mesh.solve.motion.real_masses import critical_dashpots
from bsm_mesh.solve.motion.shaken_motion import ShakenMotion
from bsm_mesh.solve.motion.shaking_memory import ShakingMemory
from bsm_mesh.solve.step.attempt import Attempt, Outcome
from bsm_mesh.solve.step.equations import Residual, StepEquations
from bsm_mesh.solve.step.system import Contacts


@dataclass(frozen=True, slots=True, kw_only=True)
class ImplicitSettings:
    """When a time step is solved, and how short it may become.

    Attributes
    ----------
    residual : float
        Maximum norm of its residual, over the mean weight; at least rounding of the inertia.
    halvings : int
        Of the longest time step, at most. The shortest is accepted whatever its energies; their balance is that of the
        stage then.
    least_energy : float
        Part of the kinetic energy of all blocks at the greatest velocity of the base, below which energies are not
        compared.
    """

    residual: float = 1e-8
    halvings: int = 12
    least_energy: float = 1e-3


SETTINGS = ImplicitSettings()


class ImplicitMotion:
    """Blocks that are shaken, from where a step of the loop starts, by the trapezoidal rule.

    Parameters
    ----------
    step : StepEquations
        The equations; their regularisation plays no part.
    shaking, base, memory
        As of `ShakenMotion`.

    Attributes
    ----------
    system : System
        The blocks, with bolts of their own.
    residual : Residual
        Where blocks are, and the static residual there.
    memory : ShakingMemory
        State of the stage.
    fault : str
        Why it ended early, in words; nothing while it has not.
    """

    def __init__(self, step: StepEquations, shaking: Shaking, base: BaseMotion, memory: ShakingMemory) -> None:
        explicit = ShakenMotion(step, replace(shaking, integrator="explicit", time_step=PART_OF_STABLE), base, memory)
        self._step = step.with_regularization(0.0).with_system_of_its_own()
        self.system, self.memory, self.fault = self._step.system, replace(memory, stable=explicit.stable), ""
        self._from = memory.time, memory.cycles
        self._last: tuple[Instant, Instant] | None = None
        self._shaking, self._base = shaking, base
        model, fixed = self.system.model, self.system.prescribed_blocks
        self._mass = real_masses(np.where(fixed & (model.weights == 0), 1.0, model.weights), model.blocks)
        self._moving = np.where(fixed[:, None], 0.0, self._mass)
        self._axis = np.append(base.axis, 0.0) * ~fixed[:, None]
        self.residual: Residual = self._step.residual_at(step.anchor)
        self._begun, self._touched = step.anchor, np.zeros(0, np.int64)
        self._least_energy = SETTINGS.least_energy * float(self._moving[:, 0].sum()) * base.peaks[1] ** 2 / 2

    @property
    def contacts(self) -> Contacts:
        """The contacts where blocks are."""
        return self._step.contacts

    @property
    def contacted(self) -> BoolArray:
        """Contacts that were closed now or at the end of any time step, (m,)."""
        closed: BoolArray = self.residual.at.closed | np.isin(self._pairs(), self._touched)
        return closed

    @property
    def settled_velocity(self) -> FloatArray:
        """Velocity (n, 3) at the present time [m/s, m/s, rad/s]."""
        return self.memory.velocity

    @property
    def passed(self) -> float:
        """How far blocks have passed each other, or moved, since the loop's step began [m]."""
        moved = self.residual.position - self._begun
        return max(self._step.max_relative_movement(moved), self._step.movement(moved))

    @property
    def diverged(self) -> bool:
        """Whether it has a fault: a time step without a solution, however short, or too many time steps."""
        return bool(self.fault)

    def _gives_up(self) -> bool:
        """Return whether halving has added too many time steps since the loop's step began, and say so.

        The loop's step takes a second at most. Too many are more than the explicit integrator takes in a second or in
        the stage; and more than without halving, where the explicit one's would be longer.
        """
        elapsed, longest, steps = self.memory.time - self._from[0], self._longest, self.memory.cycles - self._from[1]
        if steps - elapsed / longest <= min(1.0, self._shaking.length) / min(self.memory.stable, longest):
            return False
        self.fault = (
            f"the implicit integrator gives up after {self.memory.time:.4g} s of shaking: contacts bounce"
            f"{self._where_restless()}, and energies balance only in {steps} time steps of {elapsed:.2g} s, more than "
            "the explicit integrator takes; set contact_damping, or integrator = 'explicit'"
        )
        return True

    def _where_restless(self) -> str:
        """Return where the blocks are whose contact changed most in the last time step tried, in words."""
        found = None if self._last is None else restless_contact(self._last)
        if self._last is None or found is None:
            return ""
        then = self._last[1]
        blocks, placed = then.contacts.candidates, self.system.placed(then.position)
        ends = (place(placed[number[found]]) for number in (blocks.block_a, blocks.block_b))
        return " where the blocks at {} and {} touch".format(*ends)

    def steps_to(self, until: float, length: float | None = None) -> int:
        """Return the number of time steps of at most a length [s] to a time [s]; None: the longest, none halved."""
        longest = self._longest if length is None else length
        return max(1, ceil((until - self.memory.time) / longest * (1 - 1e-9)))

    def go_on(self, until: float) -> None:
        """Take time steps to a time [s], or until blocks have passed each other by a step length."""
        while self.memory.time < until and not self.diverged and self.passed <= self.system.d:
            self._advance(until)

    def _advance(self, until: float) -> None:
        """Go through a time step that ends at a time [s] or before it."""
        memory, longest = self.memory, self._longest
        wanted = min(longest, 2 * memory.time_step) if memory.time_step > 0 else longest
        while wanted >= longest / 2 ** (SETTINGS.halvings + 1):
            if self._gives_up():
                return
            count = self.steps_to(until, wanted)
            length = (until - memory.time) / count
            now = self._now(length)
            then = self._after(now)
            if then is not None:
                self._last = now, then
                work = work_of(self.system, (now, then), self._shaking.drag * self._moving)
                missing, energy = self._missing(work, now, then)
                share = self._shaking.max_imbalance * length / self._shaking.length
                if abs(missing) <= share * energy or length <= longest / 2**SETTINGS.halvings:
                    self._accept(then, work, until if count == 1 else memory.time + length)
                    return
            wanted = length / 2
        self.fault = (
            f"a time step of the implicit integrator has no solution after {memory.time:.4g} s of shaking; set "
            "integrator = 'explicit'"
        )

    @property
    def _longest(self) -> float:
        return self._shaking.time_step * self._shaking.interval

    def _now(self, length: float) -> Instant:
        """Return the state at the begin of a time step [s]."""
        memory, begun = self.memory, self.residual
        gain = float(np.diff(self._base.velocity_at(memory.time + np.array([0.0, length])))[0])
        return Instant(
            position=begun.position,
            velocity=memory.velocity,
            contacts=self.contacts,
            at=begun.at,
            dashpots=np.zeros_like(begun.position) if memory.dashpots is None else memory.dashpots,
            push=-gain / length * self._moving * self._axis,
            length=length,
        )

    def _after(self, now: Instant) -> Instant | None:
        """Return the state at the end of a time step; None where none is found near."""
        length, drag, mass = now.length, self._shaking.drag, self._mass
        gained = now.push / mass * length
        acceleration = self._onto_free_axes((self.residual.forces + now.dashpots) / mass - drag * now.velocity)
        free = length * now.velocity + length**2 / 4 * acceleration + length / 2 * gained  # (1)
        inertia = mass * (4 / length**2 + 2 * drag / length)
        reached = now.position + mass * (4 / length**2 * free + drag * now.velocity) / inertia
        start = self._step.start + self._onto_free_axes(length * now.velocity)
        found = self._solved(inertia, reached, start, self.contacts, length)  # (2)
        if found is None:
            return None
        contacts, attempt = found
        position = attempt.position
        velocity = self._onto_free_axes(2 * (position - now.position) / length - now.velocity)  # (3)
        at = self._step.with_contacts(contacts).evaluate(position)
        dashpots = attempt.at.forces - at.forces
        return replace(now, position=position, velocity=velocity, contacts=contacts, at=at, dashpots=dashpots)

    def _solved(
        self, inertia: FloatArray, reached: FloatArray, start: FloatArray, contacts: Contacts, length: float
    ) -> tuple[Contacts, Attempt] | None:
        """Return contacts and the solution of a time step [s] by Newton's method; None where none is found near.

        A contact whose strength drops as it fails may leave no solution, however short the time step. Unfailed it
        carries too much, failed too little. Contacts that fail during the iterations have failed then.
        """
        damped = self._damped(contacts, length)
        equations = self._step.with_contacts(damped).with_inertia(inertia, reached)
        if not equations.within_search_range(start):
            return None
        rounding = 4 * ROUNDING * float(np.abs(equations.project(inertia * reached)).max()) / self.system.mean_weight
        tolerance = max(SETTINGS.residual, rounding)
        attempt = newton(equations, start, tolerance, exact=True)
        if attempt.outcome is not Outcome.SOLVED:
            attempt = newton(equations, attempt.position, tolerance)
        if attempt.outcome is Outcome.SOLVED:
            return (contacts, attempt) if equations.within_search_range(attempt.position) else None
        failing = attempt.at.failed & ~contacts.failed
        if not failing.any():
            return None
        return self._solved(inertia, reached, start, failed_contacts(contacts, failing), length)

    def _damped(self, contacts: Contacts, length: float) -> Contacts:
        """Return contacts with their dashpots in a time step [s]."""
        if self._shaking.dashpots == 0:
            return contacts
        fixed = self.system.prescribed_blocks
        inverse = np.where(fixed, 0.0, 1 / self._mass[:, 0])
        both = inverse[contacts.candidates.block_a] + inverse[contacts.candidates.block_b]
        critical = critical_dashpots(contacts.normal_stiffness, both)
        return damped_contacts(contacts, self.residual.at, self._shaking.dashpots * critical, length)

    def _missing(self, work: StepWork, now: Instant, then: Instant) -> tuple[float, float]:
        """Return the energy that a time step has lost [N], and the greatest energy so far."""
        kinetic = [float((self._moving * one.velocity**2).sum() / 2) for one in (now, then)]
        springs = [spring_energy(one.contacts, one.at) for one in (now, then)]
        missing = work.balance - (kinetic[1] - kinetic[0]) - (springs[1] - springs[0])
        sums = np.abs(self.memory.sums + work.sums).max()
        return missing, max(self.memory.greatest_energy, float(sums), *kinetic, self._least_energy)

    def _accept(self, then: Instant, work: StepWork, time: float) -> None:
        """Take over the end of a time step, commit what slipped there, and search for contacts."""
        memory, step, system, position = self.memory, self._step, self.system, then.position
        forces = self.system.acting_at(position) + then.at.forces + then.dashpots
        acceleration = self._onto_free_axes(forces / self._mass - self._shaking.drag * then.velocity)
        peaks = np.column_stack([distances(rows) for rows in (then.velocity, acceleration)])
        joints = len(memory.slip_energy)
        self.memory = replace(
            memory,
            time=time,
            time_step=then.length,
            velocity=then.velocity,
            dashpots=then.dashpots if self._shaking.dashpots > 0 else None,
            sums=memory.sums + work.sums,
            slip_energy=memory.slip_energy + np.bincount(self.contacts.joint % joints, work.slip, joints),
            peaks=np.maximum(memory.peaks, peaks),
            least_step=min(memory.least_step, then.length),
            cycles=memory.cycles + 1,
            windows=memory.windows + 1,
        )
        self._touched = np.union1d(self._touched, self._pairs()[then.at.closed])
        history, _ = system.commit(then.contacts, then.at, position)
        if len(system.bolts.alive):
            system.bolts = system.bolts.commit(system.bolts.evaluate(position))
        contacts = system.gather(history, position, first=False, keeps_lengths=True)
        self._step = StepEquations(system, step.factors, contacts, position, 0.0)
        self.residual = self._step.residual_at(position)

    def _pairs(self) -> IntArray:
        """Return a number of the two blocks of every contact, (m,)."""
        candidates = self.contacts.candidates
        pairs: IntArray = candidates.block_a.astype(np.int64) * len(self._mass) + candidates.block_b
        return pairs

    def _onto_free_axes(self, movement: FloatArray) -> FloatArray:
        """Return movements (n, 3) with those of supported blocks along their free axes only."""
        supports = self._step.supports
        moved = np.where(self.system.prescribed_blocks[:, None], 0.0, movement)
        projector = projectors(supports, self._mass)
        moved[supports.block] = np.einsum("kij,kj->ki", projector, moved[supports.block])
        return moved

    @property
    def _kinetic(self) -> float:
        return float((self._moving * self.memory.velocity**2).sum() / 2)

    @property
    def stored(self) -> float:
        """Kinetic energy, and that in springs of contacts, now [N]."""
        return self._kinetic + spring_energy(self.contacts, self.residual.at)

    def keep_record(self) -> None:
        """Add a row to the records: the present time, acceleration of the base and energies."""
        memory = self.memory
        base = float(self._base.acceleration_at(np.array([memory.time]), memory.time_step)[0])
        springs = spring_energy(self.contacts, self.residual.at)
        self.memory = memory.with_record(base, self._kinetic, springs)
