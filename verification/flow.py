"""Flow in joints: the cubic law, joints in series and ladders, Dupuit's dam, uplift, joints that close under water."""

from __future__ import annotations

from functools import partial

import numpy as np
from scipy.linalg import solve
from scipy.optimize import brentq
from scipy.sparse import coo_array
from scipy.sparse.csgraph import laplacian
from scipy.special import ellipk

import bsm_mesh as bsm
from bsm_mesh.flow.steady import solve_steady
from bsm_mesh.model.water_pressure import WaterLoad
from tests.scenes.flow_models import bricks, dam, on_two_joints
from tests.scenes.flow_networks import (
    VISCOSITY,
    WEIGHT,
    conditions,
    conductance,
    network,
    random_network,
    sheet_pile,
    under_water,
)
from tests.scenes.flow_networks import dam as dam_of_joints
from tests.scenes.models import LINEAR
from verification.case import Answer, Case

CLOSED, BALANCE, TURNS = 1e-12, 1e-12, 1e-9
DENSE = 1e-11  # heads by elimination in full matrices
LIMIT = 2e-4  # two spacings leave what falls with their square


def one_joint() -> Answer:
    """Compare discharges of joints of 0.01 to 1 mm."""
    length, drop, exact, found = 7.0, 2.5, [], []
    net = network([(0, 0), (length, 0)], [(0, 1)])
    for a in (1e-5, 1e-4, 3e-4, 1e-3):
        exact.append(a**3 * WEIGHT * (drop / length) / (12 * VISCOSITY))
        found.append(solve_steady(net, conductance(net, a), conditions(net, head={0: 10.0, 1: 7.5})).discharge[0])
    return np.array(exact) / exact[0], np.array(found) / exact[0]


def series() -> Answer:
    """Compare heads between three joints of different aperture, and the discharge over its own size."""
    a = np.array([0.2e-3, 0.5e-3, 0.1e-3])
    net = network([(0, 0), (2, 1), (5, 1), (9, 0)], [(0, 1), (1, 2), (2, 3)])
    flow = solve_steady(net, conductance(net, a), conditions(net, head={0: 50.0, 3: 20.0}))
    resistance = 12 * VISCOSITY / WEIGHT * net.length / a**3
    through = 30 / resistance.sum()
    exact = 50 - through * np.array([0, *np.cumsum(resistance)])
    return np.append(exact, 1.0), np.append(flow.head, flow.discharge.mean() / through)


def ladder() -> Answer:
    """Compare the discharge into a ladder of eight bays, in units of the conductance of its rails."""
    bays = 8
    points = [(x, y) for x in range(bays + 1) for y in (0, 1)]
    rails = [(2 * k + side, 2 * k + 2 + side) for k in range(bays) for side in (0, 1)]
    rungs = [(2 * k, 2 * k + 1) for k in range(1, bays + 1)]
    net = network(points, rails + rungs)
    c = conductance(net, [0.2e-3] * len(rails) + [0.3e-3] * len(rungs))
    flow = solve_steady(net, c, conditions(net, head={0: 30.0, 1: 20.0}))
    seen = 0.0
    for _ in range(bays):
        seen = 1 / (2 / c[0] + 1 / (c[-1] + seen))
    return 10 * seen / c[0], -flow.outflow[0] / c[0]


def balance() -> Answer:
    """Compare the imbalance of the nodes of twenty random networks with none, over the greatest discharge."""
    worst = []
    for seed in range(20):
        net, c, given = random_network(seed)
        flow = solve_steady(net, c, given)
        n = len(net.point)
        leaving = np.bincount(net.first, flow.discharge, n) - np.bincount(net.last, flow.discharge, n)
        worst.append(np.abs(leaving + flow.outflow).max() / max(np.abs(flow.discharge).max(), 1e-300))
    return np.zeros(20), np.array(worst)


def random_networks() -> Answer:
    """Count random networks, apertures over powers of ten, whose flow is found and balances to 1e-12, of 2000."""
    found = 0
    for seed in range(2000):
        net, c, given = random_network(seed)
        flow = solve_steady(net, c, given)
        found += flow.converged and flow.imbalance <= BALANCE
    return 2000.0, float(found)


def laplacians() -> Answer:
    """Compare heads in fifty networks under water with those of SciPy's graph Laplacian, solved densely."""
    exact, found = [], []
    for seed in range(50):
        net, c, given = under_water(seed)
        n, known = len(net.point), given.given
        matrix = laplacian(coo_array((c, (net.first, net.last)), shape=(n, n)).toarray(), symmetrized=True)
        head = given.head.copy()
        head[~known] = solve(matrix[np.ix_(~known, ~known)], -matrix[np.ix_(~known, known)] @ head[known])
        flow = solve_steady(net, c, given)
        scale = np.abs(matrix @ head).max()
        exact.append(np.concatenate([head, (matrix @ head)[known] / scale]))
        found.append(np.concatenate([flow.head, -flow.outflow[known] / scale]))
    return np.concatenate(exact), np.concatenate(found)


def under_a_sheet_pile() -> Answer:
    """Compare q / (k h) under piles of 1/4, 1/2 and 3/4 of the layer, extrapolated from joints T/32 and T/64 apart."""
    exact, found = [], []
    for depth in (0.25, 0.5, 0.75):
        modulus = np.sin(np.pi * depth / 2) ** 2
        exact.append(ellipk(1 - modulus) / (2 * ellipk(modulus)))
        coarse, fine = (_under_pile(depth, spacing) for spacing in (1 / 32, 1 / 64))
        found.append(2 * fine - coarse)
    return np.array(exact), np.array(found)


