"""Reduced strength: of laws, of joints and rocks by name, of bolts."""

import dataclasses
import math

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import bsm_mesh as bsm
from bsm_mesh.errors import ModelError
from bsm_mesh.model.joint_laws import Elastic, JointResponse, MohrCoulomb, Patton, Weaker
from bsm_mesh.model.law_faults import law_faults
from bsm_mesh.model.strength import Reduced, reduced_law, with_bolt_capacities, with_strength
from tests.scenes.models import model_of
from tests.scenes.shapes import rectangle

PRESSURE = np.array([0.0, 1e3, 1e5, 1e6, 1e8])
LAWS = [
    MohrCoulomb(friction=40, cohesion=2e5),
    MohrCoulomb(friction=40, cohesion=2e5, residual_friction=30, residual_cohesion=1e4),
    Patton(friction=30),
    Patton(friction=30, dilation=10, cohesion=0.5e6, residual_friction=25),
    Patton(friction=30, dilation=10, cohesion=0.5e6),
]
LAWS.append(Weaker(LAWS[0], LAWS[1]))


class Parabolic:
    """A law of the user's own: shear up to the root of the pressure, its slope finite at none."""

    def respond(self, pressure, trial_shear, length, failed):
        pressing = np.maximum(pressure, 0.0)
        strength = 300.0 * (np.sqrt(pressing + 1e3) - np.sqrt(1e3))
        sticking = np.abs(trial_shear) <= strength
        slope = np.where(pressure > 0, 150.0 / np.sqrt(pressing + 1e3), 0.0)
        return JointResponse(
            shear=np.where(sticking, trial_shear, np.copysign(strength, trial_shear)),
            by_pressure=np.where(sticking, 0.0, np.copysign(slope, trial_shear)),
            strength=strength,
            sticking=sticking,
            failed=failed.copy(),
        )


class Straight(Parabolic):
    """The same with lines above it."""

    def strength_lines(self, length):
        pressure = np.array([1e4, 1e6])
        slope = np.tile(150.0 / np.sqrt(pressure), (len(length), 1))
        return slope, np.tile(150.0 * np.sqrt(pressure), (len(length), 1))


def strength_of(law, *, failed, length=0.7):
    count = np.ones(len(PRESSURE))
    return law.respond(PRESSURE, 0 * count, length * count, np.full(len(PRESSURE), failed)).strength


@pytest.mark.parametrize("factor", [0.5, 1.3, 4.0])
@pytest.mark.parametrize("law", LAWS, ids=lambda law: type(law).__name__)
def test_every_line_of_a_law_is_divided(law, factor):
    weaker = reduced_law(law, factor)
    assert type(weaker) is type(law)
    for failed in (False, True):
        assert_allclose(strength_of(weaker, failed=failed), strength_of(law, failed=failed) / factor, rtol=1e-12)
    lines = zip(weaker.strength_lines(np.ones(3)), law.strength_lines(np.ones(3)), strict=True)
    for have, given in lines:
        assert_allclose(have, given / factor, rtol=1e-12)


@pytest.mark.parametrize("law", [*LAWS, Parabolic(), Straight()], ids=lambda law: type(law).__name__)
def test_a_factor_of_one_leaves_a_law_as_it_is(law):
    assert reduced_law(law, 1) == law


def test_what_is_brittle_stays_so_and_what_is_not_does_not_become_so():
    assert reduced_law(LAWS[1], 2).is_brittle
    assert not reduced_law(LAWS[0], 2).is_brittle


def test_elastic_has_nothing_to_divide():
    assert reduced_law(Elastic(), 3) == Elastic()


@pytest.mark.parametrize("factor", [0.5, 1.3])
@pytest.mark.parametrize("law", [Parabolic(), Straight()])
def test_a_law_of_the_users_own_is_divided_as_a_whole(law, factor):
    weaker = reduced_law(law, factor)
    assert law_faults(weaker, tension=False) == []
    assert_allclose(strength_of(weaker, failed=False), strength_of(law, failed=False) / factor, rtol=1e-15)
    trial = np.array([3e3, 1e4, -1e9])
    pressure, length, whole = np.array([1e6, 1e2, 1e6]), np.ones(3), np.zeros(3, dtype=bool)
    answer, given = weaker.respond(pressure, trial, length, whole), law.respond(pressure, factor * trial, length, whole)
    assert_array_equal(answer.sticking, [True, False, False])
    assert answer.shear[0] == trial[0]
    assert_allclose(answer.shear, given.shear / factor, rtol=1e-15)
    step = 1e-3
    ahead = weaker.respond(pressure + step, trial, length, whole)
    assert_allclose(answer.by_pressure[1:], ((ahead.shear - answer.shear) / step)[1:], rtol=1e-4)


