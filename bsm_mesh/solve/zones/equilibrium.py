"""Equilibrium of the continuum and its joints: unbalanced forces and their tangents."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import scipy.sparse as sp

from bsm_mesh.arrays import FloatArray
from bsm_mesh.solve.bolts.evaluation import BoltEvaluation
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
NEUTRAL = 1e-3  # of a node's load over a block's size: a negative stiffness up to it counts as none
OPEN_STIFFNESS = 1e-9  # left to open and slipping points, so that a block without contacts makes no singular matrix
FARTHEST = 0.01  # of a block's size: by how much a correction may open or shear joints, as small displacements hold


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
    def can_freeze(self) -> bool:
        """Whether joints with frozen friction leave a convex problem: not in large displacement, nor if rock yields."""
        return self.joints is not None and self.history is not None and self.large is None and self.plastic is None

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
