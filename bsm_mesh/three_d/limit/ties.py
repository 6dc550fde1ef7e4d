"""Forces in a conic program besides those of contact points: bars of supports, and bolts.

The unknowns are the force of every bar and the tension of every element of a bolt. A bolt with dowel action has two
shears where it crosses from one block into another.
"""

from __future__ import annotations

from dataclasses import dataclass

import clarabel
import numpy as np
from scipy.sparse import coo_array, csc_array, csr_array, vstack

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.model.bolt_layout import lay_out_bolts
from bsm_mesh.model.model import Model
from bsm_mesh.model.supports import bars_of
from bsm_mesh.three_d.blocks.polygons import tangents
from bsm_mesh.three_d.bolts.dowels import SpaceDowels


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Ties:
    """Unit forces on blocks, and what bounds them.

    Attributes
    ----------
    block, column : (k,) int32
        The block that each unit force acts on, and its unknown.
    point, direction : (k, 3) float64 [m, -]
        Where it acts and its direction; the axis of a unit moment.
    turns : (k,) bool
        Whether it is a moment.
    bars : int
        Number of bars, the first unknowns.
    first_node : (e,) int32
        First node of every element of a bolt; the second is the next one.
    yield_force : (e,) float64 [N]
        Of the elements; infinite for no bound.
    capacity : (n_nodes,) float64 [N]
        Of the bond at every node; infinite for no bound.
    dowel : (d,) float64 [N]
        Strength in shear; infinite for no bound.
    """

    block: IntArray
    column: IntArray
    point: FloatArray
    direction: FloatArray
    turns: BoolArray
    bars: int
    first_node: IntArray
    yield_force: FloatArray
    capacity: FloatArray
    dowel: FloatArray

    @classmethod
    def none(cls) -> Ties:
        """Return no ties."""
        whole, places = np.zeros(0, np.int32), np.zeros((0, 3))
        return cls(
            block=whole,
            column=whole,
            point=places,
            direction=places,
            turns=np.zeros(0, dtype=bool),
            bars=0,
            first_node=whole,
            yield_force=np.zeros(0),
            capacity=np.zeros(0),
            dowel=np.zeros(0),
        )

    @classmethod
    def of(cls, model: Model, fixed: BoolArray) -> Ties:
        """Return the bars on blocks that are not fixed (n,), and the bolts that name no stage."""
        bars = bars_of(model.supports, model.blocks)
        acting = np.flatnonzero(~fixed[bars.block])
        layout = lay_out_bolts([bolt for bolt in model.bolts if bolt.stage is None], model.blocks)
        dowels = SpaceDowels.of(layout, model.blocks.moments.centroid)
        sizes = (len(acting), len(layout.first_node), len(dowels.element), len(dowels.element))
        starts = np.cumsum((0, *sizes))
        first = layout.first_node
        along = _units(layout.point[first + 1] - layout.point[first])
        parts = [
            (bars.block[acting], starts[0], bars.point[acting], bars.direction[acting], bars.holds_rotation[acting])
        ]
        for node, sign in ((first, 1.0), (first + 1, -1.0)):
            parts.append((layout.block[node], starts[1], layout.point[node], sign * along, np.zeros(len(node), bool)))
        for across, start in zip(tangents(dowels.across), starts[2:4], strict=True):
            for block, sign in ((dowels.near, 1.0), (dowels.far, -1.0)):
                parts.append((block, start, dowels.crossing, sign * across, np.zeros(len(block), bool)))
        return cls(
            block=np.concatenate([part[0] for part in parts]).astype(np.int32),
            column=np.concatenate([part[1] + np.arange(len(part[0])) for part in parts]).astype(np.int32),
            point=np.concatenate([part[2] for part in parts]),
            direction=np.concatenate([part[3] for part in parts]),
            turns=np.concatenate([part[4] for part in parts]),
            bars=len(acting),
            first_node=first,
            yield_force=layout.yield_force[layout.bolt_of_element],
            capacity=layout.capacity,
            dowel=dowels.strength,
        )

    @property
    def count(self) -> int:
        """Number of unknowns."""
        return self.bars + len(self.yield_force) + 2 * len(self.dowel)

    @property
    def tensions(self) -> slice:
        """The elements' tensions among the unknowns."""
        return slice(self.bars, self.bars + len(self.yield_force))

    def rows(self, part: float) -> tuple[csc_array, FloatArray, list[object]]:
        """Return rows, right sides and cones that hold the forces within a part of the bolts' strength.

        Tensions are not below 0 nor above yield, ``+-bond force <= capacity``, the bond force being the tension after a
        node less that before it; last the shears.
        """
        e, d, t = len(self.yield_force), len(self.dowel), self.bars + np.arange(len(self.yield_force))
        bounded = np.flatnonzero(np.isfinite(self.yield_force))
        bond = self._bond()
        limited = np.flatnonzero(np.isfinite(self.capacity))
        tension = coo_array((np.ones(e), (np.arange(e), t)), shape=(e, self.count)).tocsr()
        shears = np.flatnonzero(np.isfinite(self.dowel))
        s, first = len(shears), self.bars + e + shears
        rows = np.concatenate([3 * np.arange(s) + 1, 3 * np.arange(s) + 2])
        shear = coo_array((-np.ones(2 * s), (rows, np.append(first, first + d))), shape=(3 * s, self.count)).tocsr()
        parts = [-tension, tension[bounded], bond[limited], -bond[limited], shear]
        matrix = csc_array(vstack(parts))
        capacity = part * self.capacity[limited]
        most = np.stack([part * self.dowel[shears], *np.zeros((2, s))], axis=1).reshape(-1)
        right = np.concatenate([np.zeros(e), part * self.yield_force[bounded], capacity, capacity, most])
        lines = len(right) - 3 * s
        cones: list[object] = [clarabel.NonnegativeConeT(lines)] if lines else []
        return matrix, right, [*cones, *[clarabel.SecondOrderConeT(3)] * s]

    def slips(self, multipliers: FloatArray) -> FloatArray:
        """Return the slips of bolts against the rock at their nodes, (n_nodes,), from the rows' multipliers."""
        limited = np.flatnonzero(np.isfinite(self.capacity))
        first = len(self.yield_force) + int(np.isfinite(self.yield_force).sum())
        slip = np.zeros(len(self.capacity))
        one, other = multipliers[first : first + 2 * len(limited)].reshape(2, -1)
        slip[limited] = one - other
        return slip

    def taken(self, rates: FloatArray, slip: FloatArray, part: float) -> tuple[float, float]:
        """Return the greatest power that the forces take up, and by how much unlimited ones would move [m].

        For any slips q of the nodes, tensions take up at most the sums of two terms, by parts: ``yield * (rate - dq)``
        where that is positive, and ``capacity * |q|``.

        Parameters
        ----------
        rates : (count,) float64 [m]
            Power of minus the unit forces, in a mechanism.
        slip : (n_nodes,) float64 [m]
            From `slips`.
        part : float
            Of the bolts' strength.
        """
        bars, stretch = np.abs(rates[: self.bars]).sum(), rates[self.tensions]
        first, second = rates[self.tensions.stop :].reshape(2, -1)
        sheared = np.hypot(first, second)
        shear, loose = _within(part * self.dowel, sheared)
        found = []
        for q in (np.zeros_like(slip), slip, -slip):
            left = stretch - q[self.first_node + 1] + q[self.first_node]
            power, beyond = _within(part * self.yield_force, np.maximum(left, 0.0))
            bond, held = _within(part * self.capacity, np.abs(q))
            found.append((beyond + held, power + bond))
        beyond, power = min(found)
        return float(power + shear), float(beyond + loose + bars)

    def _bond(self) -> csr_array:
        """Return the tensions after every node less those before it, (n_nodes, count)."""
        e = len(self.yield_force)
        rows = np.append(self.first_node, self.first_node + 1)
        cols = np.tile(self.bars + np.arange(e), 2)
        values = np.append(np.ones(e), -np.ones(e))
        return coo_array((values, (rows, cols)), shape=(len(self.capacity), self.count)).tocsr()


def _within(most: FloatArray, moves: FloatArray) -> tuple[float, float]:
    """Return the power of forces at their bounds, and the sum of movements against forces without one."""
    bounded = np.isfinite(most)
    return float((most[bounded] * moves[bounded]).sum()), float(moves[~bounded].sum())


def _units(vectors: FloatArray) -> FloatArray:
    found: FloatArray = vectors / np.linalg.norm(vectors, axis=1)[:, None]
    return found
