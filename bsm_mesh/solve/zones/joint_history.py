"""Memory of the points of the continuum's joints, and their state at a displacement."""

from __future__ import annotations

from dataclasses import dataclass, replace

from bsm_mesh.arrays import BoolArray, FloatArray
from bsm_mesh.contact.feature import Springs


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class JointHistory:
    """Memory of the points, and actions on them besides the rock.

    Attributes
    ----------
    initial_pressure : (q,) float64 [N/m]
        Normal force at no opening, compression positive.
    offset : (q,) float64 [m]
        Relative displacement that counts as no opening: of blocks put back later, that of their neighbours until then;
        of points that met, or passed to another block, in motion: so that no force begins or changes there.
    slip, shear, pressure : (q,) float64 [m], [N/m], [N/m]
        At the end of the last state of equilibrium.
    slip_path, opened_by : (q,) float64 [m]
        How far the points have slid so far, elastic part apart; and had at the end of the last state of equilibrium.
    failed : (q,) bool
        As the law has it, and where the sides have parted.
    parted : (q,) bool
        Whether the sides have come apart: nothing is left of the tensile strength.
    present : (q,) bool
        Whether the blocks of both sides are there.
    water : (q,) float64 [N/m]
        Pressure of the joint's own water beyond the water table's.
    """

    initial_pressure: FloatArray
    offset: FloatArray
    slip: FloatArray
    shear: FloatArray
    pressure: FloatArray
    slip_path: FloatArray
    opened_by: FloatArray
    failed: BoolArray
    parted: BoolArray
    present: BoolArray
    water: FloatArray


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class JointState:
    """Forces of the points at a displacement, (q,) each; evaluating changes no history.

    Attributes
    ----------
    opening, slip : (q,) float64 [m]
        Displacement of the second side relative to the first, along its outward normal and its tangent.
    pressure, shear : (q,) float64 [N/m]
        Normal force, compression positive, and shear force.
    normal_stiffness : (q,) float64 [Pa]
        Derivative of the pressure by the closure.
    by_pressure : (q,) float64
        Derivative of the shear force by the pressure.
    by_slip, shear_by_slip : (q,) float64 [Pa]
        Derivatives of pressure and shear by the slip of points that open as they slide.
    springs : Springs
        Shear springs of the points.
    strength : (q,) float64 [N/m]
        Greatest shear force.
    closed, touching, sticking, failed, parted : (q,) bool
        Whether a point carries force, or would with any pressure at all; whether it does not slip; its new state.
    """

    opening: FloatArray
    slip: FloatArray
    pressure: FloatArray
    normal_stiffness: FloatArray
    shear: FloatArray
    by_pressure: FloatArray
    by_slip: FloatArray
    shear_by_slip: FloatArray
    springs: Springs
    strength: FloatArray
    closed: BoolArray
    touching: BoolArray
    sticking: BoolArray
    failed: BoolArray
    parted: BoolArray


def remember(history: JointHistory, state: JointState, path: FloatArray) -> JointHistory:
    """Return the history after a state of equilibrium, with how far points have slid then, (q,) [m]."""
    return replace(
        history,
        slip=state.slip,
        shear=state.shear,
        pressure=state.pressure,
        slip_path=path,
        opened_by=path,
        failed=state.failed,
        parted=state.parted,
    )
