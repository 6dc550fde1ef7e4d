"""No joint gives energy: whatever closed path a joint is led on, the work that goes in is not negative."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import bsm_mesh as bsm
from bsm_mesh.joint_test.specimen import Specimen, position_of

FINE = 60  # steps from corner to corner of a path
ROUGH = 2e-3  # of all work back and forth: the trapezoidal rule on paths with corners in the forces
ROUNDING = 1e-9  # J: positions round by 2e-16 m, and paths may be as short as that

JOINTS = {
    "mohr_coulomb": {"law": bsm.MohrCoulomb(friction=35, cohesion=2e5)},
    "softening": {
        "law": bsm.MohrCoulomb(
            friction=40, cohesion=2e5, residual_friction=25, residual_cohesion=1e4, softening_slip=1e-3
        )
    },
    "barton_bandis": {"law": bsm.BartonBandis(jrc=12, jcs=60e6, residual_friction=26, roughness_wears=True)},
    "hyperbolic": {"law": bsm.BartonBandis(jrc=12, jcs=60e6, residual_friction=26), "max_closure": 3e-4},
    "dilating": {
        "law": bsm.MohrCoulomb(friction=30, cohesion=2e5),
        "dilation_angle": 30.0,
        "dilation_slip": 2e-3,
    },
    "dilating, hyperbolic": {
        "law": bsm.BartonBandis(jrc=12, jcs=60e6, residual_friction=26, roughness_wears=True),
        "max_closure": 3e-4,
        "dilation_angle": 20.0,
        "dilation_slip": 1e-3,
    },
    "no law, hyperbolic": {"max_closure": 3e-4},
    "stiffening": {
        "law": bsm.MohrCoulomb(friction=35, cohesion=2e6),
        "shear_stiffness_exponent": 1.0,
        "reference_stress": 1e6,
    },
    "no law, stiffening": {"shear_stiffness_exponent": 1.0, "reference_stress": 1e6},
    "stiffening by its strength, dilating, hyperbolic": {
        "shear_stiffness": None,
        "law": bsm.BartonBandis(jrc=12, jcs=60e6, residual_friction=26, roughness_wears=True),
        "reference_stress": 1e6,
        "max_closure": 3e-4,
        "dilation_angle": 20.0,
        "dilation_slip": 1e-3,
    },
}
LONGEST = "stiffening by its strength, dilating, hyperbolic"
corner = st.tuples(st.floats(-3e-3, 3e-3), st.floats(-2.5e-4, 1e-4))


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.heavy] if name == LONGEST else []) for name in JOINTS]
)
@settings(max_examples=12, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(corners=st.lists(corner, min_size=2, max_size=4))
def test_no_energy_is_gained_on_a_closed_path(name, corners):
    specimen = Specimen(bsm.Joint("J", **{"normal_stiffness": 10e9, "shear_stiffness": 1e9, **JOINTS[name]}))
    path = np.array([(0.0, 0.0), *corners, (0.0, 0.0)])
    number = np.arange(FINE * (len(path) - 1) + 1) / FINE
    path = np.stack([np.interp(number, np.arange(len(path)), column) for column in path.T], axis=1)
    forces, at = [], position_of(0.0, 0.0)
    for shear, opening in path:
        contacts = specimen.contacts(at)
        at = position_of(shear, opening)
        found = specimen.system.evaluate(contacts, at)
        specimen.keep(contacts, found)
        forces.append(-found.forces[1, :2])
    forces = np.array(forces)
    work = (0.5 * (forces[1:] + forces[:-1]) * np.diff(path, axis=0)).sum(axis=1)
    assert work.sum() >= -ROUGH * np.abs(work).sum() - ROUNDING
