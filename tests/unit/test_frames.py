"""States of a results folder by name, and factors on movements."""

from __future__ import annotations

from dataclasses import replace

import pytest

import bsm_mesh as bsm
from bsm_mesh.app.exaggeration import exaggeration, factors_up_to
from bsm_mesh.app.frames import frames_in
from bsm_mesh.app.storage import SavedResults
from tests.scenes.openings import opening


def test_names_of_states(tmp_path):
    bsm.run(opening(bolted=False)).save(tmp_path / "out")
    first, last = frames_in(SavedResults(tmp_path / "out"))
    assert (first.label, last.label) == ("stage initial: stable", "stage dig: unstable")
    assert first.file("joints") == "joints_0000.vtu"
    assert replace(first, step=11, verdict="").file("joints") == "joints_0000_00011.vtu"


@pytest.mark.parametrize(("greatest", "factor"), [(0.0, 1), (1.0, 2), (1e-3, 2000), (0.9e-3, 2000), (30.0, 1)])
def test_movements_are_seen_and_never_made_smaller(greatest, factor):
    """A hundred metres of rock; a fiftieth of that is two metres."""
    assert exaggeration(greatest, 100.0) == factor


def test_factors_to_choose_from():
    assert factors_up_to(1.0) == [0.0, 1.0]
    assert factors_up_to(60.0) == [0.0, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0]
