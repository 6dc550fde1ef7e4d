"""Probability of failure against its closed form: blocks on an incline, whose friction is normally distributed.

Their factor of safety is tan(friction) / tan(slope), in the first stage as in a later one, so that the probability of
a factor below 1 is that of a friction below the slope.
"""

from __future__ import annotations

import math
from pathlib import Path
from statistics import NormalDist

import numpy as np
import pytest

import bsm_mesh as bsm
from tests.scenes.small_case import LOAD, MODEL
from tests.scenes.square_mesh import msh

SLOPE, FRICTION = 30.0, NormalDist(mu=32.0, sigma=3.0)
RUNS, TOLERANCE = 8, 0.02


@pytest.mark.slow
@pytest.mark.parametrize("answers", ["factor_of_safety", "verdict"])
def test_an_unstable_first_stage_is_a_failure(tmp_path: Path, answers: str) -> None:
    """A stage that is not reached has a factor below 1. Such runs were counted as faults."""
    stage = '\n[[stage]]\nname = "later"\n'
    (tmp_path / "mesh.msh").write_text(msh())
    (tmp_path / "model.toml").write_text(MODEL.replace(LOAD, "") + f"\n[gravity]\ndirection = {SLOPE - 90}\n" + stage)
    (tmp_path / "study.toml").write_text(
        f'model = "model.toml"\nruns = {RUNS}\nsampling = "latin_hypercube"\nanswers = ["{answers}"]\n'
        f'[vary]\njoint.J1.friction = {{distribution = "normal", mean = {FRICTION.mean}, '
        f"deviation = {FRICTION.stdev}}}\n[safety]\ntolerance = {TOLERANCE}\n"
    )
    found = bsm.study(tmp_path / "study.toml", processes=1)
    failure, friction = found.summary["failure"], found.table.numbers("joint.J1.friction")
    assert failure["failed"] == failure["undecided"] == 0
    assert failure["share"] == pytest.approx(FRICTION.cdf(SLOPE), abs=1 / RUNS)  # a Latin hypercube's accuracy
    assert found.table.has_status("unstable").tolist() == (friction < SLOPE).tolist()
    if answers == "factor_of_safety":
        exact = np.tan(np.radians(friction)) / math.tan(math.radians(SLOPE))
        assert (found.table.numbers("factor_stable") <= exact).all()
        assert (found.table.numbers("factor_unstable") >= exact * (1 - 1e-4)).all()
        assert next(each for each in found.summary["answers"] if each["answer"] == "factor")["runs"] == RUNS
