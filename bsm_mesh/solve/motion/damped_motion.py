"""Explicit damped motion: cycles of unit time with the smallest stable masses.

Common to relaxation and to following of slides: forces as changes since the last evaluation of contacts, scaled masses
(Underwood 1983), and local damping by a part of the residual against the velocity (Cundall 1987), which is zero at
rest.
"""

from __future__ import annotations

from copy import copy
from dataclasses import replace

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.model.joint_laws import JointResponse
from bsm_mesh.solve.algebra.constraints import Constraints
from bsm_mesh.solve.contacts.forces import ContactSet, Evaluation, slipping
from bsm_mesh.solve.contacts.history import commit
from bsm_mesh.solve.motion.cycles import ExplicitContacts, ExplicitLoads, blocks_in_order, run_cycles
from bsm_mesh.solve.motion.kernels import BROKEN, frames_of, masses
from bsm_mesh.solve.step.equations import Step

REFRESH_TRANSITS, MIN_CYCLES = 1.0, 100  # wave transits between evaluations of contacts, and smallest number of cycles
REACH_MARGIN = 2.0  # times the relative movement in the last cycles: gaps of contacts that count in the next
UNLIMITED = 1e30  # strength without limit [N/m], in single precision


def wave_transit_cycles(step: Step) -> float:
    """Return the number of cycles in which a wave crosses the model: about its number of blocks across."""
    return float(np.sqrt(len(step.start)))


def cycles_at_once(step: Step) -> int:
    """Return the number of cycles between evaluations of contacts."""
    return max(MIN_CYCLES, int(REFRESH_TRANSITS * wave_transit_cycles(step)))


class DampedMotion:
    """Explicit integrator of the damped motion of a step's blocks.

    Parameters
    ----------
    step : Step
        The equations at its start.
    ramp : int
        Cycles over which the initial residual is applied; 1: at once.
    damping : float
        Part of the residual that acts against the velocity.
    position : (n, 3) float64, optional
        Initial position; by default that of the step's start.
    lightest : float
        Smallest mass of a block, over the mean mass of those that are not fixed.

    Attributes
    ----------
    residual : Balance
        The residual at the current position.
    contacted : (m,) bool
        Contacts that were closed at any time since the last search.
    velocity : (n, 3) float64 [m, m, rad]
        Movement in a cycle.
    least_mass : (n, 3) float64
        Masses over the square of a cycle when cycles began; 0 before.
    done : int
        Cycles so far.
    searches : int
        Number of contact searches.
    """

    def __init__(
        self, step: Step, ramp: int, damping: float, position: FloatArray | None = None, lightest: float = 0.0
    ) -> None:
        self._step, self._ramp, self._damping, self._lightest = copy(step), ramp, damping, lightest
        self._searched = step.start if position is None else position
        self.done, self.searches, self._pace = 0, 0, np.inf
        self.residual = step.residual_at(self._searched)
        self.contacted = self.residual.at.closed.copy()
        self._ramped_load = self.residual.forces
        self.velocity = np.zeros_like(step.start)
        self.least_mass = np.zeros_like(step.start)
        self._order = blocks_in_order(step.system.outlines.centroid)

    @property
    def contacts(self) -> ContactSet:
        """The contacts, with slip and failures so far."""
        return self._step.contacts

    @property
    def passed(self) -> float:
        """Largest relative movement of neighbouring blocks since the last contact search [m]."""
        return self._step.max_relative_movement(self.residual.position - self._searched)

    def is_at_rest(self, most: float, tolerance: float) -> bool:
        """Return whether, fully loaded, the rms residual is below `most` or its maximum norm below `tolerance`."""
        rests = self.residual.max_norm < tolerance or self._step.is_localized(self.residual, most)
        return rests and self.done >= self._ramp

    def accepted(self, *, at_rest: bool) -> Step:
        """Return the step from the current position, with the blocks' velocity unless they are at rest."""
        if self._searched is not self.residual.position:
            self.search()
        step = self._step
        begun = Step(step.system, step.factors, step.contacts, self.residual.position, step.lam)
        begun.velocity = None if at_rest else self.velocity
        return begun

    def search(self) -> None:
        """Commit slip and failures, and search contacts again."""
        step, position = self._step, self.residual.position
        history, _ = commit(step.contacts, self.residual.at, position, step.system.outlines.size)
        step.contacts = step.system.gather(history, position, first=False)
        self.residual, self._searched, self.searches = step.residual_at(position), position, self.searches + 1
        self.contacted = self.residual.at.closed.copy()

    def advance(self, cycles: int, margin: float = 0.0) -> None:
        """Advance by some cycles, and keep slip and failures.

        `margin`: approach of blocks [m] to be expected beyond that by their velocity. Contacts with gaps beyond the
        approach of the last cycles are left out; the cycles are repeated with more of them where blocks move farther.
        """
        step, at, before = self._step, self.residual.at, self.velocity.copy()
        at_most = margin + 2 * cycles * step.movement(before)
        for distance in (min(at_most, REACH_MARGIN * cycles * self._pace), at_most):
            rows = _within_reach(step.contacts, at, distance)
            moved, changed, contacted, failed = self._moved(cycles, rows)
            past = step.max_relative_movement(moved)
            if distance == at_most or past <= distance:
                break
            self.velocity[:] = before
        self.done, self._pace = self.done + cycles, past / cycles
        self.contacted[rows] = contacted
        self._keep(self.residual.position + moved, rows, at.shear[rows] + changed, rows[failed])

    def _moved(self, cycles: int, rows: IntArray) -> tuple[FloatArray, FloatArray, BoolArray, BoolArray]:
        """Return movement (n, 3), change of shear of rows (k,), and which of these were closed, and failed."""
        step, at = self._step, self.residual.at
        candidates = step.contacts.candidates
        block_a, block_b = candidates.block_a[rows], candidates.block_b[rows]
        frame, arms = frames_of(at.position, block_a, block_b, step.contacts.geometry, rows)
        pressure = np.maximum(at.pressure, np.finfo(float).tiny)
        answer = slipping(step.contacts, step.system.catalogue.laws, pressure)
        explicit = ExplicitContacts(
            block_a,
            block_b,
            frame,
            _springs(step.contacts, at, answer, rows),
            step.contacts.tension[rows].astype(np.float32),
            np.zeros(len(rows), np.float32),
            self.contacted[rows],
            np.zeros(len(rows), dtype=bool),
        )
        mass = self._mass(explicit, arms)
        loads = ExplicitLoads(
            self.residual.forces,
            self._ramped_load,
            1 / mass,
            step.supports.block,
            _projectors(step.supports, mass),
            self._damping,
            self.velocity,
        )
        unramped_fraction = _unramped_fraction(np.arange(self.done + 1, self.done + cycles + 1) / self._ramp)
        moved, changed = run_cycles(explicit, loads, unramped_fraction, self._order, step.factors.options.threads)
        failed = (explicit.slipped & answer.failed[rows]) | (explicit.tension == BROKEN)
        return moved, changed, explicit.contacted, failed

    def _keep(self, position: FloatArray, rows: IntArray, shear: FloatArray, failed: IntArray) -> None:
        """Set the new position with slip and failures; open contacts have no shear force."""
        step, contacts = self._step, self._step.contacts
        at = step.evaluate(position)
        kept = np.zeros(contacts.count)
        kept[rows] = shear
        broken = at.failed | ((contacts.tension > 0) & ~at.closed)
        broken[failed] = True
        step.contacts = replace(
            contacts,
            old_shear=np.where(at.closed, kept, 0.0),
            old_tangential=np.where(at.closed | ~np.isnan(contacts.old_tangential), at.tangential, np.nan),
            failed=broken,
            tension=np.where(broken, 0.0, contacts.tension),
        )
        self.residual = step.residual_at(position)

    def _mass(self, explicit: ExplicitContacts, arms: FloatArray) -> FloatArray:
        """Return the smallest stable masses (n, 3), over the square of a cycle.

        Central differences are stable up to a stiffness of four times the mass, in which damping counts 1 + damping
        times. That of contacts is at most four times the sum of theirs: the square of a difference of two movements,
        each of a translation and a rotation. No mass is less than at the first cycle, nor than `lightest` demands.
        """
        sums = masses(explicit.block_a, explicit.block_b, explicit.spring, arms, len(self.velocity))
        mass: FloatArray = (1 + self._damping) * sums
        if not self.least_mass.any():
            least = mass.min(axis=0, where=mass > 0, initial=np.inf)
            least = np.where(np.isfinite(least), least, 1.0)  # no contacts
            begun = np.where(mass > 0, mass, least)
            free = ~self._step.system.outlines.fixed
            self.least_mass = np.maximum(begun, self._lightest * begun.mean(axis=0, where=free[:, None]))
        return np.maximum(mass, self.least_mass)


