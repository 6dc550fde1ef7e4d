"""Equilibrium of the continuum and its joints: Newton's method with the consistent tangent.

Where many points of joints slip or part at once Newton is helped in five ways:

* A correction is shortened until the residual is less than the greatest of the last few, not of the last: a point that
  goes from stick to slip to open and back may have to pass through a greater one (Grippo et al. 1986).
* None opens or shears joints by more than small displacements allow: where hardly anything holds a block a full one
  carries it metres away.
* A part of the joints' elastic stiffness is added to the tangent while corrections have to be shortened; the residual
  stays exact.
* Where rock yields, so is a part of its own elastic stiffness, up to all of it.
* If that leads nowhere, friction is frozen at the pressures reached, the convex problem that this leaves is solved, and
  Newton continues.

The loop of rigid blocks (`methods/newton.py`) shares the line search, not these five. With its acceptance,
regularization and stall rule instead, 3 of the first 115 tests of zones failed: joints that slip or part.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import scipy.sparse as sp

from bsm_mesh.arrays import FloatArray
from bsm_mesh.errors import ModelError
from bsm_mesh.solve.algebra.line_search import Decrease
from bsm_mesh.solve.bolts.evaluation import BoltEvaluation
from bsm_mesh.solve.stages.scheme import Reporter
from bsm_mesh.solve.zones.embedded_bolts import EmbeddedBolts
from bsm_mesh.solve.zones.joint_history import JointHistory, JointState, remember
from bsm_mesh.solve.zones.joint_points import JointPoints
from bsm_mesh.solve.zones.large_blocks import LargeBlocks
from bsm_mesh.solve.zones.plastic_rock import PlasticRock, PlasticState
from bsm_mesh.solve.zones.system import FreeUnknowns
from bsm_mesh.solve.zones.tangents import PointStiffness, Tangents
from bsm_mesh.solve.zones.water_near import WaterNear

BALANCED = 1e-9  # of the greatest force: the residual at which a state counts as equilibrium
ROUNDING = 10 * np.finfo(float).eps  # of the greatest stiffness times the greatest displacement
MOST_ROUNDING = 1e-6  # of the greatest force: where rounding may leave more, nothing shows what is in balance
MAX_ITERATIONS = 150  # corrections for one equilibrium before it counts as not found
WHOLE = 30  # corrections that are not shortened, of blocks that bend
NEUTRAL = 1e-3  # of a node's load over a block's size: a negative stiffness up to it counts as none
MAX_FROZEN = 4  # times that friction is frozen before the state counts as not found
FROZEN_ITERATIONS = 25  # corrections with friction frozen, a convex problem
OPEN_STIFFNESS = 1e-9  # left to open and slipping points, so that a block without contacts makes no singular matrix
SHORTENED = (1.0, 0.5, 0.25, 0.1)  # parts of a correction that are tried
ENOUGH = 0.1  # of a part of a correction: by how much the residual has to fall for no shorter one to be tried
RECENT = 3  # residuals below the greatest of which it has to fall
FARTHEST = 0.01  # of a block's size: by how much a correction may open or shear joints, as small displacements hold
FIRST_REGULARIZATION = 1e-4  # of the joints' elastic stiffness
MAX_REGULARIZATION = 0.1  # of the same: with more a correction hardly moves anything
FROZEN_REGULARIZATION = 1e-5  # of the same, where friction is frozen


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Equations:
    """Unknowns and forces in balance.

    Attributes
    ----------
    stiffness : sparse (N, N)
        Of the rock that is there.
    load : (N,) float64 [N/m]
        Weight, loads and water, less the initial stress's forces and the part of an excavation that is held back.
    free : FreeUnknowns
        The unknowns left by the supports.
    joints : JointPoints or None
        The joints.
    history : JointHistory or None
        Their memory.
    bolts : EmbeddedBolts or None
        The bolts.
    plastic : PlasticRock or None
        The rock that yields.
    tangents : Tangents
        Of rock and joints on the free unknowns.
    size : float [m]
        Of a block, the median.
    large : LargeBlocks or None
        The rock in large displacement; None: forces act where blocks were given.
    water : WaterNear or None
        Part of `load` that changes as blocks move.
    """

    stiffness: Any
    load: FloatArray
    free: FreeUnknowns
    joints: JointPoints | None
    history: JointHistory | None
    bolts: EmbeddedBolts | None
    plastic: PlasticRock | None
    tangents: Tangents
    size: float
    large: LargeBlocks | None = None
    water: WaterNear | None = None

    def at(self, u: FloatArray, multipliers: FloatArray, friction_at: FloatArray | None = None) -> Iterate:
        """Return the unbalanced force at displacements u (N,)."""
        internal, state = self.stiffness @ u if self.large is None else self.large.forces(u), None
        if self.joints is not None and self.history is not None:
            state = self.joints.evaluate(u, self.history, friction_at)
            internal = internal + self.joints.forces(u, state, self.history)
        bolts = None if self.bolts is None else self.bolts.evaluate(u)
        if self.bolts is not None and bolts is not None:
            internal = internal - self.bolts.forces(bolts)
        plastic = None if self.plastic is None else self.plastic.evaluate(u)
        if self.plastic is not None and plastic is not None:
            internal = internal - self.plastic.relieved(plastic)
        residual = self.load_at(u) - internal
        return Iterate(
            u=u,
            multipliers=multipliers,
            state=state,
            bolts=bolts,
            plastic=plastic,
            residual=residual,
            left=self.free.reduced(residual, multipliers),
            rounding=ROUNDING * float(self.stiffness.diagonal().max() * np.abs(u).max(initial=0.0)),
            scale=float(max(np.abs(self.load).max(initial=0.0), np.abs(internal).max(initial=0.0))),
        )

    def load_at(self, u: FloatArray) -> FloatArray:
        """Return `load` with the change of the water up to displacements u (N,), (N,) [N/m]."""
        return self.load if self.water is None else self.load + self.water.change(u)

    def tangent(self, at: Iterate, regularization: float) -> Any:
        """Return the derivative (free, free) of the internal forces, and a part of the elastic stiffness besides."""
        points = None
        if self.joints is not None and self.history is not None and at.state is not None:
            points = self.joints.stiffness(at.state, self.history, OPEN_STIFFNESS, regularization)
        softer = None
        if self.plastic is not None and at.plastic is not None and (at.plastic.yields.any() or self.large is not None):
            softer = self.plastic.softer(at.plastic)
        if self.large is None:
            return self._with_bolts(self.tangents.at(points, 1 + regularization, softer), at)
        return self._with_bolts(self.large.tangent(at.u, self.joints, at.state, points, 1 + regularization, softer), at)

    def allowed(self, correction: FloatArray) -> float:
        """Return the part of a correction (N,) that small displacements of the joints' sides allow, at most 1."""
        part = 1.0 if self.large is None else self.large.allowed(correction)
        if self.joints is None or self.history is None or self.are_linear:
            return part
        moved = self.joints.moved(correction, self.history.present)
        return min(part, FARTHEST * self.size / moved) if moved else part

    def moved(self, u: FloatArray, correction: FloatArray) -> FloatArray:
        """Return displacements u (N,) after a correction (N,)."""
        return u + correction if self.large is None else self.large.moved(u, correction)

    def elastic(self, at: Iterate) -> Any:
        """Return the stiffness (free, free) with all joints closed and sticking."""
        points = None
        if self.joints is not None and self.history is not None:
            points = self.joints.elastic_stiffness(self.history)
        if self.large is not None:
            turning = None if self.plastic is None or at.plastic is None else self.plastic.turning(at.plastic)
            return self.large.tangent(at.u, self.joints, at.state, points, softer=turning)
        return self.tangents.at(points)

    def leaves(self, at: Iterate) -> bool:
        """Return whether blocks in large displacement leave an equilibrium by the least disturbance.

        Slipping points keep their shear force and carry no more. Rock that yields adds no negative stiffness.
        """
        if self.large is None:
            return False
        points = None
        if at.state is not None:
            none = np.zeros_like(at.state.pressure)
            normal = np.where(at.state.closed, at.state.normal_stiffness, 0.0)
            points = PointStiffness(normal, np.where(at.state.sticking, at.state.springs.stiffness, 0.0), none, none)
        softer = None
        if self.plastic is not None and at.plastic is not None:
            softer = self.plastic.softer(at.plastic, positive=True)
        A = self._with_bolts(self.large.tangent(at.u, self.joints, at.state, points, softer=softer), at)
        mean = float(np.abs(self.load).sum()) / max(1, len(self.load))
        return self.large.leaves(A, NEUTRAL / self.size * mean)

    def _with_bolts(self, A: Any, at: Iterate) -> Any:
        if self.water is not None:
            A = sp.csc_matrix(A + self.free.reduced_matrix(self.water.stiffness))
        if self.bolts is None or at.bolts is None:
            return A
        return sp.csc_matrix(A + self.free.reduced_matrix(self.bolts.tangent(at.bolts)))

    def after(self, at: Iterate, path: FloatArray | None) -> Equations:
        """Return them after a state of equilibrium, which joints and bolts remember; `path` as for `remember`."""
        history, bolts, plastic = self.history, self.bolts, self.plastic
        if history is not None and at.state is not None and path is not None:
            history = remember(history, at.state, path)
        if bolts is not None and at.bolts is not None:
            bolts = bolts.commit(at.bolts, at.u)
        if plastic is not None and at.plastic is not None:
            plastic = plastic.after(at.plastic)
        return replace(self, history=history, bolts=bolts, plastic=plastic)

    @property
    def are_linear(self) -> bool:
        """Whether one correction solves them."""
        bolts = self.bolts is None or self.bolts.elastic is not None
        return bolts and self.large is None and self.plastic is None and (self.joints is None or self.joints.are_linear)


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Iterate:
    """A displacement, the state of the joints there, and the unbalanced force.

    Attributes
    ----------
    u : (N,) float64 [m]
        Displacements.
    multipliers : (m,) float64 [N/m]
        Of constraints that take in many unknowns.
    state : JointState or None
        Of the joints.
    bolts : BoltEvaluation or None
        Forces of the bolts.
    plastic : PlasticState or None
        Of the rock that yields.
    residual : (N,) float64 [N/m]
        Loads less internal forces, at all unknowns.
    left : (free,) float64 [N/m]
        The same at the free unknowns.
    scale : float [N/m]
        The greatest force.
    rounding : float [N/m]
        What rounding leaves of the residual where rock is very stiff.
    """

    u: FloatArray
    multipliers: FloatArray
    state: JointState | None
    bolts: BoltEvaluation | None
    plastic: PlasticState | None
    residual: FloatArray
    left: FloatArray
    scale: float
    rounding: float

    @property
    def is_balanced(self) -> bool:
        """Whether this counts as equilibrium."""
        rounding = min(self.rounding, MOST_ROUNDING * self.scale)
        return bool(np.abs(self.left).max(initial=0.0) <= BALANCED * self.scale + rounding)

    @property
    def size(self) -> float:
        """The residual over the greatest force."""
        greatest = float(np.abs(self.left).max(initial=0.0))
        return greatest / self.scale if self.scale else greatest

    @property
    def norm(self) -> float:
        """Of the residual."""
        return float(np.linalg.norm(self.left))


