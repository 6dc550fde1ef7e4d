"""Primal-dual interior point method for a step: complementarity of contact and friction, relaxed by a barrier.

Newton's method on the laws has to guess the active set: which contacts open and which slip. Where thousands change it
cycles. Here every inequality holds strictly throughout, and one barrier parameter drives all products to zero, so that
the number of factorizations hardly grows with the number of blocks (Wright, Primal-Dual Interior-Point Methods, 1997;
predictor and corrector as Mehrotra's). Friction does not dilate, so the problem is not convex and convergence is not
proved: the end is checked by the exact laws, and where there is no equilibrium nearby the method stalls.
"""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.solve.contacts.force_kernels import add_moving_forces, fill_tangent
from bsm_mesh.solve.contacts.forces import resolve_corner_corner, slipping
from bsm_mesh.solve.contacts.smoothed_forces import typical_mu
from bsm_mesh.solve.methods.interior_kernels import (
    ABSENT,
    BONDED,
    LIMITED,
    condense,
    increments,
    mean_product,
    relative_movement,
    smoothed_pressure,
    smoothed_shear,
)
from bsm_mesh.solve.step.equations import Step, moved_by

MAX_ITERATIONS = 60
MAX_STALLED, STALLED_PART = 4, 0.02  # successive iterations that advance by less than this part of their step
PATIENCE, HALF = 20, 0.5  # iterations in which the barrier must fall to this part; else the method has stalled
FAR = 20.0  # step lengths: blocks that move farther have no equilibrium nearby
NEAR = 1e-2  # mean product over that of the mean weight, below which the exact residual is checked
SOLVED = 1e-5  # the same, below which only contacts entering or leaving an edge separate it from the exact laws
INSIDE = 0.9  # smallest part of the way to the nearest bound that an iteration takes
MIN_CENTRING = 1e-5
BELOW_STRENGTH = 1 - 1e-12


def interior_point(step: Step, elastic: FloatArray, tolerance: float, *, barrier: float = 1.0) -> FloatArray | None:
    """Return a position close enough to a solution for Newton's method on the exact laws, or None.

    Parameters
    ----------
    step : Step
        The equations.
    elastic : (n, 3) float64
        A position at which pressures have about the size of those at the solution.
    tolerance : float
        Maximum norm of the exact residual over the mean weight.
    barrier : float
        Initial barrier over the typical product of pressure and gap: a greater one stalls less where much slips, and
        takes longer.
    """
    problem = _Problem(step)
    position = step.start
    weight = step.system.weight(step.evaluate(elastic))
    state, barrier = problem.begin(position, barrier * typical_mu(step.contacts, elastic, weight))
    unit = weight**2 / problem.middle_stiffness
    stalled, part, barriers = 0, 1.0, [np.inf] * PATIENCE
    for _ in range(MAX_ITERATIONS):
        problem.update(position, state)
        nearness = barrier / unit
        if nearness < NEAR:
            found = step.residual(position, step.evaluate(position).forces)
            solved = nearness < SOLVED and step.residual_norms(problem.forces, weight)[0] < tolerance
            if solved or step.residual_norms(found, weight)[0] < tolerance:
                return position
        stalled = stalled + 1 if part < STALLED_PART else 0
        far = nearness < 1 and step.movement(position - step.anchor) > FAR * step.system.d + step.settlement_allowance
        slow = barrier > HALF * barriers[-PATIENCE]
        if stalled == MAX_STALLED or slow or far or not np.isfinite(barrier):
            return None
        barriers.append(barrier)
        movement, change, part = problem.direction(state, barrier)
        if movement is None:
            return None
        part = min(1.0, max(INSIDE, 1.0 - nearness) * part)
        position, state = moved_by(position, part * movement), state + part * change
        barrier = problem.barrier(state)
    return None


