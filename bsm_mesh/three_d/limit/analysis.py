"""Limit analysis of polyhedral blocks: are there forces within strength, at which strength, and the proof if not.

As in the plane it knows statics and strength, but neither stiffness nor movement. Where no such forces exist the
blocks must move, whatever the flow rule; where they exist nothing is proved. Friction is associated: the factor of
strength of a wedge between two planes is an upper bound, 5 to 16 % above that of limit equilibrium.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray
from bsm_mesh.errors import ModelError
from bsm_mesh.three_d.blocks.moments import Moments
from bsm_mesh.three_d.limit.points import LimitPoints
from bsm_mesh.three_d.limit.program import NOTHING, ConeProgram, Optimum
from bsm_mesh.three_d.limit.strength import ConeStrength
from bsm_mesh.three_d.limit.ties import Ties

MOST = 1000.0  # greatest factor sought, 1 / MOST the least
ACCURACY = 1e-5  # relative, of the factor
NEAR = 1e-4  # the same, where the solver gives up next to it
SLOW = 1e-6  # of the fastest block: others do not move
ENORMOUS = 1e6  # times all loads together: forces that no rock bears


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Witness:
    """A mechanism and what its virtual work proves, by sums alone.

    Forces in equilibrium take up the power of the loads. Within strength points take up at most `dissipation`, and
    `closing` times the greatest pressure, which is of rounding only. So forces that balance the loads would have to be
    `least` or more.

    Attributes
    ----------
    velocity : (n, 6) float64 [m, rad]
        The mechanism.
    power, dissipation : float [N m]
        Of the loads, and by cohesion, tensile strength and bolts.
    closing : float [m]
        By how much the points slip without opening by slope times slip, in all. Movements of supports and of bolts
        without limits are added.
    least : float
        Least force that balances, over all loads together; infinite where nothing closes.
    """

    velocity: FloatArray
    power: float
    dissipation: float
    closing: float
    least: float

    @property
    def proves(self) -> bool:
        """Whether no forces that rock bears balance the loads."""
        return self.power > self.dissipation and self.least > ENORMOUS


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class ConeAnalysis:
    """Answer of the conic program for the given geometry.

    Attributes
    ----------
    lacking : float
        Strength that is lacking at every point, over the mean load of a block; at least -1.
    pressure : (m,) float64 [N]
        Of the points, with the missing strength, compression positive.
    shear : (m, 3) float64 [N]
        Shear force on block_b.
    ties : (t,) float64 [N]
        Forces in supports and bolts.
    witness : Witness
        The mechanism of the strength that is lacking; it proves something only where forces do not exist.
    """

    lacking: float
    pressure: FloatArray
    shear: FloatArray
    ties: FloatArray
    witness: Witness

    @property
    def admissible(self) -> bool:
        """Whether forces within strength balance the loads. False proves movement, True proves nothing."""
        return self.lacking <= NOTHING

    def __str__(self) -> str:
        """Return the proved statement."""
        if self.admissible:
            return "admissible: forces within strength exist; that does not prove that the blocks stay at rest"
        if self.witness.proves:
            return "inadmissible: no forces within strength balance the loads; this geometry must move"
        return (
            "inadmissible: the program found no forces within strength; its mechanism proves it only for forces up to "
            f"{self.witness.least:.1e} times all loads"
        )


class LimitAnalysis3D:
    """Limit analysis of blocks that are given: one geometry, any loads and strength.

    Parameters
    ----------
    moments : Moments
        Of the blocks.
    points : LimitPoints
        Where they touch.
    fixed : (n,) bool
        Blocks that bear whatever comes.
    ties : Ties, optional
        Supports of blocks that are not fixed, and bolts.
    """

    def __init__(
        self,
        moments: Moments,
        points: LimitPoints,
        fixed: BoolArray,
        ties: Ties | None = None,
    ) -> None:
        self.moments = moments
        self.chosen = np.flatnonzero(~(fixed[points.block_a] & fixed[points.block_b]))  # of the points given
        self.points = points.some(self.chosen)
        self.program = ConeProgram(moments, self.points, fixed, ties)

    def analyse(self, loads: FloatArray, strength: ConeStrength) -> ConeAnalysis:
        """Return whether forces within strength balance loads (n, 6) [N, N m], and the mechanism if not."""
        found = self.program.balance(loads, strength)
        witness = self.witness(found.velocity, loads, strength, found.slip)
        if found.value > NOTHING and not witness.proves:
            witness = self._among_moving(found.velocity, loads, strength) or witness
        return ConeAnalysis(
            lacking=found.value, pressure=found.pressure, shear=found.shear, ties=found.ties, witness=witness
        )

    def _among_moving(self, velocity: FloatArray, loads: FloatArray, strength: ConeStrength) -> Witness | None:
        """Return the witness of the blocks that move alone, all others fixed; None where these can be at rest then.

        Rounding in the velocities of all others does not disturb it.
        """
        rates = velocity.copy()
        rates[:, 3:] *= self.program.radius[:, None]
        speed = np.linalg.norm(rates, axis=1)
        still = speed < SLOW * speed.max()
        part = LimitAnalysis3D(self.moments, self.points, self.program.fixed | still, self.program.ties)
        rows = part.chosen
        some = replace(
            strength, slope=strength.slope[rows], intercept=strength.intercept[rows], tension=strength.tension[rows]
        )
        found = part.program.balance(loads, some)
        return part.witness(found.velocity, loads, some, found.slip) if found.value > NOTHING else None

    def load_factor(self, dead: FloatArray, live: FloatArray, strength: ConeStrength) -> Optimum:
        """Return the greatest factor on live loads with dead ones, with its mechanism; an upper bound."""
        return self.program.maximise(dead, live, strength)

    def strength_factor(
        self, loads: FloatArray, strength: ConeStrength, chosen: BoolArray | None = None, *, bolts: bool = False
    ) -> float:
        """Return the greatest factor by which strength may be divided while forces balance the loads; an upper bound.

        Divided is that of all points, or of chosen ones (m,), and of the bolts or not. 0 where a thousandfold strength
        does not suffice, infinite where a thousandth does.

        Next to the factor next to nothing is lacking, and the solver may give up. Then the factor is one a little
        greater, at which strength is lacking, if none is a little below.
        """
        from scipy.optimize import brentq

        low, high = -math.log(MOST), math.log(MOST)
        tried = []

        def lacking(logarithm: float) -> float:
            tried.append(logarithm)
            weaker = strength.divided(math.exp(logarithm), chosen, bolts=bolts)
            return self.program.balance(loads, weaker).value - NOTHING

        if lacking(high) <= 0:
            return math.inf
        if lacking(low) > 0:
            return 0.0
        try:
            return math.exp(brentq(lacking, low, high, xtol=ACCURACY))
        except ModelError:
            below, above = tried[-1] - NEAR, tried[-1] + NEAR
            if lacking(below) <= 0 < lacking(above):
                return math.exp(above)
            raise

    def witness(
        self, velocity: FloatArray, loads: FloatArray, strength: ConeStrength, of_bolts: FloatArray | None = None
    ) -> Witness:
        """Return the proof by a mechanism for loads and strength, by NumPy alone; `of_bolts`: slips at their nodes."""
        slips = np.zeros(len(self.program.ties.capacity)) if of_bolts is None else of_bolts
        opening, slip = self.program.rates(velocity)
        speed = np.linalg.norm(slip, axis=1)
        bounded = np.isfinite(strength.intercept).any(axis=1)
        with np.errstate(invalid="ignore"):
            ratio = np.where(speed > 0, opening / np.where(speed > 0, speed, 1.0), np.inf)
        # The line that bounds shear most is that of the mechanism: any line gives an upper bound.
        fits = np.where(np.isfinite(strength.intercept), np.maximum(strength.slope - ratio[:, None], 0), np.inf)
        line = np.argmin(fits, axis=1)
        rows = np.arange(len(line))
        slope, intercept = strength.slope[rows, line], strength.intercept[rows, line]
        pull = np.where(np.isfinite(strength.tension), strength.tension, 0.0)
        over = opening - slope * speed
        taken = np.where(bounded, intercept * speed + np.maximum(over, 0) * pull, 0.0)
        closing = np.where(bounded, np.maximum(-over, 0), np.abs(opening) + speed)
        free = self.program.free
        power = float((velocity[free] * loads[free]).sum())
        of_ties, moved = self.program.ties.taken(self.program.tie_rates(velocity), slips, strength.bolts)
        dissipation, gap = float(taken.sum()) + of_ties, float(closing.sum()) + moved
        whole = float(np.linalg.norm(loads[free, :3], axis=1).sum())
        least = math.inf if gap == 0 else max(power - dissipation, 0.0) / (gap * max(whole, 1e-300))
        return Witness(velocity=velocity, power=power, dissipation=dissipation, closing=gap, least=least)


def weights(moments: Moments, unit_weight: FloatArray, direction: Sequence[float] = (0, 0, -1)) -> FloatArray:
    """Return the weights of blocks as loads, (n, 6) [N, N m]; the direction's length multiplies them."""
    force = (moments.volume * unit_weight)[:, None] * np.asarray(direction, dtype=np.float64)
    return np.concatenate([force, np.zeros_like(force)], axis=1)