def test_lines_of_a_law_of_the_users_own_are_divided_and_those_it_has_not_are_not_invented():
    slope, intercept = Straight().strength_lines(np.ones(2))
    have = reduced_law(Straight(), 2).strength_lines(np.ones(2))
    assert_array_equal(have[0], slope / 2)
    assert_array_equal(have[1], intercept / 2)
    assert not hasattr(reduced_law(Parabolic(), 2), "strength_lines")


@pytest.mark.heavy
def test_a_law_of_the_users_own_runs_at_another_strength_and_keeps_its_name():
    polygons = [rectangle(0, -1, 4, 0), rectangle(1, 0, 2, 1)]
    model = model_of(polygons, law=Parabolic(), gravity_horizontal=0.1)
    uneven = np.array([0.45, 0.55]) * 25e3  # pressures of both contacts: the resultant is 0.05 from the middle
    most = 300 * (np.sqrt(uneven + 1e3) - np.sqrt(1e3)).sum() / 25e3
    for factor, verdict in ((most / 0.1 * 0.99, "stable"), (most / 0.1 * 1.01, "unstable")):
        results = bsm.run(with_strength(model, {"J": 1 / factor}))
        assert results.status == verdict
        assert results.stages[0].evidence.laws[0]["name"] == "Parabolic"
    with pytest.raises(ModelError, match="the law Parabolic has no method strength_lines"):
        bsm.limit_analysis(with_strength(model, {"J": 0.5}))


def test_factors_of_a_law_of_the_users_own_multiply():
    law = Parabolic()
    assert reduced_law(reduced_law(law, 2), 3) == Reduced(law, 6)
    assert reduced_law(reduced_law(law, 2), 0.5) is law


@pytest.mark.parametrize("factor", [0.0, -1.0, math.nan, math.inf, 1e9, "2", None])
def test_factors_that_are_none_are_refused(factor):
    for act in (MohrCoulomb(friction=30).reduced, Patton(friction=30).reduced):
        with pytest.raises(ModelError, match=r"reduced strength: factor = .*"):
            act(factor)
    with pytest.raises(ModelError, match="reduced strength: factor"):
        reduced_law(Parabolic(), factor)


def test_a_strength_that_is_out_of_range_is_named_with_the_factor():
    with pytest.raises(ModelError, match=r"strength divided by 0\.001: law 'mohr_coulomb': cohesion = 1e\+10 Pa"):
        MohrCoulomb(friction=30, cohesion=1e7).reduced(1e-3)
    steep = MohrCoulomb(friction=80).reduced(1e-3).friction
    assert_allclose(math.tan(math.radians(90 - steep)), 1e-3 / math.tan(math.radians(80)), rtol=1e-9)


def model_with(*, joints, rocks):
    polygons = [rectangle(0, 0, 1, 1), rectangle(0, 1, 1, 2)]
    return bsm.Model(
        blocks=bsm.Blocks.from_polygons(polygons, rock=rocks[0].name),
        rocks=rocks,
        joints=joints,
        default_joint=joints[0].name,
        supports=[bsm.Fixed(blocks=[0])],
    )


STRONG = bsm.Rock(
    "granite", 26e3, young=1e10, poisson=0.2, cohesion=1e6, friction=45, tensile_strength=2e5, residual_friction=30
)
PLAIN = bsm.Rock("shale", 25e3, young=1e10, poisson=0.2)
JOINTS = [
    bsm.Joint("J1", 1e9, 1e9, law=MohrCoulomb(friction=45, cohesion=1e4), tensile_strength=5e3),
    bsm.Joint("J2", 1e9, 1e9, law=Patton(friction=30)),
    bsm.Joint("glued", 1e9, 1e9),
]


def test_joints_are_weakened_by_name_and_the_others_by_the_star():
    model = model_with(joints=JOINTS, rocks=[STRONG, PLAIN])
    weak = with_strength(model, {"J1": 0.5, "*": 0.8})
    one, two, glued = weak.joints
    assert_allclose([np.tan(np.radians(one.law.friction)), one.law.cohesion, one.tensile_strength], [0.5, 5e3, 2.5e3])
    assert_allclose(np.tan(np.radians(two.law.friction)), 0.8 * np.tan(np.radians(30)))
    assert glued == JOINTS[2]
    assert weak.rocks == model.rocks
    assert (one.normal_stiffness, one.shear_stiffness) == (1e9, 1e9)


