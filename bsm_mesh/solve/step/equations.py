"""The equations of one step, ``r(q) = loads + bolts + contacts - lam M (q - q_n) = 0``: residual, tangent, solution."""

from __future__ import annotations

from collections.abc import Callable
from copy import copy
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.solve.algebra.block_matrix import constrain
from bsm_mesh.solve.step.factorization import Factors
from bsm_mesh.solve.step.system import BAND, Contacts, Evaluation, System

MAX_MOVEMENT = 2.0  # of a block in one correction, and in a step, over the step length


@dataclass(frozen=True, eq=False, slots=True)
class Residual:
    """The residual of a step's equations at a position.

    Attributes
    ----------
    position : (n, axes) float64 [m, rad]
        The position.
    evaluate : callable
        Returns the contact forces at it.
    forces : (n, axes) float64 [N/m, N]
        Residual of every block.
    max_norm : float
        Its maximum norm over the mean weight, moments over radii of gyration, on the free axes.
    l2_norm : float [N/m]
        Its 2-norm, on the same axes.
    weight : float [N/m]
        The mean weight.
    """

    position: FloatArray
    evaluate: Callable[[], Evaluation]
    forces: FloatArray
    max_norm: float
    l2_norm: float
    weight: float

    @property
    def at(self) -> Evaluation:
        """The contact forces at the position, evaluated again unless they were among the last evaluated.

        Many positions are compared while a step is solved. The contact forces at one of them take 0.3 GB in a model of
        a million blocks.
        """
        return self.evaluate()

    @property
    def rms(self) -> float:
        """Root mean square over the blocks, over the mean weight: small where few blocks cause the maximum norm."""
        return self.l2_norm / self.weight / float(np.sqrt(max(1, len(self.position))))


