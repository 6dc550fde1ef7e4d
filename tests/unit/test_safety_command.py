"""The commands ``safety`` and ``back-analysis``: what they print, write and refuse, and their exit codes."""

import csv
import json
import math
import shutil
from dataclasses import replace
from types import SimpleNamespace

import pytest
from click.testing import CliRunner

import bsm_mesh as bsm
from bsm_mesh.commands.cli import cli
from bsm_mesh.modelfile.variation import Variation
from bsm_mesh.pictures import plot
from bsm_mesh.pictures.safety_pictures import draw_movement
from bsm_mesh.safety.bracket import Verdict
from bsm_mesh.safety.trials import Reduction
from bsm_mesh.text.safety_text import answer_rows
from tests.scenes.here import run_here
from tests.scenes.known_factors import incline, tan

EXACT = tan(40.0) / tan(30.0)
PNG = b"\x89PNG"


@pytest.fixture(scope="module")
def given(tmp_path_factory):
    """Return a model file: a block on a plane of 30 degrees with a friction of 40."""
    folder = tmp_path_factory.mktemp("given")
    bsm.run(incline(40.0, 30.0)).save(folder / "run")
    return folder / "run" / "model.toml"


def asked(*arguments):
    outcome = CliRunner().invoke(cli, [*map(str, arguments)])
    return outcome.exit_code, outcome.stdout, outcome.stderr, outcome.exception


@pytest.fixture(scope="module")
def answered(given, tmp_path_factory):
    out = tmp_path_factory.mktemp("answered") / "out"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(plot, "run_with_lines", run_here)
        code, shown, _, _ = asked("safety", given, "-o", out, "--tolerance", "0.002")
    return code, shown, out


@pytest.mark.heavy
def test_the_answer_in_words(answered):
    code, shown, out = answered
    assert code == 0
    words = " ".join(shown.split())
    assert "factor of safety 1.4" in words
    assert "upper bound 1.453" in words
    assert "no forces within strength balance the loads" in words
    assert "block 1: 1 m2" in words
    assert "at the last stable value: J" in words
    assert f"written to {out}" in " ".join(shown.replace("\n", " ").split())


