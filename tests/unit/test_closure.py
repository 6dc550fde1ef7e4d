"""Hyperbolic closure: the published curve, its inverse and tangent, in series with rock, in situ, in every scheme."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.contact.history import History
from bsm_mesh.joint_test import closure_test
from bsm_mesh.joint_test.specimen import Specimen, position_of
from bsm_mesh.model.joint_laws.closure import overlap_at, pressure_at
from tests.scenes.models import model_of
from tests.scenes.shapes import rectangle

KN, VM = 10e9, 2e-4


@pytest.mark.parametrize("rock", [0.0, 1e-11, 1e-9])
def test_pressure_and_overlap_are_each_others_inverse(rock):
    pressure = np.array([-1e5, 0.0, 1.0, 1e4, 1e6, 1e8, 3e9, 1e11])
    joint = np.full(8, KN), np.full(8, VM), np.full(8, rock)
    overlap = overlap_at(pressure, *joint)
    assert_allclose(pressure_at(overlap, *joint)[0], pressure, rtol=1e-9, atol=1e-6)
    assert (np.diff(overlap) > 0).all()


@pytest.mark.parametrize("rock", [0.0, 1e-11, 1e-9])
def test_the_tangent_is_the_difference_quotient(rock):
    overlap = np.array([-1e-5, 1e-6, 5e-5, 1.5e-4, 1.9e-4, 2.5e-4])
    joint = np.full(6, KN), np.full(6, VM), np.full(6, rock)
    step = 1e-7 * np.abs(overlap)
    ahead, behind = (pressure_at(overlap + sign * step, *joint)[0] for sign in (1, -1))
    assert_allclose(pressure_at(overlap, *joint)[1], (ahead - behind) / (2 * step), rtol=1e-6)


def test_closure_is_goodmans_and_bandis_hyperbola():
    """S = Kn v / (1 - v / vm), to and back."""
    curve = closure_test(bsm.Joint("J", KN, 1e9, law=bsm.MohrCoulomb(friction=30), max_closure=VM), 50e6, steps=40)
    v = curve.closure
    assert_allclose(curve.normal_stress, KN * v / (1 - v / VM), rtol=1e-9, atol=1.0)
    assert_allclose(v[:41], v[:39:-1], rtol=1e-12)
    assert 0.95 * VM < v.max() < VM


def column(rock, joint, stress, **more):
    """Return a block pressed on a fixed one by a stress."""
    polygons = [rectangle(0, -1, 1, 0), rectangle(0, 0, 1, 1)]
    blocks = bsm.Blocks.from_polygons(polygons, rock="r")
    return bsm.Model(
        blocks=blocks,
        rocks=[rock],
        joints=[joint],
        default_joint="J",
        supports=[bsm.Fixed(blocks=[0])],
        loads=[bsm.PointLoad(block=1, point=(0.5, 1.0), force=(0.0, -stress))],
        **more,
    )


RIGID = bsm.Rock("r", unit_weight=0.0)
SOFT = bsm.Rock("r", unit_weight=0.0, young=200e9, poisson=0.0)
JOINT = bsm.Joint("J", KN, 1e9, law=bsm.MohrCoulomb(friction=30), max_closure=VM)


@pytest.mark.parametrize("rock", [RIGID, SOFT])
@pytest.mark.parametrize("scheme", ["continuation", "wang"])
@pytest.mark.parametrize("stress", [1e5, 2e6, 4e7])
def test_joint_and_rock_close_in_series(rock, scheme, stress):
    results = bsm.run(column(rock, JOINT, stress), bsm.Options(scheme=scheme))
    assert results.status == "stable"
    of_rock = 0.0 if rock is RIGID else stress * 2 * 0.5 / 200e9  # half a block on either side
    expected = stress * VM / (KN * VM + stress) + of_rock
    assert_allclose(-results.stages[0].displacement[1, 1], expected, rtol=1e-6 if rock is RIGID else 3e-4)  # h shrinks
    assert_allclose(-results.stages[0].contacts.normal_force.sum(), stress, rtol=1e-5)


def test_the_linear_scheme_takes_the_stiffness_without_stress():
    results = bsm.run(column(RIGID, JOINT, 1e6), bsm.Options(scheme="linear"))
    assert_allclose(-results.stages[0].displacement[1, 1], 1e6 / KN, rtol=1e-9)


def test_in_situ_a_joint_begins_closed_by_the_field():
    """More stress closes it by the rest of the curve only."""
    field = bsm.InSitu(stress={"xx": 0.0, "yy": -2e6, "xy": 0.0})
    loads = [bsm.PointLoad(block=1, point=(0.5, 1.0), force=(0.0, -5e6))]
    model = column(RIGID, JOINT, 2e6).replace(in_situ=field, stages=[bsm.Stage(name="more", loads=loads)])
    results = bsm.run(model)
    moved = [-stage.displacement[1, 1] for stage in results.stages]
    v = [s * VM / (KN * VM + s) for s in (2e6, 7e6)]
    assert_allclose(moved, [0.0, v[1] - v[0]], atol=1e-9)


@pytest.mark.parametrize("limit", [1e-4, 1e-3])
def test_a_block_comes_to_rest_on_a_soft_joint(limit):
    polygons = [rectangle(-2, -1, 3, 0), rectangle(0, 0, 1, 1)]
    joint = bsm.Joint("J", 1e8, 1e8, law=bsm.MohrCoulomb(friction=30), max_closure=limit)
    model = model_of(polygons, joint=joint)
    results = bsm.run(model, bsm.Options(displacement_limit=2.0))
    assert results.status == "stable"
    expected = 25e3 * limit / (1e8 * limit + 25e3)
    assert_allclose(-results.stages[0].displacement[1, 1], expected, rtol=1e-6)


def test_contacts_that_arise_later_do_not_close_by_the_hyperbola():
    """Their walls no longer fit together; and one that is found deep in another would be thrown out."""
    specimen = Specimen(JOINT)
    first = specimen.contacts(position_of(0.0, -1e-5))
    assert first.mated[first.features.closure.rows].all()
    assert len(first.features.closure.rows) >= 2
    specimen.keep(first, specimen.system.evaluate(first, position_of(0.0, -1e-5)))
    assert len(specimen.contacts(position_of(0.0, -1e-5)).features.closure.rows) == len(specimen.history.mated)
    specimen.history = History.none()  # what opened has no history
    assert not len(specimen.contacts(position_of(0.0, -1e-5)).features.closure.rows)


def test_a_filling_has_no_closure_limit():
    filling = bsm.Filling(thickness=0.01, young=1e8, poisson=0.2)
    with pytest.raises(bsm.ModelError, match="max_closure is that of bare walls, and a filling keeps them apart"):
        bsm.Joint("J", filling=filling, law=bsm.MohrCoulomb(friction=30), max_closure=1e-3)