class StepEquations:
    """The equations of a step from an accepted position: a value, whose changes are copies.

    Parameters
    ----------
    system : System
        The blocks.
    factors : Factors
        The linear solver.
    contacts : Contacts
        Contacts at the accepted position.
    anchor : (n, axes) float64 [m, rad]
        The accepted position q_n.
    lam : float [1/m]
        Regularisation.

    Attributes
    ----------
    start : (n, axes) float64
        The accepted position plus the prescribed displacement of this step.
    supports_move : bool
        Whether a displacement is prescribed in this step.
    mass, scale : (n, axes) float64
        As in `System`.
    settlement_allowance : float [m]
        Movement that this step allows beyond `MAX_MOVEMENT`, for settlement of all blocks together.
    is_symmetric : bool
        Whether the tangent has but the symmetric part of the loads' stiffness.
    has_inertia : bool
        Whether the regularisation is the inertia of a time step.
    regularization_reference : (n, axes) float64
        Position at which the regularisation is zero: the accepted one, unless contacts were updated within the step.
    searched : (n, axes) float64
        Position at which contacts were searched for.
    """

    def __init__(self, system: System, factors: Factors, contacts: Contacts, anchor: FloatArray, lam: float) -> None:
        self.system, self.factors, self.contacts, self.anchor, self.lam = system, factors, contacts, anchor, lam
        self.regularization_reference = self.searched = anchor
        self.settlement_allowance, self.mass, self.scale = 0.0, system.mass, system.scale
        self.is_symmetric = self.has_inertia = False
        self.supports = system.constraints_at(anchor)
        increment = system.prescribed_increment(self.supports)
        self.supports_move = bool(increment.any())
        self.start = anchor + increment if self.supports_move else anchor
        self.pattern = factors.pattern_of(contacts)

    def with_regularization(self, lam: float) -> StepEquations:
        """Return the same step with another regularisation [1/m]."""
        return self._changed(lam=lam)

    def with_inertia(self, inertia: FloatArray, reference: FloatArray) -> StepEquations:
        """Return the step with the inertia of a time step in the place of the regularisation.

        A rule of the Newmark family gives the acceleration at the end of a time step as a linear function of the
        position there. So mass times acceleration, with forces that are constant or grow with velocity, is
        ``inertia (q - reference)``: the residual is zero where the equations of motion hold.

        Parameters
        ----------
        inertia : (n, axes) float64 [N/m2, N]
            Of every block: for the trapezoidal rule ``4 m / h^2``, with the time step h.
        reference : (n, axes) float64 [m, rad]
            Position to which blocks would come without forces.

        References
        ----------
        Newmark 1959, J. Eng. Mech. Div. ASCE 85(3), 67-94, with beta = 1/4, gamma = 1/2.
        """
        return self._changed(lam=1.0, mass=inertia, regularization_reference=reference, has_inertia=True)

    def with_system_of_its_own(self) -> StepEquations:
        """Return the same step with a copy of the system, whose bolts a method may commit on its way."""
        return self._changed(system=self.system.copy())

    def with_contacts(self, contacts: Contacts) -> StepEquations:
        """Return the same step with other states of the same contacts."""
        return self._changed(contacts=contacts)

    def updated(self, contacts: Contacts, position: FloatArray) -> StepEquations:
        """Return the step with contacts searched at a position, which becomes the reference of the regularisation."""
        pattern = self.factors.pattern_of(contacts)
        reference = self.regularization_reference if self.has_inertia else position
        return self._changed(contacts=contacts, regularization_reference=reference, searched=position, pattern=pattern)

    def static_problem_at(self, position: FloatArray, lam: float, *, is_symmetric: bool = False) -> StepEquations:
        """Return the static equations at another position, with another regularisation."""
        supports = self.system.constraints_at(position)
        pattern = self.factors.pattern_of(self.contacts)  # a later step may have had another
        return self._changed(
            anchor=position,
            regularization_reference=position,
            searched=position,
            lam=lam,
            supports=supports,
            pattern=pattern,
            is_symmetric=is_symmetric,
        )

    def allowing_settlement(self, elastic: FloatArray) -> StepEquations:
        """Return the step that allows movements up to the elastic position, if neighbours hardly move apart by them."""
        size = self.movement(elastic - self.start)
        if size <= max(MAX_MOVEMENT * self.system.d, self.settlement_allowance):
            return self
        if not self._is_within_band(elastic - self.start):
            return self
        return self._changed(settlement_allowance=size)

    def _changed(self, **attributes: Any) -> StepEquations:
        """Return a copy with other attributes, whose solutions are its own."""
        other = copy(self)
        vars(other).pop("elastic_position", None)
        vars(other).update(attributes)
        return other

    @cached_property
    def elastic_position(self) -> FloatArray:
        """The elastic solution of the step: every contact within tolerance closed and sticking, (n, axes).

        No line search: the laws may be far from satisfied there. It is kept: where one method begins with it without
        success, the next may begin with it too.
        """
        at = self.evaluate(self.start)
        forces = self.residual(self.start, at.forces)
        data = self.system.first_tangent(self.contacts, at, self.pattern)
        if not self.factorize(data, self.start):
            return self.start
        movement = self.solve(forces)
        return self.moved_by(self.start, movement) if np.isfinite(movement).all() else self.start

    @property
    def max_movement(self) -> float:
        """Largest movement of a block in this step, and in a correction of it [m]."""
        return MAX_MOVEMENT * self.system.d + self.settlement_allowance

    def within_search_range(self, position: FloatArray) -> bool:
        """Return whether no block can have reached a contact outside the range of the search."""
        moved = position - self.searched
        if self.movement(moved) > self.max_movement:
            return False
        return self.settlement_allowance == 0 or self._is_within_band(moved)

    def max_relative_movement(self, movement: FloatArray) -> float:
        """Return the largest relative movement of neighbouring blocks [m]."""
        return self.system.max_relative_movement(self.contacts, movement)

    def _is_within_band(self, movement: FloatArray) -> bool:
        """Return whether neighbours hardly move apart, and blocks without one no more than in any step."""
        candidates, alone = self.contacts.candidates, np.ones((len(movement), 1), dtype=bool)
        alone[candidates.block_a] = alone[candidates.block_b] = False
        if self.movement(movement * alone) > MAX_MOVEMENT * self.system.d:
            return False
        return self.max_relative_movement(movement) <= BAND * self.system.d

    def evaluate(self, position: FloatArray) -> Evaluation:
        """Return the contact forces at a position."""
        return self.system.evaluate(self.contacts, position)

    def tangent(self, at: Evaluation, regularization: float = 0.0) -> FloatArray:
        """Return the blocks of the contacts' tangent; open and slipping ones keep a part of their stiffness."""
        return self.system.tangent(self.contacts, at, self.pattern, regularization)

    def elastic_tangent(self, at: Evaluation) -> FloatArray:
        """Return the stiffest possible tangent of the contacts."""
        return self.system.elastic_tangent(self.contacts, at, self.pattern)

    def moved_by(self, position: FloatArray, movement: FloatArray) -> FloatArray:
        """Return positions after a finite movement, exact in the rotations."""
        return self.system.moved_by(position, movement)

    def with_contacts_at(self, position: FloatArray) -> StepEquations:
        """Return the step with its contacts searched at a position, before anything is committed."""
        contacts = self.system.searched_again(self.contacts, self.evaluate(position), position)
        return self.updated(contacts, position)

    def residual(self, position: FloatArray, contact_forces: FloatArray) -> FloatArray:
        """Return the residual at a position, (n, axes) [N/m, N]."""
        forces = self.acting_at(position) + contact_forces
        forces -= self.lam * self.mass * (position - self.regularization_reference)
        return forces

    def acting_at(self, position: FloatArray) -> FloatArray:
        """Return weights, loads, water and bolt forces at a position, (n, axes)."""
        return self.system.acting_at(position)

    def load_stiffness(self, position: FloatArray) -> FloatArray | None:
        """Return the derivatives of minus weights, loads and water at a position, (n, axes, axes); None: all are zero.

        Their symmetric part, of which the work of second order comes, if the equations are to be symmetric.
        """
        found = self.system.load_stiffness(position)
        return (found + found.transpose(0, 2, 1)) / 2 if self.is_symmetric and found is not None else found

    def project(self, forces: FloatArray) -> FloatArray:
        """Project forces (n, axes) onto the free degrees of freedom, moments over radii of gyration."""
        return self.supports.scaled(forces, self.scale)

    def residual_norms(self, forces: FloatArray, weight: float) -> tuple[float, float]:
        """Return maximum norm and 2-norm of a residual (n, axes) over a weight."""
        free = self.project(forces)
        square = np.einsum("ij,ij", free, free)  # not BLAS: its threads would wait beside the linear solver's
        return float(np.abs(free).max(initial=0.0)) / weight, float(np.sqrt(square)) / weight

    def residual_at(self, position: FloatArray, weight: float | None = None) -> Residual:
        """Return the residual at a position, with its norms over the mean weight or another."""
        evaluate = partial(self.system.evaluate, self.contacts, position)
        at = evaluate()
        weight = weight or self.system.weight(at)
        forces = self.residual(position, at.forces)
        max_norm, l2_norm = self.residual_norms(forces, weight)
        return Residual(position, evaluate, forces, max_norm, l2_norm * weight, weight)

    def movement(self, step: FloatArray) -> float:
        """Return the largest component of a movement (n, axes), rotations times radii of gyration [m]."""
        return float(np.abs(step / self.scale).max(initial=0.0))

    def complete(self, data: FloatArray, position: FloatArray) -> FloatArray:
        """Return the tangent of contacts, bolts, loads and regularisation, constrained axes eliminated."""
        bolts, pattern, support = self.system.bolts, self.pattern, self.supports
        if len(bolts.alive):
            bolts.add_tangent(bolts.evaluate(position), self.factors.bolt_places, data)
        loads = self.load_stiffness(position)
        if loads is not None:
            data[pattern.diagonal] += loads
        own_axes = support.number, support.basis, support.constrained
        axis = np.arange(self.system.axes)[:, None]
        data[pattern.diagonal, axis, axis] += self.lam * self.mass.T
        constrain(pattern.row_start, pattern.column, pattern.diagonal, data, *own_axes)
        return data

    def factorize(self, data: FloatArray, position: FloatArray) -> bool:
        """Factorize the completed tangent; return False where it is singular."""
        return self.factors.factorize(self.complete(data, position))

    def solve(self, forces: FloatArray) -> FloatArray:
        """Return the movement (n, axes) under forces with the last factors."""
        return self.supports.expand(self.factors.solve(self.supports.free_part(forces)))
