"""States of a results folder by name, and factors on movements."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import bsm_mesh as bsm
from bsm_mesh.folder.frames import frames_in
from bsm_mesh.folder.saved_results import SavedResults
from bsm_mesh.text.exaggeration import exaggeration, factors_up_to
from tests.scenes.openings import OPENED, opening


@pytest.mark.heavy
def test_names_of_states(tmp_path):
    bsm.run(opening(bolted=False)).save(tmp_path / "out")
    first, last = frames_in(SavedResults(tmp_path / "out"))
    assert (first.label, last.label) == (
        "stage initial: stable",
        "stage dig: unstable, 2 blocks fall: 10 % of the area",
    )
    assert first.file("joints") == "joints_0000.vtu"
    assert replace(first, step=11, verdict="").file("joints") == "joints_0000_00011.vtu"


@pytest.mark.parametrize(("greatest", "factor"), [(0.0, 1), (1.0, 1), (1e-3, 200), (0.9e-3, 200), (30.0, 1)])
def test_movements_are_seen_and_close_no_opening(greatest, factor):
    """Six by four metres without two by two: a twentieth of the first is .36 m, a tenth of the other .2 m."""
    blocks = opening(bolted=False).blocks
    assert exaggeration(greatest, blocks, np.setdiff1d(np.arange(24), OPENED)) == factor


def test_without_an_opening_the_model_alone_is_asked():
    assert exaggeration(1e-3, opening(bolted=False).blocks, np.arange(24)) == 200  # of 7.21 m
    assert exaggeration(1e-4, opening(bolted=False).blocks, np.arange(24)) == 2000


def test_factors_to_choose_from():
    assert factors_up_to(1.0) == [0.0, 1.0]
    assert factors_up_to(60.0) == [0.0, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0]
