"""Barton and Bandis's law: the published formula, scale, wear of roughness, straight lines, and every scheme."""

import json
import warnings
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.certificate import verify_certificate
from bsm_mesh.certificate.verify_certificate import strength_of
from bsm_mesh.model.joint_laws import memory_of
from bsm_mesh.model.strength import reduced_law, with_strength
from bsm_mesh.results.evidence import law_table
from tests.scenes.models import model_of
from tests.scenes.shapes import rectangle, turned

LAW = bsm.BartonBandis(jrc=8, jcs=50e6, residual_friction=28)
STRESS = np.array([1e4, 1e5, 1e6, 5e6, 2e7])  # between the cap of 70 degrees and JCS
FAR = 1e15


def ask_far(law, stress, *, length=1.0, failed=False, slid=0.0, trial=FAR):
    one = np.ones(len(stress))
    contacts = SimpleNamespace(failed=one < 2 * failed, slip_path=slid * one)
    return law.respond(stress * length, trial * one, length * one, *memory_of(law, contacts))


def barton(stress, jrc, jcs, phi):
    """Barton and Choubey 1977, Eq. 4."""
    return stress * np.tan(np.radians(phi + jrc * np.log10(jcs / stress)))


def test_the_angle_is_70_degrees_at_most_and_not_below_the_residual_one():
    low, high = np.array([1e-3, 1.0]), np.array([5e7, 1e9])
    assert_allclose(ask_far(LAW, low).strength, low * np.tan(np.radians(70)), rtol=1e-12)
    assert_allclose(ask_far(LAW, high).strength, high * np.tan(np.radians(28)), rtol=1e-12)


def test_a_contact_that_failed_has_the_residual_friction():
    assert_allclose(ask_far(LAW, STRESS, failed=True).strength, STRESS * np.tan(np.radians(28)), rtol=1e-12)


@pytest.mark.parametrize(("slip", "left"), [(0, 1), (1, 0.85), (3, 0.7), (9, 0.5), (54, 0.25), (99, 0), (500, 0)])
def test_slip_behind_the_peak_wears_roughness_off(slip, left):
    """Barton, Bandis and Bakhtar 1985: displacement over that at the peak 1, 2, 4, 10, 100 leaves 1, .85, .7, .5, 0."""
    law = replace(LAW, roughness_wears=True, joint_length=1.0)
    strength = ask_far(law, STRESS[:4], slid=slip * law.peak_displacement).strength
    assert_allclose(strength, barton(STRESS[:4], left * law.roughness, law.wall_strength, 28), rtol=1e-9)
    assert_allclose(
        ask_far(replace(law, roughness_wears=False), STRESS, slid=1.0).strength, ask_far(law, STRESS).strength
    )


@pytest.mark.parametrize("law", [LAW, replace(LAW, roughness_wears=True), replace(LAW, jrc=20, joint_length=3.0)])
@pytest.mark.parametrize("trial", [-FAR, -1.0, FAR])
def test_derivative_by_pressure(law, trial):
    stress = np.array([1e2, 1e4, 3e5, 2.5e6, 1e7, 4e8])
    step = 1e-6 * stress
    ahead, behind = (ask_far(law, stress + sign * step, slid=3e-3, trial=trial).shear for sign in (1, -1))
    found = ask_far(law, stress, slid=3e-3, trial=trial)
    assert_allclose(found.by_pressure, (ahead - behind) / (2 * step), rtol=1e-6, atol=1e-9)


@pytest.mark.parametrize("jrc", [0, 0.5, 2, 8, 14, 20])
@pytest.mark.parametrize("phi", [15, 28, 45, 60])
def test_straight_lines_lie_above_the_strength_and_near_it(jrc, phi):
    """From 1 kPa to 0.2 JCS within 2 %; above that they may not bend towards residual friction beyond JCS."""
    law = bsm.BartonBandis(jrc=jrc, jcs=50e6, residual_friction=phi)
    stress = np.logspace(0, 10, 2001)
    slope, intercept = law.strength_lines(np.array([2.0]))
    lines = (intercept[0] / 2.0 + slope[0] * stress[:, None]).min(axis=1)
    over = lines / ask_far(law, stress).strength - 1
    assert over.min() > -1e-12
    near = (stress >= 1e3) & (stress <= 0.2 * law.wall_strength)
    assert over[near].max() < 0.02


def test_strength_reduction_divides_the_whole_strength():
    weaker = reduced_law(replace(LAW, roughness_wears=True), 1.25)
    plain = ask_far(replace(LAW, roughness_wears=True), STRESS, slid=0.01)
    assert_allclose(ask_far(weaker, STRESS, slid=0.01).strength, plain.strength / 1.25, rtol=1e-12)
    slope, intercept = LAW.strength_lines(np.ones(1))
    assert_allclose(weaker.strength_lines(np.ones(1)), (slope / 1.25, intercept / 1.25), rtol=1e-12)


