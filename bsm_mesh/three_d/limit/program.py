"""The conic program of limit analysis: equilibrium of blocks, friction cones at contact points."""

from __future__ import annotations

import math
from dataclasses import dataclass

import clarabel
import numpy as np
from scipy.sparse import block_array, coo_array, csc_array, hstack, vstack

from bsm_mesh.arrays import BoolArray, FloatArray
from bsm_mesh.errors import ModelError
from bsm_mesh.solve.limit.conic import Answer, solve_conic
from bsm_mesh.three_d.blocks.moments import Moments
from bsm_mesh.three_d.blocks.polygons import tangents
from bsm_mesh.three_d.limit.points import LimitPoints
from bsm_mesh.three_d.limit.strength import ConeStrength
from bsm_mesh.three_d.limit.ties import Ties

NOTHING = 1e-7  # over the mean load of a block: a smaller shortfall is none; programs are solved to 1e-10


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Optimum:
    """Answer of a program.

    Attributes
    ----------
    value : float
        The load factor; or the strength that is lacking at every point, over the mean load of a block.
    pressure : (m,) float64 [N]
        Normal force of every point, compression positive.
    shear : (m, 3) float64 [N]
        Shear force on block_b.
    velocity : (n, 6) float64 [m, rad]
        The mechanism: velocities and rates of rotation of the blocks, the greatest of a centroid, or of rotation times
        radius of gyration, 1.
    ties : (t,) float64 [N]
        Forces in supports and bolts.
    slip : (n_nodes,) float64 [m]
        Of the bolts against the rock, in the mechanism.
    """

    value: float
    pressure: FloatArray
    shear: FloatArray
    velocity: FloatArray
    ties: FloatArray
    slip: FloatArray


