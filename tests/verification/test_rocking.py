"""A block that settles over a flat corner, at the angle up to which edges count as lying on each other.

The corner at x = 1 represents half the lengths of both edges beside it; beyond `Rules.parallel` the second counts for
nothing. The spring is half as stiff then, and the block turns until the edge counts: neither is an equilibrium of its
own. Statics: the corners carry W (1 - x) and W x for a centroid at x, and settle by that over kn times their lengths.
"""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.contact.rules import RULES
from tests.scenes.models import GAMMA, model_of
from tests.scenes.shapes import rectangle, turned

KN = 1e8


def over_a_flat_corner(beyond, *, mirrored=False, degrees=0.0):
    """Return a block on a floor, one of whose edges is `beyond` [rad] past that angle before it settles."""
    rise = np.tan(np.arcsin(RULES.parallel) + beyond)
    block = np.array([(0.0, 0.0), (1.0, 0.0), (2.0, rise), (2.0, 1.0), (0.0, 1.0)])
    sign = -1 if mirrored else 1
    polygons = [rectangle(-1, -1, 3, 0), block]
    placed = [turned((points * (sign, 1))[::sign], degrees) for points in polygons]
    return model_of(placed, friction=30, kn=KN, gravity_direction=degrees - 90.0)


def settled(beyond, *, both):
    """Return how far such a block turns by statics."""
    blocks = over_a_flat_corner(beyond).blocks
    weight, x = GAMMA * blocks.moments.area[1], blocks.moments.centroid[1, 0]
    edge = np.hypot(*(blocks.polygon(1)[2] - blocks.polygon(1)[1]))
    return weight / KN * (x / (0.5 * (1.0 + edge * both)) - (1.0 - x) / 0.5)


@pytest.mark.parametrize("mirrored", [False, True])
@pytest.mark.parametrize("degrees", [0.0, 33.0])
@pytest.mark.parametrize("beyond", [5e-4, 7e-4, 9e-4])
def test_an_edge_that_counts_from_some_turn_on(beyond, degrees, mirrored):
    """Seen: a sliver in the wall of a tunnel turned back and forth in 500 steps, and the run had no verdict."""
    assert settled(beyond, both=True) < beyond < settled(beyond, both=False)  # it counts, and does not
    model = over_a_flat_corner(beyond, mirrored=mirrored, degrees=degrees)
    results = bsm.run(model, bsm.Options(scheme="continuation", max_steps=20))
    assert results.status == "stable"
    assert results.check().ok, str(results.check())
    turn = np.abs(results.stages[-1].displacement[1, 2])
    assert_allclose(turn, settled(beyond, both=True), rtol=2e-3)


@pytest.mark.parametrize(("beyond", "both"), [(-1e-3, True), (2e-3, False)])
def test_away_from_that_angle_the_edge_counts_or_not(beyond, both):
    results = bsm.run(over_a_flat_corner(beyond), bsm.Options(scheme="continuation"))
    assert results.status == "stable"
    assert_allclose(np.abs(results.stages[-1].displacement[1, 2]), settled(beyond, both=both), rtol=2e-3)
