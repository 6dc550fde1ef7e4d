"""Where contacts press with more than the crushing strength of their joint, a stage's notes say so."""

from dataclasses import replace

import pytest

import bsm_mesh as bsm
from tests.scenes.models import model_of
from tests.scenes.shapes import rectangle


@pytest.mark.parametrize("scheme", ["continuation", "wang", "linear"])
@pytest.mark.parametrize(("strength", "told"), [(10e3, True), (30e3, False), (None, False)])
def test_notes_name_what_is_crushed_and_nothing_is_limited(scheme, strength, told):
    """A block of 25 kPa on its base, two contacts of half a metre each."""
    model = model_of([rectangle(-2, -1, 2, 0), rectangle(-0.5, 0, 0.5, 1)])
    model = model.replace(joints=[replace(model.joints[0], crushing_strength=strength)])
    stage = bsm.run(model, bsm.Options(scheme=scheme)).stages[0]
    text = "joint 'J': 2 of 2 contacts press with more than its crushing_strength = 10000 Pa (the most, 2.5e+04 Pa"
    assert any(text in note for note in stage.notes) is told
    assert stage.contacts.normal_force.sum() == pytest.approx(-25e3, rel=1e-6)


def test_it_is_out_of_range_below_ten_kilopascals():
    with pytest.raises(bsm.ModelError, match="crushing_strength"):
        bsm.Joint("J", 1e9, 1e9, law=bsm.MohrCoulomb(friction=30), crushing_strength=1.0)
