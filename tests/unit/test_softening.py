"""Mohr-Coulomb that softens over a slip: strength between peak and residual, equilibrium, movement, what is refused."""

import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import bsm_mesh as bsm
from bsm_mesh.certificate.verify_certificate import strength_of
from bsm_mesh.model.joint_laws import MohrCoulomb, Weaker, memory_of
from bsm_mesh.results.evidence import law_table
from tests.scenes.models import model_of
from tests.scenes.shapes import rectangle, turned

LAW = MohrCoulomb(friction=40, cohesion=1e5, residual_friction=30, residual_cohesion=2e4, softening_slip=0.01)
PEAK, LEFT = np.tan(np.radians(40)), np.tan(np.radians(30))
FAR = 1e12


def respond(law, pressure, *, slid=0.0, trial=FAR, length=2.0, failed=False):
    one = np.ones(len(pressure))
    contacts = SimpleNamespace(failed=one < 2 * failed, slip_path=slid * one)
    return law.respond(pressure, trial * one, length * one, *memory_of(law, contacts))


@pytest.mark.parametrize(("slid", "worn"), [(0.0, 0.0), (0.0025, 0.25), (0.01, 1.0), (1.0, 1.0)])
def test_both_values_fall_linearly_with_slip(slid, worn):
    pressure = np.array([0.0, 1e4, 1e6])
    peak, residual = 2e5 + PEAK * pressure, 4e4 + LEFT * pressure
    answer = respond(LAW, pressure, slid=slid)
    assert_allclose(answer.strength, peak + worn * (residual - peak), rtol=1e-14)
    assert_array_equal(answer.failed, [worn == 1.0] * 3)
    assert_allclose(respond(LAW, pressure, slid=slid, failed=True).strength, residual)


def test_without_slip_nothing_fails_and_the_first_slip_takes_nothing():
    assert not respond(LAW, np.array([1e4])).failed.any()
    assert not respond(LAW, np.array([0.0]), slid=1.0, trial=0.0).failed.any()  # does not touch


def test_derivative_by_pressure():
    pressure = np.array([1e3, 1e5, 1e7])
    step = 1e-6 * pressure
    ahead, behind = (respond(LAW, pressure + sign * step, slid=0.003).shear for sign in (1, -1))
    assert_allclose(respond(LAW, pressure, slid=0.003).by_pressure, (ahead - behind) / (2 * step), rtol=1e-6)


def test_the_weaker_of_two_rocks_softens():
    law = Weaker(LAW, MohrCoulomb(friction=60, cohesion=1e6))
    assert law.wear_length == 0.01
    pressure = np.array([1e5])
    assert_allclose(respond(law, pressure, slid=0.005).strength, respond(LAW, pressure, slid=0.005).strength)


@pytest.mark.parametrize("slid", [0.0, 0.004, 0.02])
def test_the_certificate_knows_the_strength_by_numbers_alone(slid):
    (table,) = json.loads(json.dumps(law_table((LAW,))))
    pressure, one = np.array([0.0, 1e4, 1e6]), np.ones(3)
    found = strength_of(table, pressure, 2 * one, one < 0, slid * one)
    assert_allclose(found, respond(LAW, pressure, slid=slid).strength, rtol=1e-12)


def test_a_softening_slip_without_anything_to_lose_is_refused():
    with pytest.raises(bsm.ModelError, match=r"softening_slip = 0.01 m never acts.*give residual_friction"):
        MohrCoulomb(friction=40, softening_slip=0.01)


def held(law, push, bolt_stiffness):
    """Return a block on a plane, pushed just above it, that a bolt to a wall holds."""
    young = bolt_stiffness * 3.0 / (np.pi * 0.025**2 / 4)
    polygons = [rectangle(-1, -1, 6, 0), rectangle(-3, -1, -1, 1), rectangle(0, 0, 2, 1)]
    return bsm.Model(
        blocks=bsm.Blocks.from_polygons(polygons, rock="r"),
        rocks=[bsm.Rock("r", unit_weight=25e3)],
        joints=[bsm.Joint("J", 1e11, 1e9, law=law)],
        default_joint="J",
        supports=[bsm.Fixed(blocks=[0, 1])],
        loads=[bsm.PointLoad(block=2, point=(1.0, 1e-3), force=(push, 0.0))],
        bolts=[bsm.Bolt(start=(-2.0, 1e-3), end=(1.0, 1e-3), kind="end_anchored", diameter=0.025, young=young)],
    )


@pytest.mark.parametrize("part", [0.3, 0.8, 3.0])
@pytest.mark.parametrize("scheme", ["continuation", "wang"])
def test_what_softens_comes_to_rest_where_the_rest_takes_over(part, scheme):
    """T = strength(s) + k u, u = s + strength(s) / ks, where the bolt is stiffer than the strength falls."""
    law = MohrCoulomb(friction=40, cohesion=2e4, residual_friction=25, softening_slip=2e-3)
    weight, k, ks = 25e3 * 2, 6e7, 2e9
    peak, left = 2 * 2e4 + weight * PEAK, weight * np.tan(np.radians(25))
    strength = peak + min(part, 1.0) * (left - peak)
    slip = part * 2e-3
    moved = slip + strength / ks
    results = bsm.run(held(law, strength + k * moved, k), bsm.Options(scheme=scheme, max_steps=3000))
    assert results.status == "stable"
    assert_allclose(results.stages[0].displacement[2, 0], moved, rtol=2e-3)
    assert_allclose(results.stages[0].evidence.slip_path[results.stages[0].contacts.length > 0.5], slip, rtol=3e-3)
    assert results.stages[0].contacts.utilisation.max() <= 1 + 1e-9


def slab(law, angle):
    polygons = [turned(p, angle) for p in (rectangle(-1, -1, 25, 0), rectangle(15, 0, 20, 1))]
    return model_of(polygons, law=law)


@pytest.mark.heavy
@pytest.mark.parametrize(("angle", "status"), [(39.8, "stable"), (40.2, "unstable")])
def test_a_slab_stands_up_to_its_peak_and_goes_beyond_it(angle, status):
    law = MohrCoulomb(friction=40, residual_friction=30, softening_slip=0.05)
    assert bsm.run(slab(law, angle)).status == status


def test_a_stage_goes_on_with_what_has_worn_off():
    """Pushed over the peak and let go, a block does not carry the same push again."""
    law = MohrCoulomb(friction=40, residual_friction=20, softening_slip=2e-3)
    weight, k = 25e3 * 2, 2e7
    push = 0.75 * weight * PEAK + k * 2e-3
    model = held(law, push, k)
    load = model.loads[0]
    pulled = bsm.PointLoad(block=2, point=load.point, force=(push + 0.3 * weight, 0.0))
    stages = [bsm.Stage(name="more", loads=(pulled,)), bsm.Stage(name="less", loads=())]
    results = bsm.run(model.replace(stages=stages))
    paths = [stage.evidence.slip_path[stage.contacts.length > 0.5] for stage in results.stages]
    assert (np.diff([path.max() for path in paths]) >= 0).all()
    assert paths[-1].max() > 1e-3


def test_rock_faces_soften_by_the_same_key():
    rock = bsm.Rock(
        "r", 25e3, cohesion=1e5, friction=40, residual_friction=30, residual_cohesion=2e4, softening_slip=0.01
    )
    assert rock.law == LAW
    assert replace(rock, softening_slip=None).law == replace(LAW, softening_slip=None)
