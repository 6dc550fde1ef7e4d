"""Dowel action: stiffness and strength of a bolt across a joint against beams solved here, and blocks that it holds.

Hetenyi (1946), Beams on Elastic Foundation; Johansen (1949), Theory of timber connections.
"""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.results import BoltStatus
from tests.scenes.models import LINEAR
from tests.scenes.shapes import rectangle

D, E, BEARING = 0.025, 200e9, 2e9
WEIGHT = 25e3
CONTINUATION = bsm.Options(scheme="continuation")


def bolt(**keys):
    return bsm.Bolt(
        **{"start": (0.5, 1), "end": (0.5, -1), "diameter": D, "young": E, "bearing_stiffness": BEARING, **keys}
    )


def pushed(load, options, spacing=1.0, **keys):
    """Return a block on a frictionless joint, pushed along it and held by a bolt across it alone."""
    blocks = bsm.Blocks.from_polygons([rectangle(-1, -1, 2, 0), rectangle(0, 0, 1, 1)], rock="rock")
    model = bsm.Model(
        blocks=blocks,
        rocks=[bsm.Rock("rock", unit_weight=WEIGHT)],
        joints=[bsm.Joint("J", normal_stiffness=1e10, shear_stiffness=1e8, law=bsm.MohrCoulomb(friction=0.0))],
        default_joint="J",
        supports=[bsm.Fixed(blocks=[0])],
        loads=[bsm.PointLoad(block=1, point=(0, 0.0), force=(load, 0.0))],
        bolts=[bolt(spacing=spacing, **keys)],
    )
    return model, bsm.run(model, options)


def test_block_held_by_the_bolt_alone():
    load, spacing = 10e3, 1.5
    _, results = pushed(load, CONTINUATION, spacing)
    stage = results.stages[-1]
    assert results.status == "stable"
    assert results.check().ok
    assert_allclose(np.abs(stage.bolts.shear_force), load * spacing, rtol=1e-4)
    assert_allclose(stage.displacement[1, 0], load * spacing / bolt().dowel_stiffness, rtol=1e-2)


def test_linear_scheme_shares_with_the_joint():
    load, ks = 10e3, 1e8
    _, results = pushed(load, LINEAR)
    k = bolt().dowel_stiffness
    assert_allclose(np.abs(results.stages[-1].bolts.shear_force), load * k / (k + ks), rtol=1e-6)
    assert results.check().ok


@pytest.mark.heavy
@pytest.mark.parametrize(("share", "status"), [(0.98, "stable"), (1.02, "unstable")])
def test_strength_decides(share, status):
    strengths = {"bearing_strength": 60e6, "yield_strength": 400e6}
    model, results = pushed(share * bolt(**strengths).dowel_strength, CONTINUATION, **strengths, bond_strength=0.0)
    assert results.status == status
    assert np.abs(results.stages[-1].bolts.shear_force[0]) <= bolt(**strengths).dowel_strength * (1 + 1e-12)
    if status == "stable":
        assert results.stages[-1].bolts.status.tolist() == [BoltStatus.ELASTIC]
        assert_allclose(results.stages[-1].bolts.utilisation, share, rtol=1e-3)
    found = bsm.limit_analysis(model.replace(loads=()), model.loads)
    assert found.factor == pytest.approx(1 / share, rel=1e-6)


@pytest.mark.heavy
def test_without_it_the_block_slides():
    _, results = pushed(10e3, CONTINUATION, bearing_stiffness=None, bond_strength=0.0)
    assert results.status == "unstable"
