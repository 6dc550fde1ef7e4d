"""Limits of any number of a model, and the number that gives the measurement."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

import bsm_mesh as bsm
from bsm_mesh.model.changes import change_of, tilted_left, with_load_factor, with_water_rise
from bsm_mesh.safety.limits import limit_value
from bsm_mesh.safety.measurements import Measured, back_analysis
from tests.scenes.models import model_of
from tests.scenes.plane_failure import hoek_and_bray
from tests.scenes.shapes import rectangle, turned

DIP = 30.0


def incline(friction=40.0, **given):
    polygons = [turned(p, DIP) for p in (rectangle(-20, -5, 5, 0), rectangle(-1, 0, 1, 0.5))]
    return model_of(polygons, friction=friction, kn=1e10, **given)


def contains(found, exact, width):
    """Assert that a bracket is closed, as narrow as asked, and contains the exact value."""
    assert found.is_closed
    low, high = sorted((found.stable, found.unstable))
    assert high - low <= width
    assert low - 1e-4 * abs(exact) <= exact <= high + 1e-4 * abs(exact)


@pytest.mark.slow
def test_least_friction_of_an_incline():
    """The range runs down: from stable to failing."""
    found = limit_value(incline, 40.0, 20.0, quantity="friction")
    contains(found, DIP, 0.005 * 20)
    assert found.stable > found.unstable
    assert str(found).startswith("friction 30: stable there")


@pytest.mark.slow
def test_greatest_load_on_an_incline():
    """A force down the incline on a block of weight W: W sin a + k F = W cos a tan(phi)."""
    a, W = np.radians(DIP), 25e3  # N: one m2
    down = np.array([-np.cos(a), -np.sin(a)])
    at = tuple(turned(np.array([[0.0, 0.25]]), DIP)[0])
    model = incline().replace(loads=[bsm.PointLoad(block=1, point=at, force=tuple(1e3 * down))])
    weight = float(model.weights[1])
    exact = weight * (np.cos(a) * np.tan(np.radians(40.0)) - np.sin(a)) / 1e3
    found = limit_value(partial(with_load_factor, model, number=1), 0.0, 20.0, quantity="load.1.factor")
    contains(found, exact, 0.1)
    assert W > 0


TOP = bsm.Pressure(boundary="top", pressure=(1e3, 10.0, 0.0))
LOADS = [
    bsm.PointLoad(block=1, point=(0.5, 1.5), force=(1e3, -2e3)),
    TOP,
    bsm.Traction(boundary="top", traction=((500.0, 0.0, 0.0), (-1e3, 0.0, 5.0))),
]


def wall_with(load):
    blocks = bsm.Blocks.from_polygons([rectangle(0, 0, 1, 1), rectangle(0, 1, 1, 2)], rock="rock")
    blocks = replace(blocks, boundaries={"top": np.array([6])})  # the edge from the third corner of the second block
    return model_of(blocks, gamma=0, joint=bsm.Joint("J1", 1e9, 1e9), loads=[load])


@pytest.mark.parametrize("load", LOADS, ids=lambda load: type(load).__name__)
def test_a_load_twice_as_great_moves_twice_as_far(load):
    linear = bsm.Options(scheme="linear")
    model = wall_with(load)
    once, twice = (bsm.run(with_load_factor(model, k, number=1), linear).stages[0].displacement for k in (1.0, 2.0))
    assert np.abs(once).max() > 1e-7
    np.testing.assert_allclose(twice, 2 * once, rtol=1e-9, atol=1e-18)


def change(name):
    return change_of(name.split(".")).apply


def test_loads_that_have_no_factor_are_told():
    model = wall_with(TOP).replace(stages=[bsm.Stage(name="rain", loads=[TOP])])
    doubled = change("stage.rain.load.1.factor")(model, 2.0)
    assert doubled.stages[0].loads[0].pressure == (2e3, 20.0, 0.0)
    assert doubled.loads == model.loads
    for name, says in {
        "stage.rian.load.1.factor": "did you mean 'rain'",
        "load.2.factor": "there are 1",
        "water.rise": "no water table",
    }.items():
        with pytest.raises(bsm.ModelError, match=says):
            change(name)(model, 2.0)
    stressed = model.replace(in_situ=bsm.InSitu(surface=2.0, k0=0.5), loads=[bsm.InSituTraction(boundary="top")])
    with pytest.raises(bsm.ModelError, match="no factor of its own"):
        with_load_factor(stressed, 2.0, number=1)
    assert change_of(["joint", "J1", "friction"]) is None


@pytest.mark.slow
def test_greatest_tilt():
    """A block on an incline of 30 degrees and 40 degrees of friction stands 10 degrees more."""
    found = limit_value(partial(tilted_left, incline()), 0.0, 20.0, quantity="tilt")
    contains(found, 10.0, 0.1)


@pytest.mark.heavy
def test_greatest_water_level():
    """Hoek & Bray's slope: the water in the crack at which limit equilibrium gives a factor of 1."""
    low, high = 1.0, 4.0
    while high - low > 1e-6:
        middle = (low + high) / 2
        stands = hoek_and_bray(zw=middle, cohesion=10e3).factor > 1
        low, high = (middle, high) if stands else (low, middle)
    found = limit_value(lambda zw: hoek_and_bray(zw=zw, cohesion=10e3).model(), 1.0, 4.0, tolerance=0.01)
    assert low - 0.031 < found.stable < low + 0.1  # where it slides a little it loses water, and may rest further down
    assert found.unstable <= found.stable + 0.031


