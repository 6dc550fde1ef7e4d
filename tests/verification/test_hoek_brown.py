"""Zones that yield by Hoek and Brown: return and tangent, closed forms of strength, strength reduction, a hole."""

from __future__ import annotations

from dataclasses import replace
from math import asin, degrees, exp, sqrt

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.optimize import brentq

import bsm_mesh as bsm
from bsm_mesh.modelfile.build_parts import make_rock
from bsm_mesh.modelfile.material_tables import RockTable
from bsm_mesh.solve.zones.hoek_brown import HoekBrownYielding
from bsm_mesh.solve.zones.mohr_coulomb import Yielding
from tests.scenes.hoek_brown_hole import HoekBrownHole
from tests.scenes.plastic_zones import slope
from tests.scenes.yield_surfaces import LAME, SHEAR, TANGENT, tangent_error, trials

CURVE = bsm.HoekBrown(sigma_ci=30e6, mb=1.7, s=0.039, a=0.5)
CUT = replace(CURVE, tensile_strength=2e5)
POOR = bsm.HoekBrown(sigma_ci=30e6, gsi=20, mi=10)
ROCKS = {
    "dilation 10": HoekBrownYielding(LAME, SHEAR, CUT, 10),
    "dilation 0, whole curve": HoekBrownYielding(LAME, SHEAR, CURVE, 0),
    "associated": HoekBrownYielding(LAME, SHEAR, CUT, 89),
    "by GSI": HoekBrownYielding(LAME, SHEAR, POOR, 5),
    "weaker": HoekBrownYielding(LAME, SHEAR, replace(CUT, reduction=1.5), 10),
    "stronger, by GSI": HoekBrownYielding(LAME, SHEAR, replace(POOR, reduction=0.7), 89),
}


@pytest.mark.parametrize("name", ROCKS)
def test_stresses_return_to_the_yield_surface(name):
    """And on every face, edge and corner of it some of them do."""
    rock, trial = ROCKS[name], trials()
    found = rock.returned(trial)
    assert rock.excess(-np.sort(-found.principal, axis=1)).max() < 1e-7 * 2e7
    assert_allclose(rock.returned(found.stress).stress, found.stress, atol=1e-7 * 2e7)
    elastic = found.set == 0
    assert_allclose(found.stress[elastic], trial[elastic])
    if name == "dilation 10":
        assert set(found.set) == set(range(11))


@pytest.mark.parametrize("name", ROCKS)
def test_the_tangent_is_the_derivative(name):
    error, compared = tangent_error(ROCKS[name], trials())
    assert compared > 0.9
    assert error < TANGENT


def test_plastic_strain_never_creates_energy():
    """Also where the dilation angle is above the friction angle of the curve."""
    for rock in ROCKS.values():
        trial = trials(500)
        found = rock.returned(trial)
        bulk = LAME + 2 * SHEAR / 3
        taken = found.trial - -np.sort(-found.principal, axis=1)
        mean = taken.mean(axis=1, keepdims=True)
        strain = (taken - mean) / (2 * SHEAR) + mean / (3 * bulk)
        energy = np.einsum("ni,ni->n", strain, -np.sort(-found.principal, axis=1))
        assert energy.min() > -1e-6 * energy.max()


def test_closed_forms_of_the_strength():
    """In compression sigma_ci s^a, in tension s sigma_ci / mb; of intact rock sigma_ci and sigma_ci / mi."""
    rock = ROCKS["dilation 0, whole curve"]
    assert_allclose(rock.strength, 30e6 * sqrt(0.039), rtol=1e-12)
    assert_allclose(rock.cut_off[1:], 0.039 * 30e6 / 1.7, rtol=1e-6)
    intact = bsm.HoekBrown(sigma_ci=30e6, gsi=100, mi=10)
    assert_allclose(intact.constants, (10, 1, 0.5), rtol=1e-12)
    assert_allclose(HoekBrownYielding(LAME, SHEAR, intact, 0).strength, 30e6, rtol=1e-12)
    blasted = bsm.HoekBrown(sigma_ci=30e6, gsi=40, mi=10, disturbance=1)
    assert_allclose(blasted.constants[:2], (10 * exp(-60 / 14), exp(-60 / 6)), rtol=1e-12)


