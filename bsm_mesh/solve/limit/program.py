"""The linear program of limit analysis: equilibrium and strength of contacts, supports and bolts, by HiGHS."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import linprog
from scipy.sparse import coo_array, csr_array

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.contact.strength import contact_strength
from bsm_mesh.contact.table import initial_contacts
from bsm_mesh.errors import ModelError
from bsm_mesh.model.bolt_layout import lay_out_bolts
from bsm_mesh.model.model import Model
from bsm_mesh.model.supports import Bars, bars_of
from bsm_mesh.solve.bolts.dowels import Dowels

SOLVED, INFEASIBLE, UNBOUNDED = 0, 2, 3  # of scipy.optimize.linprog
METHODS = "highs-ipm", "highs-ds"  # the simplex method cycles where layers must move, so it is the reserve


@dataclass(frozen=True, eq=False, slots=True)
class Optimum:
    """The greatest factor, and the mechanism that limits it.

    Attributes
    ----------
    factor : float
        Infinite where there is no limit.
    forces : (k,) float64 [N/m]
        The unknown forces.
    velocity : (n, 3) float64
        Of the blocks, the greatest of a centroid, or rotation times radius of gyration, 1.
    slip : (n_nodes,) float64
        Velocity of the bolts against the rock at their nodes, towards the tip positive.
    """

    factor: float
    forces: FloatArray
    velocity: FloatArray
    slip: FloatArray


class LimitProgram:
    """Equilibrium and strength of a model's contacts, supports and bolts, as the matrices of a linear program.

    The unknowns are pressure and shear of every contact, the forces in the bars, the tensions of the bolts' elements
    and their shears across joints over their spacing, and the factor.

    Parameters
    ----------
    model : Model
        What is given, with contact points at the ends of faces; bolts that name a stage are not there.
    """

    def __init__(self, model: Model) -> None:
        self.blocks = model.blocks
        self.contacts = initial_contacts(model)
        self.bars = bars_of(model.supports, model.blocks)
        self.bolts = lay_out_bolts([bolt for bolt in model.bolts if bolt.stage is None], model.blocks)
        self.dowels = Dowels.of(self.bolts, model.blocks.moments.centroid)
        self.crossing = model.blocks.moments.centroid[self.dowels.near] + self.dowels.arm_near
        strength = contact_strength(model, self.contacts)
        self.tension = strength.tension
        # The convex hull: with tension the strength itself, friction only under pressure, would not be convex.
        raised = np.where(np.isfinite(self.tension), self.tension, 0.0)[:, None]
        slope, intercept = strength.lines()
        self.lines = slope, intercept + slope * raised
        self.radius = model.blocks.moments.gyration

    @property
    def is_cone(self) -> bool:
        """Whether admissible forces stay so when multiplied: no cohesion, no tension, bolts without limits."""
        of_bolts = self.bolts.yield_force, self.bolts.capacity, self.dowels.strength
        bounds = np.concatenate([self.lines[1].reshape(-1), self.tension, *of_bolts])
        return bool(((bounds == 0) | np.isinf(bounds)).all())

    @property
    def unlimited(self) -> int:
        """Number of contacts of unlimited strength."""
        return int((np.isinf(self.lines[1]).all(axis=1) & np.isinf(self.tension)).sum())

    def balance(self, loads: FloatArray) -> Optimum | None:
        """Return forces within strength that balance the loads, without any factor; None if there are none.

        As a question of feasibility this takes a fifth of the time of a greatest factor.
        """
        found = self._solve(loads, None, None, _mean_force(loads))
        if found.status == INFEASIBLE:
            return None
        forces = _expect(found).x * _mean_force(loads)
        return self._unlimited(forces)

    def _unlimited(self, forces: FloatArray) -> Optimum:
        return Optimum(math.inf, forces, np.zeros((self.blocks.count, 3)), np.zeros(len(self.bolts.block)))

    def maximise(self, dead: FloatArray, live: FloatArray, most: float | None = None) -> Optimum:
        """Return the greatest factor, not above `most`, with ``dead + factor * live`` in equilibrium within strength.

        Raises
        ------
        ModelError
            If the solver gives up.
        """
        scale = _mean_force(dead + live)
        found = self._solve(dead, live, most, scale)
        if found.status == UNBOUNDED or "nbounded" in found.message:  # feasible at 0: no factor is too great
            return self._unlimited(np.zeros(2 * self.contacts.count))
        x = _expect(found).x
        velocity = -(np.asarray(found.eqlin.marginals) * self._rows()).reshape(-1, 3)
        size = max(float(np.abs(velocity * [1, 1, 0]).max()), float(np.abs(velocity[:, 2] * self.radius).max())) or 1.0
        slip = self._slip(np.asarray(found.ineqlin.marginals))
        return Optimum(max(float(x[-1]), 0.0), x[:-1] * scale, velocity / size, slip / size)

    def _slip(self, marginals: FloatArray) -> FloatArray:
        """Return the velocities of the bolts against the rock at their nodes: the dual of the bonds' capacities."""
        bounded = np.flatnonzero(np.isfinite(self.bolts.capacity))
        slip = np.zeros(len(self.bolts.block))
        if bounded.size:  # the last rows: one way, then the other
            one, other = marginals[-2 * bounded.size :].reshape(2, -1)
            slip[bounded] = other - one
        return slip

    def _rows(self) -> FloatArray:
        """Return what makes moments forces: the inverse of the radius of gyration, and 1 for forces, (3n,)."""
        return np.column_stack([np.ones((self.blocks.count, 2)), 1 / self.radius]).reshape(-1)

    def _solve(self, dead: FloatArray, live: FloatArray | None, most: float | None, scale: float) -> Any:
        """Return HiGHS' answer; the last unknown is the factor on the live loads, where there are any."""
        rows = self._rows()
        balance = (self._equilibrium() * rows[:, None]).tocsr()
        bounded, bound = self._strength()
        bounds, goal = self._bounds(scale), np.zeros(balance.shape[1])
        if live is not None:
            balance = _beside(balance, csr_array((live.reshape(-1) * rows / scale)[:, None]))
            bounded = _beside(bounded, csr_array((bounded.shape[0], 1)))
            bounds, goal = [*bounds, (0.0, most)], np.append(goal, -1.0)
        given = {
            "A_eq": balance,
            "b_eq": -(dead.reshape(-1) * rows) / scale,
            "A_ub": bounded if bounded.shape[0] else None,
            "b_ub": bound / scale if bounded.shape[0] else None,
            "bounds": bounds,
        }
        for method in METHODS:
            answer = linprog(goal, **given, method=method)
            if answer.status in (SOLVED, INFEASIBLE, UNBOUNDED):
                break
        return answer

    def bolt_force(self, optimum: Optimum) -> FloatArray:
        """Return the tensions of the bolts' elements, of one bolt each, (n_elements,) [N]."""
        spacing = self.bolts.spacing[self.bolts.bolt_of_element]
        tension: FloatArray = optimum.forces[self._first_bolt : self._first_dowel] * spacing
        return tension

    @property
    def _first_bolt(self) -> int:
        """Column of the first element of a bolt."""
        return 2 * self.contacts.count + len(self.bars.block)

    @property
    def _unknowns(self) -> int:
        """Number of the unknown forces."""
        return self._first_dowel + len(self.dowels.element)

    @property
    def _first_dowel(self) -> int:
        """Column of the first shear of a bolt across a joint."""
        return self._first_bolt + len(self.bolts.first_node)

    def _equilibrium(self) -> coo_array:
        """Return the forces and moments that unit pressures, shears and bar forces give the blocks (3n rows)."""
        c = self.contacts
        tangent = c.normal[:, ::-1] * (-1.0, 1.0)
        parts = []
        for column, direction in ((0, -c.normal), (c.count, tangent)):
            for block, sign in ((c.block_b, 1.0), (c.block_a, -1.0)):
                parts.append(self._columns(column, block, c.point, sign * direction, 0.0))
        bars: Bars = self.bars
        parts.append(
            self._columns(2 * c.count, bars.block, bars.point, bars.direction, bars.holds_rotation.astype(np.float64))
        )
        bolts, first = self.bolts, self.bolts.first_node
        along = bolts.point[first + 1] - bolts.point[first]
        along = along / np.hypot(*along.T)[:, None]
        for node, sign in ((first, 1.0), (first + 1, -1.0)):
            parts.append(self._columns(self._first_bolt, bolts.block[node], bolts.point[node], sign * along, 0.0))
        dowels = self.dowels
        for block, sign in ((dowels.near, 1.0), (dowels.far, -1.0)):
            parts.append(self._columns(self._first_dowel, block, self.crossing, sign * dowels.across, 0.0))
        row, col, value = (np.concatenate(part) for part in zip(*parts, strict=True))
        return coo_array((value, (row, col)), shape=(3 * self.blocks.count, self._unknowns))

    def _columns(
        self, first: int, block: IntArray, point: FloatArray, direction: FloatArray, moment: FloatArray | float
    ) -> tuple[IntArray, IntArray, FloatArray]:
        arm = point - self.blocks.moments.centroid[block]
        turn = arm[:, 0] * direction[:, 1] - arm[:, 1] * direction[:, 0] + moment
        row = 3 * block.astype(np.int64)[:, None] + np.arange(3)
        col = np.repeat(first + np.arange(len(block)), 3)
        return row.reshape(-1), col, np.column_stack([direction, turn]).reshape(-1)

    def _strength(self) -> tuple[csr_array, FloatArray]:
        """Return the rows that bound something.

        ``+-shear - slope * pressure <= intercept`` of all lines, and ``+-bond force <= capacity`` of the bolts' nodes,
        the bond force being the tension after the node less that before it.
        """
        m = self.contacts.count
        rows, cols, values, bounds = [], [], [], []
        start = 0
        for slope, intercept in zip(*(values.T for values in self.lines), strict=True):
            chosen = np.flatnonzero(np.isfinite(intercept))
            for sign in (1.0, -1.0):
                row = start + np.arange(len(chosen))
                start += len(chosen)
                rows += [row, row]
                cols += [chosen, m + chosen]
                values += [-slope[chosen], np.full(len(chosen), sign)]
                bounds.append(intercept[chosen])
        bolts = self.bolts
        capacity = bolts.capacity / bolts.spacing[bolts.bolt_of_node]
        row_of = np.full(len(capacity), -1)
        bounded = np.flatnonzero(np.isfinite(capacity))
        column = self._first_bolt + np.arange(len(bolts.first_node))
        for sign in (1.0, -1.0):
            row_of[bounded] = start + np.arange(len(bounded))
            start += len(bounded)
            bounds.append(capacity[bounded])
            for node, side in ((bolts.first_node, 1.0), (bolts.first_node + 1, -1.0)):
                there = row_of[node] >= 0
                rows.append(row_of[node][there])
                cols.append(column[there])
                values.append(np.full(int(there.sum()), sign * side))
        shape = (start, self._unknowns)
        index = (np.concatenate(rows), np.concatenate(cols))
        return csr_array((np.concatenate(values), index), shape=shape), np.concatenate(bounds)

    def _bounds(self, scale: float) -> list[tuple[float | None, float | None]]:
        """Return the bounds: pressures not below minus the tension, bolts between 0 and yield, all else free."""
        pressures = [(None if math.isinf(t) else -t / scale, None) for t in self.tension.tolist()]
        most = (self.bolts.yield_force / self.bolts.spacing)[self.bolts.bolt_of_element] / scale
        bolts = [(0.0, None if math.isinf(force) else force) for force in most.tolist()]
        limits = (self.dowels.strength / self.dowels.spacing / scale).tolist()
        shears = [(None, None) if math.isinf(v) else (-v, v) for v in limits]
        return [*pressures, *[(None, None)] * (self._first_bolt - len(pressures)), *bolts, *shears]


def _mean_force(loads: FloatArray) -> float:
    return max(float(np.hypot(*loads[:, :2].T).mean()), np.finfo(float).tiny)


def _expect(found: Any) -> Any:
    """Return an answer of HiGHS that is one."""
    if found.status != SOLVED:
        raise ModelError(f"limit analysis: the linear program could not be solved ({found.message.strip()})")
    return found


def _beside(left: csr_array, right: csr_array) -> csr_array:
    from scipy.sparse import hstack

    return csr_array(hstack([left, right]))
