"""Networks of joints for flow: chains, ladders, and dams of closely spaced joints."""

import numpy as np

from bsm_mesh.flow.network import Network, cubic_law
from bsm_mesh.flow.steady import Conditions

WEIGHT, VISCOSITY = 9810.0, 1e-3


def network(points, pieces) -> Network:
    """Return a network of points (n, 2) and pieces (m, 2)."""
    first, last = np.array(pieces, dtype=np.int32).reshape(-1, 2).T
    return Network(point=np.array(points, dtype=float), first=first, last=last)


def conductance(net: Network, aperture) -> np.ndarray:
    """Return the conductance of pieces of constant aperture."""
    a = np.broadcast_to(np.asarray(aperture, dtype=float), net.first.shape)
    return cubic_law(a, a, net.length, WEIGHT, VISCOSITY)


def conditions(net: Network, *, head=None, spill=None, pumped=None) -> Conditions:
    """Return conditions given by node: mappings of node numbers to values."""
    columns = []
    for given, default in ((head, np.nan), (spill, np.inf), (pumped, 0.0)):
        column = np.full(len(net.point), default)
        for node, value in (given or {}).items():
            column[node] = value
        columns.append(column)
    return Conditions(head=columns[0], spill=columns[1], pumped=columns[2])


def dam(width: float, height: float, spacing: float, upstream: float, downstream: float):
    """Return a rectangular dam of level and upright joints on an impervious base, and the input on its faces."""
    x = np.concatenate([[0.0], np.arange(spacing / 2, width, spacing), [width]])
    y = np.arange(spacing / 2, height, spacing)
    points = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    number = np.arange(len(points)).reshape(len(x), len(y))
    level = np.stack([number[:-1], number[1:]], axis=-1).reshape(-1, 2)
    upright = np.stack([number[1:-1, :-1], number[1:-1, 1:]], axis=-1).reshape(-1, 2)
    net = network(points, np.concatenate([level, upright]))
    head, spill = {}, {}
    for nodes, water in ((number[0], upstream), (number[-1], downstream)):
        head |= {k: water for k in nodes if points[k, 1] <= water}
        spill |= {k: points[k, 1] for k in nodes if points[k, 1] > water}
    return net, conditions(net, head=head, spill=spill), number


def random_network(seed: int):
    """Return a random network with random conductances (over many powers of ten), and conditions of every kind."""
    from scipy.spatial import Delaunay

    rng = np.random.default_rng(seed)
    n = int(10 ** rng.uniform(1, 2.5))
    points = rng.uniform(0, 1, (n, 2)) * [rng.uniform(5, 40), 10]
    if rng.random() < 0.3:
        points[:, 1] = np.round(points[:, 1])
    sides = Delaunay(points, qhull_options="QJ").simplices[:, [0, 1, 1, 2, 0, 2]].reshape(-1, 2)
    pieces = np.unique(np.sort(sides, axis=1), axis=0)
    pieces = pieces[rng.random(len(pieces)) < rng.uniform(0.4, 1)]
    net = network(points, pieces)
    aperture = 1e-3 * np.exp(rng.normal(0, rng.choice([0, 0.2, 0.5, 1.0]), len(pieces)))
    aperture[rng.random(len(pieces)) < rng.choice([0, 0.1])] = 0.0
    width, head, spill = points[:, 0].max(), {}, {}
    for side, water in (
        (points[:, 0] < 0.1 * width, rng.uniform(3, 12)),
        (points[:, 0] > 0.9 * width, rng.uniform(-1, 12)),
    ):
        for k in np.flatnonzero(side):
            (head if points[k, 1] <= water else spill)[k] = max(water, points[k, 1])
    drains = rng.integers(0, n, n // 20)
    spill |= {k: points[k, 1] + rng.choice([0.0, 1.0]) for k in drains if k not in head}
    wells = [k for k in rng.integers(0, n, 2) if k not in head and k not in spill]
    pumped = {k: rng.uniform(0, 1) * np.median(conductance(net, 1e-3)) for k in wells}
    return net, conductance(net, aperture), conditions(net, head=head, spill=spill, pumped=pumped)


def under_water(seed: int):
    """Return a random network that is connected and deep under water, conductances, and heads at both its sides."""
    from scipy.spatial import Delaunay

    rng = np.random.default_rng(seed)
    points = rng.uniform(0, 1, (int(rng.integers(20, 300)), 2)) * [20, 10]
    sides = Delaunay(points).simplices[:, [0, 1, 1, 2, 0, 2]].reshape(-1, 2)
    net = network(points, np.unique(np.sort(sides, axis=1), axis=0))
    order = np.argsort(points[:, 0])
    head = dict.fromkeys(order[:3].tolist(), 40.0) | dict.fromkeys(order[-3:].tolist(), 15.0)
    aperture = 0.3e-3 * np.exp(rng.normal(0, 0.5, len(net.first)))
    return net, conductance(net, aperture), conditions(net, head=head)


def sheet_pile(depth: float, spacing: float, reach: int = 5):
    """Return joints in a layer 1 m thick on tight rock, a sheet pile in its middle, heads of 3 and 2 m on top.

    Level and upright joints stand `spacing` apart, and `reach` metres to both sides; the pile, of some `depth`, cuts
    the level joints it crosses.
    """
    half, rows = round(reach / spacing), round(1 / spacing)
    x = (np.arange(-half, half) + 0.5) * spacing
    y = -np.concatenate([[0.0], (np.arange(rows) + 0.5) * spacing])
    points = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    number = np.arange(len(points)).reshape(len(x), len(y))
    level = np.stack([number[:-1, 1:], number[1:, 1:]], axis=-1)
    cut = (np.arange(len(x) - 1) == half - 1)[:, None] & (y[1:] > -depth)
    upright = np.stack([number[:, :-1], number[:, 1:]], axis=-1).reshape(-1, 2)
    net = network(points, np.concatenate([level[~cut], upright]))
    head = dict.fromkeys(number[:half, 0].tolist(), 3.0) | dict.fromkeys(number[half:, 0].tolist(), 2.0)
    return net, conditions(net, head=head)
