"""Joint laws: strength lines, what is remembered, derivatives, and a law of the user's own."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from bsm_mesh.errors import ModelError
from bsm_mesh.model.joint_laws import Elastic, MohrCoulomb, Patton, Weaker

FAR = 1e12  # a trial shear beyond any strength


def tan(degrees):
    return np.tan(np.radians(degrees))


def respond(law, pressure, trial=FAR, length=1.0, failed=False):
    pressure = np.atleast_1d(np.asarray(pressure, dtype=float))
    full = np.ones_like(pressure)
    return law.respond(pressure, trial * full, length * full, np.full(len(pressure), failed))


def test_patton_bears_line_3_once_sheared_off():
    law = Patton(friction=30, dilation=10, cohesion=0.5e6, residual_friction=25)
    pressure = np.array([1e3, 1e6, 1e8])
    answer = respond(law, pressure, failed=True)
    assert_allclose(answer.shear, pressure * tan(25))
    assert answer.failed.all()
    assert respond(law, pressure, 0.0, failed=True).failed.all()


def test_patton_crosses_where_it_should():
    """Tan 40 Fn = C + tan 30 Fn with C = 0.5 MN: 1.91022 and 1.60287 MN."""
    law = Patton(friction=30, dilation=10, cohesion=0.5e6)
    crossing = 0.5e6 / (tan(40) - tan(30))
    answer = respond(law, [crossing * (1 - 1e-9), crossing * (1 + 1e-9)])
    assert_allclose([crossing, crossing * tan(40)], [1.91022e6, 1.60287e6], rtol=5e-6)
    assert_allclose(answer.strength, crossing * tan(40), rtol=2e-9)
    assert_allclose(answer.by_pressure, [tan(40), tan(30)])
    assert_array_equal(answer.failed, [False, True])  # slip over the asperities leaves them, slip through them not


def test_patton_slips_on_line_1_without_harm_and_sticks_unharmed():
    law = Patton(friction=30, dilation=10, cohesion=0.5e6)
    assert not respond(law, [1e4, 1e6]).failed.any()
    assert not respond(law, [1e8], trial=1e6).failed.any()


def test_patton_without_dilation_or_cohesion_is_plain_friction():
    answer = respond(Patton(friction=30), [0.0, 1e5])
    assert_allclose(answer.shear, [0, 1e5 * tan(30)])
    assert not answer.failed.any()


@pytest.mark.parametrize(
    "keys",
    [
        {},
        {"residual_friction": 25},
        {"residual_friction": 30, "dilation": 5},
        {"residual_friction": 30 + 1e-12, "dilation": 5},  # sums of angles round
        {"dilation": 1e-5},  # the lines cross beyond any pressure in rock
    ],
)
def test_a_cohesion_of_patton_that_cannot_act_is_refused(keys):
    cures = r"never acts.*mohr_coulomb \(bsm\.MohrCoulomb\).*dilation of the asperities, or a residual_friction below"
    with pytest.raises(ModelError, match=cures):
        Patton(friction=25, cohesion=1e5, **keys)


@pytest.mark.parametrize("keys", [{"dilation": 5}, {"residual_friction": 20}])
def test_a_first_line_of_patton_that_cannot_act_is_refused(keys):
    """Without cohesion the second line is below the first at every pressure."""
    with pytest.raises(ModelError, match=r"friction \+ dilation = .* never acts.*give the cohesion.*MohrCoulomb"):
        Patton(friction=25, **keys)


@pytest.mark.parametrize("keys", [{"dilation": 5}, {"residual_friction": 20}, {"dilation": 5, "residual_friction": 28}])
def test_a_cohesion_of_patton_that_is_accepted_acts(keys):
    law = Patton(friction=25, cohesion=1e5, **keys)
    assert respond(law, 1e9).strength < 1e9 * tan(law.friction + law.dilation)
    assert respond(law, 1e3).strength == pytest.approx(1e3 * tan(law.friction + law.dilation))


@pytest.mark.parametrize(
    ("law", "keys"),
    [
        (MohrCoulomb, {"friction": 35, "residual_friction": 35.1}),
        (MohrCoulomb, {"friction": 35, "cohesion": 1e6, "residual_friction": 60}),
        (Patton, {"friction": 35, "residual_friction": 60}),
        (Patton, {"friction": 30, "dilation": 5, "cohesion": 1e5, "residual_friction": 35.1}),
    ],
)
def test_a_joint_does_not_grow_stronger_by_failing(law, keys):
    with pytest.raises(ModelError, match=r"residual_friction = .* is above friction.*stronger by failing"):
        law(**keys)


def test_mohr_coulomb_loses_cohesion_by_slip():
    law = MohrCoulomb(friction=35, cohesion=1e5, residual_friction=30)
    peak = 1e5 * 2 + 1e6 * tan(35)
    below, above = respond(law, 1e6, peak * 0.999, 2.0), respond(law, 1e6, peak * 1.001, 2.0)
    assert below.sticking.all()
    assert not below.failed.any()
    assert not above.sticking.any()
    assert above.failed.all()
    assert_allclose(above.shear, peak)
    assert_allclose(respond(law, 1e6, failed=True).shear, 1e6 * tan(30))


def test_mohr_coulomb_without_anything_to_lose_does_not_fail():
    assert not respond(MohrCoulomb(friction=35), [0.0, 1e6]).failed.any()


def test_without_residual_values_slip_leaves_cohesion_whole_and_opening_takes_it():
    law = MohrCoulomb(friction=35, cohesion=1e5)
    slipped = respond(law, 1e6, 1e9, 2.0)
    assert not slipped.failed.any()
    assert_allclose(slipped.shear, 1e5 * 2 + 1e6 * tan(35))
    assert_allclose(respond(law, 1e6, 1e9, 2.0, failed=True).shear, 1e6 * tan(35))


def test_residual_cohesion_is_left_by_the_first_slip():
    law = MohrCoulomb(friction=35, cohesion=1e5, residual_cohesion=2e4)
    assert respond(law, 1e6, 1e9, 2.0).failed.all()
    assert_allclose(respond(law, 1e6, 1e9, 2.0, failed=True).shear, 2e4 * 2 + 1e6 * tan(35))


def test_a_residual_cohesion_above_the_peak_is_refused():
    with pytest.raises(ModelError, match=r"residual_cohesion = 200000 Pa is above cohesion = 100000 Pa"):
        MohrCoulomb(friction=35, cohesion=1e5, residual_cohesion=2e5)


@pytest.mark.parametrize("law", [MohrCoulomb(friction=35, cohesion=1e5), Patton(friction=30, dilation=5, cohesion=1e5)])
def test_under_tension_there_is_no_friction(law):
    answer = respond(law, -1e4)
    assert_allclose(answer.by_pressure, 0)
    assert_allclose(answer.strength, law.cohesion if isinstance(law, MohrCoulomb) else 0.0)


def test_elastic_has_no_limit():
    answer = respond(Elastic(), [-1e6, 0.0, 1e6])
    assert_allclose(answer.shear, FAR)
    assert answer.sticking.all()
    assert np.isinf(answer.strength).all()
    assert not answer.failed.any()


def test_weaker_follows_the_law_that_bears_less():
    """C = 0 at 45 degrees and c = 1 MPa at 20 degrees cross at 1 MPa / (tan 45 - tan 20)."""
    law = Weaker(MohrCoulomb(friction=45), MohrCoulomb(friction=20, cohesion=1e6, residual_cohesion=0))
    crossing = 1e6 / (tan(45) - tan(20))
    answer = respond(law, [0.5 * crossing, 2 * crossing])
    assert_allclose(answer.shear, [0.5 * crossing, 1e6 + 2 * crossing * tan(20)])
    assert_allclose(answer.strength, answer.shear)
    assert_allclose(answer.by_pressure, [1, tan(20)])
    assert_array_equal(answer.failed, [False, True])


LAWS = [
    Patton(friction=30, dilation=10, cohesion=0.5e6, residual_friction=25),
    MohrCoulomb(friction=35, cohesion=1e5, residual_friction=30),
    Weaker(MohrCoulomb(friction=45), MohrCoulomb(friction=20, cohesion=1e6)),
    Elastic(),
]


@pytest.mark.parametrize("trial", [0.0, 1e3, FAR])
@pytest.mark.parametrize("failed", [False, True])
@pytest.mark.parametrize("law", LAWS)
def test_derivative_by_pressure(law, failed, trial):
    pressure = np.array([1e4, 3e5, 2.5e6, 4e7])  # none on a corner of a law
    step = 1e-6 * pressure
    ahead, behind = (respond(law, pressure + sign * step, trial, failed=failed).shear for sign in (1, -1))
    found = respond(law, pressure, trial, failed=failed)
    assert_allclose(found.by_pressure, (ahead - behind) / (2 * step), rtol=1e-6, atol=1e-9)
    assert (np.abs(found.shear) <= found.strength).all()


@pytest.mark.parametrize("law", LAWS)
def test_a_response_changes_nothing_it_is_given(law):
    given = np.array([1e5, 1e6]), np.full(2, FAR), np.ones(2), np.zeros(2, dtype=bool)
    copies = [a.copy() for a in given]
    law.respond(*given)
    for array, copy in zip(given, copies, strict=True):
        assert_array_equal(array, copy)
