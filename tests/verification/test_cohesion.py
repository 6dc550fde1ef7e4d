"""Books with cohesion: limit equilibrium takes the whole of it, so a plastic joint gives their factors of safety.

Strength reduced by a factor of safety F leaves a block just at its limit: friction tan(phi) / F and cohesion c / F.
"""

from dataclasses import replace

import numpy as np
import pytest

import bsm_mesh as bsm
from tests.scenes.models import model_of
from tests.scenes.shapes import rectangle, turned

GAMMA, WATER, PHI, C = 26e3, 9.81e3, 37.0, 25e3
TOE, CREST, TOP, CRACK = (0.0, 0.0), (6.928, 12.0), (10.928, 12.0), (10.928, 7.652)
MARGIN = 1e-3


def plane_failure(zw, factor, **law):
    """Return Hoek and Bray's slope with a tension crack, its strength reduced by a factor."""
    rock = [(0.0, -15.0), (20.0, -15.0), (20.0, 12.0), TOP, CRACK, TOE]
    sliding, below = np.array([TOE, CRACK, TOP, CREST]), np.array(rock)
    reduced = np.degrees(np.arctan(np.tan(np.radians(PHI)) / factor))
    blocks = bsm.Blocks.from_polygons([below, sliding], rock="rock")
    in_crack = (blocks.vertices[:, 0] == CRACK[0]) & (blocks.vertices[blocks.following, 0] == CRACK[0])
    joints = [
        bsm.Joint("J", 1e10, 1e10, law=bsm.MohrCoulomb(friction=reduced, cohesion=C / factor, **law)),
        bsm.Joint("crack", 1e10, 1e10, law=bsm.MohrCoulomb(friction=0.0)),
    ]
    return bsm.Model(
        blocks=replace(blocks, edge_joint=np.where(in_crack, 0, -1).astype(np.int32), joint_names=("crack",)),
        rocks=[bsm.Rock("rock", unit_weight=GAMMA)],
        joints=joints,
        default_joint="J",
        supports=[bsm.Fixed(blocks=[0])],
        water=bsm.Water(table=[(0, 0), (CRACK[0], CRACK[1] + zw)]) if zw else None,
    )


def factor_of(zw):
    """Return the book's factor of safety."""
    p = np.arctan2(CRACK[1] - TOE[1], CRACK[0] - TOE[0])
    base = float(np.hypot(*np.subtract(CRACK, TOE)))
    x, y = np.array([TOE, CRACK, TOP, CREST]).T
    W = GAMMA * 0.5 * abs(x @ np.roll(y, -1) - y @ np.roll(x, -1))
    V, U = WATER * zw**2 / 2, WATER * zw * base / 2
    return (C * base + (W * np.cos(p) - U - V * np.sin(p)) * np.tan(np.radians(PHI))) / (W * np.sin(p) + V * np.cos(p))


def stands(model):
    """Return whether the block rests where it is: one that slides leaves water behind, and may rest farther down."""
    results = bsm.run(model)
    return results.status == "stable" and results.stages[0].max_displacement < 1e-3


@pytest.mark.parametrize(("zw", "printed"), [(3.0, 1.247), (4.348, 1.072), (0.0, 1.544)])
def test_plane_failure_stands_up_to_the_books_factor(zw, printed):
    factor = factor_of(zw)
    assert factor == pytest.approx(printed, abs=2e-3)
    assert stands(plane_failure(zw, factor * (1 - MARGIN)))
    assert not stands(plane_failure(zw, factor * (1 + MARGIN)))


def test_a_brittle_joint_bears_less():
    """Contacts reach their strength one after the other, and the first that slips leaves its load to the others."""
    assert stands(plane_failure(3.0, 1.129 * 0.99, residual_cohesion=0.0))
    assert not stands(plane_failure(3.0, 1.129 * 1.01, residual_cohesion=0.0))


@pytest.mark.parametrize(
    ("peak", "left", "status"), [(1.01, None, "stable"), (0.99, None, "unstable"), (1.01, 0.5, "stable")]
)
def test_cohesion_alone_on_an_incline(peak, left, status):
    """A block without friction; what is left of its cohesion matters only once it has slipped."""
    polygons = [turned(p, 30.0) for p in (rectangle(-20, -5, 5, 0), rectangle(-1, 0, 1, 0.5))]
    need = 25e3 * 0.5 * np.sin(np.radians(30.0))  # Pa: weight along the incline over the base's length
    law = bsm.MohrCoulomb(
        friction=0.0, cohesion=peak * need, residual_cohesion=None if left is None else left * peak * need
    )
    assert bsm.run(model_of(polygons, law=law)).status == status