def _within_reach(contacts: ContactSet, at: Evaluation, distance: float) -> IntArray:
    """Return the contacts (k,) that are closed, or would be after an approach of blocks by a distance [m]."""
    end = contacts.candidates.edge_length + contacts.edge_overhang
    over = (at.tangential >= -contacts.edge_overhang) & (at.tangential <= end)
    gap = at.gap - contacts.offset
    closes = over & (gap >= 0) & (contacts.within_tolerance | (gap <= distance))
    return np.flatnonzero(at.closed | closes)


def _springs(contacts: ContactSet, at: Evaluation, answer: JointResponse, rows: IntArray) -> FloatArray:
    """Return springs and strengths (k, 6) of contacts as `relax_cycles` takes them; strengths by their tangents.

    `answer`: the response of slipping contacts.
    """
    strength = np.minimum(answer.strength, UNLIMITED)
    columns = (
        contacts.normal_stiffness,
        contacts.shear_stiffness,
        np.where(at.closed, at.pressure, contacts.normal_stiffness * (contacts.offset - at.gap)),
        strength - at.shear,
        strength + at.shear,
        answer.by_pressure,
    )
    return np.column_stack([column[rows] for column in columns]).astype(np.float32)


def _projectors(supports: Constraints, mass: FloatArray) -> FloatArray:
    """Return the projectors (k, 3, 3) of supported blocks onto their free axes, orthogonal over masses (n, 3)."""
    projectors = np.zeros((len(supports.block), 3, 3))
    moves = np.flatnonzero(supports.constrained < 3)  # of the others it is zero
    own, constrained = mass[supports.block[moves]], np.arange(3) < supports.constrained[moves, None]
    free = np.where(constrained, 0.0, 1.0)[:, None, :] * supports.basis[moves]
    inverse = np.linalg.pinv(np.einsum("kri,kr,krj->kij", free, own, free), hermitian=True)
    projectors[moves] = np.einsum("kri,kij,ksj,ks->krs", free, inverse, free, own)
    return projectors


def _unramped_fraction(time: FloatArray) -> FloatArray:
    """Return the part of the ramped load that does not act yet, (k,), at times (k,) over that of the ramp."""
    fraction: FloatArray = 0.5 + 0.5 * np.cos(np.pi * np.minimum(time, 1.0))
    return fraction
