"""Joints of zones as the compiled laws of contacts take them: their columns at the begin of a window of cycles."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.contact.closure import Hyperbolic
from bsm_mesh.contact.features import Features
from bsm_mesh.contact.forces import rows_by_law
from bsm_mesh.model.joint_laws import wear_length_of
from bsm_mesh.solve.motion.contact_columns import LEAST_SHARE, column_of
from bsm_mesh.solve.motion.cycles import wear_room
from bsm_mesh.solve.motion.energy import spring_energy
from bsm_mesh.solve.motion.window_columns import UNLIMITED, ExtremeLines, chunks_of, strength_lines
from bsm_mesh.solve.zones.joint_history import JointHistory, JointState
from bsm_mesh.solve.zones.joint_points import TOUCHING, JointPoints
from bsm_mesh.solve.zones.moving_points import MovingPoints


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class _Asked:
    """Points of joints with the state variables that laws ask for."""

    candidates: JointPoints  # with the `length` of each
    by_law: tuple[tuple[int, Any], ...]
    features: Features
    normal_stiffness: FloatArray
    failed: Any
    slip_path: FloatArray
    offset: FloatArray

    @property
    def count(self) -> int:
        """Number of points."""
        return len(self.offset)


class JointWindow:
    """The points of joints in a window of cycles.

    Parameters
    ----------
    points : JointPoints
        The points.
    history : JointHistory
        Their memory at the begin.
    state : JointState
        Their state there.
    before : JointWindow, optional
        The window before.

    Attributes
    ----------
    stiffness : (q,) float64 [Pa]
        The stiffer spring of every point, as stiff as it may become.
    """

    def __init__(
        self, points: JointPoints, history: JointHistory, state: JointState, before: JointWindow | None = None
    ) -> None:
        self._points, self._history, self._state = points, history, state
        fits = np.isfinite(points.closure_limit) & ~history.parted
        rows, whole = np.flatnonzero(fits), ~history.parted[points.dilating.rows]
        hyperbolic = Hyperbolic(
            rows=rows,
            stiffness=points.normal_stiffness[rows],
            limit=points.closure_limit[rows],
            compliance=np.zeros(len(rows)),
        )
        dilating = replace(points.dilating, slope=points.dilating.slope * whole)
        self._asked: _Asked = _Asked(
            candidates=points,
            by_law=rows_by_law(points.joint) if before is None else before._asked.by_law,
            features=Features(hyperbolic, points.growing, dilating),
            normal_stiffness=points.normal_stiffness,
            failed=history.failed,
            slip_path=history.slip_path,
            offset=history.offset,
        )
        same = before is not None and before._extreme.hold_for(self._asked)
        self._extreme: ExtremeLines = (
            before._extreme if before is not None and same else ExtremeLines(self._asked, points.laws)
        )
        self._columns = self._made()
        softest = np.where(fits, LEAST_SHARE, 1.0)
        self.stiffness = np.maximum(
            self._columns["normal_stiffness"].astype(np.float64) / softest, self._columns["shear_stiffness"]
        )

    def _made(self) -> dict[str, Any]:
        points, history, state = self._points, self._history, self._state
        here = history.present
        trial, normal = points.pressures(state.opening, history)
        left = np.where(history.parted, 0.0, points.residual_tension)
        tension = np.minimum(np.where(history.failed, left, points.tension), UNLIMITED)
        # What may part keeps nothing of its strength once it has: its least opening is looked at.
        touches = TOUCHING * points.length * points.normal_stiffness
        tension = np.where(np.isfinite(points.tension) & ~history.parted, np.maximum(tension, touches), tension)
        stiffening, share = self._asked.features.closure.stiffening(state.pressure, normal)
        columns = {
            **strength_lines(self._asked, state, points.laws, self._extreme),
            "normal_stiffness": normal * here,
            "stiffening": stiffening * here,
            "rock_share": share,
            "shear_stiffness": state.springs.stiffness * here,
            "trial_pressure": np.where(here, trial, -1.0),
            "pressure": state.pressure,
            "shear": state.shear,
            "carried": state.shear,
            "tension": tension * here,
            "low": np.full(len(trial), -UNLIMITED),
            "high": np.full(len(trial), UNLIMITED),
        }
        return {name: column.astype(np.float32) for name, column in columns.items()}

    def chunks(self, dashpots: FloatArray, opened: FloatArray, slid: FloatArray) -> dict[str, Any]:
        """Return the points in chunks, as kernels take them, with their work.

        Parameters
        ----------
        dashpots : (q,) float64 [N/m]
            Of the normal forces, over a cycle.
        opened, slid : (q,) float64 [m]
            Movement in the cycle before.
        """
        given = {"dashpot": dashpots, "gap": -opened, "last": slid}
        columns = self._columns | {name: values.astype(np.float32) for name, values in given.items()}
        rows: IntArray = np.arange(self._asked.count)
        return chunks_of(self._asked, self._state.springs, rows, columns, slips=True, works=True)

    @property
    def count(self) -> int:
        """Number of points."""
        return self._asked.count

    @property
    def energy(self) -> float:
        """Energy in the springs of closed points at the begin [N]."""
        return spring_energy(self._asked, self._state)

    def farthest(self, window: float, slide: float) -> FloatArray:
        """Return how far points may slide in the window, (q,) [m]: not far from their places, nor from their strength.

        `window`: the part of a wear length in which strength counts as constant; `slide`: over a zone's side.
        """
        points, history = self._points, self._history
        side = points.pieces if isinstance(points, MovingPoints) else points.length
        found = np.where(history.present, slide * side, np.inf)
        for number, law in enumerate(points.laws):
            if (wear := wear_length_of(law)) is not None:
                on = (points.joint == number) & ~history.failed
                found[on] = np.minimum(found[on], wear_room(window, wear, history.slip_path[on]))
        return found

    def after(self, chunks: dict[str, Any], slip: FloatArray) -> JointHistory:
        """Return the memory at the end of the window, where points have slipped to `slip` (q,) [m]."""
        history, points, count = self._history, self._points, self._asked.count

        def of(kind: str, name: str) -> FloatArray:
            if not len(chunks[kind]):
                return np.zeros(count)
            return column_of(chunks[kind], name, count).astype(np.float64)

        broken = history.present & np.isfinite(points.tension) & (of("strengths", "broken") > 0)
        path = history.slip_path + of("slips", "slid")
        pressure = self._state.pressure
        if len(chunks["growths"]):
            pressure = np.where(of("growths", "factor") > 0, of("growths", "last_pressure"), pressure)
        return replace(
            history,
            slip=np.where(history.present, slip, history.slip),
            shear=np.where(history.present, of("contacts", "carried"), history.shear),
            pressure=pressure,
            slip_path=path,
            opened_by=path,
            failed=history.failed | broken | (of("strengths", "failed") > 0),
            parted=history.parted | broken,
        )

    def touched(self, chunks: dict[str, Any]) -> IntArray:
        """Return the blocks at points that were closed at any time in the window, (k, 2)."""
        found: IntArray = self._points.block[column_of(chunks["contacts"], "contacted", self._asked.count) > 0]
        return found

    def work(self, chunks: dict[str, Any], after: JointState) -> tuple[FloatArray, float]:
        """Return the energies that slip took at every point, (q,) [N], and that dashpots took, in the window.

        `after` is the state at its end: within a window shear springs grow in single precision, and no further than
        masses allow. Their loss there belongs to slip.
        """
        count = self._asked.count
        slip, damped = (column_of(chunks["works"], name, count).astype(np.float64) for name in ("dissipated", "damped"))
        if len(chunks["growths"]):
            before, carried = (column_of(chunks["contacts"], name, count) for name in ("shear_stiffness", "carried"))
            springs = after.closed & (before > 0) & (after.springs.stiffness > 0)
            stored = carried[springs].astype(np.float64) ** 2 / before[springs]
            slip[springs] += (stored - after.shear[springs] ** 2 / after.springs.stiffness[springs]) / 2
        return slip, float(damped.sum())
