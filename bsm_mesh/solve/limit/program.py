"""The linear program of limit analysis: equilibrium and strength of contacts, supports and bolts."""

from __future__ import annotations

import math
from copy import copy
from dataclasses import dataclass

import numpy as np
from scipy.sparse import block_diag, coo_array, csr_array, hstack, vstack

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.contact.table import initial_contacts
from bsm_mesh.errors import ModelError
from bsm_mesh.model.bolt_layout import lay_out_bolts
from bsm_mesh.model.model import Model
from bsm_mesh.model.supports import Bars, bars_of
from bsm_mesh.solve.bolts.dowels import Dowels
from bsm_mesh.solve.limit.interior_point import Answer, minimise
from bsm_mesh.solve.limit.strength import Strength


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
    """What is lacking for forces within strength to balance loads, and the mechanism that lacks it.

    Attributes
    ----------
    lacking : float
        In mean forces of the loads; at least -1; infinite where no strength of what was asked for helps.
    forces : (k,) float64 [N/m]
        The unknown forces with what is lacking; zero where nothing helps.
    velocity, slip : (n, 3), (n_nodes,) float64
        As in `Optimum`.
    of_bounds : (r,) float64
        Multipliers of the rows that bound the forces.
    """

    lacking: float
    forces: FloatArray
    velocity: FloatArray
    slip: FloatArray
    of_bounds: FloatArray


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
        self.strength = Strength.of(model, self.contacts, self.bolts, self.dowels)
        self.radius = model.blocks.moments.gyration
        # what makes moments forces: the inverse of the radius of gyration, and 1 for forces
        self.rows = np.column_stack([np.ones((self.blocks.count, 2)), 1 / self.radius]).reshape(-1)
        self.equilibrium = csr_array(self._equilibrium() * self.rows[:, None])

    def at(self, strength: Strength) -> LimitProgram:
        """Return the program of another strength."""
        other = copy(self)
        other.strength = strength
        return other

    def balance(self, loads: FloatArray) -> Optimum | None:
        """Return forces within strength that balance the loads, without any factor; None if there are none.

        As a question of feasibility this takes a fifth of the time of a greatest factor.
        """
        scale = mean_force(loads)
        bounded, bound = self.bounds(self.strength)
        right = -(loads.reshape(-1) * self.rows) / scale
        found = minimise(np.zeros(self.unknowns), self.equilibrium, right, bounded, bound / scale)
        return None if found.answer is Answer.INFEASIBLE else self._unlimited(found.x * scale)

    def _unlimited(self, forces: FloatArray) -> Optimum:
        return Optimum(math.inf, forces, np.zeros((self.blocks.count, 3)), np.zeros(len(self.bolts.block)))

    def maximise(self, dead: FloatArray, live: FloatArray, most: float | None = None) -> Optimum:
        """Return the greatest factor, not above `most`, with ``dead + factor * live`` in equilibrium within strength.

        Raises
        ------
        ModelError
            If the solver gives up.
        """
        scale = mean_force(dead + live)
        bounded, bound = self.bounds(self.strength)
        limits = [-1.0] if most is None else [-1.0, 1.0]  # the factor is not negative, and not above `most`
        found = minimise(
            np.append(np.zeros(self.unknowns), -1.0),
            csr_array(hstack([self.equilibrium, (live.reshape(-1) * self.rows / scale)[:, None]])),
            -(dead.reshape(-1) * self.rows) / scale,
            csr_array(block_diag([bounded, np.array(limits)[:, None]])),
            np.concatenate([bound / scale, [0.0] if most is None else [0.0, most]]),
        )
        if found.answer is Answer.UNBOUNDED:  # feasible at 0: no factor is too great
            return self._unlimited(np.zeros(self.unknowns))
        if found.answer is Answer.INFEASIBLE:
            raise ModelError("limit analysis: no forces within strength exist, whatever the factor")
        velocity, slip = self.motion(found.of_balance, found.of_bounds[: len(bound)])
        return Optimum(max(float(found.x[-1]), 0.0), found.x[:-1] * scale, velocity, slip)

    def shortfall(self, loads: FloatArray, bounded: csr_array, bound: FloatArray, helps: FloatArray) -> Shortfall:
        """Return by how much rows that bound the forces must give way for forces that balance the loads.

        Parameters
        ----------
        loads : (n, 3) float64 [N/m, N/m, N]
            What is to be balanced.
        bounded, bound : (r, k), (r,) float64 [-, N/m]
            As `bounds` returns them.
        helps : (r,) float64
            What a mean force of the loads adds to a bound, in mean forces: 1 or 0.
        """
        scale, rows = mean_force(loads), len(bound)
        found = minimise(
            np.append(np.zeros(self.unknowns), 1.0),
            csr_array(hstack([self.equilibrium, csr_array((len(self.rows), 1))])),
            -(loads.reshape(-1) * self.rows) / scale,
            csr_array(vstack([hstack([bounded, -helps[:, None]]), coo_array(([-1.0], ([0], [self.unknowns])))])),
            np.append(bound / scale, 1.0),
        )
        solved = found.answer is Answer.SOLVED
        return Shortfall(
            float(found.x[-1]) if solved else math.inf,
            found.x[:-1] * scale if solved else np.zeros(self.unknowns),
            *self.motion(found.of_balance, found.of_bounds[:rows]),
            found.of_bounds[:rows],
        )

    def motion(self, of_balance: FloatArray, of_bounds: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return velocities of the blocks and of the bolts against the rock, as in `Optimum`: the multipliers."""
        velocity = (of_balance * self.rows).reshape(-1, 3)
        size = max(float(np.abs(velocity * [1, 1, 0]).max()), float(np.abs(velocity[:, 2] * self.radius).max())) or 1.0
        bounded = np.flatnonzero(np.isfinite(self.strength.capacity))
        slip = np.zeros(len(self.bolts.block))
        if bounded.size:  # the last rows: one way, then the other
            one, other = of_bounds[-2 * bounded.size :].reshape(2, -1)
            slip[bounded] = one - other
        return velocity / size, slip / size

    def bounds(self, strength: Strength) -> tuple[csr_array, FloatArray]:
        """Return the rows of the linear program that hold the forces within a strength, and their bounds [N/m]."""
        return strength.rows(self._first_bolt, self.unknowns)

    def bolt_force(self, forces: FloatArray) -> FloatArray:
        """Return the tensions of the bolts' elements, of one bolt each, (n_elements,) [N], among forces (k,) [N/m]."""
        spacing = self.bolts.spacing[self.bolts.bolt_of_element]
        tension: FloatArray = forces[self._first_bolt : self._first_dowel] * spacing
        return tension

    @property
    def _first_bolt(self) -> int:
        """Column of the first element of a bolt."""
        return 2 * self.contacts.count + len(self.bars.block)

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
        return coo_array((value, (row, col)), shape=(3 * self.blocks.count, self.unknowns))

    def _columns(
        self, first: int, block: IntArray, point: FloatArray, direction: FloatArray, moment: FloatArray | float
    ) -> tuple[IntArray, IntArray, FloatArray]:
        arm = point - self.blocks.moments.centroid[block]
        turn = arm[:, 0] * direction[:, 1] - arm[:, 1] * direction[:, 0] + moment
        row = 3 * block.astype(np.int64)[:, None] + np.arange(3)
        col = np.repeat(first + np.arange(len(block)), 3)
        return row.reshape(-1), col, np.column_stack([direction, turn]).reshape(-1)


def mean_force(loads: FloatArray) -> float:
    """Return the mean of the forces among loads (n, 3), to measure forces by [N/m]."""
    return max(float(np.hypot(*loads[:, :2].T).mean()), np.finfo(float).tiny)
