"""The study file: what it may hold, and what is refused in one message."""

from __future__ import annotations

from pathlib import Path

import pytest

from bsm_mesh.commands.study_file import load_study
from bsm_mesh.errors import ModelError
from bsm_mesh.studies.scatter import Scatter
from tests.scenes.small_case import MODEL, Case

STUDY = """\
model = "model.toml"
runs = 6

[vary]
"joint.J1.friction" = {distribution = "normal", mean = 35, deviation = 2, lower = 25, upper = 45}
"""
FRICTION = '{distribution = "normal", mean = 35, deviation = 2, lower = 25, upper = 45}'


@pytest.fixture
def study(case: Case) -> Case:
    case.write("study.toml", STUDY)
    return case


def test_keys_without_quotes_are_the_same(study: Case) -> None:
    quoted = load_study(Path("study.toml")).plan
    study.write("study.toml", STUDY.replace('"joint.J1.friction"', "joint.J1.friction"))
    assert load_study(Path("study.toml")).plan.values == quoted.values


def test_texts_bear_units(study: Case) -> None:
    study.write(
        "study.toml",
        'model = "model.toml"\nsampling = "grid"\n[vary]\nrock.gneiss.young = {values = ["10 GPa", 2e10]}\n'
        '"load.1.pressure" = {from = "0 MPa", to = "2 MPa", count = 3}\n'
        "mesh.parameters.seed = {from = 1, to = 3, count = 3}\n"
        'joint.J1.law = {values = ["patton", "mohr_coulomb"]}\n'
        '[scatter]\njoint.J1.friction = {deviation = "0.02 rad", classes = 5}\n',
    )
    loaded = load_study(Path("study.toml"))
    assert loaded.plan.count == 2 * 3 * 3 * 2
    assert set(loaded.plan.values["rock.gneiss.young"]) == {1e10, 2e10}
    assert set(loaded.plan.values["load.1.pressure"]) == {0.0, 1e6, 2e6}
    assert all(isinstance(value, int) for value in loaded.plan.values["mesh.parameters.seed"])
    assert set(loaded.plan.values["joint.J1.law"]) == {"patton", "mohr_coulomb"}
    (scatter,) = loaded.scatters
    assert scatter == Scatter(joint="J1", strength="friction", deviation=pytest.approx(1.1459, abs=1e-3), classes=5)
    assert not loaded.is_drawn


def test_what_safety_varies_a_study_varies(study: Case) -> None:
    """Numbers that no key holds, with their units."""
    study.write("model.toml", MODEL + "[water]\ntable = [[-1, 0.5], [3, 0.5]]\n")
    study.write(
        "study.toml",
        'model = "model.toml"\nruns = 6\n[vary]\nwater.rise = {distribution = "uniform", lower = 0, upper = "40 cm"}\n'
        'tilt.left = {values = ["0.1 rad", 3]}\nload.1.factor = {distribution = "normal", mean = 1, deviation = 0.1}\n',
    )
    loaded = load_study(Path("study.toml"))
    assert all(0 <= rise <= 0.4 for rise in loaded.plan.values["water.rise"])  # type: ignore[operator]
    assert {round(float(tilt), 3) for tilt in loaded.plan.values["tilt.left"]} == {5.73, 3.0}
    built = loaded.variation.model(loaded.plan.of(0)).model
    assert built.gravity_direction == -90 - float(loaded.plan.values["tilt.left"][0])