def test_rocks_are_weakened_by_their_name_and_by_the_star():
    model = model_with(joints=JOINTS, rocks=[STRONG, PLAIN])
    for key in ("rock:granite", "rock:*"):
        weak = with_strength(model, {key: 0.5})
        rock, plain = weak.rocks
        assert_allclose([np.tan(np.radians(rock.friction)), rock.cohesion, rock.tensile_strength], [0.5, 5e5, 1e5])
        assert_allclose(np.tan(np.radians(rock.residual_friction)), 0.5 * np.tan(np.radians(30)))
        assert rock.residual_cohesion is None
        assert plain == PLAIN
        assert weak.joints == model.joints
    only = dataclasses.replace(PLAIN, tensile_strength=1e5)
    rock = with_strength(model_with(joints=JOINTS, rocks=[only]), {"rock:shale": 0.5}).rocks[0]
    assert (rock.friction, rock.cohesion, rock.tensile_strength) == (None, None, 5e4)


def test_strength_of_one_is_the_model_itself():
    model = model_with(joints=JOINTS, rocks=[STRONG])
    assert with_strength(model, {"J1": 1.0, "*": 1, "rock:*": 1.0}) is model
    assert with_strength(model, {}) is model


@pytest.mark.parametrize(
    ("factors", "message"),
    [
        ({"J3": 0.5}, r"there is no joint 'J3'; did you mean 'J[12]'\?"),
        ({"rock:granit": 0.5}, r"there is no rock 'granit'; did you mean 'granite'\?"),
        ({"glued": 0.5}, "joint 'glued' has no law"),
        ({"rock:shale": 0.5}, "rock 'shale' has no strength"),
        ({"J1": 0.0}, "J1 = 0 must be 1e-6 to 1e6"),
        ({"J1": "half"}, "J1 = 'half' is not a finite number"),
        (0.5, "must be a mapping by names"),
        ({"J1": 1e6}, r"joint 'J1': strength divided by 1e-06: law 'mohr_coulomb': cohesion = 1e\+10 Pa"),
        ({"rock:*": 1e4}, r"rock 'granite': strength divided by 0.0001: law 'mohr_coulomb': cohesion = 1e\+10 Pa"),
    ],
)
def test_factors_that_a_model_has_no_use_for_are_refused(factors, message):
    with pytest.raises(ModelError, match=message):
        with_strength(model_with(joints=JOINTS, rocks=[STRONG, PLAIN]), factors)


def test_all_faults_are_told_at_once():
    with pytest.raises(ModelError) as caught:
        with_strength(model_with(joints=JOINTS, rocks=[STRONG, PLAIN]), {"J3": 0.5, "glued": 0.5, "rock:x": -1})
    assert len(caught.value.faults) == 4


def bolted(**keys):
    polygons = [rectangle(0, 0, 1, 1), rectangle(0, 1, 1, 2)]
    bolt = bsm.Bolt(start=(0.5, 1.9), end=(0.5, 0.1), diameter=0.025, **keys)
    return model_of(polygons, bolts=[bolt])


def test_all_that_limits_a_bolt_is_multiplied():
    grouted = bolted(yield_strength=500e6, bond_strength=2e5, plate=1e5, bearing_stiffness=1e9, bearing_strength=60e6)
    given, weak = grouted.bolts[0], with_bolt_capacities(grouted, 0.5).bolts[0]
    for name in ("yield_force", "bond_capacity", "dowel_strength", "plate"):
        assert_allclose(getattr(weak, name), 0.5 * getattr(given, name), rtol=1e-12)
    assert (weak.dowel_stiffness, weak.axial_stiffness) == (given.dowel_stiffness, given.axial_stiffness)
    holes = bolted(hole_diameter=0.04, bond_steel_grout=2e6, bond_grout_rock=1e6, plate=math.inf)
    given, weak = holes.bolts[0], with_bolt_capacities(holes, 0.5).bolts[0]
    assert_allclose(weak.bond_capacity, 0.5 * given.bond_capacity)
    assert (weak.plate, weak.yield_force) == (math.inf, math.inf)


def test_a_pretension_that_a_weaker_bolt_does_not_bear_is_what_it_bears():
    anchored = bolted(kind="end_anchored", anchor_capacity=1e5, pretension=8e4)
    assert with_bolt_capacities(anchored, 0.9).bolts[0].pretension == 8e4
    assert with_bolt_capacities(anchored, 0.5).bolts[0].pretension == 5e4
    assert with_bolt_capacities(anchored, 1) is anchored


def test_capacities_out_of_range_name_the_bolt():
    with pytest.raises(ModelError, match=r"bolt 1.*capacities times 1e-06: .*yield_strength = 500 Pa"):
        with_bolt_capacities(bolted(yield_strength=500e6), 1e-6)
    with pytest.raises(ModelError, match="reduced strength: factor = 0"):
        with_bolt_capacities(bolted(), 0)
