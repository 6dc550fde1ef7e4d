"""What a model does must not depend on where it lies: coordinates on a national grid leave a nanometre to a double.

That is more than a contact closes by under a thousandth of a block's weight.
"""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from tests.scenes.models import LINEAR, model_of
from tests.scenes.shapes import grid, rectangle, running_bond

GRID = np.array([5e5, 5e6])  # easting and northing of a mine [m]
TILT = -85.0  # of gravity: joints slip and open
LOAD = 3e4  # N/m
CLOSE = 1e-8  # of the greatest; 4e-10 measured


def bolted_wall(origin: np.ndarray, **given) -> bsm.Model:
    """Return a tilted wall of bricks with bolts, a load, and a water table, its lower left corner at the origin."""
    at = [(origin + point).tolist() for point in ((0.3, 0.2), (7.2, 2.8), (0.4, 3.7), (6.6, 1.2), (0.0, 3.7))]
    bricks = [polygon + origin for polygon in [rectangle(-1, -0.5, 9, 0), *running_bond(8, 8)]]
    return model_of(
        bricks,
        kn=1e10,
        gravity_direction=TILT,
        bolts=[
            bsm.Bolt(start=at[0], end=at[1], diameter=0.02, bond_strength=2e4, bearing_stiffness=1e9),
            bsm.Bolt(start=at[2], end=at[3], diameter=0.02, kind="end_anchored", pretension=2e4),
        ],
        loads=[bsm.PointLoad(block=len(bricks) - 9, point=at[4], force=(LOAD, 0.0))],
        water=bsm.Water(table=[(origin[0] - 2, origin[1] + 1), (origin[0] + 10, origin[1] + 0.5)]),
        **given,
    )


def opening_in_situ(origin: np.ndarray) -> bsm.Model:
    """Return square blocks under in-situ stress, of which a stage excavates nine."""
    cells = [polygon + origin for polygon in grid(9, 9)]
    x, y = np.array([polygon.mean(axis=0) - origin for polygon in cells]).T
    hole = [(origin + corner).tolist() for corner in rectangle(3, 3, 6, 6)]
    return model_of(
        cells,
        kn=1e10,
        fixed=np.flatnonzero((np.abs(x - 4.5) > 3.9) | (np.abs(y - 4.5) > 3.9)),
        in_situ=bsm.InSitu(surface=[(origin[0], origin[1] + 30), (origin[0] + 9, origin[1] + 30)], k0=0.8),
        stages=[bsm.Stage(name="hole", excavate=[hole])],
    )


@pytest.mark.parametrize("build", [bolted_wall, opening_in_situ])
@pytest.mark.parametrize("options", [bsm.Options(), LINEAR])
def test_the_same_wherever_it_lies(build, options):
    here, there = (bsm.run(build(origin), options) for origin in (np.zeros(2), GRID))
    for results in (here, there):
        assert results.status == ("no_verdict" if options is LINEAR else "stable")
        assert results.check().ok
        assert (results.stages[-1].steps[0].slipping_contacts > 0) == (options is not LINEAR)
    for one, other in zip(here.stages, there.stages, strict=True):
        size = np.abs(one.displacement[:, :2]).max()
        assert_allclose(other.displacement, one.displacement, rtol=0, atol=CLOSE * size)
        assert len(other.steps) == len(one.steps)
        forces = np.abs(one.contacts.normal_force).max()
        assert_allclose(other.contacts.normal_force, one.contacts.normal_force, rtol=0, atol=CLOSE * forces)
        assert_allclose(other.contacts.point - GRID, one.contacts.point, rtol=0, atol=3e-9)
        assert_allclose(other.bolts.point - GRID, one.bolts.point, rtol=0, atol=3e-9)