def test_names_with_dots(study: Case) -> None:
    study.write("model.toml", MODEL.replace("[joint.J1]", '[groups]\n"joint:J1" = "joint:J.1"\n[joint."J.1"]'))
    study.write("study.toml", STUDY.replace('"joint.J1.friction"', 'joint."J.1".friction'))
    assert list(load_study(Path("study.toml")).plan.values) == ['joint."J.1".friction']


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("runs = 6", "rnus = 6", "study.toml: top level: unknown key 'rnus'; did you mean 'runs'"),
        ("runs = 6", "", "study.toml: sampling = 'monte_carlo' needs the key 'runs'"),
        ("runs = 6", "runs = 0", "runs = 0"),
        ("runs = 6", 'runs = 6\nsampling = "latin"', "did you mean 'latin_hypercube'"),
        ("runs = 6", 'runs = 6\nanswers = ["factor"]', "is not known; did you mean 'factor_of_safety'"),
        ("J1.friction", "J1.fricton", "study.toml: model.toml: 'joint.J1.fricton': joint.J1 has no key 'fricton'"),
        (
            '"joint.J1.friction"',
            '"water.rise"',
            "water.rise = 0.0: water.rise: the model has no water table",
        ),
        ("joint.J1", "joint.J2", "the model file has no [joint.J2]; did you mean 'J1'"),
        ('"normal"', '"norml"', "[vary] joint.J1.friction: distribution 'norml' is not known; did you mean 'normal'"),
        ("mean = 35", "maen = 35", "unknown key 'maen'; did you mean 'mean'"),
        ("mean = 35", 'mean = "35 kPa"', 'mean = "35 kPa": is in kPa, which does not convert to degrees'),
        ("mean = 35, ", "", "distribution 'normal' needs the key 'mean'"),
        ("deviation = 2, lower = 25, upper = 45", "deviation = 30", "cannot be, the first"),
        (FRICTION, "{values = []}", "values"),
        (FRICTION, "{values = [30], mean = 3}", "mean: belong to a distribution"),
        (FRICTION, "{from = 1, to = 3}", "from, to and count go together"),
        (FRICTION, "{mean = 3}", "given: none"),
        (FRICTION, '{values = [30], distribution = "normal"}', "given: distribution and values"),
        ('model = "model.toml"', 'model = "modle.toml"', "there is no such file; did you mean 'model.toml'"),
        ('model = "model.toml"', "", "needs the key 'model'"),
        ("[vary]", "[scatter]\njoint.J1.dilation = {deviation = 1}\n[vary]", "only joint.NAME.friction and"),
        ("[vary]", "[scatter]\njoint.J1.friction = {deviation = -1}\n[vary]", "deviation = -1 must be above 0"),
        ("[vary]", "[scatter]\nrock.gneiss.friction = {deviation = 1}\n[vary]", "only joint.NAME.friction and"),
        (
            "[vary]",
            '[[correlation]]\nbetween = ["joint.J1.friction", "joint.J1.cohesion"]\ncoefficient = 0.5\n[vary]',
            "'joint.J1.cohesion' is not drawn in [vary]",
        ),
        ("[vary]", "[vary]\nsolver.max_steps = {distribution = 'normal', mean = 9, deviation = 1}", "whole number"),
        ('"joint.J1.friction" = ' + FRICTION, "", "[vary]"),
        (STUDY, "runs = [", "not valid TOML"),
    ],
)
def test_bad_study_files(study: Case, old: str, new: str, says: str) -> None:
    assert old in STUDY
    study.write("study.toml", STUDY.replace(old, new))
    study.refuses("study", "study.toml", "-q", says=[says])


@pytest.mark.parametrize("command", ["run", "check", "safety", "limit", "key-blocks", "compare"])
def test_a_study_file_for_a_model_file_is_named_with_the_command(study: Case, command: str) -> None:
    study.write("deep/study.toml", STUDY)
    says = ["deep/study.toml: is a study file, not a model file", "`bsm-mesh study deep/study.toml`", "deep/model.toml"]
    study.refuses(command, "deep/study.toml", says=says)


def test_a_model_file_for_a_study_file_is_named_with_the_command(study: Case) -> None:
    says = ["model.toml: is a model file, not a study file", "`bsm-mesh run model.toml`", 'model = "model.toml"']
    study.refuses("study", "model.toml", "-q", says=says)
    study.write("other.toml", MODEL + "[vary]\n")  # both: the keys are judged one by one
    study.refuses("run", "other.toml", "-q", says=["unknown key 'vary'"])


def test_no_study_file(study: Case) -> None:
    study.refuses("study", "stduy.toml", says=["there is no such file; did you mean 'study.toml'"])
    study.refuses("study", ".", says=["is a folder; give the study file in it (study.toml)"])


def test_without_scripts_the_model_lies_beside_the_study(study: Case) -> None:
    study.write("deeper/study.toml", STUDY.replace("model.toml", "../model.toml"))
    study.refuses("study", "deeper/study.toml", "--no-scripts", says=['model = "../model.toml" leads out of'])
    assert load_study(Path("deeper/study.toml")).plan.count == 6


def test_all_faults_of_keys_come_together(study: Case) -> None:
    study.write("study.toml", STUDY + 'rock.gneiss.yuong = {values = [1]}\n"load.2.pressure" = {values = [1]}\n')
    with pytest.raises(ModelError) as caught:
        load_study(Path("study.toml"))
    assert len(caught.value.faults) == 2
