"""Rocks, joints and laws: rules of their numbers, and the moduli of Wang Eqs. 3.21-3.26."""

import math
import re

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm

RTOL = 1e-14  # a handful of operations


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (
            lambda: bsm.Rock("r", unit_weight=0, young=-1.0, poisson=0.2),
            "rock 'r': young = -1 Pa must be 1e-6 to 1e18 Pa",
        ),
        (
            lambda: bsm.Rock("r", unit_weight=0, young=1e9),
            "rock 'r': young is given without poisson; give poisson (0 to 0.5) as well",
        ),
        (lambda: bsm.Rock("r", unit_weight=0, young=1e9, poisson=0.5), "rock 'r': poisson = 0.5 must be 0 to 0.499"),
        (lambda: bsm.Rock("r", unit_weight=-1), "rock 'r': unit_weight = -1 N/m^3 must be 0 to 1e12 N/m^3"),
        (lambda: bsm.Rock("r", unit_weight=None), "rock 'r': unit_weight = None is not a finite number [N/m^3]"),
        (lambda: bsm.Rock("r", unit_weight=True), "rock 'r': unit_weight = True is not a finite number [N/m^3]"),
        (
            lambda: bsm.Rock("r", unit_weight=0, friction=90),
            "rock 'r': friction = 90 degrees must be at least 0 and below 90 degrees",
        ),
        (lambda: bsm.Rock("r", unit_weight=0, stiffness="wag"), "stiffness = 'wag' is unknown; did you mean 'wang'?"),
        (lambda: bsm.Rock(" ", unit_weight=0), "the name must be a non-empty text"),
        (lambda: bsm.Joint("J"), "joint 'J': needs normal_stiffness and shear_stiffness [Pa/m], or filling"),
        (lambda: bsm.Joint("J", normal_stiffness=1e9), "joint 'J': needs normal_stiffness and shear_stiffness"),
        (lambda: bsm.Joint("J", 0, 1e9), "joint 'J': normal_stiffness = 0 Pa/m must be 1 to 1e18 Pa/m"),
        (
            lambda: bsm.Joint("J", 1e9, 1e9, bsm.Filling(thickness=0.1, young=1e9, poisson=0.3)),
            "joint 'J': give normal_stiffness and shear_stiffness or filling, not both",
        ),
        (lambda: bsm.Filling(thickness=0, young=1e9, poisson=0.3), "filling: thickness = 0 m must be 1e-6 to 10 m"),
        (lambda: bsm.Patton(friction=math.nan), "law 'patton': friction = nan is not a finite number [degrees]"),
        (lambda: bsm.Patton(friction=None), "law 'patton': friction = None is not a finite number [degrees]"),
        (lambda: bsm.Patton(friction="30"), "law 'patton': friction = '30' is not a finite number [degrees]"),
        (
            lambda: bsm.Patton(friction=50, dilation=40),
            "law 'patton': friction + dilation = 90 degrees must be at least 0 and below 90",
        ),
        (
            lambda: bsm.MohrCoulomb(friction=30, cohesion=-1),
            "law 'mohr_coulomb': cohesion = -1 Pa must be 0 to 1e9 Pa",
        ),
    ],
)
def test_faults_say_thing_value_and_rule(make, message):
    with pytest.raises(bsm.ModelError, match=re.escape(message)):
        make()


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (
            lambda: bsm.Joint("J", 1e9, 1e9, tensile_strength=1e5),
            "joint 'J': tensile_strength = 100000 Pa never acts: a ",
        ),
        (
            lambda: bsm.Rock("schist", unit_weight=26e3, young=1e9, poisson=0.2, residual_friction=20),
            "rock 'schist': residual_friction = 20 never acts: faces of a rock without cohesion, friction and",
        ),
        (
            lambda: bsm.Filling(thickness=1e-6, young=1e13, poisson=0.3),
            "filling: normal_stiffness of young, poisson and thickness = 1.34615e+19 Pa/m must be 1 to 1e18 Pa/m",
        ),
        (
            lambda: bsm.library.rock("sandstones"),
            "the library has no unit weight of 'sandstones'; give it: unit_weight",
        ),
        (lambda: bsm.Fixed(blocks=[]), "support Fixed: blocks is empty: it holds nothing; give block numbers, or no"),
        (lambda: bsm.Stage(name="a", pressure=1e3), "stage 'a': pressure acts on surfaces that the stage lays bare"),
        (
            lambda: bsm.PointLoad(block=0, point=(0, 0), force=(1e29, 0)),
            "force x = 1e+29 N/m must be -1e13 to 1e13 N/m",
        ),
        (lambda: bsm.Pressure(boundary="b", pressure=(0, 1e29, 0)), "pressure: value = 1e+29 Pa/m must be -1e8 to 1e8"),
        (lambda: bsm.InSitu(surface=0.0, k0=(0, -5, 0)), "in_situ: k0 b = -5 must be 0 to 20"),
        (
            lambda: bsm.InSitu(method="gravity", surcharge=1e3),
            "in_situ: surcharge belongs to a surface; give the surface",
        ),
        (
            lambda: bsm.Options(tolerance=0.05),
            "solver: tolerance = 0.05 must be 1e-12 to 1e-4; with a greater one blocks",
        ),
        (lambda: bsm.Options(max_steps=True), "solver: max_steps = True is not a finite number"),
    ],
)
def test_what_was_once_taken_is_refused(make, message):
    with pytest.raises(bsm.ModelError, match=re.escape(message)):
        make()


