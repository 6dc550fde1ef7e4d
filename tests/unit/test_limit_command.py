"""The command ``limit --strength``: what it prints, tells as JSON, writes and refuses."""

import json

import numpy as np
import pytest

from bsm_mesh.converters.vtk_files import read_vtu
from tests.scenes.small_case import Case


@pytest.fixture
def arch(case: Case) -> Case:
    case.run("new", "arch", "arch")
    return case


def test_it_says_how_far_strength_may_be_divided(arch: Case) -> None:
    outcome = arch.run("limit", "arch/model.toml", "--strength")
    assert outcome.code == 0
    assert "forces within strength exist up to the factor" in outcome.out
    assert "the blocks must move (proved), whatever stiffness and history" in " ".join(outcome.out.split())
    (written,) = [name for name in outcome.new if name.endswith("limit.vtu")]
    assert np.abs(read_vtu(arch.folder / written).point_data["velocity"]).max() > 0.5
    told = json.loads(arch.run("limit", "arch/model.toml", "--strength", "--json").out)
    assert told["proved"]
    assert 1 < told["factor"] < told["beyond"] < told["factor"] * (1 + 1e-4)
    assert f"{told['factor']:.6g}" in told["notes"][-1]


def test_joints_are_chosen_by_name(arch: Case) -> None:
    whole = json.loads(arch.run("limit", "arch/model.toml", "--strength", "--json").out)["factor"]
    of_one = json.loads(arch.run("limit", "arch/model.toml", "--strength", "--joints", "bed", "--json").out)["factor"]
    assert of_one == pytest.approx(whole)
    outcome = arch.run("limit", "--strength", "--joints", "bed", "J9", "--bolts", "arch/model.toml")
    assert outcome.code == 2
    assert "there is no joint 'J9'" in outcome.err


def test_where_there_is_no_limit_nothing_is_written(case: Case) -> None:
    outcome = case.run("limit", "model.toml", "--strength")
    assert "no limit: forces within strength exist at a thousandth" in " ".join(outcome.out.split())
    assert outcome.new == []
    assert json.loads(case.run("limit", "model.toml", "--strength", "--json").out)["factor"] is None


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--strength", "--tilt", "left"], "give one of --load, --tilt and --strength"),
        (["--strength", "--load", "1"], "give one of --load, --tilt and --strength"),
        (["--joints", "J1"], "give --strength too"),
        (["--no-rocks"], "give --strength too"),
    ],
)
def test_what_does_not_go_together_is_refused(case: Case, words: list[str], said: str) -> None:
    outcome = case.run("limit", "model.toml", *words)
    assert outcome.code == 2
    assert said in outcome.err
