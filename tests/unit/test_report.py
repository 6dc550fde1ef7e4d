"""The report of a results folder: one page that needs nothing else, whose numbers are those of the results."""

import base64
import json
import re
import shutil
from dataclasses import replace
from html import escape
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import bsm_mesh as bsm
from bsm_mesh.commands.cli import cli
from bsm_mesh.commands.safety import ask_safety
from bsm_mesh.folder.own_files import own_files
from bsm_mesh.folder.verify import Ground
from bsm_mesh.pages import report as report_page
from bsm_mesh.pages import report_results
from bsm_mesh.pages.report_results import PNG, _shown, input_tables
from bsm_mesh.pictures import plot
from bsm_mesh.pictures.pictures import NAMES
from bsm_mesh.pictures.plot import PictureChoice, draw_in_subprocess
from bsm_mesh.results.joint_sets import joint_sets
from bsm_mesh.text.progress import Progress
from bsm_mesh.text.tables import percent
from tests.scenes.here import run_here
from tests.scenes.known_factors import incline, tutorial_slope
from tests.scenes.small_case import LOAD, MODEL
from tests.scenes.square_mesh import msh


def report(folder, *options):
    outcome = CliRunner().invoke(cli, ["report", str(folder), *options])
    return outcome, (folder / "report.html").read_text(encoding="utf-8") if outcome.exit_code == 0 else ""


@pytest.fixture(scope="module")
def slope(tmp_path_factory):
    """Return the results of a slope whose left block is excavated, their folder and its report without pictures."""
    folder = tmp_path_factory.mktemp("slope") / "out"
    results = bsm.run(tutorial_slope(30.0))
    results.save(folder)
    return results, folder, report(folder, "--no-pictures")[1]


@pytest.fixture(scope="module")
def drawn(slope, tmp_path_factory):
    """Return that folder and its report with pictures."""
    folder = shutil.copytree(slope[1], tmp_path_factory.mktemp("drawn") / "out")
    return folder, report(folder)[1]


@pytest.mark.slow
def test_verdicts_with_their_grounds(slope):
    results, _, page = slope
    assert [stage.name for stage in results.stages] == re.findall(r"<h3>Stage (\w+)</h3>", page)
    assert page.count("<td>stable</td>") == 2
    assert "equilibrium: every block is in balance" in page
    assert 'class="fails"' not in page


def test_a_verdict_that_does_not_hold_is_said_in_words_on_the_page_and_by_the_command(answered, monkeypatch):
    """A colour alone is lost in print and to some eyes."""
    ground = Ground(
        stage="initial", verdict="stable", kind="equilibrium", holds=False, text="block 0 is out of balance"
    )
    monkeypatch.setattr(report_results, "grounds_in", lambda out: (ground,))
    outcome, page = report(answered[0], "--no-pictures")
    said = "the verdict on stage initial DOES NOT HOLD in the check (bsm-mesh verify): block 0 is out of balance"
    assert f"note: {said}" in outcome.stderr
    assert page.index(said) < page.index("<h2>")
    assert "<td>checked</td><td>equilibrium: DOES NOT HOLD: block 0 is out of balance</td>" in page


def test_numbers_are_those_of_the_results(slope):
    results, folder, page = slope
    last = results.stages[-1]
    most = int(np.hypot(*last.stage_displacement[:, :2].T).argmax())
    assert f"block {most} at " in page
    assert f"<td>{int(last.present.sum())}</td>" in page
    assert f"<td>{len(last.contacts.length)}</td>" in page
    assert results.model_digest in page
    assert str((folder / "contacts_0000.vtu").stat().st_size) in page
    (joint,) = joint_sets(results, last)
    assert f">{escape(percent(joint.slipping))}</td>" in page


def test_numbers_of_the_input_bear_their_units(slope):
    """With a prefix where that loses no digit."""
    _, _, page = slope
    rows = dict(re.findall(r"<tr><td>(\w+)</td><td>(.*?)</td></tr>", page))
    assert rows["unit_weight"].endswith("N/m^3")
    assert rows["normal_stiffness"].endswith("Pa/m")
    assert rows["friction"].endswith(" degrees")
    assert _shown(26123.25, "N/m^3") == "26123.25 N/m^3"
    assert _shown(["x", "y"]) == "x, y"
    assert _shown([3.0, 0.5], "m") == "(3, 0.5) m"
    assert _shown([1e5, 0.0, -2e4], "Pa") == "(100000, 0, -20000) Pa, Pa/m"
    assert _shown([[-25.0, 15.0], [10.0, 4.5]]) == "(-25, 15), (10, 4.5)"
    assert _shown({"centre": [0.0, 2.0], "count": 7, "load": []}) == "centre (0, 2), count 7"