def find_equilibrium(equations: Equations, u: FloatArray, report: Reporter = lambda text: None) -> tuple[Iterate, bool]:
    """Return the state of equilibrium near displacements u (N,), else the last tried, and whether it is one.

    `report` gets the unbalanced force of every correction, in words.

    Raises
    ------
    ModelError
        If the equations are singular, or the supports contradict each other.
    """
    free = equations.free
    at = equations.at(free.fulfilled(u), free.none)
    if equations.are_linear and at.is_balanced and not free.misfit(at.u).any():
        return at, True
    if equations.are_linear:
        solved = _shortened(equations, at, 0.0, at.norm, (1.0,))[0]
        at = replace(solved, scale=max(at.scale, solved.scale))  # a motion as a whole leaves no force to compare with
    else:
        at = _newton(equations, _bent(equations, _tied(equations, at)), report)
    free.refuse_misfit(at.u)
    return at, at.is_balanced


def _tied(equations: Equations, at: Iterate) -> Iterate:
    """Return the solution with all joints closed and sticking where some that touch carry no force yet."""
    misses = np.abs(equations.free.misfit(at.u)).max(initial=0.0) > 0
    if (at.state is None or not at.state.touching.any()) and not misses:
        return at
    correction, multipliers = equations.free.solve(equations.elastic(at), at.residual, at.u)
    return equations.at(equations.moved(at.u, correction), multipliers)


