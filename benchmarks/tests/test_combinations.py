"""Random combinations of features: what their judge says, and what their table counts."""

import pytest

from benchmarks.combinations import combination, judged, table


@pytest.mark.heavy
@pytest.mark.parametrize("seed", [18, 5, 14])
def test_a_combination_has_an_answer_that_holds(seed):
    """The first: a load on a block that a stage takes away, in large displacement; then softening zones, and water."""
    record = judged(seed)
    assert record["verdict"] == "stable", record
    assert record["faults"] == []


def test_a_combination_that_is_refused_says_why():
    record = judged(10)
    assert record["verdict"] == "refused"
    assert "zones know no flow in joints" in record["reason"]
    assert record["faults"] == []


def test_draws_are_the_same_again():
    assert combination(3)[2] == combination(3)[2]
    assert len({tuple(combination(seed)[2]) for seed in range(20)}) == 20


def test_faults_are_named():
    right = {"seed": 0, "verdict": "stable", "faults": [], "tags": ["rigid"], "seconds": 1.0}
    wrong = {"seed": 1, "verdict": "error", "faults": ["error"], "tags": ["flow", "bolt"], "seconds": 2.0}
    assert table([right, wrong]).splitlines()[2:] == [
        "| error | 1 | 2 |",
        "| stable | 1 | 1 |",
        "",
        "seed 1: error (flow, bolt)",
    ]
