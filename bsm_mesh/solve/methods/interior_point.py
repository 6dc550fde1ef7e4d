"""A primal-dual interior point method for a step: contact and friction as products that shrink together.

Newton's method on the laws has to guess which contacts open and which slide; where thousands change at once it goes
round in circles. Here every inequality holds strictly all the way, and one barrier brings all products to zero
together, so that the number of factorizations hardly grows with the number of blocks (Wright, Primal-Dual
Interior-Point Methods, 1997; predictor and corrector as Mehrotra's). Friction does not dilate, so the problem is not
convex and nothing is proved: the end is checked with the exact laws, and where there is no equilibrium nearby the
method jams.
"""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.solve.contacts.force_kernels import add_moving_forces, fill_tangent
from bsm_mesh.solve.contacts.forces import may_bear, slipping
from bsm_mesh.solve.contacts.smoothed_forces import typical_smoothing
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

MOST_ITERATIONS = 60
MOST_JAMMED, JAMMED = 4, 0.02  # iterations in a row that get no farther than this part of their step
PATIENCE, HALF = 20, 0.5  # iterations in which the barrier falls to this part of itself; else the method has jammed too
FAR = 20.0  # step lengths: blocks that move farther have no equilibrium nearby
NEAR = 1e-2  # mean product over that of the mean weight, from which on the exact laws are looked at
SOLVED = 1e-5  # the same, below which only contacts that came or went on the way keep it from the exact laws
INSIDE = 0.9  # least part of the way to the nearest bound that an iteration goes
LEAST_CENTRING = 1e-5
BELOW_STRENGTH = 1 - 1e-12


def interior_point(step: Step, elastic: FloatArray, tolerance: float, *, barrier: float = 1.0) -> FloatArray | None:
    """Return a position near enough to a solution for Newton's method on the exact laws, or None.

    Parameters
    ----------
    step : Step
        The equations.
    elastic : (n, 3) float64
        A position at which the contacts' pressures have about the size that they have at the solution.
    tolerance : float
        Greatest force out of balance by the exact laws, over the mean weight.
    barrier : float
        What it begins with, over the typical product of pressure and approach: a greater one jams less where much
        slides, and takes longer.
    """
    problem = _Problem(step)
    position = step.start
    weight = step.moving.weight(step.evaluate(elastic))
    state, barrier = problem.begin(position, barrier * typical_smoothing(step.contacts, elastic, weight))
    unit = weight**2 / problem.middle_stiffness
    jammed, part, barriers = 0, 1.0, [np.inf] * PATIENCE
    for _ in range(MOST_ITERATIONS):
        problem.look(position, state)
        nearness = barrier / unit
        if nearness < NEAR:
            found = step.unbalanced(position, step.evaluate(position).forces)
            solved = nearness < SOLVED and step.sizes(problem.forces, weight)[0] < tolerance
            if solved or step.sizes(found, weight)[0] < tolerance:
                return position
        jammed = jammed + 1 if part < JAMMED else 0
        far = nearness < 1 and step.movement(position - step.anchor) > FAR * step.moving.d + step.room
        slow = barrier > HALF * barriers[-PATIENCE]
        if jammed == MOST_JAMMED or slow or far or not np.isfinite(barrier):
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
        self.laws, self.length = step.moving.catalogue.laws, contacts.candidates.length
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
        on_edge = (tangential >= -c.reach) & (tangential <= c.candidates.edge_length + c.reach)
        on_edge &= may_bear(c, position, gap, tangent)
        self.kind[0, on_edge] = LIMITED
        self.kind[0, on_edge & np.isinf(c.tension)] = BONDED
        self.now[0], self.now[1] = gap - c.offset, self._trial(tangential)
        state = smoothed_pressure(self.now, self.spring, self.kind, barrier)
        self._set_strength(state)
        self.kind[1, on_edge & self.anchored & (self.now[2] > 0)] = LIMITED
        self.kind[1, on_edge & self.anchored & np.isinf(self.now[2])] = BONDED
        smoothed_shear(self.now, self.spring, self.kind, barrier, state)
        return state, barrier

    def look(self, position: FloatArray, state: FloatArray) -> None:
        """Set gaps, trial shears and strengths at a position, and the forces out of balance."""
        c, self.position = self.step.contacts, position
        gap, tangential, *self.frame = self.step.contacts.relative_positions(position)
        self.now[0], self.now[1] = gap - c.offset, self._trial(tangential)
        self._set_strength(state)
        limited = self.kind[1] == LIMITED
        most = np.where(limited, BELOW_STRENGTH * self.now[2], np.inf)
        np.clip(state[1], -most, most, out=state[1])
        self.forces = self.step.unbalanced(position, self._on_blocks(state[0], state[1]))

    def _set_strength(self, state: FloatArray) -> None:
        held = self.step.friction_pressure
        pressure = state[0] if held is None else held
        answer = slipping(self.step.contacts, self.laws, pressure)
        self.now[2], self.now[3] = answer.strength, answer.by_pressure
        if held is not None:
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
        target = barrier * max(min(1.0, reached / barrier) ** 3, LEAST_CENTRING) if barrier > 0 else 0.0
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