def test_units_of_the_input_are_those_of_the_tables_of_the_model_file():
    """In tables within tables too, and of the histories."""
    given = """
        [gravity]
        direction = -90
        [in_situ]
        surface = 42.0
        [[bolt]]
        radial = { centre = [0, 2], radius = 2.5, count = 5, first = 50 }
        [[load]]
        traction = [[1e5, 0, -2e4], 3e4]
        [[stage]]
        name = "wave"
        shaking = { amplitude = 1.5, frequency = 2.0 }
        [[history]]
        name = "roof"
        point = [0.0, 3.0]
    """
    told = {name: dict(rows) for name, rows in input_tables(given)}
    assert told["gravity"]["direction"] == "-90 degrees"
    assert told["in situ"]["surface"] == "42 m"
    assert told["bolt 1"]["radial"] == "centre (0, 2) m, radius 2.5 m, count 5, first 50 degrees"
    assert told["load 1"]["traction"] == "(100000, 0, -20000), 30000 Pa, Pa/m"
    assert told["stage wave"]["shaking"] == "amplitude 1.5, frequency 2 Hz"
    assert told["history roof"]["point"] == "(0, 3) m"


@pytest.mark.heavy
def test_the_page_needs_nothing_else(drawn):
    _, page = drawn
    assert not re.findall(r'(?:src|href)="(?!data:)', page)
    assert "http" not in page
    assert "<script" not in page


@pytest.mark.heavy
def test_pictures_are_in_the_page(drawn):
    """All of the last stage; of the stage before what moved and slipped, before them and by its name."""
    folder, page = drawn
    names = {path.stem for path in (folder / "pictures").glob("*.png")}
    last = {name for name in names if "_stage_" not in name}
    before = {name for name in ("displacement_stage_0", "joints_state_stage_0") if name in names}
    captions = re.findall(r"<figcaption>(.*?)</figcaption>", page)
    told = sorted(f"{name.removesuffix('_stage_0').replace('_', ' ')}, stage initial" for name in before)
    assert captions == told + [name.replace("_", " ") for name in NAMES if name in last - {"model"}]
    assert page.index('alt="overview"') < page.index("<h2>Verdicts</h2>")
    assert page.count('src="data:image/png;base64,') == len(captions) + 1 > 3
    assert before
    assert len(names) == len(captions) + 1  # none that the page does not show


@pytest.mark.slow
def test_pictures_that_are_missing_are_drawn(slope, drawn, tmp_path):
    """After `plot --only` the others are drawn, and those that are there stay; of other stages they are counted."""
    results, whole = slope[0], drawn[1]
    results.save(tmp_path / "out")
    choice = PictureChoice(only=("displacement", "sigma_1"))
    draw_in_subprocess(tmp_path / "out", choice)
    there = tmp_path / "out" / "pictures" / "displacement.png"
    before = there.stat()
    page = report(tmp_path / "out")[1]
    captions = r"<figcaption>(.*?)</figcaption>"
    assert re.findall(captions, page) == re.findall(captions, whole)
    assert there.stat().st_mtime_ns == before.st_mtime_ns
    assert "1 more picture of" in page


def test_a_picture_of_a_stage_that_there_is_none(slope, tmp_path):
    """A file that somebody put there is no picture of these results."""
    results, _, _ = slope
    results.save(tmp_path / "out")
    (tmp_path / "out/pictures").mkdir()
    (tmp_path / "out/pictures/displacement_stage_99.png").write_bytes(b"a picture")
    outcome, page = report(tmp_path / "out", "--no-pictures")
    assert outcome.exit_code == 0
    assert "None were drawn." in page


def test_the_next_run_takes_it_away(slope, tmp_path):
    results, _, _ = slope
    results.save(tmp_path / "out")
    assert report(tmp_path / "out", "--no-pictures")[0].exit_code == 0
    assert "report.html" in own_files(tmp_path / "out")
    results.save(tmp_path / "out")
    assert not (tmp_path / "out" / "report.html").exists()


@pytest.mark.heavy
def test_blocks_that_come_down_and_texts_that_are_no_html(tmp_path):
    bsm.run(replace(incline(20.0, 30.0), title="a < b & <script>alert(1)</script>")).save(tmp_path / "out")
    _, page = report(tmp_path / "out", "--no-pictures")
    assert "<td>falls</td><td>1 block, 1 m2 (" in page
    assert "proved: " in page
    assert "&lt;script&gt;" in page
    assert "<script" not in page
    assert "None were drawn." in page


