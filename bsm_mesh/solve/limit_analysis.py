"""Limit analysis: is there any field of contact forces in equilibrium and within strength? A linear program.

It knows statics and strength, but neither stiffness nor movement. So it proves one thing only: where no such field
exists, this geometry cannot be at rest and its blocks must move. Where one exists nothing is proved: a block wedged
between two walls is "at rest" for it, and friction at which blocks would in fact slide is mobilised as needed. Where a
joint bears tension the convex hull of its strength is taken, a little more than it has.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import linprog
from scipy.sparse import coo_array, csr_array

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.contact.strength import contact_strength
from bsm_mesh.contact.table import ContactTable, initial_contacts
from bsm_mesh.errors import ModelError
from bsm_mesh.model.bolt_layout import lay_out_bolts
from bsm_mesh.model.loads import Load
from bsm_mesh.model.model import Model
from bsm_mesh.model.supports import Bars, bars_of
from bsm_mesh.solve.dowels import Dowels
from bsm_mesh.solve.system import external_loads

INFEASIBLE, UNBOUNDED = 2, 3  # of scipy.optimize.linprog


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class LimitAnalysis:
    """What the linear program says of the geometry as it is given.

    Attributes
    ----------
    admissible : bool
        Whether forces in equilibrium and within strength exist. False proves that the blocks must move; True
        proves nothing.
    factor : float
        Greatest factor on the chosen loads (all of them, weights included, where none were chosen); infinite where
        there is no limit.
    mechanism : (n, 3) float64
        Velocities u, v, theta of the blocks in the collapse at that factor (the dual of equilibrium), the greatest
        displacement of a centroid or rotation times radius of gyration being 1; zero where there is no limit.
    normal_force, shear_force : (m,) float64 [N/m]
        An admissible field at the factor, or at 1 where there is no limit; zero where there is none.
    contacts : ContactTable
        The contacts that they belong to.
    unlimited : int
        How many of them bear any force: joints without a law, faces of rock without strength.
    bolt_force : (n_elements,) float64 [N]
        Tension of the bolts' elements in that field, of one bolt each; bolts that name a stage are not there.
    """

    admissible: bool
    factor: float
    mechanism: FloatArray
    normal_force: FloatArray
    shear_force: FloatArray
    contacts: ContactTable
    unlimited: int
    bolt_force: FloatArray

    def __str__(self) -> str:
        """Return what is proved, in words."""
        if not self.admissible:
            return "inadmissible: no forces within strength balance the loads; this geometry must move"
        return "admissible: forces within strength exist; that alone does not prove that the blocks stay at rest"


def limit_analysis(model: Model, live: Sequence[Load] | None = None) -> LimitAnalysis:
    """Return whether the model is statically admissible, and the greatest factor on loads.

    Parameters
    ----------
    model : Model
        What is given; the contacts are those of the geometry as it is.
    live : sequence of load, optional
        Loads that the factor multiplies, beside the model's own, which stay as they are. Without them the factor
        multiplies everything: weights and loads together.

    Raises
    ------
    ModelError
        If the model has no weight and no load, blocks overlap, or the linear program cannot be solved.

    References
    ----------
    Livesley (1978), Limit analysis of structures formed from rigid blocks, Int. J. Num. Meth. Engng 12.
    """
    program = _Program(model.replace(contact_points="ends"))
    dead = external_loads(model)
    if live is None:
        if not dead.any():
            raise ModelError("limit analysis: the model has neither weight nor load; nothing can fail")
        nothing = np.zeros_like(dead)
        whole = program.balance(dead)
        if whole is None:
            return program.result(program.maximise(nothing, dead, most=1.0), admissible=False)
        limit = whole if program.is_cone else program.maximise(nothing, dead)
        return program.result(whole if math.isinf(limit.factor) else limit, admissible=True, factor=limit.factor)
    chosen = external_loads(model.replace(loads=tuple(live))) - external_loads(model.replace(loads=()))
    if not chosen.any():
        raise ModelError("limit analysis: the chosen loads are zero")
    unloaded = program.balance(dead)
    if unloaded is None:
        short = program.maximise(np.zeros_like(dead), dead, most=1.0)
        return program.result(short, admissible=False, factor=0.0)
    limit = program.maximise(dead, chosen)
    return program.result(unloaded if math.isinf(limit.factor) else limit, admissible=True, factor=limit.factor)


def limit_tilt(model: Model, *, clockwise: bool = False, accuracy: float = 1e-6) -> float:
    """Return the greatest angle by which gravity may turn before the model is inadmissible [degrees].

    Found by halving between 0 and 90 degrees; 0 where the model is inadmissible as it stands, 90 where it never is.

    Parameters
    ----------
    model : Model
        What is given. Its loads keep their directions.
    clockwise : bool
        Turn gravity clockwise, as if the model were tilted counter-clockwise; else the other way.
    accuracy : float [degrees]
        Width of the last interval.
    """
    sense = -1.0 if clockwise else 1.0
    model = model.replace(loads=model.acting_loads, in_situ=None, stages=())  # a ground surface is not tilted

    def stands(tilt: float) -> bool:
        turned = model.replace(gravity_direction=model.gravity_direction + sense * tilt)
        return _Program(turned.replace(contact_points="ends")).balance(external_loads(turned)) is not None

    if not stands(0.0):
        return 0.0
    low, high = 0.0, 90.0
    if stands(high):
        return high
    while high - low > accuracy:
        middle = (low + high) / 2
        low, high = (middle, high) if stands(middle) else (low, middle)
    return (low + high) / 2


@dataclass(frozen=True, eq=False, slots=True)
class _Optimum:
    factor: float
    forces: FloatArray
    velocity: FloatArray


class _Program:
    """Equilibrium and strength of a model's contacts, supports and bolts, as the matrices of a linear program.

    The unknowns are pressure and shear of every contact, the forces in the bars, the tensions of the bolts' elements
    and their shears across joints over their spacing, and the factor.
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
        self.lines = strength.slope, strength.intercept + strength.slope * raised
        self.radius = model.blocks.moments.gyration

    @property
    def is_cone(self) -> bool:
        """Whether admissible forces stay so when multiplied: no cohesion, no tension, or no limit at all."""
        bounds = np.append(self.lines[1].reshape(-1), self.tension)
        return bool(((bounds == 0) | np.isinf(bounds)).all())

    def balance(self, loads: FloatArray) -> _Optimum | None:
        """Return forces within strength that balance the loads, without any factor; None if there are none.

        As a question of feasibility this takes a fifth of the time of a greatest factor.
        """
        found = self._solve(loads, None, None, _mean_force(loads))
        if found.status == INFEASIBLE:
            return None
        forces = _expect(found).x * _mean_force(loads)
        return _Optimum(math.inf, forces, np.zeros((self.blocks.count, 3)))

    def maximise(self, dead: FloatArray, live: FloatArray, most: float | None = None) -> _Optimum:
        """Return the greatest factor, not above `most`, with ``dead + factor * live`` in equilibrium within strength.

        Raises
        ------
        ModelError
            If the solver gives up.
        """
        scale = _mean_force(dead + live)
        found = self._solve(dead, live, most, scale)
        if found.status == UNBOUNDED or "nbounded" in found.message:  # feasible at 0: no factor is too great
            return _Optimum(math.inf, np.zeros(2 * self.contacts.count), np.zeros((self.blocks.count, 3)))
        x = _expect(found).x
        velocity = -(np.asarray(found.eqlin.marginals) * self._rows()).reshape(-1, 3)
        size = max(float(np.abs(velocity * [1, 1, 0]).max()), float(np.abs(velocity[:, 2] * self.radius).max()))
        return _Optimum(max(float(x[-1]), 0.0), x[:-1] * scale, velocity / size if size > 0 else velocity)

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
        return linprog(
            goal,
            A_eq=balance,
            b_eq=-(dead.reshape(-1) * rows) / scale,
            A_ub=bounded if bounded.shape[0] else None,
            b_ub=bound / scale if bounded.shape[0] else None,
            bounds=bounds,
            method="highs",
        )

    def result(self, optimum: _Optimum, *, admissible: bool, factor: float | None = None) -> LimitAnalysis:
        """Return the record of an optimum; its mechanism belongs to a limit only."""
        limited = not admissible or (factor is not None and math.isfinite(factor))
        m = self.contacts.count
        return LimitAnalysis(
            admissible=admissible,
            factor=optimum.factor if factor is None else factor,
            mechanism=optimum.velocity if limited else np.zeros_like(optimum.velocity),
            normal_force=-optimum.forces[:m],
            shear_force=optimum.forces[m : 2 * m],
            contacts=self.contacts,
            bolt_force=optimum.forces[self._first_bolt : self._first_dowel]
            * self.bolts.spacing[self.bolts.bolt_of_element],
            unlimited=int((np.isinf(self.lines[1]).all(axis=1) & np.isinf(self.tension)).sum()),
        )

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
        for line in range(2):
            slope, intercept = self.lines[0][:, line], self.lines[1][:, line]
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
    if found.status != 0:
        raise ModelError(f"limit analysis: the linear program could not be solved ({found.message.strip()})")
    return found


def _beside(left: csr_array, right: csr_array) -> csr_array:
    from scipy.sparse import hstack

    return csr_array(hstack([left, right]))
