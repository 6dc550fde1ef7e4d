"""The equations of one step, ``loads + bolts + contacts - lam M (q - q_n) = 0``, and their linear algebra."""

from __future__ import annotations

from collections.abc import Callable
from copy import copy
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.solve.algebra.block_matrix import constrain
from bsm_mesh.solve.contacts.force_kernels import farthest_past
from bsm_mesh.solve.contacts.forces import Evaluation, MovingContacts, tangent_stiffness
from bsm_mesh.solve.contacts.smoothed_forces import Smoothed, smoothed_tangent
from bsm_mesh.solve.step.block_system import BAND, MovingModel
from bsm_mesh.solve.step.factorization import Factors

SCATTERED = 0.03  # of a weight: root mean square out of balance of which few blocks are the cause
PAST = BAND  # of the step length: how far blocks may pass each other, for so far away contacts are looked for
LONGEST = 2.0  # of the step length: what one correction, and a whole step, may move a block


@dataclass(frozen=True, eq=False, slots=True)
class Balance:
    """What is out of balance at a position.

    Attributes
    ----------
    position : (n, 3) float64 [m, m, rad]
        Where.
    evaluate : callable
        Returns the contact forces there.
    forces : (n, 3) float64 [N/m, N/m, N]
        What the equations lack.
    greatest : float
        The greatest component of what counts of them, over the mean weight.
    norm : float [N/m]
        Their 2-norm.
    weight : float [N/m]
        The mean weight.
    """

    position: FloatArray
    evaluate: Callable[[], Evaluation]
    forces: FloatArray
    greatest: float
    norm: float
    weight: float

    @property
    def at(self) -> Evaluation:
        """The contact forces there, worked out again unless they were among the last that anyone asked for.

        Many positions are compared while a step is solved; of all contacts' forces at each of them a million blocks
        would take 0.3 GB.
        """
        return self.evaluate()


