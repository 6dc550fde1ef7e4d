"""Random piles and jointed banks of convex blocks end in a verdict that stands its check; no crash, no NaN."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import bsm_mesh as bsm
from tests.scenes.random_models import jointed_banks, piles

FEW = settings(max_examples=20, derandomize=True, deadline=None)


@pytest.mark.slow
@FEW
@given(st.one_of(piles(), jointed_banks()))
def test_a_pile_ends_in_a_verdict(model):
    results = bsm.run(model, bsm.Options(scheme="continuation"))
    stage = results.stages[-1]
    for values in (stage.displacement, stage.reactions, stage.contacts.force, stage.stress, stage.residual):
        assert np.isfinite(values).all()
    assert results.status != "not_converged", stage.reason
    if results.status == "stable":
        assert results.check().ok, str(results.check())
        assert stage.unstable_blocks.size == 0
    else:
        assert stage.unstable_blocks.size > 0
        assert 0 not in stage.unstable_blocks
        assert stage.reason


@pytest.mark.heavy
@FEW
@given(st.one_of(piles(), jointed_banks()))
def test_the_thesis_iteration_calls_nothing_stable_that_is_not(model):
    results = bsm.run(model, bsm.Options(scheme="wang", max_steps=300))
    assert np.isfinite(results.stages[-1].displacement).all()
    if results.status == "stable":
        assert results.check().ok, str(results.check())