@pytest.mark.parametrize("failed", [False, True])
@pytest.mark.parametrize("law", [LAW, replace(LAW, roughness_wears=True, joint_length=2.0), replace(LAW, jrc=0)])
def test_the_certificate_knows_the_strength_by_numbers_alone(law, failed):
    for told, factor in ((law, 1.0), (reduced_law(law, 1.5), 1.5)):
        (table,) = json.loads(json.dumps(law_table((told,))))
        stress, one = np.array([0.0, 1.0, *STRESS, 1e9]), np.ones(8)
        found = strength_of(table, 2 * stress, 2 * one, one < 2 * failed, 4e-3 * one)
        expected = ask_far(law, stress, length=2.0, failed=failed, slid=4e-3).strength / factor
        assert_allclose(found, expected, rtol=1e-12, atol=1e-300)


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ({"jrc": 21}, "jrc = 21 must be 0 to 20"),
        ({"jcs": 10}, "jcs = 10 Pa"),
        ({"residual_friction": 70}, "residual_friction = 70 degrees"),
        ({"joint_length": 0.05}, "joint_length = 0.05 m"),
        ({"roughness_wears": "yes"}, "roughness_wears = 'yes' must be true or false"),
    ],
)
def test_bad_values_are_told_with_the_range(keys, words):
    with pytest.raises(bsm.ModelError, match=f"law 'barton_bandis': {words}"):
        replace(LAW, **keys)


def slab(law, angle, height=0.5, width=10.0):
    """Return a wide slab on a plane of this angle, a block each."""
    polygons = [turned(p, angle) for p in (rectangle(-1, -1, 12, 0), rectangle(0, 0, width, height))]
    return model_of(polygons, law=law)


def steepest(law, height=0.5):
    """Return the angle at which a slab slides: friction angle at the stress 25 kN/m3 h cos(angle), a fixed point."""
    angle = 30.0
    for _ in range(200):
        stress = 25e3 * height * np.cos(np.radians(angle))
        angle = law.residual_friction + law.roughness * np.log10(law.wall_strength / stress)
    return angle


FLAT = bsm.BartonBandis(jrc=4, jcs=20e6, residual_friction=25, joint_length=2.0)


@pytest.mark.heavy
@pytest.mark.parametrize("law", [FLAT, replace(FLAT, roughness_wears=True)])
@pytest.mark.parametrize("scheme", ["continuation", "wang"])
@pytest.mark.parametrize(("beyond", "stable"), [(-0.3, True), (0.3, False)])
def test_a_slab_slides_at_bartons_angle(law, scheme, beyond, stable):
    model = slab(law, steepest(law) + beyond)
    results = bsm.run(model, bsm.Options(scheme=scheme, sliding_stiffness=0.01 if scheme == "wang" else 1.0))
    assert (results.status == "stable") == stable
    assert not stable or results.check().ok
    assert scheme == "wang" or results.status == ("stable" if stable else "unstable")


def test_the_linear_scheme_reports_the_utilisation():
    contacts = bsm.run(slab(FLAT, 20.0), bsm.Options(scheme="linear")).stages[0].contacts
    stress = -contacts.normal_force / contacts.length
    expected = np.abs(contacts.shear_force) / contacts.length
    expected /= barton(stress, FLAT.roughness, FLAT.wall_strength, 25)
    assert_allclose(contacts.utilisation, expected, rtol=1e-10)


def test_the_factor_of_safety_is_the_strength_over_the_shear():
    angle = 35.0
    stress = 25e3 * 0.5 * np.cos(np.radians(angle))
    expected = np.tan(np.radians(25 + FLAT.roughness * np.log10(FLAT.wall_strength / stress))) / np.tan(
        np.radians(angle)
    )
    found = bsm.factor_of_safety(slab(FLAT, angle))
    assert_allclose([found.stable, found.unstable], expected, rtol=0.01)
    assert found.limit.factor > expected * (1 - 1e-4)


def test_limit_analysis_bounds_the_pull_from_above():
    pulled = bsm.PointLoad(block=1, point=(5.0, 0.25), force=(1e3, 0.0))
    stress = 25e3 * 0.5
    strength = 10.0 * barton(stress, FLAT.roughness, FLAT.wall_strength, 25)
    found = bsm.limit_analysis(slab(FLAT, 0.0), [pulled]).factor * 1e3
    assert strength * (1 - 1e-9) <= found <= 1.01 * strength


@pytest.mark.heavy
@pytest.mark.parametrize("reduction", [1.0, 1.3])
@pytest.mark.parametrize("law", [FLAT, replace(FLAT, roughness_wears=True)])
@pytest.mark.parametrize("beyond", [-1.0, 1.0])
def test_verdicts_bear_out_by_their_certificates_alone(tmp_path, law, reduction, beyond):
    """Stable by the formula of the strength; unstable by a mechanism whose lines lie above it."""
    angle = np.degrees(np.arctan(np.tan(np.radians(steepest(law))) / reduction))
    model = with_strength(slab(law, angle + beyond), {"J": 1 / reduction})
    results = bsm.run(model)
    assert results.status == ("stable" if beyond < 0 else "unstable")
    assert beyond < 0 or results.stages[0].proof.witness is not None
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", bsm.ResultsWarning)  # a reduced law has no form in a model file
        results.save(tmp_path / "out")
    assert verify_certificate.main(tmp_path / "out") == 0