def test_all_water_tables_rise():
    line = [(0.0, 0.0), (10.0, 2.0)]
    model = hoek_and_bray().model().replace(water=bsm.Water(table=line))
    stages = [bsm.Stage(name="wet", water=bsm.Water(table=[(0.0, 1.0)])), bsm.Stage(name="as before")]
    risen = with_water_rise(model.replace(stages=stages), 0.5)
    assert risen.water.table == (((0.0, 0.5), (10.0, 2.5)),)
    assert risen.stages[0].water.table == (((0.0, 1.5),),)
    assert risen.stages[1].water is None


@pytest.mark.parametrize(
    ("name", "says"),
    [
        ("load.3.factor", "there is no \\[\\[load\\]\\] number 3; there are 0"),
        ("stage.dig.load.1.factor", "there is no stage 'dig'"),
        ("water.rise", "no water table"),
    ],
)
def test_changes_that_cannot_be_made(name, says):
    with pytest.raises(bsm.ModelError, match=says):
        change(name)(incline(), 2.0)


def test_keys_of_a_file_are_no_changes():
    assert change_of(["gravity", "horizontal"]) is None


def test_a_range_must_be_one():
    with pytest.raises(bsm.ModelError, match="two different ends"):
        limit_value(incline, 30.0, 30.0)


def column(stiffness):
    """Return a block of 25 kN on a joint of two contacts: it settles by its weight over Kn and length."""
    return model_of([rectangle(-5, -1, 5, 0), rectangle(-1, 0, 1, 1)], kn=10.0**stiffness)


@pytest.mark.heavy
def test_back_analysis_of_a_stiffness():
    """Settlement w = W / (Kn L), so that log10 Kn = log10(W / (L w)); its scatter follows from that of w."""
    weight = float(column(8.0).weights[1])
    exact = 8.3
    settlement = weight / (2.0 * 10**exact)
    measured = Measured(point=(0.0, 0.5), component="y", movement=-settlement, deviation=0.1 * settlement)
    found = back_analysis(column, 9.0, 7.5, [measured], quantity="log Kn", tolerance=0.002)
    assert found.value == pytest.approx(exact, abs=0.004)
    assert found.deviation == pytest.approx(0.1 / np.log(10), rel=0.1)
    (estimate,) = found.estimates
    assert estimate.low < found.value < estimate.high
    assert str(found).startswith("log Kn = 8.3")


@pytest.mark.heavy
def test_several_measurements_are_weighed():
    weight = float(column(8.0).weights[1])
    rows = [(8.2, 0.02), (8.4, 0.04)]
    measured = [
        Measured(point=(0.0, 0.5), movement=weight / (2 * 10**log), deviation=part * weight / (2 * 10**log))
        for log, part in rows
    ]
    found = back_analysis(column, 9.0, 7.5, measured, tolerance=0.001)
    assert found.value == pytest.approx((4 * 8.2 + 8.4) / 5, abs=0.01)


def test_what_is_out_of_range_is_told():
    measured = Measured(point=(0.0, 0.5), movement=1.0)
    found = back_analysis(column, 9.0, 7.5, [measured])
    assert found.value is None
    assert str(found) == "value: no value in the range gives the measurement"
    with pytest.raises(bsm.ModelError, match="is in no block"):
        back_analysis(column, 9.0, 7.5, [Measured(point=(99.0, 0.5), movement=1.0)])
    with pytest.raises(bsm.ModelError, match="give a movement"):
        back_analysis(column, 9.0, 7.5, [])
