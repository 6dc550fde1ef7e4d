"""Oracles catch what is false, and leave what is true alone."""

from __future__ import annotations

from dataclasses import replace

import pytest

import bsm_mesh as bsm
from benchmarks.campaign import outcome
from benchmarks.campaign.families import FAMILIES
from benchmarks.campaign.oracles import Case, judge
from benchmarks.campaign.trial import Expected, trial_of

NONE = Expected(form="", margin=0.0, tolerance=0.0)


@pytest.fixture(scope="module")
def standing():
    """Return a wall that stands, as a case."""
    trial = trial_of(FAMILIES["wall"], 1)
    results, seconds = outcome.run(trial.scene)
    assert results.status == "stable"
    return Case(trial=trial, record=outcome.record_of(trial.scene, results, seconds), results=results)


def test_what_is_missing_is_kept_where_there_is_no_verdict(standing):
    scene = standing.trial.scene
    results = bsm.run(scene.model(), replace(outcome.OPTIONS, max_steps=1))
    assert "the limit of 1 steps was reached" in outcome.record_of(scene, results, 0.0)["reason"]
    assert "reason" not in standing.record


def names(case):
    return sorted(text.partition(":")[0] for text in judge(case)["contradictions"])


def claim(case, **record):
    return Case(trial=case.trial, record=case.record | record, results=case.results)


def slippery(case, friction):
    """Return the case as if its joints had other friction: its end is no longer admissible."""
    trial = replace(case.trial, scene=replace(case.trial.scene, friction=friction))
    return Case(trial=trial, record=case.record, results=case.results)


@pytest.mark.heavy
def test_a_true_end_contradicts_nothing(standing):
    found = judge(standing)
    assert found["contradictions"] == []
    assert found["facts"]["admissible"]
    assert found["facts"]["lack_at_end"] < 1e-6


@pytest.mark.heavy
def test_an_end_that_no_forces_hold_is_found(standing):
    assert {"end", "start"} <= set(names(slippery(standing, 0.5)))


@pytest.mark.heavy
def test_an_unstable_end_without_movement_is_found(standing):
    assert names(claim(standing, status="unstable", fallen=3, fell=1e-6))[0] == "sense"
    assert names(claim(standing, status="unstable", fallen=0, fell=0.0))[0] == "sense"


@pytest.mark.heavy
def test_a_closed_form_that_is_contradicted_is_found():
    judged = set()
    for seed in range(40):
        trial = trial_of(FAMILIES["beam"], seed)
        if trial.expected.rests in (None, *judged) or abs(trial.expected.margin) < 0.05:
            continue
        results, seconds = outcome.run(trial.scene)
        case = Case(trial=trial, record=outcome.record_of(trial.scene, results, seconds), results=results)
        assert "closed form" not in names(case)
        false = {"status": "unstable", "fallen": 1} if trial.expected.rests else {"status": "stable", "moved": 1e-5}
        assert "closed form" in names(claim(case, **false))
        judged.add(trial.expected.rests)
    assert judged == {True, False}


@pytest.mark.heavy
def test_a_twin_with_another_verdict_is_found():
    for seed in range(40):
        trial = trial_of(FAMILIES["wall"], seed)
        if trial.scene.count > 150 or trial.parameters["tilt"] > 15:
            continue
        results, seconds = outcome.run(trial.scene)
        case = Case(trial=trial, record=outcome.record_of(trial.scene, results, seconds), results=results)
        twins = set(judge(case)["facts"].get("twins", {})) - {"stronger"}
        if twins and results.status == "stable":
            break
    assert "symmetry" not in names(case)
    assert "symmetry" in names(claim(case, status="unstable", fallen=1, fell=1.0))


@pytest.mark.heavy
def test_a_rest_elsewhere_than_the_form_says_is_found():
    seed = next(s for s in range(60) if (trial_of(FAMILIES["rocking"], s).expected or NONE).moved)
    trial = trial_of(FAMILIES["rocking"], seed)
    results, seconds = outcome.run(trial.scene)
    case = Case(trial=trial, record=outcome.record_of(trial.scene, results, seconds), results=results)
    assert names(case) == []
    assert names(claim(case, moved=case.record["moved"] + 0.1)) == ["closed form"]
