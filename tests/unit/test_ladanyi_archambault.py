"""Ladanyi and Archambault's law: its limits, the published formula, derivative, lines above it, certificate."""

import json

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.certificate.verify_certificate import strength_of
from bsm_mesh.results.evidence import law_table
from tests.unit.test_barton_bandis import slab

LAW = bsm.LadanyiArchambault(friction=30, dilation=15, jcs=40e6)
FAR = 1e15


def respond(law, stress, *, failed=False, length=1.0):
    one = np.ones(len(stress))
    return law.respond(stress * length, FAR * one, length * one, one < 2 * failed)


def published(stress, phi, i, c):
    """Wang Eq. 4.3 with a_s = 1 - (1 - s/c)^1.5, D = (1 - s/c)^4 tan i, and Fairhurst's strength of rock, n = 10."""
    a, dilation = 1 - (1 - stress / c) ** 1.5, (1 - stress / c) ** 4 * np.tan(np.radians(i))
    rock = c * (np.sqrt(11) - 1) / 10 * np.sqrt(1 + 10 * stress / c)
    tan = np.tan(np.radians(phi))
    return (stress * (1 - a) * (dilation + tan) + a * rock) / (1 - (1 - a) * dilation * tan)


@pytest.mark.parametrize("dilation", [0, 15, 50])
def test_derivative_by_pressure(dilation):
    law = bsm.LadanyiArchambault(friction=30, dilation=dilation, jcs=40e6)
    stress = np.array([1e2, 1e5, 1e6, 1e7, 3.5e7, 1e8])
    step = 1e-6 * stress
    ahead, behind = (respond(law, stress + sign * step).shear for sign in (1, -1))
    assert_allclose(respond(law, stress).by_pressure, (ahead - behind) / (2 * step), rtol=1e-6)


@pytest.mark.parametrize("phi", [0, 20, 30, 50])
@pytest.mark.parametrize("dilation", [0, 15, 35])
def test_straight_lines_lie_above_the_strength_and_near_it(phi, dilation):
    """Within 2 % from 1 kPa to a tenth of the wall strength; but where asperities are flat the law is not concave."""
    law = bsm.LadanyiArchambault(friction=phi, dilation=dilation, jcs=40e6)
    stress = np.logspace(0, 11, 5003)
    slope, intercept = law.strength_lines(np.array([2.0]))
    over = (intercept[0] / 2 + slope[0] * stress[:, None]).min(axis=1) / respond(law, stress).strength - 1
    assert over.min() > -1e-9
    near = (stress >= 1e3) & (stress <= 4e6)
    assert over[near].max() < (0.02 if phi and dilation else 1.5)
    assert (slope >= 0).all()
    assert (intercept >= 0).all()


@pytest.mark.parametrize("failed", [False, True])
def test_the_certificate_knows_the_strength_by_numbers_alone(failed):
    (table,) = json.loads(json.dumps(law_table((LAW,))))
    stress, one = np.array([0.0, 1.0, 1e5, 1e7, 1e9]), np.ones(5)
    found = strength_of(table, 2 * stress, 2 * one, one < 2 * failed, 0 * one)
    assert_allclose(found, respond(LAW, stress, failed=failed, length=2.0).strength, rtol=1e-12)


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ({"dilation": 60}, r"friction \+ dilation = 90 degrees"),
        ({"friction": -1}, "friction = -1 degrees"),
        ({"jcs": 0}, "jcs = 0 Pa"),
    ],
)
def test_bad_values(keys, words):
    with pytest.raises(bsm.ModelError, match=f"law 'ladanyi_archambault': {words}"):
        bsm.LadanyiArchambault(**({"friction": 30, "dilation": 10, "jcs": 40e6} | keys))


FLAT = bsm.LadanyiArchambault(friction=20, dilation=8, jcs=40e6)


@pytest.mark.heavy
@pytest.mark.parametrize("scheme", ["continuation", "wang"])
@pytest.mark.parametrize(("beyond", "stable"), [(-0.3, True), (0.3, False)])
def test_a_slab_slides_at_its_strength(scheme, beyond, stable):
    angle = 30.0
    for _ in range(200):
        stress = 25e3 * 0.5 * np.cos(np.radians(angle))
        angle = np.degrees(np.arctan(published(stress, 20, 8, 40e6) / stress))
    options = bsm.Options(scheme=scheme, sliding_stiffness=0.01 if scheme == "wang" else 1.0)
    assert (bsm.run(slab(FLAT, angle + beyond), options).status == "stable") == stable


def test_limit_analysis_bounds_the_pull_from_above():
    pulled = bsm.PointLoad(block=1, point=(5.0, 0.25), force=(1e3, 0.0))
    strength = 10.0 * published(12.5e3, 20, 8, 40e6)
    found = bsm.limit_analysis(slab(FLAT, 0.0), [pulled]).factor * 1e3
    assert strength * (1 - 1e-9) <= found <= 1.02 * strength
