"""Steady flow with a free surface in a network: the balance of water at every node, by Newton's method.

A node's unknown is one number u [m]. Where u > 0 the node is under water: its pressure head is u. Where u <= 0 it
carries
no pressure (atmospheric), and ``w = 1 + u / d`` (at least 0) is the part of what its joints could lead down which they
do: water trickles. So the pressure is never negative, and a joint is either under pressure or not full. Along a piece
the discharge is ``C w (h_up - h_down)``: conductance C, heads ``h = y + max(u, 0)``, and the upper end's w.
What leaves a node rises with its own u and falls with those of others (an M-function: J.M. Ortega, W.C. Rheinboldt,
Iterative solution of nonlinear equations in several variables, 1970, 13.5): no two flows differ where water moves.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, Portable, show_only
from bsm_mesh.flow.network import Network, floating_nodes, sums_at_nodes

BALANCED = 1e-13  # of the greatest discharge: imbalance of a node at which iteration ends
ROUNDING = 8 * np.finfo(float).eps  # of conductance times head: what a difference of heads cannot do better than
MOST_ITERATIONS = 300
FLOATING = 1e-10  # on the diagonal, of what is there: at nodes whose change no node held feels; it moves no solution
HELD = 1e-14  # at the others: no pivot is 0 by rounding, and joints a million times as wide as others are distinguished
BELOW = 0.1  # of d: where u is first tried when a node is no longer under water
USUAL_ITERATIONS = 30  # after these, corrections may go round in circles
CORRECTED = 0.7  # part of the nodes, drawn anew for each iteration, that are corrected then: it breaks circles
SEED = 20
REFINEMENTS = 4


@dataclass(frozen=True, eq=False, repr=False, slots=True, kw_only=True)
class Conditions(Portable):
    """The input at the nodes.

    Attributes
    ----------
    head : (n,) float64 [m]
        Head that is given, not below the node; NaN where it is sought.
    spill : (n,) float64 [m]
        Head that a node cannot exceed, for water leaves there: at a seepage face the node's own height, in a drain
        the level in it, not below the node; infinite where nothing lets it out.
    pumped : (n,) float64 [m2/s]
        Discharge that wells take, per metre of thickness; of a node that is not under water the part w of it.
        Negative: put in.
    """

    head: FloatArray
    spill: FloatArray
    pumped: FloatArray

    def __post_init__(self) -> None:
        show_only(self)

    @property
    def given(self) -> BoolArray:
        """Where the head is given, (n,)."""
        given: BoolArray = ~np.isnan(self.head)
        return given


@dataclass(frozen=True, eq=False, repr=False, slots=True, kw_only=True)
class SteadyFlow(Portable):
    """Flow in which the water of every node balances.

    Attributes
    ----------
    u : (n,) float64 [m]
        The unknown: pressure head where positive, else how little trickles.
    head : (n,) float64 [m]
        Height plus pressure head.
    filled : (n,) float64
        The part w: 1 under water, 0 dry, between them where water trickles.
    discharge : (m,) float64 [m2/s]
        In every piece, from its first node to its last, per metre of thickness.
    outflow : (n,) float64 [m2/s]
        What leaves the network at every node: through boundaries, drains and wells; negative where it enters.
    imbalance : float
        Greatest imbalance of a node where water can neither leave nor enter, over the greatest discharge.
    iterations : int
        Of Newton's method.
    converged : bool
        Whether the balance was reached.
    """

    u: FloatArray
    head: FloatArray
    filled: FloatArray
    discharge: FloatArray
    outflow: FloatArray
    imbalance: float
    iterations: int
    converged: bool

    def __post_init__(self) -> None:
        show_only(self)

    @property
    def pressure_head(self) -> FloatArray:
        """At every node, (n,) [m], at least 0."""
        return np.maximum(self.u, 0.0)


def solve_steady(
    network: Network, conductance: FloatArray, conditions: Conditions, start: FloatArray | None = None
) -> SteadyFlow:
    """Return the steady flow.

    Parts of the network where no head is given and nothing is put in are dry. A pool that no water passes is as full as
    the start has it. Where water is put in and nothing lets it out there is no steady flow: none is found.

    Parameters
    ----------
    network : Network
        Nodes and pieces.
    conductance : (m,) float64 [m2/s]
        Of the pieces.
    conditions : Conditions
        At the nodes.
    start : (n,) float64 [m], optional
        Where the iteration starts: `u` of a flow like this one. By default all is under water as high as any head.
    """
    balance = _Balance(network, conductance, conditions)
    u, iterations, converged = balance.solved(balance.full() if start is None else start)
    discharge, pumped = balance.refined(u) if converged else (balance.discharge(u), balance.pumped(u))
    outflow = -sums_at_nodes(network, discharge, discharge)
    head, filled = balance.heads(u)
    free = ~(conditions.given | balance.spilling(u, -outflow + pumped))
    greatest = float(np.abs(discharge).max(initial=0.0))
    worst = float(np.abs(outflow - pumped)[free].max(initial=0.0))
    return SteadyFlow(
        u=u,
        head=head + balance.datum,
        filled=filled,
        discharge=discharge,
        outflow=np.where(free, pumped, outflow),
        imbalance=worst / greatest if greatest > 0 else 0.0,
        iterations=iterations,
        converged=converged,
    )


class _Balance:
    """What leaves every node as a function of u, with its derivative; heads count from mid-height, for rounding."""

    def __init__(self, network: Network, conductance: FloatArray, conditions: Conditions) -> None:
        self.network, self.conductance, self.conditions = network, conductance, conditions
        height = network.point[:, 1]
        self.datum = float((height.max() + height.min()) / 2)
        self.y = height - self.datum
        self.d = float(np.median(network.length)) if len(network.first) else 1.0
        at_node = self._sums(conductance, -conductance)
        self.conductance_at_node = np.where(at_node > 0, at_node, 1.0)
        self.given = conditions.given
        self.highest = conditions.spill - height
        self.u_given = np.where(self.given, np.nan_to_num(conditions.head) - height, 0.0)

    def _sums(self, of_first: FloatArray, of_last: FloatArray) -> FloatArray:
        """Return the sum at every node over its pieces: `of_first` (m,) where it is the first, less `of_last`."""
        return sums_at_nodes(self.network, of_first, of_last)

    def heads(self, u: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return heads over the datum and the part w of every node."""
        return self.y + np.maximum(u, 0.0), np.clip(1 + u / self.d, 0.0, 1.0)

    def discharge(self, u: FloatArray) -> FloatArray:
        """Return the discharge of every piece from its first node to its last."""
        head, filled = self.heads(u)
        first, last = self.network.first, self.network.last
        drop = head[first] - head[last]
        discharge: FloatArray = self.conductance * np.where(drop >= 0, filled[first], filled[last]) * drop
        return discharge

    def pumped(self, u: FloatArray) -> FloatArray:
        """Return what wells take at every node."""
        pumped = self.conditions.pumped
        taken: FloatArray = np.where(pumped > 0, pumped * self.heads(u)[1], pumped)
        return taken

    def by_u(self, u: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return derivatives: of every piece's discharge by u of its first and of its last node; of what wells take."""
        head, filled = self.heads(u)
        first, last, c = self.network.first, self.network.last, self.conductance
        drop = head[first] - head[last]
        wet, trickles = (u >= 0).astype(float), (u < 0) & (u >= -self.d)
        part = np.where(drop >= 0, filled[first], filled[last])
        by_part = trickles / self.d
        by_first = c * (part * wet[first] + np.where(drop >= 0, drop * by_part[first], 0.0))
        by_last = c * (-part * wet[last] + np.where(drop < 0, drop * by_part[last], 0.0))
        return by_first, by_last, np.maximum(self.conditions.pumped, 0.0) * by_part

    def full(self) -> FloatArray:
        """Return u with all nodes that water can reach under water, as high as the highest head or place of entry."""
        y, enters = self.network.point[:, 1], self.given | (self.conditions.pumped < 0)
        part = self.network.parts(self.conductance > 0)
        levels = np.where(self.given, self.conditions.head, y)[enters]
        reached = np.isin(part, part[enters])
        full: FloatArray = np.where(reached, levels.max(initial=float(y.min())) - y, -self.d)
        return full

    def solved(self, u: FloatArray) -> tuple[FloatArray, int, bool]:
        """Return u where every node balances, the number of iterations, and whether it is so, from a start."""
        random = np.random.default_rng(SEED)
        u = np.where(self.given, self.u_given, np.minimum(np.maximum(u, -self.d), self.highest))
        for iteration in range(MOST_ITERATIONS):
            discharge = self.discharge(u)
            leaving = self._sums(discharge, discharge) + self.pumped(u)
            held = self.given | self.spilling(u, leaving)
            if self._balances(u, np.where(held, 0.0, leaving), float(np.abs(discharge).max(initial=0.0))):
                return u, iteration, True
            there = self._corrected(u, leaving, held)
            if iteration > USUAL_ITERATIONS:
                there = np.where(random.random(len(u)) < CORRECTED, there, u)
            u = there
        return u, MOST_ITERATIONS, False

    def spilling(self, u: FloatArray, leaving: FloatArray) -> BoolArray:
        """Return the nodes, as high as water can be there, to which more comes than continues: the rest spills."""
        spills: BoolArray = (u >= self.highest) & (leaving <= 0) & ~self.given
        return spills

    def _balances(self, u: FloatArray, imbalance: FloatArray, greatest: float) -> bool:
        """Return whether the imbalance is rounding everywhere."""
        rounding = self._rounding(u)
        return bool((np.abs(imbalance) <= np.maximum(BALANCED * greatest, self._sums(rounding, -rounding))).all())

    def _rounding(self, u: FloatArray) -> FloatArray:
        """Return the rounding of every piece's discharge, (m,) [m2/s]: of a difference of heads, and of the part w.

        A joint that could lead much and leads nothing, for its upper end is dry, has none.
        """
        head, filled = self.heads(u)
        first, last = self.network.first, self.network.last
        drop = head[first] - head[last]
        part = np.where(drop >= 0, filled[first], filled[last])
        highest = max(float(np.abs(head).max(initial=0.0)), self.d)
        of_part = np.where((part > 0) & (part < 1), np.abs(drop), 0.0)
        rounding: FloatArray = ROUNDING * self.conductance * (part * highest + of_part)
        return rounding

    def _corrected(self, u: FloatArray, leaving: FloatArray, held: BoolArray) -> FloatArray:
        """Return u after a correction of all but the nodes `held` (n,).

        Where a node would come to be under water, or no longer be, it goes only so far that it is. So the iteration
        ends after about ten corrections whatever the size of the network, and seldom goes round in circles.
        """
        there = u - self._newton(u, leaving, held)
        there = np.where((u > 0) & (there < 0), -BELOW * self.d, there)
        there = np.where((u < 0) & (there > 0), 0.0, there)
        return np.where(self.given, u, np.minimum(np.maximum(there, -self.d), self.highest))

    def _newton(self, u: FloatArray, leaving: FloatArray, held: BoolArray) -> FloatArray:
        """Return the change of u (n,) that makes up for what leaves, to first order; 0 at the nodes `held`."""
        from scipy.sparse import coo_array
        from scipy.sparse.linalg import splu

        by_first, by_last, by_well = self.by_u(u)
        first, last, nodes = self.network.first, self.network.last, np.arange(len(u))
        data = np.concatenate([by_first, by_last, -by_first, -by_last, by_well])
        rows = np.concatenate([first, first, last, last, nodes])
        columns = np.concatenate([first, last, first, last, nodes])
        free, floating = np.flatnonzero(~held), floating_nodes(self.network, by_first, by_last, by_well, held)
        number = np.full(len(u), -1)
        number[free] = among = np.arange(len(free))
        own = self._sums(by_first, by_last) + by_well
        diagonal = (np.where(floating, FLOATING, HELD) * np.where(own > 0, own, self.conductance_at_node))[free]
        inner = (number[rows] >= 0) & (number[columns] >= 0)
        data = np.concatenate([data[inner], diagonal])
        place = np.concatenate([number[rows[inner]], among]), np.concatenate([number[columns[inner]], among])
        change = np.zeros(len(u))
        if len(free):
            change[free] = splu(coo_array((data, place), shape=(len(free), len(free))).tocsc()).solve(leaving[free])
        return change

    def refined(self, u: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return discharges and what wells take, better balanced than differences of rounded heads can be.

        Still water has none.
        """
        discharge, pumped = self.discharge(u), self.pumped(u)
        by_first, by_last, by_well = self.by_u(u)
        dry, worst = u <= -self.d, np.inf
        for _ in range(REFINEMENTS):
            leaving = self._sums(discharge, discharge) + pumped
            held = self.given | dry | self.spilling(u, leaving)
            imbalance = float(np.abs(leaving)[~held].max(initial=0.0))
            if imbalance >= worst:
                break
            best, worst = (discharge, pumped), imbalance
            change = self._newton(u, leaving, held)
            discharge = discharge - by_first * change[self.network.first] - by_last * change[self.network.last]
            pumped = pumped - by_well * change
        if (np.abs(best[0]) <= self._rounding(u)).all():
            return np.zeros_like(discharge), np.zeros_like(pumped)
        return best