class Step:
    """A step from an accepted position with given contacts and regularisation.

    Parameters
    ----------
    moving : MovingModel
        The blocks.
    factors : Factors
        The linear solver.
    contacts : MovingContacts
        Contacts at the accepted position.
    anchor : (n, 3) float64 [m, m, rad]
        The accepted position q_n.
    lam : float [1/m]
        Regularisation.

    Attributes
    ----------
    start : (n, 3) float64
        The accepted position with what the supports move in this step.
    driven : bool
        Whether they move anything.
    mass, scale : (n, 3) float64
        As in `MovingModel`.
    room : float [m]
        How much farther than `LONGEST` blocks may go in this step, all together.
    still : (n, 3) float64
        Where the regularisation bears nothing: the accepted position, unless a step goes on with contacts updated.
    friction_pressure : (m,) float64 or None [N/m]
        Pressures at which the contacts' shear strengths are held; None: they follow the pressures.
    smoothing : float [N]
        Of the contacts' laws; 0: the laws themselves.
    velocity : (n, 3) float64 or None [m, m, rad]
        Of blocks that are followed by cycles, where the step begins; None: they are not.
    jammed : bool
        Whether the interior point method found no equilibrium of its worst blocks: it is not asked again until the
        step is nearly in balance.
    """

    def __init__(
        self, moving: MovingModel, factors: Factors, contacts: MovingContacts, anchor: FloatArray, lam: float
    ) -> None:
        self.moving, self.factors, self.contacts, self.anchor, self.lam = moving, factors, contacts, anchor, lam
        self.friction_pressure: FloatArray | None = None
        self.smoothing = 0.0
        self.velocity: FloatArray | None = None
        self.jammed = False
        self.still = anchor
        self.room, self.mass, self.scale = 0.0, moving.mass, moving.scale
        self.supports = moving.constraints_at(anchor)
        given = moving.given(self.supports)
        self.driven = bool(given.any())
        self.start = anchor + given if self.driven else anchor
        self.pattern = factors.pattern_of(contacts)

    def with_friction_of(self, pressure: FloatArray) -> Step:
        """Return the same step with shear strengths held at those of a pressure (m,)."""
        held = copy(self)
        held.friction_pressure = pressure
        return held

    def smoothed(self, smoothing: float) -> Step:
        """Return the same step with laws that have a smoothing [N]."""
        soft = copy(self)
        soft.smoothing = smoothing
        return soft

    def resting(self, position: FloatArray, lam: float) -> Step:
        """Return the same step from another position, with another regularisation and shear strengths not held."""
        there = copy(self)
        there.anchor = there.still = position
        there.lam, there.friction_pressure = lam, None
        there.supports = self.moving.constraints_at(position)
        there.pattern = self.factors.pattern_of(self.contacts)  # a later step may have had another
        return there

    def renew(self, contacts: MovingContacts, position: FloatArray) -> None:
        """Go on with contacts as they are at a position; the regularisation begins anew there."""
        self.contacts, self.still, self.jammed = contacts, position, False
        self.pattern = self.factors.pattern_of(contacts)

    def break_contacts(self, rows: IntArray) -> None:
        """Take cohesion and tensile strength from contacts (k,), as if an earlier step had opened them."""
        if not rows.size:
            return
        failed, tension = self.contacts.failed.copy(), self.contacts.tension.copy()
        failed[rows], tension[rows] = True, 0.0
        self.contacts = replace(self.contacts, failed=failed, tension=tension)

    def make_room(self, elastic: FloatArray) -> None:
        """Let blocks settle together as far as their elastic position lies, if they hardly move past each other."""
        size, most = self.movement(elastic - self.start), LONGEST * self.moving.d
        if size > most and self.past_each_other(elastic - self.start) <= PAST * self.moving.d:
            self.room = size

    @property
    def longest(self) -> float:
        """How far a block may move in this step, and in a correction of it [m]."""
        return LONGEST * self.moving.d + self.room

    def takes(self, position: FloatArray) -> bool:
        """Return whether the step may end at a position: no block has come to contacts that the step does not know."""
        if self.movement(position - self.still) > self.longest:
            return False
        return self.room == 0 or self.past_each_other(position - self.still) <= PAST * self.moving.d

    def past_each_other(self, movement: FloatArray) -> float:
        """Return how far blocks that are near each other move past each other, at most [m]."""
        candidates = self.contacts.candidates
        past: float = farthest_past(candidates.block_a, candidates.block_b, movement, self.moving.outlines.block_size)
        return past

    def evaluate(self, position: FloatArray) -> Evaluation:
        """Return the contact forces at a position."""
        return self.moving.evaluate(self.contacts, position, self.friction_pressure, self.smoothing)

    def tangent(self, at: Evaluation, softness: float = 0.0) -> FloatArray:
        """Return the blocks of the contacts' tangent at a position; `softness` as `tangent_stiffness` takes it."""
        places = self.pattern.place, len(self.pattern.column)
        if isinstance(at, Smoothed):
            return smoothed_tangent(self.contacts, at, *places)
        return tangent_stiffness(self.contacts, at, *places, softness)

    def unbalanced(self, position: FloatArray, contact_forces: FloatArray) -> FloatArray:
        """Return what the equations lack at a position, (n, 3) [N/m, N/m, N]."""
        forces = self.acting_at(position) + contact_forces
        forces -= self.lam * self.mass * (position - self.still)
        return forces

    def acting_at(self, position: FloatArray) -> FloatArray:
        """Return weights, loads, water and bolt forces at a position, (n, 3)."""
        return self.moving.acting_at(position)

    def free(self, forces: FloatArray) -> FloatArray:
        """Return what counts of forces (n, 3) as being out of balance: what moves a block that may move."""
        return self.supports.scaled(forces, self.scale)

    def sizes(self, forces: FloatArray, weight: float) -> tuple[float, float]:
        """Return greatest component and 2-norm of forces out of balance over a weight."""
        free = self.free(forces)
        norm = np.sqrt(np.einsum("ij,ij", free, free))  # not BLAS: its threads would wait beside the linear solver's
        return float(np.abs(free).max()) / weight, float(norm) / weight

    def balance_at(self, position: FloatArray, weight: float | None = None) -> Balance:
        """Return what is out of balance at a position, its greatest component over the mean weight or another."""
        at = self.evaluate(position)
        weight = weight or self.moving.weight(at)
        forces = self.unbalanced(position, at.forces)
        greatest, norm = self.sizes(forces, weight)
        asked = self.contacts, position, self.friction_pressure, self.smoothing
        return Balance(position, partial(self.moving.evaluate, *asked), forces, greatest, norm * weight, weight)

    def is_scattered(self, balance: Balance, most: float = SCATTERED) -> bool:
        """Return whether the root mean square out of balance is below a part of a weight: all but few blocks rest."""
        blocks = max(1, len(balance.position))
        return balance.norm < most * balance.weight * float(np.sqrt(blocks))

    def movement(self, step: FloatArray) -> float:
        """Return the greatest movement of a block in a step (n, 3), turns over the radius of gyration [m]."""
        return float(np.abs(step / self.scale).max())

    def complete(self, data: FloatArray, position: FloatArray) -> FloatArray:
        """Return contacts' tangent blocks with the bolts' at a position and the regularisation, supports eliminated."""
        bolts = self.moving.bolts
        if len(bolts.alive):
            bolts.add_tangent(bolts.evaluate(position), self.factors.bolt_places, data)
        pattern, support = self.pattern, self.supports
        data[pattern.diagonal, [[0], [1], [2]], [[0], [1], [2]]] += self.lam * self.mass.T
        constrain(
            pattern.row_start, pattern.column, pattern.diagonal, data, support.number, support.basis, support.held
        )
        return data

    def factorize(self, data: FloatArray, position: FloatArray) -> bool:
        """Factorize contacts' tangent blocks, completed; False where that is singular."""
        return self.factors.factorize(self.complete(data, position))

    def solve(self, forces: FloatArray) -> FloatArray:
        """Return the movement (n, 3) under forces with the last factors."""
        return self.supports.expand(self.factors.solve(self.supports.free_part(forces)))


def moved_by(position: FloatArray, step: FloatArray) -> FloatArray:
    """Return positions after finite turns about the instant centres of a step (n, 3): the exponential map of SE(2).

    A block that turns about a stiff corner so keeps the corner in place; added up plainly, translation and rotation
    would move it by the square of the angle, and the line search would cut every step to that.
    """
    u, v, turn = step.T
    sinc = np.sinc(turn / np.pi)
    versed = np.sin(turn / 2) * np.sinc(turn / (2 * np.pi))  # (1 - cos) / turn
    moved: FloatArray = position + np.column_stack([sinc * u - versed * v, versed * u + sinc * v, turn])
    return moved
