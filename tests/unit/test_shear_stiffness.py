"""Shear stiffness that grows with normal stress: published curves, tangents, energy, every way of solving, faults."""

import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.contact.stage_transfer import in_situ_history
from bsm_mesh.contact.tangents import tangent_stiffness
from bsm_mesh.joint_test import direct_shear_test
from bsm_mesh.joint_test.specimen import Specimen, position_of
from bsm_mesh.model.joint_laws.shear_stiffness import ShearCurve, stiffness_at
from bsm_mesh.model.strength import with_strength
from bsm_mesh.solve.step.block_system import BlockSystem
from tests.scenes.models import model_of
from tests.scenes.shapes import rectangle

KN, KS, AT = 10e9, 2e9, 1e6
BARTON = bsm.BartonBandis(jrc=10, jcs=80e6, residual_friction=28, joint_length=1.0)
HARD = bsm.MohrCoulomb(friction=60, cohesion=50e6)
POWER = {"shear_stiffness_exponent": 0.6, "reference_stress": AT}


def power(stress):
    return KS * (stress / AT) ** 0.6


def barton(stress):
    """Peak strength of a joint 1 m long over L / 500 (JRCn / L)^0.33 (Barton and Bandis 1982)."""
    rough, wall = 10 * 10 ** (-0.2), 80e6 * 10 ** (-0.3)
    return stress * math.tan(math.radians(28 + rough * math.log10(wall / stress))) / (rough**0.33 / 500)


CURVES = {
    "power": (bsm.Joint("J", KN, KS, law=HARD, **POWER), power),
    "barton": (bsm.Joint("J", KN, law=BARTON, reference_stress=AT), barton),
}


@pytest.mark.parametrize("name", CURVES)
@pytest.mark.parametrize("stress", [0.1e6, 0.5e6, 1e6, 5e6, 20e6])
def test_a_joint_under_constant_stress_is_as_stiff_as_published(name, stress):
    joint, formula = CURVES[name]
    curve = direct_shear_test(joint, stress, 2e-4, steps=20)
    assert_allclose(curve.shear_stress[1:], formula(stress) * curve.shear_displacement[1:], rtol=1e-9)


@pytest.mark.parametrize("stress", [0.1e6, 1e6, pytest.param(5e6, marks=pytest.mark.heavy)])
def test_bartons_joint_peaks_at_its_displacement(stress):
    """L / 500 (JRCn / L)^0.33, whatever the stress."""
    joint = CURVES["barton"][0]
    at_peak = BARTON.peak_displacement
    assert at_peak == pytest.approx((10 * 10 ** (-0.2)) ** 0.33 / 500, rel=1e-12)
    curve = direct_shear_test(joint, stress, 2 * at_peak, steps=200)
    slides = curve.slip_path > 1e-9 * at_peak
    assert curve.shear_displacement[slides][0] == pytest.approx(1.01 * at_peak, rel=1e-9)


@pytest.mark.parametrize(
    "curve", [ShearCurve.power(KS, AT, 0.6), ShearCurve.power(KS, AT, 1.5), ShearCurve.barton(BARTON, AT)]
)
def test_the_curves_derivative_is_the_difference_quotient(curve):
    stress = np.geomspace(2 * curve.least, 0.4 * curve.most, 25)
    rows = np.tile(np.array(curve), (25, 1))
    ahead, behind = (stiffness_at(stress * (1 + sign * 1e-6), rows)[0] for sign in (1, -1))
    assert_allclose(stiffness_at(stress, rows)[1], (ahead - behind) / (2e-6 * stress), rtol=1e-6, atol=1e-9)


def test_beyond_a_thousand_times_the_reference_stress_it_is_constant():
    rows = np.tile(np.array(ShearCurve.power(KS, AT, 0.5)), (4, 1))
    stiffness, slope = stiffness_at(np.array([0.0, 1e3, 1e9, 1e11]), rows)
    assert_allclose(stiffness, KS * np.array([1, 1, 1e3, 1e3]) / np.array([1e3**0.5, 1e3**0.5, 1e3**0.5, 1e3**0.5]))
    assert not slope.any()


def test_the_force_falls_with_the_stiffness_and_stays_as_it_grows():
    """Sheared under 4 MPa, unloaded to 1 MPa and loaded again: the secant of the lower stress is left."""
    specimen = Specimen(CURVES["power"][0])
    forces, at = [], position_of(0.0, 0.0)
    for shear, stress in ((0.0, 4e6), (1e-4, 4e6), (1e-4, 1e6), (1e-4, 4e6), (2e-4, 4e6)):
        contacts = specimen.contacts(at)
        at = position_of(shear, -stress / KN)
        found = specimen.system.evaluate(contacts, at)
        specimen.keep(contacts, found)
        forces.append(-found.forces[1, 0])
    high, low = power(4e6) * 1e-4, power(1e6) * 1e-4
    assert_allclose(forces, [0.0, high, low, low, low + high], rtol=1e-9, atol=1e-3)


