"""Plane failure with a tension crack (Hoek & Bray) and a gravity dam on its joint: statics of one block on one joint.

Water pressures come in as loads on the block, so that these hold without the water module. The factor of safety is
(c A + sum N' tan phi) / |sum S| over the contact forces of the linear scheme.
"""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from tests.scenes.models import LINEAR

RTOL = 1e-10  # asked for by the case: pure statics
GAMMA_W = 9.81e3


def contact_sums(polygons, unit_weight, loads, **more):
    model = bsm.Model(
        blocks=bsm.Blocks.from_polygons(polygons, rock=["base", "block"]),
        rocks=[bsm.Rock("base", unit_weight=0), bsm.Rock("block", unit_weight=unit_weight)],
        joints=[bsm.Joint("J", normal_stiffness=1e9, shear_stiffness=3e8)],
        default_joint="J",
        supports=[bsm.Fixed(blocks=[0])],
        loads=loads,
        **more,
    )
    results = bsm.run(model, LINEAR)
    assert results.check().ok
    return results.stages[-1].contacts


# --- C3 ---------------------------------------------------------------------------------------------------------

TOE, CREST, TOP, CRACK = np.array([(0, 0), (6.928, 12), (10.928, 12), (10.928, 7.652)])
ROCK_BELOW = np.array([(0, 0), CRACK, (CRACK[0], -8.0), (0.0, -8.0)])
GAMMA, COHESION, PHI = 26e3, 25e3, 37.0


def area(corners):
    x, y = np.asarray(corners).T
    return (x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2


@pytest.mark.parametrize("points", ["ends", "gauss"])
@pytest.mark.parametrize(
    ("zw", "cohesion", "bolt", "plunge"),
    [
        (3, 25e3, 0, 0),
        (4.348, 25e3, 0, 0),
        (0, 25e3, 0, 0),
        (0, 0, 0, 0),
        (3, 0, 0, 0),
        (0, 0, 4e5, 55),
        (0, 0, 4e5, 20),
    ],
)
def test_plane_failure(zw, cohesion, bolt, plunge, points):
    sliding = np.array([TOE, CRACK, TOP, CREST])
    p = np.arctan2(CRACK[1] - TOE[1], CRACK[0] - TOE[0])
    A = np.hypot(*(CRACK - TOE))
    W = GAMMA * area(sliding)
    V, U = GAMMA_W * zw**2 / 2, GAMMA_W * zw * A / 2
    T, plunge = bolt, np.radians(plunge)
    out_of_plane = np.array([-np.sin(p), np.cos(p)])
    loads = [
        bsm.PointLoad(block=1, point=(CRACK[0], CRACK[1] + zw / 3), force=(-V, 0)),  # at a third of the water's height
        bsm.PointLoad(block=1, point=TOE + (CRACK - TOE) * 2 / 3, force=U * out_of_plane),
        bsm.PointLoad(block=1, point=(TOE + CREST) / 2, force=(T * np.cos(plunge), -T * np.sin(plunge))),
    ]
    contacts = contact_sums([ROCK_BELOW, sliding], GAMMA, loads, contact_points=points)
    tan_phi = np.tan(np.radians(PHI))
    found = (cohesion * A - contacts.normal_force.sum() * tan_phi) / abs(contacts.shear_force.sum())
    normal = W * np.cos(p) - U - V * np.sin(p) + T * np.sin(plunge + p)
    driving = W * np.sin(p) + V * np.cos(p) - T * np.cos(plunge + p)
    assert_allclose(found, (cohesion * A + normal * tan_phi) / driving, rtol=RTOL)


def test_published_factors_of_safety():
    """1.544 drained and 1.076 drained without cohesion: printed in the case with three decimals."""
    sliding = np.array([TOE, CRACK, TOP, CREST])
    contacts = contact_sums([ROCK_BELOW, sliding], GAMMA, [])
    N, S, tan_phi = -contacts.normal_force.sum(), abs(contacts.shear_force.sum()), np.tan(np.radians(PHI))
    A = np.hypot(*(CRACK - TOE))
    assert_allclose((COHESION * A + N * tan_phi) / S, 1.544, atol=1e-3)
    assert_allclose(N * tan_phi / S, 1.076, atol=1e-3)


# --- C10 --------------------------------------------------------------------------------------------------------

H, B, GAMMA_DAM = 50.0, 40.0, 24e3


@pytest.mark.parametrize("uplift", [False, True])
@pytest.mark.parametrize("wide", [False, True])
def test_gravity_dam(uplift, wide):
    rock = (
        np.array([(-60, -50), (100, -50), (100, 0), (-60, 0)])
        if wide
        else np.array([(0, -30), (B, -30), (B, 0), (0, 0)])
    )
    dam = np.array([(0, 0), (B, 0), (0, H)])  # heel at the origin, water on the left
    head = GAMMA_W * H
    blocks = bsm.Blocks.from_polygons([rock, dam], rock=["base", "block"])
    face = [e for e in range(4, 7) if np.allclose(blocks.edge_vectors[e], (0, -H))]
    blocks = bsm.Blocks(
        **{
            name: getattr(blocks, name) for name in ("vertices", "offsets", "nodes", "rock", "rock_names", "edge_joint")
        },
        boundaries={"upstream": face},
    )
    loads = [bsm.Pressure(boundary="upstream", pressure=(head, 0.0, -GAMMA_W))]
    if uplift:  # from the full head at the heel to zero at the toe: two thirds and one third of it at the ends
        loads += [
            bsm.PointLoad(block=1, point=(0, 0), force=(0, B * 2 * head / 6)),
            bsm.PointLoad(block=1, point=(B, 0), force=(0, B * head / 6)),
        ]
    model = bsm.Model(
        blocks=blocks,
        rocks=[bsm.Rock("base", unit_weight=0), bsm.Rock("block", unit_weight=GAMMA_DAM)],
        joints=[bsm.Joint("J", normal_stiffness=1e9, shear_stiffness=1e9)],
        default_joint="J",
        supports=[bsm.Fixed(blocks=[0])],
        loads=loads,
    )
    contacts = bsm.run(model, LINEAR).stages[-1].contacts
    W, thrust, U = GAMMA_DAM * H * B / 2, GAMMA_W * H**2 / 2, uplift * GAMMA_W * H * B / 2
    N = -contacts.normal_force.sum()
    S = abs(contacts.shear_force.sum())
    assert_allclose(N, W - U, rtol=RTOL)
    assert_allclose(S, thrust, rtol=RTOL)
    about_toe = W * 2 * B / 3 - thrust * H / 3 - U * 2 * B / 3
    resultant = about_toe / (W - U)
    heel, toe = np.argsort(contacts.point[:, 0])
    assert_allclose(-contacts.normal_force[heel], (W - U) * resultant / B, rtol=RTOL)
    assert_allclose(-contacts.normal_force[toe], (W - U) * (1 - resultant / B), rtol=RTOL)
    factor = N * np.tan(np.radians(45)) / S
    assert_allclose(factor, 1.15719 if uplift else 1.95719, atol=5e-6)  # as the case prints it
    if uplift:
        assert_allclose(resultant, 12.264, atol=5e-4)
        assert_allclose((N * np.tan(np.radians(45)) + 200e3 * B) / S, 1.80958, atol=5e-6)