def _bent(equations: Equations, at: Iterate) -> Iterate:
    """Return the state after whole corrections of blocks in large displacement, or the given one where they fail.

    A correction that bends a slab stretches it by half the square of the angle. So the residual rises by far more than
    the loads, and falls with the next correction, never reached by shortened ones.
    """
    best, now, last = at, at, np.inf
    for _ in range(0 if equations.large is None else WHOLE):
        if now.is_balanced and (now.size <= BALANCED or now.norm > last / 2):  # no more than rounding is left
            break
        last = now.norm
        try:
            now = _shortened(equations, now, 0.0, np.inf, (1.0,))[0]
        except ModelError:  # a block came off its neighbours
            break
        if not np.isfinite(now.norm):
            break
        best = min(best, now, key=lambda one: one.norm)
    return best


def _newton(equations: Equations, at: Iterate, report: Reporter) -> Iterate:
    regularization, frozen, recent = 0.0, 0, deque([at.norm], RECENT)
    for number in range(MAX_ITERATIONS):
        report(f"correction {number}: unbalanced force {at.size:.1e} of the greatest")
        if at.is_balanced:
            break
        most = max(recent)
        try:
            new, part = _shortened(equations, at, regularization, most)
        except ModelError:
            if equations.large is None:
                raise
            break  # a block came off its neighbours, or is about to leave an equilibrium
        if new.norm < most * (1 - 1e-3):
            regularization = _relieved(regularization, part)
            at = new
            recent.append(at.norm)
            continue
        regularization = max(10 * regularization, FIRST_REGULARIZATION)
        if regularization > (MAX_REGULARIZATION if equations.plastic is None else 1):  # 1: as stiff as elastic rock
            if frozen == MAX_FROZEN or at.state is None or equations.large is not None:  # no energy is convex then
                break
            frozen, regularization = frozen + 1, 0.0
            at = _with_frozen_friction(equations, at, report)
            recent = deque([at.norm], RECENT)
    return at