JOINTS = {
    "power": CURVES["power"][0],
    "barton, sliding": CURVES["barton"][0],
    "with closure and rock": replace(CURVES["barton"][0], max_closure=4e-4),
    "with dilation": replace(CURVES["barton"][0], max_closure=4e-4, dilation_angle=10.0, dilation_slip=5e-3),
}


@pytest.mark.parametrize("name", JOINTS)
@pytest.mark.parametrize("shear", [2e-5, 4e-3])
@pytest.mark.parametrize("closes", [True, False])
def test_the_tangent_is_the_difference_quotient(name, shear, closes):
    specimen = Specimen(JOINTS[name])
    at = position_of(-1e-5, -1.1e-4)
    first = specimen.contacts(at)
    specimen.keep(first, specimen.system.evaluate(first, at))
    contacts = specimen.contacts(at)
    here = position_of(shear, -1.5e-4 if closes else -0.8e-4)
    here[1, 2] = 1e-5
    places = np.tile(np.arange(4), (contacts.count, 1)).astype(np.int32)
    swapped = contacts.candidates.block_a == 0
    places[swapped] = places[swapped][:, [3, 2, 1, 0]]
    at_here = specimen.system.evaluate(contacts, here)
    blocks = tangent_stiffness(contacts, at_here, places, 4)
    number = {(1, 1): 0, (1, 0): 1, (0, 1): 2, (0, 0): 3}
    found = blocks[number[1, 1]]
    quotient, steps = np.zeros((3, 3)), (1e-9, 1e-9, 1e-9)
    for axis, step in enumerate(steps):
        moved = np.zeros((2, 3))
        moved[1, axis] = step
        ahead, behind = (specimen.system.evaluate(contacts, here + sign * moved).forces[1] for sign in (1, -1))
        quotient[:, axis] = -(ahead - behind) / (2 * step)
    assert_allclose(found, quotient, rtol=1e-6, atol=1e-6 * np.abs(found).max())


def test_in_series_with_rock():
    """The springs of a block's contacts in situ: half blocks over G, and the joint at the field's stress."""
    rock = bsm.Rock("r", unit_weight=0.0, young=20e9, poisson=0.25)
    model = bsm.Model(
        blocks=bsm.Blocks.from_polygons([rectangle(0, -1, 1, 0), rectangle(0, 0, 1, 1)], rock="r"),
        rocks=[rock],
        joints=[CURVES["power"][0]],
        default_joint="J",
        supports=[bsm.Fixed(blocks=[0])],
        loads=[bsm.PointLoad(block=1, point=(0.5, 0.5), force=(0.0, -4e6))],
        in_situ=bsm.InSitu(stress={"xx": 0.0, "yy": -4e6, "xy": 0.0}),
    )
    history, notes = in_situ_history(model)
    assert not notes
    system = BlockSystem(model)
    at = np.zeros((2, 3))
    found = system.evaluate(system.gather(history, at, first=False), at)
    halves = 2 * 0.5 / (20e9 / 2 / 1.25)
    assert_allclose(found.springs.stiffness[found.closed].sum(), 1 / (1 / power(4e6) + halves), rtol=1e-9)


def test_strength_reduction_leaves_the_stiffness():
    model = model_of([rectangle(-2, -1, 2, 0), rectangle(-0.5, 0, 0.5, 1)])
    joint = bsm.Joint("J", KN, law=BARTON, reference_stress=AT)
    weaker = with_strength(model.replace(joints=[joint]), {"J": 0.5}).joints[0]
    assert weaker.shear_curve == joint.shear_curve
    assert weaker.contact_stiffness == joint.contact_stiffness


@pytest.mark.parametrize(
    ("keys", "told"),
    [
        ({"shear_stiffness": KS, "shear_stiffness_exponent": 0.5}, "at which normal stress .* Give reference_stress"),
        ({"shear_stiffness": KS, "reference_stress": AT}, "never acts: shear_stiffness is constant; give shear_st"),
        ({"shear_stiffness_exponent": 0.5, "reference_stress": AT}, "needs shear_stiffness, which the joint has at"),
        ({"reference_stress": AT}, "which the law barton_bandis knows; give that law"),
        ({"reference_stress": AT, "law": bsm.BartonBandis(jrc=0, jcs=1e8, residual_friction=30)}, "give .*jrc above 0"),
    ],
)
def test_what_cannot_act_is_refused_with_its_cure(keys, told):
    with pytest.raises(bsm.ModelError, match=told):
        bsm.Joint("J", KN, **{"law": bsm.MohrCoulomb(friction=30), **keys})


def test_a_fillings_stiffness_is_its_own():
    filling = bsm.Filling(thickness=0.01, young=1e8, poisson=0.2)
    with pytest.raises(bsm.ModelError, match="a filling's shear stiffness is G over its thickness"):
        bsm.Joint("J", filling=filling, law=HARD, **POWER)