def test_damaged_results_have_no_report(slope, tmp_path):
    results, _, _ = slope
    results.save(tmp_path / "out")
    (tmp_path / "out" / "history.csv").write_text("nothing")
    outcome, _ = report(tmp_path / "out", "--no-pictures")
    assert "history.csv" in str(outcome.exception)
    assert not (tmp_path / "out" / "report.html").exists()


def test_a_folder_without_results(tmp_path):
    outcome = CliRunner().invoke(cli, ["report", str(tmp_path)])
    assert isinstance(outcome.exception, bsm.ModelError)


FIELDS = '[report]\nproject = "Road <7>"\nauthor = "A. Engineer"\n'


@pytest.fixture(scope="module")
def answered(tmp_path_factory):
    """Return the folders of a run and of its factor of safety."""
    folder = tmp_path_factory.mktemp("answered")
    (folder / "model.toml").write_text(MODEL.replace(LOAD, "") + FIELDS)
    (folder / "mesh.msh").write_text(msh())
    bsm.run(folder / "model.toml", output=folder / "out")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(plot, "run_with_lines", run_here)
        ask_safety(
            folder / "model.toml",
            folder / "out-safety",
            Progress(quiet=True),
            vary=None,
            movement=0.05,
            as_json=False,
            scripts=True,
            stage=None,
            tolerance=0.02,
            trials=12,
            processes=1,
            joints=None,
            rocks=None,
            bolts=False,
            start="stage",
            spread=False,
        )
    return folder / "out", folder / "out-safety"


@pytest.mark.heavy
def test_the_factor_of_safety_of_the_model_is_on_the_first_page(answered):
    _, safety = answered
    told = json.loads((safety / "safety.json").read_text())
    for folder in answered:
        page = report(folder, "--no-pictures", "--author", "B. Other")[1]
        first, _, _ = page.partition("<h2>Verdicts</h2>")
        assert told["answer"] in first
        assert told["limit_analysis"]["text"] in first
        assert first.count("data:image/png") == 2
        fields = dict(re.findall(r"<tr><td>(project|author|date)</td><td>(.*?)</td></tr>", first))
        assert fields == {"project": "Road &lt;7&gt;", "author": "B. Other"}


def test_the_limit_of_a_key_is_no_factor_of_safety(answered, tmp_path):
    """The page names the key, beside the results and alone."""
    folders = tmp_path / "out", tmp_path / "out-limit-gravity.horizontal"
    for old, new in zip(answered, folders, strict=True):
        shutil.copytree(old, new)
    told = json.loads((folders[1] / "safety.json").read_text())
    told |= {"quantity": "gravity.horizontal", "answer": "gravity.horizontal 0.3"}
    (folders[1] / "safety.json").write_text(json.dumps(told))
    for folder in folders:
        page = report(folder, "--no-pictures")[1]
        assert "<h2>Limit of gravity.horizontal in stage " in page
        assert "<strong>gravity.horizontal 0.3</strong>" in page
        assert "Factor of safety" not in page


def test_factors_of_stages_are_beside_each_other_under_their_names(answered, tmp_path):
    run, factor, cut = tmp_path / "out", tmp_path / "out-safety", tmp_path / "out-safety-cut"
    for old, new in zip((*answered, answered[1]), (run, factor, cut), strict=True):
        shutil.copytree(old, new)
    told = json.loads((cut / "safety.json").read_text())
    (cut / "safety.json").write_text(json.dumps({**told, "stage": "cut", "answer": "factor of safety 9"}))
    page = report(run, "--no-pictures")[1]
    headings = re.findall(r"<h2>Factor of safety in stage &#39;(.*?)&#39;</h2>\s*<p><strong>(.*?)</strong>", page)
    assert headings == [("initial", told["answer"]), ("cut", "factor of safety 9")]


def test_factors_are_in_the_order_of_the_stages(monkeypatch):
    """Not in that of their folders' names."""
    monkeypatch.setattr(report_page, "safety_content", lambda folder: {"stage": folder.name})
    found = report_page._in_order(
        [Path("anchors"), Path("initial"), Path("other"), Path("wet")], ["initial", "wet", "anchors"]
    )
    assert [one["stage"] for one in found] == ["initial", "wet", "anchors", "other"]


