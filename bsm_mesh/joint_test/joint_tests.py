"""Direct shear under constant normal stress or stiffness, back and forth, and closure with unloading."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from bsm_mesh.arrays import FloatArray, show_only
from bsm_mesh.contact.forces import ContactSet
from bsm_mesh.errors import raise_faults
from bsm_mesh.joint_test.specimen import Specimen, position_of
from bsm_mesh.model.materials import Joint
from bsm_mesh.model.quantities import COUNT_OF_CYCLES, SHEAR_MOVEMENT, STEPS_OF_TEST, STIFFNESS, TEST_STRESS
from bsm_mesh.model.values import Rules

STEPS = 200  # from the start to the greatest displacement or stress


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class JointCurve:
    """A test of a joint, a row a step.

    Attributes
    ----------
    shear_displacement, closure : (k,) float64 [m]
        Along the joint, and of its walls towards each other.
    normal_stress, shear_stress : (k,) float64 [Pa]
        Compression positive.
    strength : (k,) float64 [Pa]
        Greatest shear stress; infinite where there is no limit.
    slip_path : (k,) float64 [m]
        How far the joint has slid, back and forth, elastic part apart.
    """

    shear_displacement: FloatArray
    closure: FloatArray
    normal_stress: FloatArray
    shear_stress: FloatArray
    strength: FloatArray
    slip_path: FloatArray

    def __post_init__(self) -> None:
        show_only(self)

    @property
    def peak(self) -> float:
        """Greatest shear stress [Pa]."""
        return float(np.abs(self.shear_stress).max())

    @property
    def work(self) -> float:
        """Work of shear and normal stress per area, by trapezia [J/m2]: work that is not stored is dissipated."""
        along = np.trapezoid(self.shear_stress, self.shear_displacement)
        return float(along + np.trapezoid(self.normal_stress, self.closure))


def direct_shear_test(
    joint: Joint,
    normal_stress: float,
    displacement: float,
    *,
    cycles: int = 0,
    steps: int = STEPS,
    normal_stiffness: float = 0.0,
) -> JointCurve:
    """Return a direct shear test under a constant normal stress, or one that grows as the joint opens.

    Parameters
    ----------
    joint : Joint
        The joint.
    normal_stress : float [Pa]
        Compression positive.
    displacement : float [m]
        Greatest shear displacement.
    cycles : int
        How often it goes to `displacement`, to as much on the other side, and back to the start; 0: there only.
    steps : int
        In a quarter of a cycle.
    normal_stiffness : float [Pa/m]
        By which the normal stress grows with the opening since the shear began (constant normal stiffness, the rock
        around the joint); 0: it is constant.

    Raises
    ------
    ModelError
        With every value out of range.

    Examples
    --------
    >>> import bsm_mesh as bsm
    >>> law = bsm.BartonBandis(jrc=8, jcs=80e6, residual_friction=28)
    >>> curve = direct_shear_test(bsm.Joint("J", 10e9, 2e9, law=law), 1e6, 5e-3)
    >>> round(curve.peak)
    939875
    """
    rules = Rules("direct shear test")
    rules.a_thing("joint", joint, Joint)
    rules.number("normal_stress", normal_stress, TEST_STRESS)
    rules.number("displacement", displacement, SHEAR_MOVEMENT)
    rules.number("cycles", cycles, COUNT_OF_CYCLES)
    rules.number("steps", steps, STEPS_OF_TEST)
    if normal_stiffness != 0:
        rules.number("normal_stiffness", normal_stiffness, STIFFNESS)
    raise_faults(rules.faults)
    corners = np.array([0.0, 1.0, *(cycles > 0) * [0.0, -1.0, 0.0], *max(cycles - 1, 0) * [1.0, 0.0, -1.0, 0.0]])
    path = displacement * np.interp(np.arange(steps * (len(corners) - 1) + 1) / steps, np.arange(len(corners)), corners)
    return _tested(joint, path, np.full(len(path), normal_stress), normal_stiffness)


def closure_test(joint: Joint, normal_stress: float, *, steps: int = STEPS) -> JointCurve:
    """Return the closure of a joint under a normal stress [Pa] that comes and goes, without shear."""
    rules = Rules("closure test")
    rules.a_thing("joint", joint, Joint)
    rules.number("normal_stress", normal_stress, TEST_STRESS)
    rules.number("steps", steps, STEPS_OF_TEST)
    raise_faults(rules.faults)
    rise = np.linspace(0.0, normal_stress, steps + 1)
    stress = np.concatenate([rise, rise[-2::-1]])
    return _tested(joint, np.zeros(len(stress)), stress)


def _tested(joint: Joint, path: FloatArray, stress: FloatArray, normal_stiffness: float = 0.0) -> JointCurve:
    """Return a test along shear displacements under normal stresses, (k,) each [m], [Pa], and what opening adds."""
    specimen = Specimen(joint, length=max(1.0, 4 * float(np.abs(path).max())))
    rows: list[tuple[float, ...]] = []
    at, first = position_of(0.0, 0.0), None
    for shear, normal in zip(path.tolist(), stress.tolist(), strict=True):
        contacts = specimen.contacts(at)
        pressure = normal * contacts.candidates.length
        closure = contacts.features.closure.overlaps(pressure, contacts.normal_stiffness) - contacts.offset
        opening = -float(closure[contacts.within_tolerance].mean())
        first = opening if first is None else first
        if len(contacts.features.dilating.rows):
            opening = _opening(specimen, contacts, shear, first, normal, normal_stiffness)
        at = position_of(shear, opening)
        found = specimen.system.evaluate(contacts, at)
        specimen.keep(contacts, found)
        force = found.forces[1] / specimen.length
        strength = found.strength[found.closed].sum() / specimen.length
        slid = specimen.history.slip_path.mean() if len(specimen.history.slip_path) else 0.0
        rows.append((shear, -at[1, 1], force[1], -force[0], strength, slid))
    names = ("shear_displacement", "closure", "normal_stress", "shear_stress", "strength", "slip_path")
    return JointCurve(**dict(zip(names, np.array(rows).T, strict=True)))


def _opening(
    specimen: Specimen, contacts: ContactSet, shear: float, first: float, normal: float, normal_stiffness: float
) -> float:
    """Return where the upper block is off the joint [m] once the joint has opened by its slip.

    There the stress is `normal` [Pa], and the opening since the `first` position [m] adds to it. Slip only opens,
    so that the stress at the first position is as much or more; where even slip to the end leaves a gap there is none.
    """
    opens = contacts.features.dilating.slope.max() * 2 * abs(shear)
    last = float(contacts.offset.max()) + opens + abs(first) + 1e-9

    def excess(opening: float) -> float:
        found = specimen.system.evaluate(contacts, position_of(shear, opening))
        return float(found.forces[1, 1] / specimen.length - normal - normal_stiffness * (opening - first))

    rounding = np.finfo(float).eps * specimen.length  # of the corners' coordinates: no stress is finer
    return float(brentq(excess, first, last, xtol=rounding, maxiter=200)) if excess(first) > 0 else first