class ConeProgram:
    """Equilibrium and strength of contact points as the matrices of a conic program.

    The unknowns are pressure and two shear forces of every point, and the forces of supports and bolts. Strength is
    associated: where a point slides the program lets it open by slope times slip. So load and strength factors are
    upper bounds.

    Parameters
    ----------
    moments : Moments
        Of the blocks.
    points : LimitPoints
        Where blocks touch.
    fixed : (n,) bool
        Blocks that bear whatever comes.
    ties : Ties, optional
        Supports and bolts; none by default.
    """

    def __init__(
        self,
        moments: Moments,
        points: LimitPoints,
        fixed: BoolArray,
        ties: Ties | None = None,
    ) -> None:
        self.fixed, self.points, self.radius = fixed, points, moments.gyration
        self.ties = ties or Ties.none()
        self.centroid = moments.centroid
        self.block_a, self.block_b = points.block_a, points.block_b
        self.basis = np.stack([points.normal, *tangents(points.normal)], axis=1)
        self.free = np.flatnonzero(~fixed)
        if not len(self.free):
            raise ModelError("limit analysis: all blocks are fixed; nothing can fail")
        self.equilibrium = self._equilibrium()

    def _equilibrium(self) -> csc_array:
        """Return forces, and moments over radii of gyration, that the unknowns' unit forces give the free blocks."""
        number = np.full(len(self.fixed), -1)
        number[self.free] = np.arange(len(self.free))
        rows, cols, values = [], [], []
        for block, sign in ((self.block_b, 1.0), (self.block_a, -1.0)):
            point = np.flatnonzero(number[block] >= 0)
            arm = (self.points.point[point] - self.centroid[block[point]]) / self.radius[block[point], None]
            for axis, turn in enumerate((-sign, sign, sign)):  # a pressure pushes block_b against its outward normal
                force = turn * self.basis[point, axis]
                values.append(np.concatenate([force, np.cross(arm, force)], axis=1).reshape(-1))
                rows.append((6 * number[block[point], None] + np.arange(6)).reshape(-1))
                cols.append(np.repeat(3 * point + axis, 6))
        ties = self.ties
        acts = np.flatnonzero(number[ties.block] >= 0)
        values.append(self._on_blocks[acts].reshape(-1))
        rows.append((6 * number[ties.block[acts], None] + np.arange(6)).reshape(-1))
        cols.append(np.repeat(3 * self.points.count + ties.column[acts], 6))
        shape = (6 * len(self.free), self.unknowns)
        return coo_array((np.concatenate(values), (np.concatenate(rows), np.concatenate(cols))), shape=shape).tocsc()

    @property
    def unknowns(self) -> int:
        """Number of the unknown forces."""
        return 3 * self.points.count + self.ties.count

    @property
    def _on_blocks(self) -> FloatArray:
        """Forces, and moments over radii of gyration, of the ties' unit forces, (k, 6)."""
        ties, radius = self.ties, self.radius[self.ties.block, None]
        arm = (ties.point - self.centroid[ties.block]) / radius
        turns = ties.turns[:, None]
        moment = np.where(turns, ties.direction / radius, np.cross(arm, ties.direction))
        return np.hstack([np.where(turns, 0.0, ties.direction), moment])

    def balance(self, loads: FloatArray, strength: ConeStrength) -> Optimum:
        """Return the least strength, in shear and tension alike, that all points lack to balance loads (n, 6) [N, N m].

        Not positive where forces within strength balance the loads; otherwise the velocity is the mechanism. Infinite
        where no contact, support or bolt resists it.
        """
        reference = self._reference(loads)
        matrix, right, cones, lacking = self._strength(strength, reference)
        column = np.concatenate([np.zeros(self.equilibrium.shape[0]), lacking])
        least = np.append(np.zeros(self.unknowns), -1.0)  # not below minus the mean load of a block
        whole = vstack([hstack([vstack([self.equilibrium, matrix]), column[:, None]]), least[None]]).tocsc()
        right = np.concatenate([-self._scaled(loads) / reference, right, [1.0]])
        cost = np.append(np.zeros(self.unknowns), 1.0)
        return self._solved(cost, whole, right, [*cones, clarabel.NonnegativeConeT(1)], reference, math.inf)

    def maximise(self, dead: FloatArray, live: FloatArray, strength: ConeStrength) -> Optimum:
        """Return the greatest factor on live loads with dead ones, (n, 6) [N, N m]; infinite for no limit."""
        reference = self._reference(dead + live)
        matrix, right, cones, _ = self._strength(strength, reference)
        column = np.concatenate([self._scaled(live) / reference, np.zeros(matrix.shape[0])])
        whole = hstack([vstack([self.equilibrium, matrix]), column[:, None]]).tocsc()
        right = np.concatenate([-self._scaled(dead) / reference, right])
        cost = np.append(np.zeros(self.unknowns), -1.0)
        return self._solved(cost, whole, right, cones, reference, 0.0)

    def _strength(
        self, strength: ConeStrength, reference: float
    ) -> tuple[csc_array, FloatArray, list[object], FloatArray]:
        """Return rows of strength, their right sides and cones, and the column of every point's missing strength."""
        rows, cols, values, right, lacking, cones = [], [], [], [], [], []
        count = 0
        for line in range(strength.slope.shape[1]):
            point = np.flatnonzero(np.isfinite(strength.intercept[:, line]))
            slope = strength.slope[point, line]
            rows.append(count + np.arange(3 * len(point)))
            cols.append((3 * point[:, None] + np.arange(3)).reshape(-1))
            values.append(-np.stack([slope, *np.ones((2, len(point)))], axis=1).reshape(-1))
            shifted = np.stack([strength.intercept[point, line] / reference, *np.zeros((2, len(point)))], axis=1)
            right.append(shifted.reshape(-1))
            lacking.append(-np.stack([np.ones(len(point)), *np.zeros((2, len(point)))], axis=1).reshape(-1))
            cones += [clarabel.SecondOrderConeT(3)] * len(point)
            count += 3 * len(point)
        bounded = np.isfinite(strength.tension)
        apex = strength.slope * np.where(bounded, strength.tension, 0.0)[:, None]
        implied = ((strength.intercept == apex) & (strength.slope > 0)).any(axis=1)  # by a cone with its tip there
        point = np.flatnonzero(bounded & ~implied)
        rows.append(count + np.arange(len(point)))
        cols.append(3 * point)
        values.append(-np.ones(len(point)))
        right.append(strength.tension[point] / reference)
        lacking.append(-np.ones(len(point)))
        if len(point):
            cones.append(clarabel.NonnegativeConeT(len(point)))
        shape = (count + len(point), 3 * self.points.count)
        triplets = np.concatenate(values), (np.concatenate(rows), np.concatenate(cols))
        matrix = coo_array(triplets, shape=shape).tocsc()
        bolts, most, of_bolts = self.ties.rows(strength.bolts)  # their rows come first
        whole = csc_array(block_array([[None, bolts], [matrix, None]]))
        right, lacking = [most / reference, *right], [np.zeros(len(most)), *lacking]
        return whole, np.concatenate(right), [*of_bolts, *cones], np.concatenate(lacking)

    def _solved(
        self,
        cost: FloatArray,
        matrix: csc_array,
        right: FloatArray,
        cones: list[object],
        reference: float,
        infeasible: float,
    ) -> Optimum:
        """Return the optimum; `infeasible` is its value where no forces balance the loads."""
        balances = self.equilibrium.shape[0]
        answer, found = solve_conic(cost, matrix, right, [clarabel.ZeroConeT(balances), *cones])
        velocity, slip = np.zeros((len(self.fixed), 6)), np.zeros(len(self.ties.capacity))
        value, x = infeasible if answer is Answer.INFEASIBLE else math.inf, np.zeros(self.unknowns)
        if answer is Answer.SOLVED:
            value, x = float(found.x[-1]), np.array(found.x[:-1]) * reference
        if answer is not Answer.UNBOUNDED:
            z = np.array(found.z)
            velocity, slip = self.mechanism(z[:balances], z[balances:])
        forces = x[: 3 * self.points.count].reshape(-1, 3)
        shear = np.einsum("mk,mkj->mj", forces[:, 1:], self.basis[:, 1:])
        return Optimum(
            value=value,
            pressure=forces[:, 0],
            shear=shear,
            velocity=velocity,
            ties=x[3 * self.points.count :],
            slip=slip,
        )

    def mechanism(self, multipliers: FloatArray, of_bolts: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return velocities (n, 6) of the blocks, the greatest 1, and slips of the bolts, from multipliers."""
        rates = np.zeros((len(self.fixed), 6))
        rates[self.free] = multipliers.reshape(-1, 6)
        slip = self.ties.slips(of_bolts)
        size = max(np.linalg.norm(rates[:, :3], axis=1).max(), np.linalg.norm(rates[:, 3:], axis=1).max())
        if size > 0:
            rates /= size
            slip /= size
        rates[:, 3:] /= self.radius[:, None]
        return rates, slip

    def tie_rates(self, velocity: FloatArray) -> FloatArray:
        """Return the power of minus the unit forces of supports and bolts, (t,) [m]."""
        moved = velocity[self.ties.block].copy()
        moved[:, 3:] *= self.radius[self.ties.block, None]
        power = -np.einsum("ij,ij->i", self._on_blocks, moved)
        found: FloatArray = np.bincount(self.ties.column, weights=power, minlength=self.ties.count).astype(np.float64)
        return found

    def _scaled(self, loads: FloatArray) -> FloatArray:
        """Return loads of the free blocks, moments over radii of gyration [N]."""
        free = loads[self.free].copy()
        free[:, 3:] /= self.radius[self.free, None]
        return free.reshape(-1)

    def _reference(self, loads: FloatArray) -> float:
        """Return the mean load of a free block [N]."""
        mean = float(np.linalg.norm(self._scaled(loads).reshape(-1, 6), axis=1).mean())
        if mean == 0:
            raise ModelError("limit analysis: there is neither weight nor load; nothing can fail")
        return mean

    def rates(self, velocity: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return how fast points open, (m,), and how fast block_b slips past block_a there, (m, 3)."""
        at = [
            velocity[block, :3] + np.cross(velocity[block, 3:], self.points.point - self.centroid[block])
            for block in (self.block_a, self.block_b)
        ]
        relative = at[1] - at[0]
        along = np.einsum("ij,ij->i", relative, self.basis[:, 0])
        return -along, relative - along[:, None] * self.basis[:, 0]
