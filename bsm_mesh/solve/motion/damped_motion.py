"""Blocks in damped motion: explicit cycles of unit time, with masses as small as stability allows.

What relaxation and slides have in common: forces by the changes since contacts were last worked out, masses
(Underwood 1983), damping by a part of the force against the velocity (Cundall 1987), which takes no force from what
stands still.
"""

from __future__ import annotations

from copy import copy
from dataclasses import replace

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.model.joint_laws import JointResponse
from bsm_mesh.solve.algebra.constraints import Constraints
from bsm_mesh.solve.contacts.forces import Evaluation, MovingContacts, slipping
from bsm_mesh.solve.contacts.history import commit
from bsm_mesh.solve.motion.cycles import Driven, Springs, blocks_in_order, go_through
from bsm_mesh.solve.motion.kernels import BROKEN, frames_of, masses
from bsm_mesh.solve.step.equations import Step

REFRESHED, LEAST_CYCLES = 1.0, 100  # times the blocks across: cycles after which contacts are worked out again; least
ROOM = 2.0  # times how far blocks moved past each other in the last cycles: gaps of contacts that count in the next
UNLIMITED = 1e30  # strength of what cannot slip [N/m], in single precision


def blocks_across(step: Step) -> float:
    """Return how many blocks the model has across: waves cross it in about as many cycles."""
    return float(np.sqrt(len(step.start)))


def cycles_at_once(step: Step) -> int:
    """Return how many cycles go by until contacts are worked out again."""
    return max(LEAST_CYCLES, int(REFRESHED * blocks_across(step)))


class DampedMotion:
    """Blocks in damped motion.

    Parameters
    ----------
    step : Step
        The equations where it begins.
    ramp : int
        Cycles in which what is out of balance there is brought on; 1: it acts at once.
    damping : float
        Part of the force out of balance that acts against the velocity.
    position : (n, 3) float64, optional
        Where it begins instead of at the step's start.
    lightest : float
        Part of the mean mass of those that are not held that no block's is less than.

    Attributes
    ----------
    balance : Balance
        Where blocks are, and what is out of balance there.
    bore : (m,) bool
        Contacts that bore at any time since they were looked for.
    velocity : (n, 3) float64 [m, m, rad]
        Movement in a cycle.
    least_mass : (n, 3) float64
        Masses over the square of a cycle when cycles began; 0 before.
    done : int
        Cycles so far.
    searches : int
        How often contacts were looked for again.
    """

    def __init__(
        self, step: Step, ramp: int, damping: float, position: FloatArray | None = None, lightest: float = 0.0
    ) -> None:
        self._step, self._ramp, self._damping, self._lightest = copy(step), ramp, damping, lightest
        self._searched = step.start if position is None else position
        self.done, self.searches, self._pace = 0, 0, np.inf
        self.balance = step.balance_at(self._searched)
        self.bore = self.balance.at.bearing.copy()
        self._missing = self.balance.forces
        self.velocity = np.zeros_like(step.start)
        self.least_mass = np.zeros_like(step.start)
        self._order = blocks_in_order(step.moving.outlines.centroid)

    @property
    def contacts(self) -> MovingContacts:
        """The contacts, with what slipped and broke so far."""
        return self._step.contacts

    @property
    def passed(self) -> float:
        """How far blocks have passed each other since contacts were looked for [m]."""
        return self._step.past_each_other(self.balance.position - self._searched)

    def is_calm(self, most: float, tolerance: float) -> bool:
        """Return whether, with all loads on, less than `most` (root mean square) or `tolerance` is out of balance."""
        rests = self.balance.greatest < tolerance or self._step.is_scattered(self.balance, most)
        return rests and self.done >= self._ramp

    def accepted(self, *, at_rest: bool) -> Step:
        """Return the step that begins here; with the blocks' velocity unless they are at rest."""
        if self._searched is not self.balance.position:
            self.search()
        step = self._step
        begun = Step(step.moving, step.factors, step.contacts, self.balance.position, step.lam)
        begun.velocity = None if at_rest else self.velocity
        return begun

    def search(self) -> None:
        """Accept what slipped and broke, and look for contacts again."""
        step, position = self._step, self.balance.position
        history, _ = commit(step.contacts, self.balance.at, position, step.moving.outlines.size)
        step.contacts = step.moving.gather(history, position, first=False)
        self.balance, self._searched, self.searches = step.balance_at(position), position, self.searches + 1
        self.bore = self.balance.at.bearing.copy()

    def go_on(self, cycles: int, margin: float = 0.0) -> None:
        """Go on by some cycles, and keep what slips and breaks in them.

        `margin`: how far blocks may come nearer to each other [m] beyond what their velocity leads to. If they came
        less far in the last cycles, contacts so far apart are left out, and cycles are gone through again where blocks
        move farther past each other than that.
        """
        step, at, before = self._step, self.balance.at, self.velocity.copy()
        at_most = margin + 2 * cycles * step.movement(before)
        for distance in (min(at_most, ROOM * cycles * self._pace), at_most):
            rows = _within_reach(step.contacts, at, distance)
            moved, changed, bore, failed = self._moved(cycles, rows)
            past = step.past_each_other(moved)
            if distance == at_most or past <= distance:
                break
            self.velocity[:] = before
        self.done, self._pace = self.done + cycles, past / cycles
        self.bore[rows] = bore
        self._keep(self.balance.position + moved, rows, at.shear[rows] + changed, rows[failed])

    def _moved(self, cycles: int, rows: IntArray) -> tuple[FloatArray, FloatArray, BoolArray, BoolArray]:
        """Return by what blocks move (n, 3) and shears of rows (k,) change, and which of these bore, and failed."""
        step, at = self._step, self.balance.at
        candidates = step.contacts.candidates
        block_a, block_b = candidates.block_a[rows], candidates.block_b[rows]
        frame, arms = frames_of(at.position, block_a, block_b, step.contacts.geometry, rows)
        pressure = np.maximum(at.pressure, np.finfo(float).tiny)
        answer = slipping(step.contacts, step.moving.catalogue.laws, pressure)
        springs = Springs(
            block_a,
            block_b,
            frame,
            _springs(step.contacts, at, answer, rows),
            step.contacts.tension[rows].astype(np.float32),
            np.zeros(len(rows), np.float32),
            self.bore[rows],
            np.zeros(len(rows), dtype=bool),
        )
        mass = self._mass(springs, arms)
        driven = Driven(
            self.balance.forces,
            self._missing,
            1 / mass,
            step.supports.block,
            _projectors(step.supports, mass),
            self._damping,
            self.velocity,
        )
        lacking = _lacking(np.arange(self.done + 1, self.done + cycles + 1) / self._ramp)
        moved, changed = go_through(springs, driven, lacking, self._order, step.factors.options.threads)
        failed = (springs.slipped & answer.failed[rows]) | (springs.tension == BROKEN)
        return moved, changed, springs.bore, failed

    def _keep(self, position: FloatArray, rows: IntArray, shear: FloatArray, failed: IntArray) -> None:
        """Keep where blocks are, what slipped, broke and failed; who has opened bears nothing and forgets its shear."""
        step, contacts = self._step, self._step.contacts
        at = step.evaluate(position)
        kept = np.zeros(contacts.count)
        kept[rows] = shear
        broken = at.failed | ((contacts.tension > 0) & ~at.bearing)
        broken[failed] = True
        step.contacts = replace(
            contacts,
            old_shear=np.where(at.bearing, kept, 0.0),
            old_tangential=np.where(at.bearing | ~np.isnan(contacts.old_tangential), at.tangential, np.nan),
            failed=broken,
            tension=np.where(broken, 0.0, contacts.tension),
        )
        self.balance = step.balance_at(position)

    def _mass(self, springs: Springs, arms: FloatArray) -> FloatArray:
        """Return masses (n, 3), over the square of a cycle, with which no wave grows.

        Cycles bear a stiffness of four times the mass, in which a force against the velocity counts 1 + damping times.
        Of contacts it is at most four times the sum of theirs: the square of a difference of two movements, each of a
        translation and a turn. No mass is less than when cycles began, nor that of a block that touches none, nor than
        the lightest that is wanted.
        """
        sums = masses(springs.block_a, springs.block_b, springs.spring, arms, len(self.velocity))
        mass: FloatArray = (1 + self._damping) * sums
        if not self.least_mass.any():
            least = mass.min(axis=0, where=mass > 0, initial=np.inf)
            least = np.where(np.isfinite(least), least, 1.0)  # none touches another
            begun = np.where(mass > 0, mass, least)
            free = ~self._step.moving.outlines.fixed
            self.least_mass = np.maximum(begun, self._lightest * begun.mean(axis=0, where=free[:, None]))
        return np.maximum(mass, self.least_mass)


