"""Jointed banks with random bolts end in a verdict, and no bolt carries more than it can."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import bsm_mesh as bsm
from bsm_mesh.model.bolt_layout import pass_blocks
from tests.scenes.random_models import jointed_banks

FEW = settings(max_examples=20, derandomize=True, deadline=None)
AREA = np.pi * 0.025**2 / 4


@st.composite
def bolted_banks(draw):
    """Return a bank with some of ten random bolts: those that lie in the rock."""
    model = draw(jointed_banks())
    rng = np.random.default_rng(draw(st.integers(0, 10_000)))
    kinds = (
        {},
        {"bond_strength": 20e3},
        {"bond_strength": 60e3, "bond_stiffness": 1e8, "plate": 30e3},
        {"kind": "end_anchored", "anchor_capacity": 40e3, "pretension": 20e3},
        {"yield_strength": 30e3 / AREA, "pretension": 10e3, "spacing": 1.5},
        {"yield_strength": 300e6, "bearing_stiffness": 1e9, "bearing_strength": 5e7},
    )
    bolts = []
    for _ in range(10):
        head, angle = rng.uniform((0.1, 0.1), (2.9, 1.9)), rng.uniform(0, 2 * np.pi)
        tip = head + rng.uniform(0.5, 2.5) * np.array([np.cos(angle), np.sin(angle)])
        bolt = bsm.Bolt(start=head, end=tip, diameter=0.025, **kinds[rng.integers(len(kinds))])
        try:
            pass_blocks([bolt], model.blocks)
        except bsm.ModelError:
            continue
        bolts.append(bolt)
    return model.replace(bolts=bolts)


@pytest.mark.slow
@FEW
@given(bolted_banks())
def test_a_bolted_bank_ends_in_a_verdict(model):
    results = bsm.run(model, bsm.Options(scheme="continuation"))
    stage, bolts = results.stages[-1], results.stages[-1].bolts
    for values in (stage.displacement, bolts.axial_force, bolts.bond_force, bolts.slip, bolts.shear_force):
        assert np.isfinite(values).all()
    assert (bolts.axial_force >= 0).all()
    assert (bolts.utilisation <= 1 + 1e-9).all()
    corners = "passed into each other" in stage.reason  # an open fault of corners that meet in a point
    assert results.status != "not_converged" or corners, stage.reason
    if results.status == "stable":
        check = results.check()
        assert max(check.block_residual, check.balance) <= check.tolerance, str(check)
    block, point, force = bolts.on_blocks()
    assert np.abs(force.sum(axis=0)).max(initial=0) <= 1e-9 * np.abs(force).sum() + 1e-12
    moment = point[:, 0] * force[:, 1] - point[:, 1] * force[:, 0]
    assert abs(moment.sum()) <= 1e-9 * np.abs(moment).sum() + 1e-12
    assert len(block) == len(force)


@pytest.mark.slow
@settings(max_examples=10, derandomize=True, deadline=None)
@given(bolted_banks())
def test_limit_analysis_agrees_with_a_stable_end(model):
    """What is where it is, within its strength and hardly moved, cannot be statically inadmissible."""
    results = bsm.run(model, bsm.Options(scheme="continuation"))
    if results.status == "stable" and results.stages[-1].max_displacement < 1e-4:
        assert bsm.limit_analysis(model).admissible