@pytest.mark.parametrize("factor", [1.0, 1.6, 0.8])
@pytest.mark.parametrize("dilation", [0.0, 12.0])
def test_a_straight_curve_is_that_of_mohr_and_coulomb(factor, dilation):
    """Of a = 1, where N - 1 = mb and 2 c sqrt(N) = s sigma_ci; reduced by cohesion and tan(friction)."""
    mb, s, unit = 2.0, 0.04, 30e6
    friction, cohesion = asin(mb / (mb + 2)), s * unit / (2 * sqrt(1 + mb))
    curve = bsm.HoekBrown(sigma_ci=unit, mb=mb, s=s, a=1.0, tensile_strength=1e5, reduction=factor)
    ours = HoekBrownYielding(LAME, SHEAR, curve, dilation)
    reduced = degrees(np.arctan(np.tan(friction) / factor))
    theirs = Yielding(LAME, SHEAR, cohesion / factor, reduced, dilation, 1e5)
    found, exact = ours.returned(trials()), theirs.returned(trials())
    assert_allclose(found.stress, exact.stress, atol=1e-8 * 2e7)
    rows = np.arange(len(found.set))
    assert_allclose(ours.tangent(found, rows), theirs.tangent(exact, rows), atol=1e-6 * LAME)


@pytest.mark.parametrize("factor", [1.7, 0.6])
@pytest.mark.parametrize("curve", [CURVE, POOR])
def test_reduction_divides_the_envelope_of_shear_strength(curve, factor):
    """Circles of the reduced rock touch the given envelope over the factor, and stay below it (Hammah et al. 2005)."""
    y = np.geomspace(1e-6, 3, 4000)
    whole, part = (HoekBrownYielding(LAME, SHEAR, replace(curve, reduction=by), 0).envelope(y) for by in (1.0, factor))
    normal, shear = whole.centre + whole.radius * whole.sine, whole.radius * np.sqrt(1 - whole.sine**2)
    for k in range(500, 3500, 300):
        on = np.abs(normal - part.centre[k]) < part.radius[k]
        circle = np.sqrt(part.radius[k] ** 2 - (normal[on] - part.centre[k]) ** 2)
        below = (shear[on] / factor - circle) / part.radius[k]
        assert -1e-9 < below.min() < 1e-4
    assert_allclose(part.d_radius, -part.sine * part.d_centre, rtol=1e-6, atol=1e-9 * curve.sigma_ci)


def column(pressure, strength):
    """Return a column under a pressure, and a second stage with a part of its strength."""
    blocks = bsm.Blocks.from_polygons([[(0, 0), (1, 0), (1, 2), (0, 2)]], rock="rock")
    for name, where in {
        "low": lambda x, y: y < 1e-9,
        "top": lambda x, y: y > 2 - 1e-9,
        "left": lambda x, y: x < 1e-9,
    }.items():
        blocks = blocks.with_boundary(name, where)
    zones = bsm.Zones(size=2.0, order=1, law="hoek_brown")
    rock = bsm.Rock("rock", unit_weight=0.0, young=5e9, poisson=0.3, zones=zones, hoek_brown=CURVE)
    return bsm.Model(
        blocks=blocks,
        rocks=[rock],
        supports=[bsm.NormalRoller(boundary="low"), bsm.NormalRoller(boundary="left")],
        loads=[bsm.Pressure(boundary="top", pressure=pressure)],
        stages=[bsm.Stage(name="weaker", strength={"rock:rock": strength})],
    )


@pytest.mark.heavy
def test_a_column_carries_its_uniaxial_strength():
    """sigma_ci s^a, and with reduced strength that of the circle through s1 = 0 that touches the reduced envelope."""
    whole, factor = 30e6 * sqrt(0.039), 1.4
    envelope = HoekBrownYielding(LAME, SHEAR, CURVE, 0).envelope(np.geomspace(1e-6, 1, 20_001))
    normal, shear = envelope.centre + envelope.radius * envelope.sine, envelope.radius * np.sqrt(1 - envelope.sine**2)
    reduced = 2 * brentq(lambda r: np.hypot(normal + r, shear / factor).min() - r, whole / 5, whole / 2)
    for strength, most in ((1.0, whole), (1 / factor, reduced)):
        assert bsm.run(column(0.99 * most, strength)).status == "stable"
        assert bsm.run(column(1.01 * most, strength)).status != "stable"


