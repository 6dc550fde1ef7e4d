"""The linear program of limit analysis: equilibrium and strength of contacts, supports and bolts."""

from __future__ import annotations

import math
from copy import copy
from dataclasses import dataclass

import numpy as np
from scipy.sparse import block_array, block_diag, coo_array, csr_array, hstack

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.contact.table import initial_contacts
from bsm_mesh.errors import ModelError
from bsm_mesh.model.bolt_layout import lay_out_bolts
from bsm_mesh.model.model import Model
from bsm_mesh.model.supports import bars_of
from bsm_mesh.solve.bolts.dowels import Dowels
from bsm_mesh.solve.limit.conic import Answer
from bsm_mesh.solve.limit.corner_contacts import with_corner_contacts
from bsm_mesh.solve.limit.interior_point import Solution, minimise
from bsm_mesh.solve.limit.measure import Measure, Measured
from bsm_mesh.solve.limit.parallel_faces import with_parallel_faces
from bsm_mesh.solve.limit.strength import Strength

NOTHING = 1e-8  # over loads on blocks: a smaller shortfall is none; programs are solved to 1e-10
HARDLY = 1e-6  # of the loads: where less is carried nothing is


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


@dataclass(frozen=True, eq=False, slots=True)
class Shortfall:
    """By how much forces within strength fall short of a balance of the loads, and the mechanism that begins there.

    Attributes
    ----------
    lacking : float
        Over the load on the less loaded block of every contact; at least -1; infinite where no strength of the
        requested kind helps.
    forces : (k,) float64 [N/m]
        The unknown forces with the missing strength; zero where nothing helps.
    velocity, slip : (n, 3), (n_nodes,) float64
        As in `Optimum`.
    of_bounds : (r,) float64 [m/N]
        By how much less is lacking when a bound grows.
    least : float
        Least size of forces that balance, over all loads together: rounding takes up no more than the missing strength
        otherwise.
    """

    lacking: float
    forces: FloatArray
    velocity: FloatArray
    slip: FloatArray
    of_bounds: FloatArray
    least: float

    @property
    def stands(self) -> bool:
        """Whether nothing is lacking."""
        return self.lacking <= NOTHING