def test_all_faults_of_a_rock_come_at_once():
    with pytest.raises(bsm.ModelError) as caught:
        bsm.Rock("r", unit_weight=-1, young=0, poisson=0.7)
    assert len(caught.value.faults) == 3


def test_numpy_numbers_become_plain_ones():
    rock = bsm.Rock("r", unit_weight=np.int64(26000), young=np.float32(1e9), poisson=np.float64(0.25))
    assert type(rock.unit_weight) is int
    assert type(rock.young) is float
    assert type(rock.contact_moduli[0]) is float


@pytest.mark.parametrize("mu", [0.0, 0.15, 0.25, 0.35, 0.49])
def test_contact_moduli_of_the_named_choices(mu):
    E = 3e9
    G, lame = E / (2 * (1 + mu)), E * mu / ((1 + mu) * (1 - 2 * mu))
    moduli = {
        name: bsm.Rock("r", unit_weight=0, young=E, poisson=mu, stiffness=name).contact_moduli
        for name in ("wang", "homogeneous", "triangle", "rigid")
    }
    assert_allclose(moduli["wang"], (lame + 2 * G, G), rtol=1e-12)  # E' = lambda + 2 G
    assert_allclose(moduli["homogeneous"], (E / (1 - mu**2),) * 2, rtol=RTOL)
    assert_allclose(moduli["triangle"], (2 * (lame + G), 2 * G * (lame + G) / (2 * lame + G)), rtol=1e-12)
    assert moduli["rigid"] == (math.inf, math.inf)


def test_rigid_without_young():
    assert bsm.Rock("r", unit_weight=0).is_rigid
    assert bsm.Rock("r", unit_weight=0, young=1e9, stiffness="rigid").is_rigid
    assert not bsm.Rock("r", unit_weight=0, young=1e9, poisson=0.2).is_rigid


def test_the_library_has_both_argillites_and_the_ranges_of_appendix_a():
    """Wang Tables 8.3 and A.1 (a tenth of its modulus); A.1's ranges of limestones, A.3's of argillite joints."""
    used, other = bsm.library.rock("argillite"), bsm.library.rock("argillites of table a.1")
    assert (used.young, used.poisson, used.unit_weight) == (21e9, 0.24, 28.2e3)
    assert (other.young, other.poisson, other.unit_weight) == (17.44e9, 0.23, 26.7e3)
    entries = {entry.name: entry for entry in bsm.library.ROCKS}
    assert entries["crystalline limestones"].young_range == (17e9, 100e9)
    assert entries["low-durability shales"].poisson_range is None
    for entry in entries.values():
        for value, reported in ((entry.young, entry.young_range), (entry.poisson, entry.poisson_range)):
            assert reported is None or reported[0] <= value <= reported[1]
    strengths = {entry.name: entry for entry in bsm.library.STRENGTHS}
    assert strengths["argillite joints"].friction_range == (27.3, 33.0)
    assert bsm.library.strength("argillite joints").friction == pytest.approx(30.15)
