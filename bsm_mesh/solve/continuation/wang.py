"""The thesis's own iteration (Wang 4.4, Fig. 4.9), for comparison with its results; ``continuation`` is the tool.

Every cycle, numbered after Wang 4.4.2, solves the elastic system of the current contacts for the residual,
moves the blocks, and resets the forces beyond the strength of the joints (Eqs. 4.8-4.13). Nothing searches for a
good step: a cycle moves sliding blocks by the residual over the shear stiffness in their way. With all of it a slide
of L takes about ``L k_s / dP`` cycles. Six corrections, without which its verdicts are wrong, or take for ever:

* opened contacts leave the stiffness matrix, but for a hundredth, until they close again: with all of it blocks hang
  from open contacts, with none a stable arch is thrown apart;
* a contact that slides on the same way keeps half the shear stiffness of the cycle before in the matrix, down to the
  part `Options.sliding_stiffness`, and all of it again once it sticks or turns round: with none from the start the
  matrix is singular in the middle of a slide that would have stopped;
* forces follow from the positions by the total law, rotations are exact: no drift, blocks keep their size;
* a cycle moves no block by more than a twentieth of its size, so that no contact is missed; a block that nothing
  holds moves on by that, and it is unstable by the rule of ``continuation`` rather than by a zero pivot;
* a contact holds a block only once it has carried for `HOLDS` cycles in a row: corners that brush past in a fall do
  not (4.4.3: one corner on one edge does not hold a block that turns about it);
* an equilibrium in which blocks balance on corners is not called stable.

A model that it calls stable is in equilibrium and within strength. One that it calls unstable may yet come to rest:
its blocks are thrown, not followed.
"""

from __future__ import annotations

import time

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.contact.force_kernels import fill_tangent
from bsm_mesh.contact.forces import ContactSet, Evaluation
from bsm_mesh.results.records import Status
from bsm_mesh.solve.algebra.block_matrix import BlockPattern
from bsm_mesh.solve.continuation.loop import Continuation
from bsm_mesh.solve.continuation.stability import falling_mode
from bsm_mesh.solve.continuation.state import CycleMemory
from bsm_mesh.solve.motion.motion import Motion
from bsm_mesh.solve.step.equations import StepEquations

OPENED = 0.01  # part of their stiffness that open contacts keep in the matrix: see above
HOLDS = 3  # cycles in a row in which a contact has to carry before it holds a block
NAME = "Wang's iteration"


class WangIteration(Continuation):
    """Wang's iteration of one model; contacts, loads, supports and verdicts are those of the continuation."""

    def run(self) -> Motion:
        """Return the final state: equilibrium, collapse, or not converged."""
        state = self.state
        contacts = self.system.gather(state.history, state.position, first=state.number == 0 and self.begin.intact)
        cycle = state.cycle.of(contacts.candidates.key)
        closed = self.system.evaluate(contacts, state.position).closed
        if state.number == 0:
            self._set_residual_scale(contacts, state.position)
            closed = contacts.within_tolerance
        position, quiet = state.position, state.quiet
        for number in range(state.number, self.options.max_steps):
            began = time.perf_counter(), self.factors.count
            moved = self._cycle(contacts, position, closed, cycle)
            if moved is None:
                return self._end(Status.NOT_CONVERGED, "the stiffness matrix is singular", contacts, position)
            position = moved
            reset = self.system.evaluate(contacts, position)  # (7)
            history, failures = self.system.commit(contacts, reset, position)  # (8)
            self.system.bolts = self.system.bolts.commit(self.system.bolts.evaluate(position))
            slid = contacts.candidates.key[reset.closed & ~reset.sticking]
            ended = contacts
            contacts = self.system.gather(history, position, first=False)  # (1)
            at = self.system.evaluate(contacts, position)
            closed, cycle = at.closed, self._next(cycle, contacts, at, slid)
            residual = self.system.static_residual(contacts, position)
            self._record(number, residual, position, ended, reset, began, (NAME,))
            complete = self.system.prescription_complete(position)
            at_rest = residual < self.options.tolerance and failures == 0 and complete
            if at_rest and quiet:
                return self._at_rest(contacts, position, at)
            quiet = bool(at_rest)
            holds = cycle.borne >= min(HOLDS, number + 1)
            if collapse := self.collapse.check(contacts, holds, position):
                return self._collapsed(collapse, contacts, position)
            self.state = self._state_after(number + 1, position, history, quiet=quiet, cycle=cycle.sorted())
            self._between_steps()
        residual = self.steps[-1].residual
        return self._end(Status.NOT_CONVERGED, self._exhausted("cycles", residual, position), contacts, position)

    def _next(self, last: CycleMemory, contacts: ContactSet, at: Evaluation, slid: IntArray) -> CycleMemory:
        """Return the memory of contacts after a cycle in which those of the keys `slid` (k,) have slid."""
        key, way = contacts.candidates.key, np.sign(at.shear)
        before = last.sorted().of(key)
        slides = np.isin(key, slid)
        on = slides & (np.sign(before.part) == way)
        least = self.options.sliding_stiffness
        part = np.where(on, np.maximum(np.abs(before.part) / 2, least) * way, np.where(slides, way, 0.0))
        skips = ~at.closed | (~slides & (before.borne == 0))  # open, or closed again: it may slide on
        part = np.where(skips, before.part, part)
        return CycleMemory(key=key, part=part, borne=np.where(at.closed, before.borne + 1, 0))

    def _cycle(
        self, contacts: ContactSet, position: FloatArray, closed: BoolArray, cycle: CycleMemory
    ) -> FloatArray | None:
        """Return the position after the elastic movement under the residual; None if K is singular."""
        step = StepEquations(self.system, self.factors, contacts, position, self.min_lam)  # (4)
        at = step.evaluate(step.start)
        data = self._elastic_stiffness(step.pattern, contacts, at, closed, cycle)  # (2)
        forces = step.residual(step.start, at.forces)  # (3)
        if not step.factorize(data, step.start):
            return None
        movement = step.solve(forces)  # (5), Eq. 4.10
        size = step.movement(movement)
        return step.moved_by(step.start, min(1.0, self.system.d / size) * movement if size > 0 else movement)  # (6)

    def _elastic_stiffness(
        self, pattern: BlockPattern, contacts: ContactSet, at: Evaluation, closed: BoolArray, cycle: CycleMemory
    ) -> FloatArray:
        """Return the blocks of K (Wang Eq. 3.22) of closed contacts; open and sliding ones keep a part."""
        kept = np.where(closed, 1.0, OPENED * contacts.within_tolerance)
        stiffness = np.where(at.closed, at.springs.stiffness, contacts.shear_stiffness)
        shear = stiffness * np.where(cycle.part == 0, 1.0, np.abs(cycle.part))
        nothing = np.zeros(contacts.count)
        data: FloatArray = fill_tangent(
            pattern.place,
            len(pattern.column),
            *contacts.frames(at.position),
            at.normal_stiffness * kept,
            nothing,
            shear * kept,
            nothing,
            nothing,
            nothing[:0],
        )
        return data

    def _at_rest(self, contacts: ContactSet, position: FloatArray, at: Evaluation) -> Motion:
        step = StepEquations(self.system, self.factors, contacts, position, self.min_lam)
        if falling_mode(step, position, at, self.tolerance) is not None:
            reason = "forces balance, but blocks are on corners from which they would fall: not an answer"
            return self._end(Status.NOT_CONVERGED, reason, contacts, position)
        return self._end(Status.STABLE, "static equilibrium", contacts, position)
