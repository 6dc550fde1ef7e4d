"""Steady flow in networks of joints: the cubic law, joints in series and side by side, free surfaces, drains, wells."""

import numpy as np
import pytest

from bsm_mesh.flow.network import cubic_law
from bsm_mesh.flow.steady import solve_steady
from tests.scenes.flow_networks import VISCOSITY, WEIGHT, conditions, conductance, dam, network, random_network

CLOSED_FORM = 1e-10
BALANCE = 1e-12  # of the greatest discharge


def test_one_joint_follows_the_cubic_law():
    a, length, drop = 0.3e-3, 7.0, 2.5
    net = network([(0, 0), (length, 0)], [(0, 1)])
    flow = solve_steady(net, conductance(net, a), conditions(net, head={0: 10.0, 1: 10.0 - drop}))
    expected = a**3 * WEIGHT * (drop / length) / (12 * VISCOSITY)
    assert flow.discharge[0] == pytest.approx(expected, rel=CLOSED_FORM)
    np.testing.assert_allclose(flow.outflow, [-expected, expected], rtol=CLOSED_FORM)


def test_aperture_that_runs_along_a_joint_conducts_as_many_short_joints_do():
    """Midpoint rule with n parts: its error falls with n squared."""
    a1, a2, length, n = 0.1e-3, 0.4e-3, 5.0, 20_000
    middle = a1 + (a2 - a1) * (np.arange(n) + 0.5) / n
    parts = cubic_law(middle, middle, np.full(n, length / n), WEIGHT, VISCOSITY)
    one = cubic_law(np.array([a1]), np.array([a2]), np.array([length]), WEIGHT, VISCOSITY)
    assert one[0] == pytest.approx(1 / (1 / parts).sum(), rel=1e-7)


def test_a_sealed_end_seals_the_piece():
    assert cubic_law(np.array([0.0, 0.0]), np.array([1e-3, 0.0]), np.ones(2), WEIGHT, VISCOSITY).tolist() == [0.0, 0.0]


def test_joints_in_series_have_the_sum_of_their_resistances():
    a = np.array([0.2e-3, 0.5e-3, 0.1e-3])
    net = network([(0, 0), (2, 1), (5, 1), (9, 0)], [(0, 1), (2, 1), (2, 3)])
    flow = solve_steady(net, conductance(net, a), conditions(net, head={0: 50.0, 3: 20.0}))
    resistance = 12 * VISCOSITY / WEIGHT * net.length / a**3
    through = 30 / resistance.sum()
    np.testing.assert_allclose(flow.discharge, [through, -through, through], rtol=CLOSED_FORM)
    np.testing.assert_allclose(flow.head, 50 - through * np.array([0, *np.cumsum(resistance)]), rtol=CLOSED_FORM)


def test_a_ladder_has_the_conductance_of_its_continued_fraction():
    """Rails and rungs of conductance r and s: seen from its open end, each bay adds 1/(2/r + 1/(s + C))."""
    bays, r_aperture, s_aperture = 8, 0.2e-3, 0.3e-3
    points = [(x, y) for x in range(bays + 1) for y in (0, 1)]
    rails = [(2 * k + side, 2 * k + 2 + side) for k in range(bays) for side in (0, 1)]
    rungs = [(2 * k, 2 * k + 1) for k in range(1, bays + 1)]
    net = network(points, rails + rungs)
    aperture = np.array([r_aperture] * len(rails) + [s_aperture] * len(rungs))
    c = conductance(net, aperture)
    flow = solve_steady(net, c, conditions(net, head={0: 30.0, 1: 20.0}))
    r, s, seen = c[0], c[-1], 0.0
    for _ in range(bays):
        seen = 1 / (2 / r + 1 / (s + seen))
    np.testing.assert_allclose(flow.outflow[:2], [-10 * seen, 10 * seen], rtol=CLOSED_FORM)


def test_still_water_stands_level_and_has_no_flow():
    net, given, _ = dam(10, 10, 1, 6.2, 6.2)
    flow = solve_steady(net, conductance(net, 1e-3), given)
    np.testing.assert_allclose(flow.head, np.maximum(6.2, net.point[:, 1]), rtol=1e-14)
    assert not flow.discharge.any()
    assert flow.converged


def test_water_that_falls_trickles_without_pressure():
    """From a pond down a shaft to a free outlet: into a wider joint it falls freely, a narrower one backs up."""
    net = network([(0, 10), (0, 5), (0, 0)], [(0, 1), (1, 2)])
    given = conditions(net, head={0: 10.5}, spill={2: 0.0})
    wide_below = solve_steady(net, conductance(net, [1e-3, 2e-3]), given)
    assert wide_below.pressure_head[1] == 0
    assert wide_below.filled[1] == pytest.approx(5.5 / 5 / 8, rel=CLOSED_FORM)
    narrow_below = solve_steady(net, conductance(net, [2e-3, 1e-3]), given)
    c, d = conductance(net, [2e-3, 1e-3])
    assert narrow_below.head[1] == pytest.approx(10.5 * c / (c + d), rel=CLOSED_FORM)
    assert narrow_below.filled[1] == 1