def _relieved(regularization: float, part: float) -> float:
    """Return the regularization after a correction of which a part was taken."""
    if regularization <= 1e-7:
        return FIRST_REGULARIZATION if part < 0.25 else 0.0
    return regularization * (0.1 if part == 1 else 1.0 if part >= 0.25 else 3.0)


def _shortened(
    equations: Equations, at: Iterate, regularization: float, most: float, parts: tuple[float, ...] = SHORTENED
) -> tuple[Iterate, float]:
    """Return the state after a part of a correction: the first with a residual well below `most`, else the best."""
    correction, multipliers = equations.free.solve(equations.tangent(at, regularization), at.residual, at.u)
    allowed = equations.allowed(correction)
    tried, decrease = [], Decrease(most, ENOUGH)
    for part in (allowed * part for part in parts):
        new = equations.at(
            equations.moved(at.u, part * correction), at.multipliers + part * (multipliers - at.multipliers)
        )
        tried.append((new, part))
        if decrease.reached(new.norm, part):
            break
    return tried[decrease.chosen]


def _with_frozen_friction(equations: Equations, at: Iterate, report: Reporter) -> Iterate:
    """Return the equilibrium with shear strengths as at the pressures reached: the minimum of a convex energy."""
    assert at.state is not None
    pressure = at.state.pressure
    free, now = equations.free, equations.at(at.u, at.multipliers, pressure)
    for _ in range(FROZEN_ITERATIONS):
        if now.size <= 0.1 * BALANCED:
            break
        report(f"friction frozen: unbalanced force {now.size:.1e} of the greatest")
        K = equations.tangent(now, FROZEN_REGULARIZATION)
        correction, multipliers = free.solve(K, now.residual, now.u)
        now = _line_minimum(equations, now, correction, multipliers, pressure)
    return equations.at(now.u, now.multipliers)


def _line_minimum(
    equations: Equations, now: Iterate, correction: FloatArray, multipliers: FloatArray, pressure: FloatArray
) -> Iterate:
    """Return the state along a correction at which the forces out of balance do no more work on it."""
    along = equations.free.reduced(correction, np.zeros_like(now.multipliers))
    first = float(along @ now.left)
    low, high, part, new = 0.0, np.inf, 1.0, now
    for _ in range(FROZEN_ITERATIONS):  # halvings: a block that slips back stops within a micrometre
        new = equations.at(equations.moved(now.u, part * correction), multipliers, pressure)
        work = float(along @ new.left)
        if abs(work) < 0.1 * abs(first):
            break
        low, high = (part, high) if work > 0 else (low, part)
        part = 2 * part if np.isinf(high) else (low + high) / 2
    return new