def _under_pile(depth: float, spacing: float) -> float:
    """Return the discharge under a sheet pile over permeability and drop of head, which is 1 m."""
    net, given = sheet_pile(depth, spacing)
    flow = solve_steady(net, conductance(net, 0.1e-3), given)
    permeability = 0.1e-3**3 * WEIGHT / (12 * VISCOSITY) / spacing
    return float(np.maximum(flow.outflow, 0.0).sum()) / permeability


def dupuit(spacing: float) -> Answer:
    """Compare discharges through dams of closely spaced joints, over that of the first."""
    exact, found = [], []
    for width, upstream, downstream in ((10, 10, 0), (10, 8, 2), (5, 10, 2), (20, 10, 1)):
        net, given, number = dam_of_joints(width, 10, spacing, upstream, downstream)
        flow = solve_steady(net, conductance(net, 0.5e-3), given)
        permeability = 0.5e-3**3 * WEIGHT / (12 * VISCOSITY) / spacing
        exact.append(permeability * (upstream**2 - downstream**2) / (2 * width))
        found.append(float(flow.outflow[number[-1]].sum()))
    return np.array(exact) / exact[0], np.array(found) / exact[0]


def uplift(level: float | None) -> Answer:
    """Compare horizontal force and uplift on a dam on one joint, with a drain 2 m from its heel or without."""
    drain = None if level is None else bsm.Drain(start=(2, -1), end=(2, 5), level=level)
    stage = bsm.run(dam(drain=drain), LINEAR).stages[-1]
    at, there = (5.0, 6.5) if level is None else (2.0, max(level, 0.0))
    exact = WEIGHT * np.array([11**2 / 2, (11 + there) / 2 * at + (there + 2) / 2 * (10 - at)])
    return exact, stage.water[1, :2]


def still_water() -> Answer:
    """Compare forces on twelve blocks in water that stands level with those of chapter 6 under a table."""
    sides = dict.fromkeys(("left", "right", "bottom", "top"), 2.3)
    flowing = bricks(flow=bsm.Flow(head=sides, coupling="one_way"))
    table = WaterLoad(bricks(water=bsm.Water(table=((0, 2.3),))))
    exact = table.on_blocks(flowing.blocks.vertices, flowing.blocks.moments.centroid)
    return exact, bsm.run(flowing, LINEAR).stages[-1].water


def closing() -> Answer:
    """Compare the head between two joints that close under loads and their own water, and discharge over its own."""
    length, kn, a0 = 2.0, 1e9, 0.4e-3

    def discharge(load: float, h1: float, h2: float) -> float:
        s1, s2 = load / length - WEIGHT * h1, load / length - WEIGHT * h2
        a1, a2 = a0 - (2 * s1 + s2) / (3 * kn), a0 - (s1 + 2 * s2) / (3 * kn)
        return 2 * a1**2 * a2**2 / (a1 + a2) * WEIGHT / (12 * VISCOSITY) * (h1 - h2) / length

    between = float(brentq(lambda h: discharge(600e3, 20, h) - discharge(240e3, h, 2), 2, 20, xtol=1e-14))
    flow = bsm.run(on_two_joints(), LINEAR).stages[-1].flow
    assert flow is not None
    head = flow.head[(flow.point == (2, 0)).all(axis=1)][0]
    return np.array([between, 1.0]), np.array([head, flow.through / discharge(600e3, 20, between)])


CASES = (
    Case(name="cubic-law", what="one joint, 0.01 to 1 mm wide", source="witherspoon",
         quantity="discharge, over the least", compute=one_joint, tolerance=CLOSED),
    Case(name="flow-in-series", what="three joints one behind the other", source="resistances",
         quantity="heads [m]; discharge over its own", compute=series, tolerance=CLOSED),
    Case(name="ladder-of-joints", what="eight bays of rails and rungs", source="resistances",
         quantity="discharge, over a rail's conductance", compute=ladder, tolerance=CLOSED),
    Case(name="water-balance", what="every node of random networks with drains and wells", source="resistances",
         quantity="imbalance over the greatest discharge", compute=balance, tolerance=BALANCE),
    Case(name="random-networks", what="flow found, and balanced to 1e-12", source="resistances",
         quantity="networks", compute=random_networks, tolerance=0.0, is_slow=True),
    Case(name="graph-laplacian", what="fifty random networks under water, apertures over powers of ten",
         source="scipy-laplacian", quantity="heads [m]; discharges over the greatest", compute=laplacians,
         tolerance=DENSE),
    Case(name="sheet-pile", what="closely spaced joints under a sheet pile, extrapolated to none between",
         source="harr", quantity="q / (k h), piles of 1/4, 1/2, 3/4 of the layer", compute=under_a_sheet_pile,
         tolerance=LIMIT),
    Case(name="dupuit-1m", what="rectangular dams of joints 1 m apart, with seepage faces", source="dupuit",
         quantity="discharge, over the first", compute=partial(dupuit, 1.0), tolerance=CLOSED),
    Case(name="dupuit-0.25m", what="the same, 0.25 m apart", source="dupuit",
         quantity="discharge, over the first", compute=partial(dupuit, 0.25), tolerance=CLOSED),
    Case(name="uplift-in-a-joint", what="a dam on one joint", source="statics",
         quantity="thrust, uplift [N/m]", compute=partial(uplift, None), tolerance=CLOSED),
    Case(name="uplift-drained", what="the same, with water 3 m high in a drain", source="statics",
         quantity="thrust, uplift [N/m]", compute=partial(uplift, 3.0), tolerance=CLOSED),
    Case(name="still-water", what="level water in all joints", source="wang",
         quantity="force [N/m], moment [N]", compute=still_water, tolerance=BALANCE),
    Case(name="closing-joints", what="two joints in series that close under loads and their own water",
         source="resistances", quantity="head between [m]; discharge over its own", compute=closing, tolerance=TURNS),
)  # fmt: skip