def test_water_does_not_rise_above_its_level_into_dead_ends():
    net = network([(0, 0), (5, 0), (5, 4), (10, 0)], [(0, 1), (1, 2), (1, 3)])
    flow = solve_steady(net, conductance(net, 1e-3), conditions(net, head={0: 3.0, 3: 3.0}))
    assert flow.pressure_head.tolist() == [3, 3, 0, 3]
    assert flow.filled[2] == 0


def test_a_drain_takes_water_out_down_to_its_level_and_gives_none():
    net = network([(0, 0), (5, 0), (10, 0)], [(0, 1), (1, 2)])
    c = conductance(net, 1e-3)
    drained = solve_steady(net, c, conditions(net, head={0: 8.0, 2: 6.0}, spill={1: 2.0}))
    assert drained.head[1] == 2
    assert drained.outflow[1] == pytest.approx(6 * c[0] + 4 * c[1], rel=CLOSED_FORM)
    above = solve_steady(net, c, conditions(net, head={0: 8.0, 2: 6.0}, spill={1: 9.0}))
    assert above.head[1] == pytest.approx(7, rel=CLOSED_FORM)
    assert above.outflow[1] == 0


def test_a_well_takes_what_it_is_told_or_what_there_is():
    net = network([(0, 0), (5, 0)], [(0, 1)])
    c = conductance(net, 1e-3)
    given = solve_steady(net, c, conditions(net, head={0: 4.0}, pumped={1: 3 * c[0]}))
    assert given.head[1] == pytest.approx(1, rel=CLOSED_FORM)
    dry = solve_steady(net, c, conditions(net, head={0: 4.0}, pumped={1: 30 * c[0]}))
    assert dry.pressure_head[1] == 0
    np.testing.assert_allclose(dry.outflow, [-4 * c[0], 4 * c[0]], rtol=CLOSED_FORM)


def test_water_put_in_without_a_way_out_is_no_steady_flow():
    net = network([(0, 0), (5, 0), (9, 9), (9, 12)], [(0, 1), (2, 3)])
    flow = solve_steady(net, conductance(net, 1e-3), conditions(net, head={0: 4.0}, pumped={2: -1e-6}))
    assert not flow.converged


def test_what_no_water_reaches_is_dry():
    net = network([(0, 0), (5, 0), (9, -9), (9, -6)], [(0, 1), (2, 3)])
    flow = solve_steady(net, conductance(net, 1e-3), conditions(net, head={0: 4.0}))
    assert flow.filled.tolist()[2:] == [0, 0]
    assert flow.pressure_head.tolist()[2:] == [0, 0]


@pytest.mark.parametrize(("width", "upstream", "downstream"), [(10, 10, 0), (10, 8, 2), (5, 10, 2), (40, 9, 0)])
@pytest.mark.parametrize("spacing", [1, 0.25])
def test_newton_ends_after_few_corrections_whatever_the_size(width, upstream, downstream, spacing):
    net, given, _ = dam(width, 10, spacing, upstream, downstream)
    flow = solve_steady(net, conductance(net, 1e-3), given)
    assert flow.converged
    assert flow.iterations <= 12


@pytest.mark.parametrize("seed", range(40))
def test_every_node_of_a_random_network_balances(seed):
    net, c, given = random_network(seed)
    flow = solve_steady(net, c, given)
    assert flow.converged
    assert flow.imbalance <= BALANCE
    greatest = np.abs(flow.discharge).max()
    n = len(net.point)
    leaving = np.bincount(net.first, flow.discharge, n) - np.bincount(net.last, flow.discharge, n)
    assert np.abs(leaving + flow.outflow).max() <= BALANCE * greatest
    assert abs(flow.outflow.sum()) <= n * BALANCE * greatest
    assert np.nanmax(given.head, initial=net.point[:, 1].max()) >= flow.head.max() * (1 - 1e-12)
    assert (flow.outflow[np.isfinite(given.spill) & ~given.given] >= -BALANCE * greatest).all()
    assert (flow.head <= np.maximum(given.spill, net.point[:, 1]) * (1 + 1e-12)).all()


@pytest.mark.heavy
def test_nodes_balance_beside_joints_a_thousand_times_as_wide():
    """Discharges in these are all but lost in rounding of heads; flows that are not found are said to be none."""
    found = 0
    for seed in range(40):
        net, c, given = random_network(seed)
        wide = np.random.default_rng(seed).random(len(c)) < 0.05
        flow = solve_steady(net, np.where(wide, 1e9, 1.0) * c, given)
        assert not flow.converged or flow.imbalance <= BALANCE
        found += flow.converged
    assert found >= 38


def test_a_dry_wide_joint_takes_nothing_from_the_balance_of_its_lower_end():
    """It could lead much and leads nothing; corrections that counted it came nearer by a twelfth each time."""
    points = [(0, 0), (5, 2), (10, 1), (5, 9), (6, 12)]
    net = network(points, [(0, 1), (1, 2), (3, 1), (3, 4)])
    c = conductance(net, [0.3e-3, 0.2e-3, 0.5, 0.2e-3])
    flow = solve_steady(net, c, conditions(net, head={0: 8.123, 2: 3.777}))
    through = (8.123 - 3.777) / (1 / c[0] + 1 / c[1])
    np.testing.assert_allclose(flow.discharge, [through, through, 0, 0], rtol=1e-15, atol=1e-15 * through)