def test_what_is_written(answered):
    _, _, out = answered
    told = json.loads((out / "safety.json").read_text(encoding="utf-8"))
    assert told["stable"] < EXACT <= told["unstable"] * (1 + 1e-4)
    assert told["closed"] is True
    assert told["mechanism"]["blocks"] == [1]
    assert told["limit_analysis"]["factor"] == pytest.approx(EXACT, rel=1e-4)
    with (out / "trials.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [float(row["value"]) for row in rows] == [trial["value"] for trial in told["trials"]]
    assert {row["verdict"] for row in rows} == {"stable", "unstable"}
    for name in ("movement.png", "mechanism.png"):
        assert (out / name).read_bytes()[:4] == PNG
    assert bsm.Results.load(out / "stable").status == "stable"
    assert bsm.Results.load(out / "unstable").status == "unstable"


@pytest.mark.parametrize(("moved", "is_explained"), [(0.001, True), (0.4, False)])
def test_a_failure_below_the_line_is_explained_in_the_picture(tmp_path, monkeypatch, moved, is_explained):
    """Limit analysis proves it, or blocks fall: the blocks of the run may have moved less than what counts."""
    drawn = []
    monkeypatch.setattr("bsm_mesh.pictures.safety_pictures.save", lambda figure, path: drawn.append(figure))
    trials = [SimpleNamespace(value=1.0, verdict=Verdict.STABLE, moved=1e-4)]
    trials.append(SimpleNamespace(value=1.2, verdict=Verdict.UNSTABLE, moved=moved))
    given = {"stable": 1.0, "unstable": 1.2, "limit": SimpleNamespace(factor=1.2), "quantity": "factor", "unit": ""}
    draw_movement(SimpleNamespace(trials=trials, **given), 0.05, "title", tmp_path / "movement.png")
    labels = [text.get_text() for text in drawn[0].axes[0].get_legend().get_texts()]
    assert any("below the dotted line" in label for label in labels) is is_explained


def test_both_states_can_be_run_again(answered):
    """The model files of the bracket's ends hold the strength that was tried."""
    _, _, out = answered
    told = json.loads((out / "safety.json").read_text(encoding="utf-8"))
    model = bsm.load(out / "stable" / "model.toml")
    assert tan(model.joints[0].law.friction) == pytest.approx(tan(40.0) / told["stable"], rel=1e-6)


@pytest.mark.heavy
def test_json_and_nothing_else(given, tmp_path):
    code, shown, heard, _ = asked("safety", given, "-o", tmp_path / "out", "--json")
    assert code == 0
    assert json.loads(shown)["answer"].startswith("factor of safety 1.4")
    assert heard == ""


@pytest.mark.heavy
def test_a_second_answer_takes_the_place_of_the_first(given, tmp_path):
    for tolerance in (0.05, 0.01):
        assert asked("safety", given, "-o", tmp_path / "out", "-q", "--tolerance", tolerance)[0] == 0
    told = json.loads((tmp_path / "out" / "safety.json").read_text(encoding="utf-8"))
    assert math.log(told["unstable"] / told["stable"]) <= 0.01


@pytest.mark.heavy
def test_states_of_the_answer_before_do_not_stay(given, tmp_path):
    """The second answer has no state that fails, and its folder none either."""
    assert asked("safety", given, "-o", tmp_path / "out", "-q", "--tolerance", 0.05)[0] == 0
    assert (tmp_path / "out" / "unstable").is_dir()
    asked("safety", given, "--vary", "joint.J.friction", 40, 39, "-o", tmp_path / "out", "-q")
    assert json.loads((tmp_path / "out" / "safety.json").read_text(encoding="utf-8"))["unstable"] is None
    assert not (tmp_path / "out" / "unstable").exists()


@pytest.mark.heavy
def test_pictures_of_the_answer_before_do_not_stay(given, tmp_path, monkeypatch):
    """The second answer is written, and its pictures cannot be drawn."""
    options = ["-o", tmp_path / "out", "-q", "--tolerance", 0.05]
    assert asked("safety", given, *options)[0] == 0
    assert {"mechanism.png", "movement.png"} <= {path.name for path in (tmp_path / "out").iterdir()}

    def fail(*_):
        raise OSError("no space")

    monkeypatch.setattr("bsm_mesh.commands.safety.draw_safety", fail)
    assert asked("safety", given, *options)[0] != 0
    assert (tmp_path / "out" / "safety.json").is_file()
    assert not list((tmp_path / "out").glob("*.png"))


@pytest.mark.slow
def test_each_varied_key_and_stage_has_its_own_folder(given, tmp_path, monkeypatch):
    model = shutil.copytree(given.parent, tmp_path / "model") / "model.toml"
    options = ["-q", "--tolerance", 0.05]
    assert asked("safety", model, *options)[0] == 0
    assert asked("safety", model, "--stage", "initial", *options)[0] == 0
    monkeypatch.chdir(model.parent)
    code, shown, *_ = asked("safety", "model.toml", "--vary", "joint.J.friction", 40, 20, *options)
    assert code == 0
    assert "written to limit-joint.J.friction: " in " ".join(shown.split())  # as the model was given: no whole path
    names = dict.fromkeys(("safety", "safety-initial"), "factor of safety")
    names["limit-joint.J.friction"] = "joint.J.friction"
    for name, quantity in names.items():
        told = json.loads((model.parent / name / "safety.json").read_text(encoding="utf-8"))
        assert told["quantity"] == quantity


@pytest.mark.heavy
def test_joints_are_named_one_after_the_other(given, tmp_path):
    code, shown, _, _ = asked("safety", given, "--joints", "J", "-o", tmp_path / "out", "-q")
    assert code == 0
    assert "joint J" in shown
    error = asked("safety", given, "--joints", "J", "K", "-o", tmp_path / "other", "-q")[3]
    assert "there is no joint 'K'" in str(error)
    assert not (tmp_path / "other").exists()


def test_a_folder_that_is_not_ours_is_refused(given, tmp_path):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "thesis.txt").write_text("mine")
    error = asked("safety", given, "-o", tmp_path / "out", "-q")[3]
    assert "is no results folder of bsm-mesh" in str(error)
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["thesis.txt"]


@pytest.mark.heavy
def test_a_bracket_with_undecided_trials_ends_with_3(given, tmp_path, monkeypatch):
    def undecided(*arguments, **asked):
        return replace(bsm.factor_of_safety(*arguments, **asked), undecided=(1.45,), is_closed=False)

    monkeypatch.setattr("bsm_mesh.commands.safety.factor_of_safety", undecided)
    code, shown, _, _ = asked("safety", given, "-o", tmp_path / "out", "-q")
    assert code == 3
    assert "undecided at 1.45" in shown


