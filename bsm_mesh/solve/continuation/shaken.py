"""The continuation of a stage that is shaken: explicit motion in time first, then the loop to rest or collapse."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import fields, replace
from math import floor
from typing import TypeAlias

import numpy as np

from bsm_mesh.arrays import ROUNDING, FloatArray, IntArray
from bsm_mesh.model.base_motion import GRAVITY, BaseMotion
from bsm_mesh.model.loads import PointForces
from bsm_mesh.model.model import Model
from bsm_mesh.model.options import Options
from bsm_mesh.model.shaking import Integrator, Shaking
from bsm_mesh.model.supports import Bars
from bsm_mesh.results.records import Status, StepRecord
from bsm_mesh.solve.continuation.implicit_motion import ImplicitMotion
from bsm_mesh.solve.continuation.loop import Continuation
from bsm_mesh.solve.continuation.pace import Pace
from bsm_mesh.solve.continuation.plan import USUAL, Route
from bsm_mesh.solve.continuation.state import LoopState
from bsm_mesh.solve.motion.energy import kinetic_energy, spring_energy
from bsm_mesh.solve.motion.following import SETTINGS as FOLLOWING
from bsm_mesh.solve.motion.motion import Motion, Start
from bsm_mesh.solve.motion.quiet_ends import QuietEnds
from bsm_mesh.solve.motion.shaken_motion import ShakenMotion
from bsm_mesh.solve.motion.shaking_faults import imbalance
from bsm_mesh.solve.motion.shaking_memory import ShakingMemory
from bsm_mesh.solve.motion.wave_speeds import stiffness_of_blocks
from bsm_mesh.solve.step.block_system import BlockSystem
from bsm_mesh.solve.step.equations import StepEquations
from bsm_mesh.solve.step.system import Contacts, System

NAME = "shaking"
ShakenBlocks: TypeAlias = ShakenMotion | ImplicitMotion
INTEGRATORS: dict[Integrator, type[ShakenBlocks]] = {"explicit": ShakenMotion, "implicit": ImplicitMotion}


class ShakenContinuation(Continuation):
    """The continuation of one model in a stage that is shaken.

    A step of the shaking ends where contacts are to be searched for, and every second, so that an interrupted run goes
    on from there.

    Parameters
    ----------
    model, options, observer, start, resumed, accepted, route
        As of `Continuation`.
    shaking : Shaking
        The input.
    shaken : ShakingMemory, optional
        How far it was shaken before some of its blocks were taken away.
    quiet : (k,) int
        Numbers of the supports of its quiet boundaries. While it is shaken dashpots replace them; then they hold
        again, where they were.
    """

    def __init__(
        self,
        model: Model,
        options: Options,
        observer: Callable[[StepRecord, Callable[[], Motion]], None],
        start: Start,
        resumed: LoopState | None = None,
        accepted: Callable[[], None] = lambda: None,
        route: Route = USUAL,
        *,
        shaking: Shaking,
        shaken: ShakingMemory | None = None,
        quiet: IntArray,
    ) -> None:
        self._shaking, self.shaken, self._is_begun = shaking, shaken, resumed is not None
        self._quiet = quiet
        self._opened: BlockSystem | None = None
        self._base = BaseMotion(shaking)
        super().__init__(model, options, observer, start, resumed, accepted, route)

    def run(self) -> Motion:
        """Return the final state: equilibrium, collapse, or not converged."""
        if not self._is_begun:
            self._begin()
        while self.shaken is not None and self.shaken.time < self._shaking.length:
            end = self._shaken_step(self.shaken)
            if end is not None:
                return end
            self._between_steps()
        return super().run()

    def blocks_at_start(self) -> ShakenBlocks:
        """Return the blocks as they are when the shaking begins, ready to be followed."""
        self._begin()
        assert self.shaken is not None
        return self._shaken_blocks(self._shaken_system(self.shaken), self.shaken)

    def _begin(self) -> None:
        """Set the unit of residuals, and the state at the start."""
        contacts = self.system.gather(self.state.history, self.state.position, first=False, keeps_lengths=True)
        super()._set_residual_scale(contacts, self.state.position)
        springs, model = spring_energy(contacts, self.system.evaluate(contacts, self.state.position)), self.system.model
        if self.shaken is None:
            quiet = self._quiet_ends() if self._shaking.quiet else None
            self.shaken = ShakingMemory.begin(model.blocks.count, len(model.joints), springs, quiet)
        elif self.shaken.time > 0:
            self.shaken = self.shaken.without(springs + kinetic_energy(model, self.shaken.velocity))
        self._is_begun = True

    def _quiet_ends(self) -> QuietEnds:
        """Return the ends of quiet boundaries at rest, with the forces of the supports that they replace."""
        system, position = self.system, self.state.position
        assert isinstance(system, BlockSystem)
        bars, supports = system.bars, system.constraints_at(position)
        nothing = PointForces(block=bars.block[:0], point=bars.point[:0], force=bars.direction[:0])
        opened = self._without_supports(nothing)  # with the contacts between blocks that were held
        contacts = opened.gather(self.state.history, position, first=False, keeps_lengths=True)
        at = opened.evaluate(contacts, position)
        forces = opened.acting_at(position) + at.forces
        rows = np.isin(bars.support, self._quiet)
        force = supports.bar_forces(supports.reactions(forces))[rows, None] * bars.direction[rows]
        held = PointForces(block=bars.block[rows], point=bars.point[rows], force=force)
        stiffness = stiffness_of_blocks(contacts, at, system.model.blocks)
        return QuietEnds.begin(system.model, self._shaking, self._base.axis, stiffness, held)

    def _without_supports(self, held: PointForces) -> BlockSystem:
        """Return the system with forces in the place of the supports of quiet boundaries."""
        system = self.system
        assert isinstance(system, BlockSystem)
        rows = ~np.isin(system.bars.support, self._quiet)
        bars = Bars(**{field.name: getattr(system.bars, field.name)[rows] for field in fields(Bars)})
        model = system.model.replace(supports=[bars], loads=[*system.model.acting_loads, held])
        opened = BlockSystem(model, system.bolts, self.state.position)
        opened.residual_scale = system.residual_scale
        return opened

    def _shaken_system(self, memory: ShakingMemory) -> System:
        """Return the system while it is shaken."""
        if memory.quiet is None:
            return self.system
        if self._opened is None:
            self._opened = self._without_supports(memory.quiet.held)
        self._opened.bolts = self.system.bolts
        return self._opened

    def _set_residual_scale(self, contacts: Contacts, position: FloatArray) -> None:
        """Keep the unit of residuals: that of the equilibrium before the shaking."""

    def _shaken_step(self, memory: ShakingMemory) -> Motion | None:
        """Go on to the end of a step of the shaking, and return the final state if it is one."""
        system = self._shaken_system(memory)
        began = time.perf_counter(), self.factors.count
        motion = self._shaken_blocks(system, memory)
        interval, last = self._shaking.interval, min(self._shaking.length, floor(memory.time + ROUNDING) + 1.0)
        while motion.memory.time < last and motion.passed <= system.d:
            output = interval * (floor(motion.memory.time / interval + ROUNDING) + 1)
            output = min(output, self._shaking.length)
            motion.go_on(min(output, last))
            if motion.diverged:
                return self._end(Status.NOT_CONVERGED, motion.fault, motion.contacts, motion.residual.position)
            if motion.memory.time == output:
                motion.keep_record()
                self._note(motion, began)
                began = time.perf_counter(), self.factors.count
        return self._after_shaking(motion)

    def _shaken_blocks(self, system: System, memory: ShakingMemory) -> ShakenBlocks:
        """Return the blocks where the present step of the shaking begins."""
        state = self.state
        contacts = system.gather(state.history, state.position, first=False, keeps_lengths=True)
        equations = StepEquations(system, self.factors, contacts, state.position, self.min_lam)
        return INTEGRATORS[self._shaking.integrator](equations, self._shaking, self._base, memory)

    def _note(self, motion: ShakenBlocks, began: tuple[float, int]) -> None:
        """Record a time of the shaking."""
        position, contacts = motion.residual.position, motion.contacts
        self.shaken, self.system.bolts = motion.memory, motion.system.bolts
        residual = self.system.static_residual(contacts, position)
        at = motion.residual.at
        self._record(len(self.steps), residual, position, contacts, at, began, (NAME,), motion.memory.time)

    def _after_shaking(self, motion: ShakenBlocks) -> Motion | None:
        """Take over where a step of the shaking ended; return the final state where blocks have fallen."""
        system, position, contacts = self.system, motion.residual.position, motion.contacts
        self.shaken, system.bolts = motion.memory, motion.system.bolts
        history, _ = system.commit(contacts, motion.residual.at, position)
        is_over = self.shaken.time >= self._shaking.length
        velocity = motion.settled_velocity / np.sqrt(GRAVITY)
        # What is without contact may land again: only a block that has flown its own size has fallen.
        collapse = self.collapse.check(contacts, motion.contacted, position, np.zeros_like(velocity), flight=1.0)
        if (is_over or collapse is not None) and (fault := imbalance(self.shaken, self._shaking)):
            return self._end(Status.NOT_CONVERGED, fault, contacts, position)
        if collapse is not None:
            self.shaken = replace(self.shaken, stored=motion.stored)
            collapse = replace(collapse, reason=f"after {self.shaken.time:.4g} s of shaking {collapse.reason}")
            return self._collapsed(collapse, contacts, position, velocity)
        if is_over:  # what slides on is hardly damped
            self._acceptance.pace = Pace(moving_steps=FOLLOWING.beginning_steps)
        self.state = self._state_after(0, position, history, velocity=velocity if is_over else None)
        return None
