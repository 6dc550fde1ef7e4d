"""Joints of the continuum at points of their own: opening, slip, and the forces of the model's own joint laws.

Each point represents a length; its normal and shear force follow the joint's stiffness, its law and its tensile
strength as a contact's of the Block-Spring Model do. `placed_points` says where they are.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.contact.dilation import Dilating, slip_of_step
from bsm_mesh.contact.feature import Springs
from bsm_mesh.contact.shear_springs import Growing
from bsm_mesh.model.joint_laws import BEYOND_STRENGTH, JointLaw, closure, memory_of, signed, wear_length_of
from bsm_mesh.model.model import Model
from bsm_mesh.solve.zones.joint_history import JointHistory, JointState
from bsm_mesh.solve.zones.rock_faces import interface_dilations, interface_laws, interface_tensions
from bsm_mesh.solve.zones.tangents import PointStiffness

TOUCHING = 1e-10  # of a point's length: sides nearer than this have not parted, and keep their cohesion
LINEAR = np.array([(2.0, 1.0), (1.0, 2.0)]) / 3  # forces at two ends, over half the length, of tractions given there


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class JointPoints:
    """The points of all joints.

    Attributes
    ----------
    point, normal : (q, 2) float64
        Where they are [m], and the unit normal out of the first side.
    length : (q,) float64 [m]
        That each represents.
    joint : (q,) int32
        Number of the joint in ``model.joints``, behind them that of a face of rock (`rock_faces`).
    block : (q, 2 sides) int32
        The blocks on both sides.
    normal_stiffness, shear_stiffness : (q,) float64 [Pa]
        Per metre of thickness.
    tension, residual_tension : (q,) float64 [N/m]
        Tensile strength, infinite for joints without a law; what slip leaves of it.
    closure_limit : (q,) float64 [m]
        Greatest closure; infinite: none.
    dilating : Dilating
        The points that open as they slide.
    growing : Growing
        The points whose shear stiffness grows with pressure.
    joints : int
        How many joints the model has.
    laws : tuple of JointLaw
        By the number of the joint.
    opening_rows, slip_rows : sparse (q, N)
        Give opening and slip from the unknowns.
    at_ends : bool
        Whether tractions, linear along a side, are given at its two ends.
    """

    point: FloatArray
    normal: FloatArray
    length: FloatArray
    joint: IntArray
    block: IntArray
    normal_stiffness: FloatArray
    shear_stiffness: FloatArray
    tension: FloatArray
    residual_tension: FloatArray
    closure_limit: FloatArray
    dilating: Dilating
    growing: Growing
    joints: int
    laws: tuple[JointLaw, ...]
    opening_rows: Any
    slip_rows: Any
    at_ends: bool

    @property
    def are_joints(self) -> BoolArray:
        """Which points belong to joints of the model, (q,)."""
        found: BoolArray = self.joint < self.joints
        return found

    @property
    def over(self) -> BoolArray:
        """Which points slid over the end of a face, (q,)."""
        return np.zeros(len(self.length), dtype=bool)

    @property
    def are_linear(self) -> bool:
        """Whether no joint in use has a law, a closure limit or a growing stiffness: none slips, opens or stiffens."""
        return not len(self.growing.rows) and bool((np.isinf(self.tension) & np.isinf(self.closure_limit)).all())

    @property
    def wear_length(self) -> FloatArray:
        """Slip over which strength changes markedly, (q,) [m]; infinite: it does not."""
        of_laws = [wear_length_of(law) for law in self.laws]
        length: FloatArray = np.array([np.inf if one is None else one for one in of_laws])[self.joint]
        return length

    @property
    def tangent_direction(self) -> FloatArray:
        """The normal turned by +90 degrees, (q, 2)."""
        tangent: FloatArray = self.normal[:, ::-1] * (-1.0, 1.0)
        return tangent

    def lumped(self, traction: FloatArray) -> FloatArray:
        """Return the forces at the points that do the work of a traction given there, (q,) [N/m]."""
        forces = (traction.reshape(-1, 2) @ LINEAR).ravel() if self.at_ends else traction
        lumped: FloatArray = forces * self.length
        return lumped

    def unstressed(self) -> JointHistory:
        """Return the history of the start without any force."""
        zero = np.zeros(len(self.length))
        none = np.zeros(len(zero), dtype=bool)
        return JointHistory(
            initial_pressure=zero,
            offset=zero,
            slip=zero,
            shear=zero,
            pressure=zero,
            slip_path=zero,
            opened_by=zero,
            failed=none,
            parted=none,
            present=~none,
            water=zero,
        )

    def with_strength_of(self, model: Model) -> JointPoints:
        """Return a copy with the laws and tensile strengths of a model with the same joints."""
        tension, residual = (values[self.joint] * self.length for values in interface_tensions(model))
        dilating = Dilating.among(*interface_dilations(model)[:, self.joint])
        return replace(self, laws=interface_laws(model), tension=tension, residual_tension=residual, dilating=dilating)

    def put_back(self, history: JointHistory, stays: BoolArray, comes: BoolArray, u: FloatArray) -> JointHistory:
        """Return the history with no force at displacements u (N,) in joints of blocks (n,) that are put back.

        As the blocks' own contacts that come later these have no cohesion and no tensile strength; only joints without
        a law keep theirs.
        """
        there = (stays | comes)[self.block].all(axis=1)
        fresh = there & comes[self.block].any(axis=1)
        return replace(
            history,
            initial_pressure=np.where(fresh, 0.0, history.initial_pressure),
            offset=np.where(fresh, self.opening_rows @ u, history.offset),
            slip=np.where(fresh, self.slip_rows @ u, history.slip),
            shear=np.where(fresh, 0.0, history.shear),
            pressure=np.where(fresh, 0.0, history.pressure),
            slip_path=np.where(fresh, 0.0, history.slip_path),
            opened_by=np.where(fresh, 0.0, history.opened_by),
            failed=np.where(fresh, np.isfinite(self.tension), history.failed),
            parted=np.where(fresh, np.isfinite(self.tension), history.parted),
        )

    def evaluate(self, u: FloatArray, history: JointHistory, friction_at: FloatArray | None = None) -> JointState:
        """Return the state at a displacement u (N,).

        With `friction_at` (q,) [N/m] shear strengths are those at these pressures: the forces are then the gradient of
        a convex energy.
        """
        opening, slip = self.relative(u)
        opening = opening - history.offset
        springs = self._springs(opening, slip - history.slip, history, friction_at)
        trial = springs.old_shear + springs.stiffness * (slip - history.slip)
        lift, slope, more = self._lift(opening, trial, history, springs, slides=friction_at is None)
        pressure, stiffness = self._pressures(opening - lift, history)
        residual = np.where(history.parted, 0.0, self.residual_tension)
        tension = np.where(history.failed, residual, self.tension)
        closed = history.present & (pressure >= -tension) & ((pressure > 0) | (tension > 0))
        parted = history.present & ~closed & (-pressure > TOUCHING * self.length * self.normal_stiffness)
        pressure = np.where(closed, pressure, 0.0)
        rubs = closed if friction_at is None else history.present & (friction_at > 0)
        asked = np.where(rubs, pressure if friction_at is None else friction_at, 0.0)
        answer = self._respond(asked, np.where(rubs, trial, 0.0), history)
        shear, by_pressure, strength, sticking, failed = answer
        opens = np.where(closed & ~sticking, slope, 0.0)
        with np.errstate(divide="ignore", invalid="ignore"):
            softer = np.where(opens > 0, 1 / (1 + opens * np.abs(by_pressure) * stiffness / springs.stiffness), 1.0)
        stiffness = stiffness * softer
        by_slip = np.copysign(opens, shear) * stiffness
        stiffness = stiffness * np.where(opens > 0, more, 1.0)
        return JointState(
            opening=opening,
            slip=slip,
            pressure=pressure,
            normal_stiffness=stiffness,
            shear=np.where(rubs, shear, 0.0),
            by_pressure=by_pressure if friction_at is None else np.zeros_like(pressure),
            by_slip=by_slip,
            shear_by_slip=by_pressure * by_slip,
            springs=springs,
            strength=strength,
            closed=closed,
            touching=history.present & ~closed & ~parted,
            sticking=sticking & rubs,
            failed=failed | (parted & np.isfinite(self.tension)),
            parted=history.parted | (parted & np.isfinite(self.tension)),
        )

    def _springs(
        self, opening: FloatArray, moved: FloatArray, history: JointHistory, friction_at: FloatArray | None
    ) -> Springs:
        """Return the shear springs at openings and slips since the last equilibrium (q,) [m]; others as `evaluate`."""
        given, rows = (self.shear_stiffness, history.shear), self.growing.rows
        if not len(rows):
            return Springs(*given, moved[:0], moved[:0])
        pressed = self.pressures(opening, history) if friction_at is None else (friction_at, np.zeros_like(moved))
        return self.growing.springs_at(given, moved, history.pressure, pressed[0][rows], pressed[1][rows])

    def _lift(
        self, opening: FloatArray, trial: FloatArray, history: JointHistory, springs: Springs, *, slides: bool
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return by how much slip has opened the points, (q,) [m], the slope by which more would, and a factor.

        The factor, of the derivative of the pressure by the closure, is that of springs which grow, as in `tangents` of
        the contacts. The slip is that of before, and with `slides` that since then, which the pressure that it leads to
        lets go by.
        """
        dilating, rows = self.dilating, self.dilating.rows
        lift, slope, more = np.zeros(len(opening)), np.zeros(len(opening)), np.ones(len(opening))
        if not len(rows):
            return lift, slope, more
        whole = ~history.parted[rows]
        room = dilating.room(history.opened_by)
        lift[rows] = whole * dilating.opening(history.opened_by)
        if not slides:
            return lift, slope, more

        def everywhere(values: FloatArray) -> FloatArray:
            found = np.zeros(len(opening))
            found[rows] = values
            return found

        def pressures(overlap: FloatArray) -> tuple[FloatArray, FloatArray]:
            pressure, stiffness = self._pressures(-everywhere(overlap), history)
            return pressure[rows], stiffness[rows]

        def strength(pressure: FloatArray) -> tuple[FloatArray, FloatArray]:
            _, by_pressure, found, *_ = self._respond(
                everywhere(pressure), np.full(len(opening), BEYOND_STRENGTH), history
            )
            return found[rows], by_pressure[rows]

        overlap, stiffness = lift[rows] - opening[rows], springs.stiffness[rows]
        slip = slip_of_step(overlap, trial[rows], stiffness, dilating.slope, room, pressures, strength)
        slip = np.where(whole & history.present[rows], slip, 0.0)
        lift[rows] += dilating.slope * np.minimum(slip, room)
        slope[rows] = np.where((slip > 0) & (slip < room), dilating.slope, 0.0)
        if len(springs.by_closure):
            by_trial = np.sign(trial[rows]) * springs.trial_by_closure[rows] - slip * springs.by_closure[rows]
            more[rows] += slope[rows] / stiffness * by_trial
        return lift, slope, more

    def pressures(self, opening: FloatArray, history: JointHistory) -> tuple[FloatArray, FloatArray]:
        """Return pressures and their derivatives (q,) at openings, as far as slip so far has opened the points.

        Negative ones too: points of such pressures are open, or in tension.
        """
        lift, rows = np.zeros(len(opening)), self.dilating.rows
        lift[rows] = ~history.parted[rows] * self.dilating.opening(history.opened_by)
        return self._pressures(opening - lift, history)

    def _pressures(self, opening: FloatArray, history: JointHistory) -> tuple[FloatArray, FloatArray]:
        """Return pressures and their derivatives by the closure (q,), negative ones too.

        Sides that have come apart fit together no more: they close again where they opened, by the stiffness alone.
        """
        initial, stiffness = history.initial_pressure, self.normal_stiffness
        pressure = initial - stiffness * opening
        rows = np.flatnonzero(np.isfinite(self.closure_limit))
        if rows.size:
            stiffness = stiffness.copy()
            joint = self.normal_stiffness[rows], self.closure_limit[rows], np.zeros(len(rows))
            overlap = closure.overlap_at(initial[rows], *joint) - opening[rows]
            whole = ~history.parted[rows]
            fitting = closure.pressure_at(overlap, *joint)
            for values, fits, not_so in zip(
                (pressure, stiffness), fitting, (joint[0] * overlap, joint[0]), strict=True
            ):
                values[rows] = np.where(whole, fits, not_so)
        return pressure, stiffness

    def _respond(self, pressure: FloatArray, trial: FloatArray, history: JointHistory) -> tuple[Any, ...]:
        names = ("shear", "by_pressure", "strength", "sticking", "failed")
        found = tuple(np.zeros(len(pressure), dtype=bool if k > 2 else float) for k in range(5))
        for number in np.unique(self.joint):
            rows = self.joint == number
            law = self.laws[number]
            memory = memory_of(law, history, rows)
            magnitude = np.abs(trial[rows])
            answer = signed(law.respond(pressure[rows], magnitude, self.length[rows], *memory), trial[rows])
            for values, name in zip(found, names, strict=True):
                values[rows] = getattr(answer, name)
        return found

    def relative(self, u: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return opening and slip (q,) [m] at displacements u (N,)."""
        return self.opening_rows @ u, self.slip_rows @ u

    def moved(self, correction: FloatArray, present: BoolArray) -> float:
        """Return how far a correction (N,) opens or shears points that are there (q,), at most [m]."""
        rows = self.opening_rows, self.slip_rows
        return max(float((np.abs(of @ correction) * present).max(initial=0.0)) for of in rows)

    def forces(self, u: FloatArray, state: JointState, history: JointHistory) -> FloatArray:
        """Return the points' part of the internal forces at displacements u (N,), (N,) [N/m]."""
        normal = state.pressure + history.water * history.present
        forces: FloatArray = self.slip_rows.T @ state.shear - self.opening_rows.T @ normal
        return forces

    def stiffness(self, state: JointState, history: JointHistory, part: float, more: float = 0.0) -> PointStiffness:
        """Return the derivatives of `forces`, and `more` of the elastic stiffness besides.

        A part of the stiffness is left to open and slipping points.
        """
        least = part * history.present
        elastic = self.elastic_stiffness(history)
        normal = np.where(state.closed, 1.0, least) * state.normal_stiffness + more * elastic.normal
        springs = state.springs
        shear = np.where(state.sticking, 1.0, least) * springs.stiffness + more * elastic.shear + state.shear_by_slip
        cross = np.where(state.closed & ~state.sticking, -state.by_pressure * state.normal_stiffness, 0.0)
        if len(springs.trial_by_closure):
            cross -= np.where(state.closed & state.sticking, springs.trial_by_closure, 0.0)
        return PointStiffness(normal, shear, cross, -state.by_slip)

    def elastic_stiffness(self, history: JointHistory) -> PointStiffness:
        """Return the derivatives with every point closed and sticking."""
        normal, shear = history.present * self.normal_stiffness, history.present * self.shear_stiffness
        none = np.zeros_like(normal)
        return PointStiffness(normal, shear, none, none)


def slip_path_after(history: JointHistory, state: JointState) -> FloatArray:
    """Return how far points have slid so far, (q,) [m]: what of their slip is not elastic counts."""
    springs = state.springs
    slides = state.closed & ~state.sticking & (springs.stiffness > 0)
    elastic = (state.shear - springs.old_shear)[slides] / springs.stiffness[slides]
    path = history.slip_path.copy()
    path[slides] += np.abs((state.slip - history.slip)[slides] - elastic)
    return path