def _within_reach(contacts: MovingContacts, at: Evaluation, distance: float) -> IntArray:
    """Return the contacts (k,) that bear, and those that would if blocks came nearer by a distance [m]."""
    over = (at.tangential >= -contacts.reach) & (at.tangential <= contacts.candidates.edge_length + contacts.reach)
    gap = at.gap - contacts.offset
    closes = over & (gap >= 0) & (contacts.touching | (gap <= distance))
    return np.flatnonzero(at.bearing | closes)


def _springs(contacts: MovingContacts, at: Evaluation, answer: JointResponse, rows: IntArray) -> FloatArray:
    """Return springs and strengths (k, 6) of contacts as `relax_cycles` takes them; strengths by their tangents.

    `answer`: how contacts respond where they slip.
    """
    strength = np.minimum(answer.strength, UNLIMITED)
    columns = (
        contacts.normal_stiffness,
        contacts.shear_stiffness,
        np.where(at.bearing, at.pressure, contacts.normal_stiffness * (contacts.offset - at.gap)),
        strength - at.shear,
        strength + at.shear,
        answer.by_pressure,
    )
    return np.column_stack([column[rows] for column in columns]).astype(np.float32)


def _projectors(supports: Constraints, mass: FloatArray) -> FloatArray:
    """Return the projectors (k, 3, 3) of supported blocks onto their free axes, orthogonal over masses (n, 3)."""
    projectors = np.zeros((len(supports.block), 3, 3))
    moves = np.flatnonzero(supports.held < 3)  # of the others it is zero
    own, held = mass[supports.block[moves]], np.arange(3) < supports.held[moves, None]
    free = np.where(held, 0.0, 1.0)[:, None, :] * supports.basis[moves]
    inverse = np.linalg.pinv(np.einsum("kri,kr,krj->kij", free, own, free), hermitian=True)
    projectors[moves] = np.einsum("kri,kij,ksj,ks->krs", free, inverse, free, own)
    return projectors


def _lacking(time: FloatArray) -> FloatArray:
    """Return the part of the loads that does not act yet, (k,), at times (k,) over that of the ramp."""
    lacking: FloatArray = 0.5 + 0.5 * np.cos(np.pi * np.minimum(time, 1.0))
    return lacking