def test_a_coarse_hole_has_the_radius_of_the_closed_form():
    """The plastic radius within 1 %; verify accepts the certificate."""
    hole = HoekBrownHole()
    results = bsm.run(hole.model(12, 6, dilation=10.0))
    assert results.status == "stable"
    assert results.check().ok
    assert abs(hole.errors(results.stages[-1].zones)[1]) < 0.01


@pytest.mark.heavy
@pytest.mark.parametrize("dilation", [0.0, 10.0, 89.0])
@pytest.mark.parametrize(
    "curve", [None, pytest.param(bsm.HoekBrown(sigma_ci=30e6, gsi=50, mi=8), marks=pytest.mark.slow)]
)
def test_hole_of_carranza_torres_and_fairhurst(curve, dilation):
    """Stresses, plastic radius and convergence within .5 %; associated flow too."""
    hole = HoekBrownHole(curve)
    if curve is None and dilation < 20:
        assert_allclose(hole.followed(dilation), hole.convergence(dilation), rtol=1e-8)
    zones = bsm.run(hole.model(30, 24, dilation=dilation)).stages[-1].zones
    stress, radius, _ = hole.errors(zones)
    assert stress < 5e-3
    assert abs(radius) < 5e-3
    assert_allclose(hole.wall(zones), hole.followed(dilation), rtol=5e-3)


@pytest.mark.slow
def test_factor_of_the_slope_of_hammah_and_others():
    """1.15 by strength reduction there, 1.153 by Bishop's method (ARMA/USRMS 05-810, Example 1)."""
    model = slope(run=1.0, young=5e9)
    zones = replace(model.rocks[0].zones, law="hoek_brown")
    curve = bsm.HoekBrown(sigma_ci=30e6, gsi=5, mi=2)
    rock = bsm.Rock("soil", unit_weight=25e3, young=5e9, poisson=0.3, zones=zones, hoek_brown=curve)
    found = bsm.factor_of_safety(model.replace(rocks=[rock]), tolerance=0.02)
    assert found.is_closed
    assert found.unstable > 0.98 * 1.15
    assert found.stable < 1.02 * 1.15


def test_the_model_file_takes_the_strength():
    """By index and by constants; a written model reads back."""
    rock = HoekBrownHole().rock(2, 10.0)
    from_file = {"unit_weight": 0.0, "young": "5.5 GPa", "poisson": 0.25}
    from_file["zones"] = {"law": "hoek_brown", "dilation": 10}
    from_file["hoek_brown"] = {"sigma_ci": "30 MPa", "mb": 1.7, "s": 0.0039, "a": 0.5}
    assert make_rock("rock", RockTable.model_validate(from_file)) == rock


def given(**changes):
    return bsm.HoekBrown(**{"sigma_ci": 30e6, "gsi": 50, "mi": 10, **changes})


REFUSED = [
    (lambda rock: replace(rock, cohesion=1e6), "leave cohesion, friction and tensile_strength out"),
    (lambda rock: replace(rock, hoek_brown=None), "give hoek_brown, with sigma_ci"),
    (lambda rock: replace(rock, zones=bsm.Zones()), "give zones = "),
    (lambda rock: given(mb=1.0), "give gsi and mi, or mb, s and a; given: gsi, mi, mb"),
    (lambda rock: bsm.HoekBrown(sigma_ci=30e6, mb=1.0, s=1.0, a=0.5, disturbance=0.5), "leave it out"),
    (lambda rock: given(gsi=120), "gsi = 120 must be"),
]


@pytest.mark.parametrize(("make", "words"), REFUSED)
def test_contradictions_are_refused(make, words):
    with pytest.raises(bsm.ModelError, match=words):
        make(HoekBrownHole().rock(2, 0.0))
