"""Flow and blocks together: joints that close under their own water, uplift of a dam, still water, in-situ stress."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

import bsm_mesh as bsm
from bsm_mesh.flow.coupling import FlowCoupling
from bsm_mesh.model.water_pressure import WaterLoad
from bsm_mesh.results.records import Status
from tests.scenes.flow_models import bricks, dam, on_two_joints
from tests.scenes.models import LINEAR

WEIGHT, VISCOSITY = 9810.0, 1e-3
CLOSED_FORM = 1e-10
BY_TURNS = 1e-8  # of values; pressures change by 1e-9 of the greatest in the last turn
TURNED = 1e-5  # water presses on blocks where they have come to


@pytest.mark.parametrize(
    ("scheme", "tolerance"), [("linear", BY_TURNS), pytest.param("continuation", TURNED, marks=pytest.mark.heavy)]
)
def test_joints_in_series_that_close_under_their_own_water(scheme, tolerance):
    """Against a scalar equation for the head between them, solved apart.

    Below a block of weight W on a joint of length L the effective stress is W / L less the pressure, linear from s1 to
    s2; the springs at both ends close by (2 s1 + s2) / (3 kn) and (s1 + 2 s2) / (3 kn).
    """
    length, kn, a0 = 2.0, 1e9, 0.4e-3

    def ends(load, h1, h2):
        s1, s2 = load / length - WEIGHT * h1, load / length - WEIGHT * h2
        return a0 - (2 * s1 + s2) / (3 * kn), a0 - (s1 + 2 * s2) / (3 * kn)

    def discharge(load, h1, h2):
        a1, a2 = ends(load, h1, h2)
        return 2 * a1**2 * a2**2 / (a1 + a2) * WEIGHT / (12 * VISCOSITY) * (h1 - h2) / length

    between = brentq(lambda h: discharge(600e3, 20, h) - discharge(240e3, h, 2), 2, 20, xtol=1e-14)
    options = bsm.Options(scheme=scheme, tolerance=1e-10)
    stage = bsm.run(on_two_joints(), options).stages[-1]
    flow = stage.flow
    assert stage.status.is_at_rest
    assert flow.head[(flow.point == (2, 0)).all(axis=1)] == pytest.approx(between, rel=tolerance)
    assert flow.through == pytest.approx(discharge(600e3, 20, between), rel=tolerance)
    apertures = [*ends(600e3, 20, between), *ends(240e3, between, 2)]
    np.testing.assert_allclose(np.sort(flow.aperture, axis=None), np.sort(apertures), rtol=tolerance)
    stiff = bsm.run(on_two_joints(coupling="one_way"), options).stages[-1].flow
    assert stiff.head[(stiff.point == (2, 0)).all(axis=1)] == pytest.approx(11, rel=CLOSED_FORM)


@pytest.mark.parametrize(("scheme", "tolerance"), [("linear", CLOSED_FORM), ("continuation", TURNED)])
@pytest.mark.parametrize(("drain", "level", "at"), [(None, 6.5, 5.0), (3.0, 3.0, 2.0), (-1.0, 0.0, 2.0)])
def test_uplift_of_a_dam_with_and_without_a_drain(scheme, tolerance, drain, level, at):
    """Linear between the levels upstream, in the drain (that of the base at least) and downstream."""
    hole = None if drain is None else bsm.Drain(start=(at, -1), end=(at, 5), level=drain)
    stage = bsm.run(dam(drain=hole), bsm.Options(scheme=scheme)).stages[-1]
    uplift = WEIGHT * ((11 + level) / 2 * at + (level + 2) / 2 * (10 - at))
    np.testing.assert_allclose(stage.water[1, :2], [WEIGHT * 11**2 / 2, uplift], rtol=tolerance)
    assert stage.status.is_at_rest
    assert stage.flow.imbalance <= 1e-12


def test_water_presses_once_on_an_edge_of_two_boundaries():
    """With the higher of their levels, as at the nodes."""
    model = dam()
    blocks = model.blocks.with_boundary("wall", lambda x, y: (x < 1e-9) & (y > -1e-9))
    heads = dict(model.flow.head)
    twice = model.replace(blocks=blocks, flow=replace(model.flow, head=heads | {"wall": 6.0}))
    once, found = (bsm.run(given, LINEAR).stages[-1] for given in (model, twice))
    np.testing.assert_allclose(found.water, once.water, rtol=CLOSED_FORM)


@pytest.mark.parametrize("level", [2.3, 3.5, 1.0])
def test_still_water_presses_as_a_water_table_does(level):
    """The forces of chapter 6 on every block, dry and half wet faces included."""
    sides = dict.fromkeys(("left", "right", "bottom", "top"), level)
    flowing = bricks(flow=bsm.Flow(head=sides, coupling="one_way"))
    stage = bsm.run(flowing, bsm.Options(scheme="linear")).stages[-1]
    table = WaterLoad(bricks(water=bsm.Water(table=((0, level),))))
    blocks = flowing.blocks
    expected = table.on_blocks(blocks.vertices, blocks.moments.centroid)
    np.testing.assert_allclose(stage.water, expected, rtol=0, atol=1e-12 * np.abs(expected).max())
    assert not stage.flow.discharge.any()


@pytest.mark.parametrize(
    ("scheme", "rock", "limit"),
    [
        ("linear", {}, None),
        ("continuation", {}, None),
        ("linear", {"young": 10e9, "poisson": 0.2}, None),
        ("continuation", {}, 4e-3),
    ],
)
def test_in_situ_stress_closes_joints_without_moving_blocks(scheme, rock, limit):
    """By the joint's spring alone: rock that gives way is no closure; hyperbolic v = s / (Kn + s / vm)."""
    ground = bsm.InSitu(surface=200.0, k0=0.5)
    loads = [bsm.InSituTraction(boundary="top")]
    sides = dict.fromkeys(("left", "right", "bottom", "top"), 50.0)
    model = bricks(flow=bsm.Flow(head=sides), in_situ=ground, loads=loads, aperture=5e-3)
    joints = [replace(model.joints[0], max_closure=limit)]
    model = model.replace(rocks=[bsm.Rock("rock", unit_weight=26e3, **rock)], joints=joints)
    stage = bsm.run(model, bsm.Options(scheme=scheme)).stages[-1]
    flow = stage.flow
    assert np.abs(stage.displacement).max() < 1e-9
    ends = np.stack([flow.point[flow.first], flow.point[flow.last]], axis=1)
    level = np.ptp(ends[:, :, 1], axis=1) == 0
    depth, pressure = 200 - ends[:, :, 1], WEIGHT * (50 - ends[:, :, 1])
    stress = np.where(level[:, None], 26e3 * depth, 0.5 * 26e3 * depth) - pressure
    mean = stress.mean(axis=1)
    closure = mean / (5e9 + (0 if limit is None else mean / limit))
    np.testing.assert_allclose(flow.aperture.mean(axis=1), 5e-3 - closure, rtol=1e-6)