@pytest.mark.heavy
def test_the_factor_of_another_model_is_left_out(answered, tmp_path):
    shutil.copytree(answered[1], tmp_path / "out-safety")
    bsm.run(incline(20.0, 30.0)).save(tmp_path / "out")
    left_out, page = report(tmp_path / "out", "--no-pictures")
    assert "Factor of safety" not in page
    assert "out-safety is of another model than" in left_out.stderr
    outcome, forced = report(tmp_path / "out", "--no-pictures", "--safety", str(tmp_path / "out-safety"))
    assert "Factor of safety" in forced
    assert "of another model than these results" in forced
    assert "of another model than these results" in outcome.stderr
    for folder in answered:
        assert "another model" not in report(folder, "--no-pictures")[0].stderr


def test_a_head_that_was_edited_after_the_run_is_named(answered, tmp_path):
    folder = shutil.copytree(answered[0], tmp_path / "out" / "model")
    source = tmp_path / "model.toml"
    shutil.copy(answered[0] / "model.toml", source)
    assert report(folder, "--no-pictures")[0].stderr.count("note: ") == 0
    source.write_text(source.read_text(encoding="utf-8").replace("A. Engineer", "B. Other"), encoding="utf-8")
    outcome, page = report(folder, "--no-pictures")
    assert f"[report] in {source} is not that of the run" in outcome.stderr
    assert "A. Engineer" in page


def test_the_head_of_results_away_from_their_model_file_is_that_of_the_run(answered, tmp_path):
    """An edited model file that no one finds has no effect, and the command says which head the page has."""
    folder = shutil.copytree(answered[0], tmp_path / "elsewhere")
    said = f"note: the head of the page is [report] of {folder / 'model.toml'}, the model as it was run"
    assert said in report(folder, "--no-pictures")[0].stderr
    given = ("--project", "P", "--author", "B. Other", "--date", "today")
    assert "the head of the page" not in report(folder, "--no-pictures", *given)[0].stderr


def test_the_head_of_a_factor_of_safety_is_that_of_its_model_file(answered, tmp_path):
    """The file of `out/model-safety` is `model.toml`."""
    folder = shutil.copytree(answered[1], tmp_path / "out" / "model-safety")
    source = tmp_path / "model.toml"
    source.write_text((answered[0] / "model.toml").read_text(encoding="utf-8").replace("A. Engineer", "B. Other"))
    outcome, _ = report(folder, "--no-pictures")
    assert f"[report] in {source} is not that of the run" in outcome.stderr


def test_an_overview_of_ones_own(answered, tmp_path):
    picture = PNG + b"a picture of the site"
    (tmp_path / "site.png").write_bytes(picture)
    page = report(answered[0], "--no-pictures", "--picture", str(tmp_path / "site.png"))[1]
    assert base64.b64encode(picture).decode() in page
    outcome, _ = report(answered[0], "--no-pictures", "--picture", str(tmp_path / "none.png"))
    assert "give a PNG file" in str(outcome.exception)


def test_what_is_no_picture_or_no_answer_is_not_shown(answered, tmp_path):
    """A link that carries a picture's name, and an answer that somebody changed."""
    folder = shutil.copytree(answered[1], tmp_path / "safety")
    (tmp_path / "secret").write_text("a secret of somebody's")
    (folder / "movement.png").unlink()
    (folder / "movement.png").symlink_to(tmp_path / "secret")
    assert "is no PNG picture" in str(report(folder, "--no-pictures")[0].exception)
    (folder / "movement.png").unlink()
    told = json.loads((folder / "safety.json").read_text())
    for changed in ({**told, "mechanism": []}, {**told, "trials": 3}, {**told, "undecided": ["x"]}, {}):
        (folder / "safety.json").write_text(json.dumps(changed))
        outcome, _ = report(folder, "--no-pictures")
        assert isinstance(outcome.exception, bsm.ModelError), changed


@pytest.mark.slow
def test_a_study_has_a_report(tmp_path):
    (tmp_path / "model.toml").write_text(MODEL.replace(LOAD, ""))
    (tmp_path / "mesh.msh").write_text(msh())
    values = "[vary.rock.gneiss.unit_weight]\nvalues = [24e3, 27e3]\n"
    study = f'model = "model.toml"\ntitle = "Weights"\nsampling = "grid"\n{values}{FIELDS}'
    (tmp_path / "study.toml").write_text(study)
    done = bsm.study(tmp_path / "study.toml", processes=1)
    page = report(done.folder)[1]
    assert "<h1>Weights</h1>" in page
    assert "Road &lt;7&gt;" in page
    assert "<tr><td>runs</td><td>2</td></tr>" in page
    assert "<tr><td>1</td><td>27000 N/m^3</td><td>stable</td>" in page
    assert page.count("data:image/png") == len(done.pictures)
    (done.folder / "summary.json").write_text("{}")
    assert "run bsm-mesh study again" in str(report(done.folder)[0].exception)