def test_bolts_that_keep_their_capacity_are_named():
    """Reduction of joints alone leaves them whole, which the answer says; not where theirs is divided, nor without."""
    bolt = bsm.Bolt(start=(0.5, 0.8), end=(0.5, 0.3), diameter=0.02)
    model = incline(40.0, 30.0)
    assert "bolts" not in Reduction().words(model)
    bolted = model.replace(bolts=[bolt])
    assert "; bolts keep their full capacity (--bolts" in Reduction().words(bolted)
    assert Reduction(bolts=True).words(bolted) == "all joints, rock faces, bolts"


def test_nothing_that_fails():
    found = bsm.factor_of_safety(incline(40.0, 0.0))
    rows = dict(answer_rows(found))
    assert rows["first unstable"] == "-"
    assert rows["limit analysis"].startswith("no upper bound: forces within strength exist")


@pytest.mark.slow
def test_the_limit_of_a_key(given, tmp_path):
    """The block slides at a friction of 30 degrees."""
    out = tmp_path / "out"
    code, shown, _, _ = asked(
        "safety", given, "--vary", "joint.J.friction", 40, "0.35 rad", "-o", out, "-q", "--tolerance", 0.01
    )
    assert code == 0
    told = json.loads((out / "safety.json").read_text(encoding="utf-8"))
    assert (told["quantity"], told["unit"]) == ("joint.J.friction", "degrees")
    assert told["changed"] == "joint.J.friction from 40 degrees to 20.05 degrees"
    assert f"joint.J.friction {told['stable']:.4g} degrees: stable there" in " ".join(shown.split())
    assert told["unstable"] <= 30.0 <= told["stable"] <= told["unstable"] + 0.2
    assert "joint.J.friction" in shown


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["--vary", "joint.K.friction", 40, 20], "'joint.K.friction': the model file has no [joint.K]"),
        (["--vary", "joint.J.fricton", 40, 20], "no key 'fricton'; did you mean 'friction'"),
        (["--vary", "load.1.factor", 0, 20], "there is no [[load]] number 1"),
        (["--vary", "joint.J.friction", "40 kPa", 20], "joint.J.friction = 40 kPa: is in kPa, which does not convert"),
        (["--vary", "joint.J.friction", 40, "few"], "joint.J.friction = few: not a number with a unit"),
        (["--vary", "joint.J.friction", 95, 20], "joint.J.friction = 95.0: must be at least 0 and below 90 degrees"),
        (["--vary", "tilt.left", 5, "5 deg"], "two different ends"),
        (["--vary", "tilt.left", 0, 5, "--spread"], "--spread belongs to strength reduction"),
    ],
)
def test_numbers_that_cannot_be_varied(given, tmp_path, arguments, says):
    error = asked("safety", given, *arguments, "-o", tmp_path / "out", "-q")[3]
    assert says in str(error)
    assert not (tmp_path / "out").exists()


def test_back_analysis_by_the_command(given):
    """A run at 1e10 Pa/m gives the movement, and the movement the stiffness."""
    u, v, _ = bsm.run(incline(40.0, 30.0)).stages[0].displacement[1]
    at = incline(40.0, 30.0).blocks.moments.centroid[1]
    measured = ["--measured", *at, "total", math.hypot(u, v), 0]
    vary = ["--vary", "joint.J.shear_stiffness", "30 GPa/m", 5e9]
    code, shown, _, _ = asked("back-analysis", given, *vary, *measured, "-q", "--json")
    assert code == 0
    assert json.loads(shown)["value"] == pytest.approx(1e10, rel=0.02)
    code, shown, _, _ = asked("back-analysis", given, *vary, "--measured", *at, "x", -1.0, 0.1, "-q")
    assert code == 3
    assert "no value in the range gives the measurement" in shown


def test_a_stage_with_its_own_value_of_the_varied_key_is_named(given, tmp_path):
    model = shutil.copytree(given.parent, tmp_path / "model") / "model.toml"
    quake = '\n[[stage]]\nname = "quake"\n[stage.gravity]\nhorizontal = -0.1\n'
    model.write_text(model.read_text(encoding="utf-8") + quake, encoding="utf-8")
    variation = Variation(model)
    (note,) = variation.overriding("gravity.horizontal", "quake")
    assert note == "stage 'quake' has its own gravity.horizontal; there stage.quake.gravity.horizontal is to be varied"
    assert not variation.overriding("gravity.horizontal", "initial")
    assert not variation.overriding("joint.J.friction", "quake")
    assert not variation.overriding("stage.quake.gravity.horizontal", "quake")