class LimitProgram:
    """Equilibrium and strength of a model's contacts, supports and bolts, as the matrices of a linear program.

    The unknowns are pressure and shear of every contact, the forces in the bars, the tensions of the bolts' elements
    and their shears across joints over their spacing, and the factor.

    Parameters
    ----------
    model : Model
        The input, with contact points at the ends of faces; bolts that name a stage are not there.
    """

    def __init__(self, model: Model) -> None:
        if model.flow is not None:
            raise ModelError(
                "limit analysis: water flows in the joints, and its pressure is known only once they have "
                "closed and opened; give [water] instead of [flow], or run the model"
            )
        self.blocks = model.blocks
        self.contacts = with_parallel_faces(model, with_corner_contacts(model, initial_contacts(model)))
        self.bars = bars_of(model.supports, model.blocks)
        self.bolts = lay_out_bolts([bolt for bolt in model.bolts if bolt.stage is None], model.blocks)
        self.dowels = Dowels.of(self.bolts, model.blocks.moments.centroid)
        self.crossing = model.blocks.moments.centroid[self.dowels.near] + self.dowels.arm_near
        self.strength = Strength.of(model, self.contacts, self.bolts, self.dowels)
        self.radius = model.blocks.moments.gyration
        self.movable = ~self.bars.held_blocks(model.blocks)
        self.acting = np.flatnonzero(self.movable[self.bars.block])  # bars of held blocks balance whatever comes
        self.equilibrium = csr_array(self._equilibrium())

    def at(self, strength: Strength) -> LimitProgram:
        """Return the program of another strength."""
        other = copy(self)
        other.strength = strength
        return other

    def balance(self, loads: FloatArray) -> Shortfall:
        """Return the strength, in shear and tension alike, that all contacts need beyond theirs to balance loads."""
        bounded, bound = self.bounds()
        return self.shortfall(loads, bounded, bound, _any(bounded[:, : 2 * self.contacts.count]))

    def collapse(self, loads: FloatArray, balance: Shortfall) -> Optimum:
        """Return the part of loads that is carried, and the mechanism, where `balance` does not stand.

        Where hardly any part is, forces have no room, in which the greatest would be sought.
        """
        if not self.strength.is_cone:
            balance = self.balance(HARDLY * loads)
            if balance.stands:
                return self.maximise(np.zeros_like(loads), loads)
        return Optimum(0.0, np.zeros(self.unknowns), balance.velocity, balance.slip)

    def _unlimited(self, forces: FloatArray) -> Optimum:
        return Optimum(math.inf, forces, np.zeros((self.blocks.count, 3)), np.zeros(len(self.bolts.block)))

    def maximise(self, dead: FloatArray, live: FloatArray) -> Optimum:
        """Return the greatest factor with ``dead + factor * live`` in equilibrium within strength.

        Raises
        ------
        ModelError
            If no factor does, or the solver gives up.
        """
        here = self._measured(dead + live, *self.bounds())
        found = minimise(
            np.append(np.zeros(self.unknowns), -1.0),
            csr_array(hstack([here.balance, (self._on_movable(live) * here.of_balance)[:, None]])),
            -self._on_movable(dead) * here.of_balance,
            csr_array(block_diag([here.bounded, [[-1.0]]])),  # the factor is not negative
            np.append(here.bound, 0.0),
        )
        if found.answer is Answer.UNBOUNDED:  # feasible at 0: no factor is too great
            return self._unlimited(np.zeros(self.unknowns))
        if found.answer is Answer.INFEASIBLE:
            raise ModelError("limit analysis: no forces within strength exist, whatever the factor")
        velocity, slip = self._motion(found, here)
        return Optimum(max(float(found.x[-1]), 0.0), found.x[:-1] * here.of_force, velocity, slip)

    def shortfall(self, loads: FloatArray, bounded: csr_array, bound: FloatArray, yields: BoolArray) -> Shortfall:
        """Return by how much rows that bound the forces must give way for forces that balance the loads.

        Parameters
        ----------
        loads : (n, 3) float64 [N/m, N/m, N]
            Loads to be balanced.
        bounded, bound : (r, k), (r,) float64 [-, N/m]
            As `bounds` returns them.
        yields : (r,) bool
            Rows that may give way.
        """
        here = self._measured(loads, bounded, bound)
        found = minimise(
            np.append(np.zeros(self.unknowns), 1.0),
            csr_array(hstack([here.balance, csr_array((here.balance.shape[0], 1))])),
            -self._on_movable(loads) * here.of_balance,
            csr_array(block_array([[here.bounded, -yields[:, None].astype(float)], [None, [[-1.0]]]])),
            np.append(here.bound, 1.0),
        )
        solved = found.answer is Answer.SOLVED
        lacking, rounded = float(found.x[-1]) if solved else math.inf, found.x if solved else np.zeros_like(found.x)
        taken = float((found.loose / here.of_force).sum() + (found.negative[:-1] / here.of_bound).sum())
        taken *= float(np.hypot(*loads[:, :2].T).sum())
        return Shortfall(
            lacking,
            rounded[:-1] * here.of_force,
            *self._motion(found, here),
            found.of_bounds[:-1] / here.of_bound,
            found.proved / taken if taken > 0 else math.copysign(math.inf, found.proved),
        )

    def _measured(self, loads: FloatArray, bounded: csr_array, bound: FloatArray) -> Measured:
        """Return equilibrium and bounds (r, k), (r,), measured by loads (n, 3)."""
        measure = Measure.of(loads, self.radius, self.movable)
        of_contact = measure.of_contacts(self.contacts.block_a, self.contacts.block_b)
        of_force = np.concatenate([of_contact, of_contact, np.full(self.unknowns - 2 * len(of_contact), measure.mean)])
        of_balance = self._on_movable(self._units * measure.of_rows[:, None]) / measure.mean
        equilibrium = self.equilibrium[np.repeat(self.movable, 3)]
        return Measured.of(equilibrium, bounded, bound, of_balance, of_force)

    def _on_movable(self, values: FloatArray) -> FloatArray:
        """Return values (n, 3) of the blocks that may move, (3 p,)."""
        return values[self.movable].reshape(-1)

    @property
    def _units(self) -> FloatArray:
        """Factors that make moments forces, (n, 3): the inverse of the radius of gyration, and 1 for forces."""
        return np.column_stack([np.ones((self.blocks.count, 2)), 1 / self.radius])

    def _motion(self, found: Solution, here: Measured) -> tuple[FloatArray, FloatArray]:
        """Return velocities of the blocks and of the bolts against the rock, as in `Optimum`: the multipliers."""
        velocity = np.zeros((self.blocks.count, 3))
        velocity[self.movable] = (found.of_balance * here.of_balance).reshape(-1, 3)
        of_bounds = found.of_bounds[: len(here.bound)] / here.of_bound
        size = max(float(np.abs(velocity * [1, 1, 0]).max()), float(np.abs(velocity[:, 2] * self.radius).max())) or 1.0
        bounded = np.flatnonzero(np.isfinite(self.strength.capacity))
        slip = np.zeros(len(self.bolts.block))
        if bounded.size:  # the last rows: one way, then the other
            one, other = of_bounds[-2 * bounded.size :].reshape(2, -1)
            slip[bounded] = one - other
        return velocity / size, slip / size

    def bounds(self) -> tuple[csr_array, FloatArray]:
        """Return the rows of the linear program that hold the forces within the strength, and their bounds [N/m]."""
        return self.strength.rows(self._first_bolt, self.unknowns)

    def bolt_force(self, forces: FloatArray) -> FloatArray:
        """Return the tensions of the bolts' elements, of one bolt each, (n_elements,) [N], among forces (k,) [N/m]."""
        spacing = self.bolts.spacing[self.bolts.bolt_of_element]
        tension: FloatArray = forces[self._first_bolt : self._first_dowel] * spacing
        return tension

    @property
    def _first_bolt(self) -> int:
        """Column of the first element of a bolt."""
        return 2 * self.contacts.count + len(self.acting)

    @property
    def unknowns(self) -> int:
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
        bars, acting = self.bars, self.acting
        turns = bars.holds_rotation[acting].astype(np.float64)
        parts.append(self._columns(2 * c.count, bars.block[acting], bars.point[acting], bars.direction[acting], turns))
        bolts, first = self.bolts, self.bolts.first_node
        along = bolts.point[first + 1] - bolts.point[first]
        along = along / np.hypot(*along.T)[:, None]
        for node, sign in ((first, 1.0), (first + 1, -1.0)):
            parts.append(self._columns(self._first_bolt, bolts.block[node], bolts.point[node], sign * along, 0.0))
        dowels = self.dowels
        for block, sign in ((dowels.near, 1.0), (dowels.far, -1.0)):
            parts.append(self._columns(self._first_dowel, block, self.crossing, sign * dowels.across, 0.0))
        row, col, value = (np.concatenate(part) for part in zip(*parts, strict=True))
        return coo_array((value, (row, col)), shape=(3 * self.blocks.count, self.unknowns))

    def _columns(
        self, first: int, block: IntArray, point: FloatArray, direction: FloatArray, moment: FloatArray | float
    ) -> tuple[IntArray, IntArray, FloatArray]:
        arm = point - self.blocks.moments.centroid[block]
        turn = arm[:, 0] * direction[:, 1] - arm[:, 1] * direction[:, 0] + moment
        row = 3 * block.astype(np.int64)[:, None] + np.arange(3)
        col = np.repeat(first + np.arange(len(block)), 3)
        return row.reshape(-1), col, np.column_stack([direction, turn]).reshape(-1)


def _any(matrix: csr_array) -> BoolArray:
    """Return which rows of a matrix hold anything."""
    return np.asarray(abs(matrix).sum(axis=1) > 0).reshape(-1)