def test_what_does_not_settle_is_not_converged():
    stage = bsm.run(on_two_joints(max_rounds=1)).stages[-1]
    assert stage.status is Status.NOT_CONVERGED
    assert "do not settle: after 1 turn" in stage.reason
    for cure in ("max_rounds", "tolerance", "smaller stages", "(asked: 1e-09)"):
        assert cure in stage.reason


@pytest.mark.parametrize(("stiffness", "turns"), [(3e8, 8), (1.2e8, 25)])
def test_turns_that_overshoot_take_part_of_the_change(stiffness, turns):
    """Without Aitken's part soft joints go back and forth, for 15 turns; softer ones, if a tenth is taken at least."""
    model = on_two_joints()
    soft = replace(model.joints[0], normal_stiffness=stiffness)
    stage = bsm.run(model.replace(joints=[soft]), LINEAR).stages[-1]
    assert stage.status.is_at_rest
    assert stage.flow.change <= 1e-9
    assert stage.flow.rounds <= turns


def test_sealed_joints_stay_sealed_where_they_open():
    model = on_two_joints()
    sealed = replace(model.joints[0], aperture=0.0, residual_aperture=0.0)
    pulled = [replace(load, force=(0, 200e3)) for load in model.loads]
    stage = bsm.run(model.replace(joints=[sealed], loads=pulled), LINEAR).stages[-1]
    assert stage.contacts.normal_force.max() > 0
    assert not stage.flow.aperture.any()


def test_a_stage_begins_in_joints_as_they_stood():
    coupling = FlowCoupling(on_two_joints())
    before = replace(coupling.first, aperture=0.5 * coupling.first.aperture)
    begun = coupling.begin(0, np.ones(3, dtype=bool), before)
    np.testing.assert_array_equal(begun.aperture, before.aperture)