class _Problem:
    """The contacts of a step as the kernels take them."""

    def __init__(self, step: Step) -> None:
        self.step, contacts = step, step.contacts
        anchored = ~np.isnan(contacts.old_tangential)
        self.laws, self.length = step.system.catalogue.laws, contacts.candidates.length
        self.old_tangential = np.where(anchored, contacts.old_tangential, 0.0)
        self.spring = np.stack(
            [contacts.normal_stiffness, np.where(anchored, contacts.shear_stiffness, 0.0), contacts.tension]
        )
        self.kind = np.full((2, contacts.count), ABSENT, dtype=np.int8)
        self.anchored = anchored
        self.middle_stiffness = float(np.median(contacts.normal_stiffness)) if contacts.count else 1.0
        self.now = np.zeros((4, contacts.count))
        self.forces, self.position = np.zeros(0), step.start

    def begin(self, position: FloatArray, barrier: float) -> tuple[FloatArray, float]:
        """Return the state at a position with all products equal to the barrier, and the barrier."""
        c = self.step.contacts
        gap, tangential, tangent, *_ = self.step.contacts.relative_positions(position)
        on_edge = (tangential >= -c.edge_overhang) & (tangential <= c.candidates.edge_length + c.edge_overhang)
        on_edge &= resolve_corner_corner(c, position, gap, tangent)
        self.kind[0, on_edge] = LIMITED
        self.kind[0, on_edge & np.isinf(c.tension)] = BONDED
        self.now[0], self.now[1] = gap - c.offset, self._trial(tangential)
        state = smoothed_pressure(self.now, self.spring, self.kind, barrier)
        self._set_strength(state)
        self.kind[1, on_edge & self.anchored & (self.now[2] > 0)] = LIMITED
        self.kind[1, on_edge & self.anchored & np.isinf(self.now[2])] = BONDED
        smoothed_shear(self.now, self.spring, self.kind, barrier, state)
        return state, barrier

    def update(self, position: FloatArray, state: FloatArray) -> None:
        """Set gaps, trial shears, strengths and residual at a position."""
        c, self.position = self.step.contacts, position
        gap, tangential, *self.frame = self.step.contacts.relative_positions(position)
        self.now[0], self.now[1] = gap - c.offset, self._trial(tangential)
        self._set_strength(state)
        limited = self.kind[1] == LIMITED
        most = np.where(limited, BELOW_STRENGTH * self.now[2], np.inf)
        np.clip(state[1], -most, most, out=state[1])
        self.forces = self.step.residual(position, self._on_blocks(state[0], state[1]))

    def _set_strength(self, state: FloatArray) -> None:
        frozen = self.step.frozen_pressure
        pressure = state[0] if frozen is None else frozen
        answer = slipping(self.step.contacts, self.laws, pressure)
        self.now[2], self.now[3] = answer.strength, answer.by_pressure
        if frozen is not None:
            self.now[3] = 0.0

    def barrier(self, state: FloatArray) -> float:
        """Return the mean product of a state."""
        return float(mean_product(self.now, self.spring, self.kind, state, np.zeros_like(state), 0.0))

    def direction(self, state: FloatArray, barrier: float) -> tuple[FloatArray | None, FloatArray, float]:
        """Return movement (n, 3), change of state (5, m), and the part of them that stays inside; None if singular."""
        plain = np.zeros((3, state.shape[1]))
        if not self._factorize(condense(self.now, self.spring, self.kind, state, 0.0, plain), state):
            return None, state, 0.0
        _, change, part = self._solve(state, 0.0, plain)
        reached = mean_product(self.now, self.spring, self.kind, state, change, min(part, 1.0))
        target = barrier * max(min(1.0, reached / barrier) ** 3, MIN_CENTRING) if barrier > 0 else 0.0
        pressure, shear = change[0], change[1]
        second_order = np.stack(
            [
                -pressure * change[2],
                -change[3] * (self.now[3] * pressure - shear),
                -change[4] * (self.now[3] * pressure + shear),
            ]
        )
        return self._solve(state, target, second_order)

    def _solve(self, state: FloatArray, barrier: float, second: FloatArray) -> tuple[FloatArray, FloatArray, float]:
        condensed = condense(self.now, self.spring, self.kind, state, barrier, second)
        movement = self.step.solve(self.forces + self._on_blocks(condensed[3], condensed[4]))
        c = self.step.contacts.candidates
        gap, tangential = relative_movement(movement, c.block_a, c.block_b, *self.frame)
        change, part = increments(self.now, self.spring, self.kind, state, condensed, barrier, second, gap, tangential)
        return movement, change, part

    def _factorize(self, condensed: FloatArray, state: FloatArray) -> bool:
        pattern = self.step.pattern
        stiffness = (condensed[0], condensed[1], condensed[2])
        data = fill_tangent(pattern.place, len(pattern.column), *self.frame, *stiffness, state[0], state[1])
        return self.step.factorize(data, self.position)

    def _trial(self, tangential: FloatArray) -> FloatArray:
        moved = tangential - self.old_tangential
        trial: FloatArray = np.where(self.anchored, self.step.contacts.old_shear + self.spring[1] * moved, 0.0)
        return trial

    def _on_blocks(self, pressure: FloatArray, shear: FloatArray) -> FloatArray:
        c = self.step.contacts.candidates
        total = np.zeros_like(self.step.anchor)
        add_moving_forces(c.block_a, c.block_b, *self.frame, pressure, shear, total)
        return total
