"""Random combinations of features: what their judge says, and what their table counts."""

import pytest

from benchmarks.combinations import plane, space
from benchmarks.combinations.judge import judged, table


@pytest.mark.heavy
@pytest.mark.parametrize("seed", [18, 5, 14])
def test_a_combination_has_an_answer_that_holds(seed):
    """The first: a load on a block that a stage takes away, in large displacement; then softening zones, and water."""
    record = judged(seed, plane.combination)
    assert record["verdict"] == "stable", record
    assert record["faults"] == []


@pytest.mark.heavy
def test_a_combination_in_space_has_an_answer_that_holds():
    """A traction that is linear in the coordinates, joint pressure and a late bolt are among its features."""
    seed = next(s for s in range(999) if {"Traction", "late bolt", "joint_pressure"} <= set(space.combination(s)[2]))
    record = judged(seed, space.combination)
    assert record["verdict"] in {"stable", "unstable"}, record
    assert record["faults"] == []


def test_a_combination_that_is_refused_says_why():
    record = judged(10, plane.combination)
    assert record["verdict"] == "refused"
    assert "zones know no flow in joints" in record["reason"]
    assert record["faults"] == []


def test_draws_are_the_same_again():
    for draw in (plane.combination, space.combination):
        assert draw(3)[2] == draw(3)[2]
        assert len({tuple(draw(seed)[2]) for seed in range(20)}) >= 18


def test_faults_are_named():
    right = {"seed": 0, "verdict": "stable", "faults": [], "tags": ["rigid"], "seconds": 1.0}
    wrong = {"seed": 1, "verdict": "error", "faults": ["error"], "tags": ["flow", "bolt"], "seconds": 2.0}
    assert table([right, wrong]).splitlines()[2:] == [
        "| error | 1 | 2 |",
        "| stable | 1 | 1 |",
        "",
        "seed 1: error (flow, bolt)",
    ]
